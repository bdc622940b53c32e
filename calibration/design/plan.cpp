#include "kinetostat/calibration/design/plan.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <set>

#include <fmt/format.h>

#include "kinetostat/calibration/campaign/load_history.h"
#include "kinetostat/calibration/campaign/noise_estimate.h"
#include "kinetostat/calibration/design/plan_choice.h"
#include "kinetostat/calibration/regression/campaign_noise.h"
#include "kinetostat/calibration/search/ranking.h"
#include "kinetostat/calibration/statistics/median.h"
#include "kinetostat/common/error.h"
#include "kinetostat/common/parallel.h"

namespace kinetostat::calibration {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// The median standard deviation of each component that is measured at all.
VectorXd usual_noise(const Campaign& campaign, const Noise& noise) {
  VectorXd sigma = VectorXd::Constant(campaign.size(), std::numeric_limits<double>::quiet_NaN());
  for (Index k = 0; k < sigma.size(); ++k) {
    std::vector<double> all;
    for (std::size_t i = 0; i < campaign.readings.size(); ++i)
      if (campaign.readings[i].uses(k)) all.push_back(noise.sigma[i][k]);
    if (all.empty()) continue;
    sigma[k] = upper_median(std::move(all));
  }
  return sigma;
}

std::vector<Index> components_of(const VectorXd& sigma) {
  std::vector<Index> components;
  for (Index k = 0; k < sigma.size(); ++k)
    if (!std::isnan(sigma[k])) components.push_back(k);
  return components;
}

// Postures and loads where the model is used, as readings that nobody takes.
MatrixXd work_spread(const PlanTask& task) {
  static const LoadPattern loaded{"at work", {{1}}};
  PlanChoices places = task.choices;
  if (!task.options.work_at.empty()) {
    places.configurations.clear();
    for (const spatial::Pose& pose : task.options.work_at)
      places.configurations.push_back({.target = pose, .joints = {}});
  }
  std::vector<PlanBlock> blocks;
  std::set<std::string> directions;
  for (const PlanBlock& block : task.choices.blocks) {
    if (block.direction.empty() || !directions.insert(block.direction).second) continue;
    for (std::size_t c = 0; c < places.configurations.size(); ++c)
      blocks.push_back({c, block.load, block.direction, &loaded, 0});
  }
  const std::vector<Index> translations = {0, 1, 2};
  Campaign of_platform = task.campaign;
  of_platform.sensors = {Sensor()};
  of_platform.components = platform_components();
  of_platform.watch = {};
  const Campaign work =
      planned_readings(of_platform, task.campaign.displacement, places.configurations, blocks,
                       translations, VectorXd::Ones(of_platform.size()), task.options.measuring);
  const Forecast all =
      forecast(task.robot, task.models.back(), work, translations, task.threads, task.progress);
  MatrixXd spread(0, all.spread.cols());
  for (Index i = 0; i < all.mean.size(); ++i)
    if (std::isfinite(all.mean[i])) {
      spread.conservativeResize(spread.rows() + 1, Eigen::NoChange);
      spread.bottomRows<1>() = all.spread.row(i);
    }
  return spread;
}

// Three readings at each posture: displacements have three components.
double rms_of(double mean_square) { return std::sqrt(3 * mean_square); }

Batch sharpen(const PlanTask& task, const Prospects& prospects, Plan& plan) {
  const PlanModel& model = task.models.back();
  const MatrixXd spread = work_spread(task);
  Knowledge knowledge(model.root.cols());
  plan.work_before = rms_of(knowledge.mean_square(spread));
  Chooser chooser(task);
  std::vector<double> gains(prospects.gains.size());
  while (true) {
    const double before = knowledge.mean_square(spread);
    common::parallel_for(gains.size(), task.threads, "what to measure", task.progress,
                         [&](std::size_t b) {
                           gains[b] = 0;
                           if (prospects.separations[b].empty() && prospects.gains[b].size() == 0)
                             return;
                           Knowledge next = knowledge;
                           next.add(prospects.gains[b]);
                           gains[b] = before - next.mean_square(spread);
                         });
    const auto best = chooser.best(gains, 1e-3 * before);
    if (!best) break;
    knowledge.add(prospects.gains[*best]);
    chooser.take(*best, fmt::format("what is unsure of displacements at work falls to {:.0f} %",
                                    100 * std::sqrt(knowledge.mean_square(spread) / before)));
  }
  plan.work_after = rms_of(knowledge.mean_square(spread));
  const MatrixXd after = model.root * knowledge.covariance() * model.root.transpose();
  for (std::size_t p = 0; p < model.parameters.size(); ++p) {
    const auto i = static_cast<Index>(p);
    plan.sharpened.push_back({model.parameters[p].phrase(), model.parameters[p].unit,
                              model.root.row(i).norm(), std::sqrt(std::max(0.0, after(i, i)))});
  }
  return chooser.batch();
}

bool has_replicates(const Campaign& campaign) {
  for (const ReplicateGroup& group : replicate_groups(campaign))
    if (group.readings.size() > 1) return true;
  return false;
}

// Blocks in the order in which they are measured: posture by posture, as they were chosen. Where
// nothing was ever repeated, the first is measured twice.
void arrange(const PlanTask& task, const Batch& batch, Plan& plan) {
  std::vector<std::size_t> order(batch.blocks.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::map<std::size_t, std::size_t> rank;  // of postures
  const auto posture = [&](std::size_t i) {
    return task.choices.blocks[batch.blocks[i]].configuration;
  };
  for (const std::size_t i : order) rank.emplace(posture(i), rank.size());
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return rank[posture(a)] < rank[posture(b)];
  });
  plan.minutes = batch.minutes;
  std::set<std::size_t> runs(batch.blocks.begin(), batch.blocks.end());
  const bool repeats = runs.size() < batch.blocks.size();
  for (const std::size_t i : order) {
    const PlanBlock& block = task.choices.blocks[batch.blocks[i]];
    plan.blocks.push_back(block);
    plan.why.push_back(batch.why[i]);
    if (i != order.front() || plan.has_replicates || repeats) continue;
    plan.blocks.push_back(block);
    plan.why.push_back("the same again: replicates, by which the noise is known");
    plan.minutes += block.minutes;
  }
  plan.readings = task.readings(plan.displacement, plan.blocks);
}

// What another kind of experiment would do where this kind fails.
std::string advice_for(const PlanTask& task, const ModelPair& pair, const Campaign& readings) {
  const PlanModel &a = task.models[pair.a], &b = task.models[pair.b];
  const auto has = [&](vjm::EffectClass some) {
    return a.effect_class == some || b.effect_class == some;
  };
  if (a.on_load != b.on_load || (a.on_load && b.on_load)) {
    const std::vector<Forecast> all = task.forecasts(
        readings, {under_known_weights(task.robot, a), under_known_weights(task.robot, b)});
    const double d =
        std::sqrt(Separation(all[0], all[1], MatrixXd(all[0].mean.size(), 0)).squared());
    return fmt::format(
        "one of them is an error of the load cell: apply some of the loads by known weights, or by "
        "another load cell (a session of its own; weights under 'known_loads' in the campaign "
        "file){}",
        a.on_load && b.on_load
            ? "; what both cells agree on is the load"
            : fmt::format(
                  "; these readings under known weights would distinguish them with d' {:.1f}", d));
  }
  if (a.on_sensor || b.on_sensor)
    return "one of them is an error of the instrument: read some of the postures with another "
           "instrument, or another target on the platform";
  if (has(vjm::EffectClass::temperature))
    return "temperature is not in a plan: take the same readings warm and cold, with the column "
           "temperature";
  if (has(vjm::EffectClass::time))
    return "hold a load, and no load, for hours, with the column time";
  if (pair.b + 1 == task.models.size()) return "nothing that is read depends on it";
  if (a.place == b.place)
    return "they do the same to the platform in all postures and under all loads that were tried: "
           "choose either, or read the current or torque of that drive, which differs";
  return "they do the same to the platform in all postures and under all loads that were tried: "
         "measure another point of the robot, between the two places";
}

void add_splits(const PlanTask& task, const Prospects& prospects, Plan& plan) {
  std::vector<Forecast> all = task.forecasts(plan.readings, task.models_for(plan.displacement));
  MatrixXd common = session_unknowns(task.campaign, plan.readings, task.components, all.back());
  whiten(plan.readings, all, common);
  std::map<std::pair<std::size_t, std::size_t>, PlannedSplit> splits;  // both ways in one
  for (std::size_t p = 0; p < task.pairs.size(); ++p) {
    const ModelPair& pair = task.pairs[p];
    const auto [first, second] = std::minmax(pair.a, pair.b);
    const PlanModel &a = task.models[first], &b = task.models[second];
    Separation everything;
    for (const auto& block : prospects.separations)
      if (!block.empty()) everything += block[p];
    const auto [found, fresh] =
        splits.emplace(std::pair(first, second),
                       PlannedSplit{.a = a.name, .b = b.name, .so_far = {}, .advice = {}});
    PlannedSplit& split = found->second;
    const double separation = std::sqrt(separation_of(pair, all, common).squared());
    const double most = std::max(separation, std::sqrt(everything.squared()));
    split.separation = fresh ? separation : std::min(split.separation, separation);
    split.most = fresh ? most : std::min(split.most, most);
    split.nats = split.separation * split.separation / 2;
    if (a.log_evidence && b.log_evidence) split.so_far = *a.log_evidence - *b.log_evidence;
    const bool by_weights = a.on_load != b.on_load && split.separation < discriminable_from;
    if ((split.most < unsplit || by_weights) && split.advice.empty())
      split.advice = advice_for(task, pair, plan.readings);
  }
  // An effect that is not observable at all need not be distinguished from others, too.
  const std::size_t nothing = task.models.size() - 1;
  std::set<std::size_t> unshown;
  for (const auto& [key, split] : splits)
    if (key.second == nothing && split.most < unsplit) unshown.insert(key.first);
  for (auto& [key, split] : splits)
    if (key.second == nothing || !(unshown.contains(key.first) || unshown.contains(key.second)))
      plan.splits.push_back(std::move(split));
  std::stable_sort(plan.splits.begin(), plan.splits.end(),
                   [](const auto& x, const auto& y) { return x.separation < y.separation; });
}

// Whether the load cell's errors are all that is asked for, and readings of it do not tell them.
bool only_weights_tell(const PlanTask& task, const Batch& batch, const Prospects& prospects) {
  for (std::size_t m = 0; m + 1 < task.models.size(); ++m)
    if (!task.models[m].is_look_alike && !task.models[m].on_load) return false;
  return mistakes_left(task, batch, prospects) > 0.9 * mistakes_left(task, {}, prospects);
}

// The same with loads by known weights, over a pulley or not: forces that do not change sign.
PlanTask with_known_weights(PlanTask task) {
  for (PlanModel& model : task.models) model = under_known_weights(task.robot, std::move(model));
  std::erase_if(task.choices.blocks, [](const PlanBlock& block) {
    return !block.load.tail<3>().isZero(0) || block.pattern->reverses();
  });
  return task;
}

constexpr double least_gain = 0.1;  // of the chance of an answer: less is not worth the time

// What the batch promises, in the probability of the verdict; nothing is asked for that hardly
// changes it.
void weigh_promise(const PlanTask& task, const Prospects& prospects, double in_catalogue,
                   Batch& batch, Plan& plan) {
  if (batch.blocks.empty()) return;
  const double now = in_catalogue * chance_of_answer(task, {}, prospects);
  const double then = in_catalogue * chance_of_answer(task, batch, prospects);
  const std::string chances = fmt::format(
      "Chance that the verdict is one answer, and the true one, as far as the candidates hold it: "
      "{:.0f} % now, {:.0f} % after {:.0f} min.",
      100 * now, 100 * then, batch.minutes);
  if (then - now >= least_gain) {
    plan.notes.push_back(chances);
    return;
  }
  plan.notes.push_back(chances + " That is not worth the time.");
  plan.asks_for_absolute = plan.asks_for_weights = false;
  batch = {};
}

void plan_split(const PlanTask& task, double in_catalogue, Plan& plan) {
  Prospects prospects = prospects_of(task, plan.displacement);
  Batch batch = split(task, prospects, false);
  if (plan.displacement == DisplacementKind::difference) {
    // What cancels in differences shows in poses.
    Prospects absolute = prospects_of(task, DisplacementKind::absolute);
    Batch other = split(task, absolute, true);
    const double before = mistakes_left(task, {}, prospects);
    const double left = mistakes_left(task, batch, prospects);
    const double left_by_poses = mistakes_left(task, other, absolute);
    const double more =
        chance_of_answer(task, other, absolute) - chance_of_answer(task, batch, prospects);
    if (left > 0.02 * before && left_by_poses < 0.8 * left && more > 0.05) {
      plan.displacement = DisplacementKind::absolute;
      plan.asks_for_absolute = true;
      prospects = std::move(absolute);
      batch = std::move(other);
    }
  }
  if (only_weights_tell(task, batch, prospects)) {
    const PlanTask weights = with_known_weights(task);
    const Prospects by_weights = prospects_of(weights, plan.displacement);
    Batch other = split(weights, by_weights, false);
    if (mistakes_left(weights, other, by_weights) < 0.8 * mistakes_left(task, batch, prospects)) {
      plan.asks_for_weights = true;
      weigh_promise(weights, by_weights, in_catalogue, other, plan);
      arrange(weights, other, plan);
      add_splits(weights, by_weights, plan);
      return;
    }
  }
  weigh_promise(task, prospects, in_catalogue, batch, plan);
  arrange(task, batch, plan);
  add_splits(task, prospects, plan);
  const bool all_apart = std::all_of(
      plan.splits.begin(), plan.splits.end(),
      [&](const PlannedSplit& split) { return split.separation >= task.options.wanted; });
  if (!plan.blocks.empty() && !all_apart && plan.minutes < 0.9 * task.options.minutes)
    plan.notes.push_back(fmt::format(
        "After {:.0f} min nothing more comes from readings of this kind.", plan.minutes));
}

// Without any noise no reading weighs anything: the only thing to do is to repeat.
void plan_replicates(const PlanTask& task, Plan& plan) {
  Batch batch;
  const auto& blocks = task.choices.blocks;
  const auto& pattern = load_patterns()[1];
  std::set<std::size_t> postures;
  for (std::size_t b = 0; b < blocks.size() && postures.size() < 3; ++b) {
    if (blocks[b].pattern != &pattern || !postures.insert(blocks[b].configuration).second) continue;
    for (int run = 0; run < most_runs; ++run) {
      batch.blocks.push_back(b);
      batch.why.emplace_back("repeated: nothing else shows how exact the readings are");
    }
    batch.minutes += task.options.measuring.minutes_per_pose + most_runs * blocks[b].minutes;
  }
  arrange(task, batch, plan);
}

bool is_friction(const PlanModel& model) {
  return model.effect_class == vjm::EffectClass::friction && !model.is_look_alike;
}

// Friction is not named before some load has been taken back, whatever else may tell it: until then
// how well its law fits is no evidence.
void leave_out_one_way(PlanTask& task) {
  if (std::none_of(task.models.begin(), task.models.end(), is_friction)) return;
  if (takes_loads_back(task.campaign)) return;
  std::erase_if(task.choices.blocks,
                [](const PlanBlock& block) { return !block.pattern->takes_back(); });
  for (std::size_t m = 0; m + 1 < task.models.size(); ++m)
    if (!task.models[m].is_look_alike) task.models[m].weight = 1;
}

// Of what else is unseen, the models that some of the readings to choose from could take for a
// candidate: those without load and those under loads that come and go, at every posture.
void choose_look_alikes(PlanTask& task) {
  if (std::none_of(task.models.begin(), task.models.end(),
                   [](const PlanModel& model) { return model.is_look_alike; }))
    return;
  std::vector<PlanBlock> sample;
  for (const PlanBlock& block : task.choices.blocks)
    if (block.pattern == &load_patterns()[1] || block.direction.empty()) sample.push_back(block);
  const Campaign readings =
      task.readings(DisplacementKind::absolute, sample, task.options.minutes / 2);
  const std::vector<Forecast> all =
      task.forecasts(readings, task.models_for(DisplacementKind::absolute));
  task.models = with_look_alikes(
      task.models, all, session_unknowns(task.campaign, readings, task.components, all.back()));
}

// Joints where something may be missing.
std::vector<std::string> joints_in(const PlanQuestion& question) {
  std::vector<std::string> joints;
  for (const OpenCandidate& open : question.open) {
    const vjm::Effect& effect = open.candidate.effect;
    if (effect.kind->place == vjm::EffectPlace::joint &&
        std::find(joints.begin(), joints.end(), effect.at) == joints.end())
      joints.push_back(effect.at);
  }
  constexpr std::size_t most = 3;
  if (joints.size() > most) joints.resize(most);
  return joints;
}

void require_choices(const PlanTask& task) {
  if (!task.choices.blocks.empty()) return;
  throw common::NotIdentifiable(
      "there is nothing to choose from: no posture of the campaign can be reached");
}

// What is planned is counted from unloaded readings as exact as those before.
Campaign with_datums_of(const Noise& noise, Campaign campaign) {
  for (const Datum& datum : noise.datums)
    for (Eigen::Index k = 0; k < datum.sigma.size(); ++k)
      if (!(campaign.datum_noise[k] <= datum.sigma[k])) campaign.datum_noise[k] = datum.sigma[k];
  return campaign;
}

}  // namespace

Plan plan(const vjm::Robot& robot, const Campaign& campaign, const PlanQuestion& question,
          const PlanOptions& options, int threads, common::Progress& progress) {
  if (campaign.control)
    throw common::InputError(
        {.file = campaign.file,
         .key = "displacement_control",
         .what = "'plan' proposes loads, and here displacements are set",
         .cure =
             "Plan by a campaign that states loads, and set the displacements that they cause"});
  Noise noise = noise_of(campaign, replicate_groups(campaign));
  if (noise.source != NoiseSource::unknown) noise = noise_of(robot, campaign, threads, progress);
  const Campaign as_seen = with_datums_of(noise, campaign);
  PlanTask task{robot, as_seen, options, threads, progress, {}, {}, {}, {}, {}};
  task.choices =
      plan_choices(robot, campaign, {.work_at = options.work_at, .joints = joints_in(question)},
                   options.measuring, threads, progress);
  require_choices(task);
  Plan plan;
  plan.displacement = campaign.displacement;
  plan.work_before = plan.work_after = std::numeric_limits<double>::quiet_NaN();
  plan.has_replicates = has_replicates(campaign);
  for (const std::string& choice : task.choices.left_out)
    plan.notes.push_back("Left out: " + choice);
  task.sigma = usual_noise(campaign, noise);
  task.components = components_of(task.sigma);
  if (noise.source == NoiseSource::unknown) {
    plan_replicates(task, plan);
    return plan;
  }
  if (question.in_catalogue < least_gain) {
    plan.notes.push_back(
        fmt::format("What is missing is an effect of the catalogue with a probability of {:.2g} % "
                    "only: readings "
                    "that distinguish its effects would not find it.",
                    100 * question.in_catalogue));
    return plan;
  }
  task.models = plan_models(robot, campaign, noise, question, threads, progress);
  choose_look_alikes(task);
  leave_out_one_way(task);
  task.pairs = pairs_of(task.models, question.perhaps_nothing);
  if (!task.pairs.empty()) {
    plan_split(task, question.in_catalogue, plan);
  } else if (question.in_catalogue < 1) {
    plan.notes.emplace_back(
        "Something is left that the nearest effect does not explain: readings that sharpen that "
        "one "
        "would not find the rest.");
  } else if (task.models.back().root.cols() == 0) {
    throw common::NotIdentifiable(
        "no candidate is left, and nothing in the model is uncertain: there is nothing to sharpen. "
        "Declare parameters under 'uncertain' in the robot file, or name effects that the next "
        "readings shall show with --show");
  } else {
    arrange(task, sharpen(task, prospects_of(task, plan.displacement), plan), plan);
  }
  if (plan.blocks.empty())
    plan.notes.emplace_back("No readings of this kind within the time would change what is known.");
  return plan;
}

}  // namespace kinetostat::calibration
