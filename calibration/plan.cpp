#include "kinetostat/calibration/plan.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <set>

#include <fmt/format.h>

#include "kinetostat/calibration/load_history.h"
#include "kinetostat/calibration/plan_models.h"
#include "kinetostat/calibration/wrench_noise.h"
#include "kinetostat/files/error.h"
#include "kinetostat/files/parallel.h"

namespace kinetostat::calibration {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using spatial::Vector6;

constexpr double unsplit = 2;  // d' of all that could be measured: no use to try
constexpr std::size_t most_blocks = 60;
constexpr int most_runs = 3;  // of one block

// Two models: the second may have any size, where nothing is known of it.
struct Pair {
  std::size_t a = 0, b = 0;
  bool any_size = false;
  double weight = 0;
};

// The last model adds nothing: it is one of the rivals, or only what they are compared with. Rivals
// of which nothing is known are paired both ways: each at its usual size with the other at any.
std::vector<Pair> pairs_of(const std::vector<PlanModel>& models, bool perhaps_nothing) {
  std::vector<Pair> pairs;
  const std::size_t nothing = models.size() - 1;
  for (std::size_t a = 0; a < models.size(); ++a)
    for (std::size_t b = a + 1; b < models.size(); ++b) {
      if (b == nothing && !perhaps_nothing) continue;
      const double weight = models[a].weight * models[b].weight;
      pairs.push_back({a, b, models[b].any_size, weight});
      if (models[a].any_size && b != nothing) pairs.push_back({b, a, true, weight});
    }
  return pairs;
}

// Bound of the chance to mistake one model of a pair for the other.
double mistaken(double squared_separation) { return std::exp(-squared_separation / 8); }

// The median standard deviation of each component that is measured at all.
Vector6 usual_noise(const Campaign& campaign, const Noise& noise) {
  Vector6 sigma = Vector6::Constant(std::numeric_limits<double>::quiet_NaN());
  for (Index k = 0; k < 6; ++k) {
    std::vector<double> all;
    for (std::size_t i = 0; i < campaign.readings.size(); ++i)
      if (campaign.readings[i].uses(k)) all.push_back(noise.sigma[i][k]);
    if (all.empty()) continue;
    std::nth_element(all.begin(), all.begin() + std::ssize(all) / 2, all.end());
    sigma[k] = all[all.size() / 2];
  }
  return sigma;
}

std::vector<Index> components_of(const Vector6& sigma) {
  std::vector<Index> components;
  for (Index k = 0; k < 6; ++k)
    if (!std::isnan(sigma[k])) components.push_back(k);
  return components;
}

// What every step of a plan needs.
struct Task {
  const vjm::Robot& robot;
  const Campaign& campaign;
  const PlanOptions& options;
  int threads;
  files::Progress& progress;
  PlanChoices choices;
  Vector6 sigma;
  std::vector<Index> components;
  std::vector<PlanModel> models;
  std::vector<Pair> pairs;

  Campaign readings(DisplacementKind kind, const std::vector<PlanBlock>& blocks,
                    std::optional<double> each_at = {}) const {
    return planned_readings(campaign, kind, choices.configurations, blocks, components, sigma,
                            options.measuring, each_at);
  }
  std::vector<Forecast> forecasts(const Campaign& planned, const std::vector<PlanModel>& of) const {
    std::vector<Forecast> result;
    for (std::size_t m = 0; m < of.size(); ++m) {
      progress.report("forecasts", static_cast<double>(m) / static_cast<double>(of.size()));
      files::Progress silent;
      result.push_back(forecast(robot, of[m], planned, components, threads, silent));
    }
    return result;
  }
};

// How many times its usual size something may be of which nothing is known.
constexpr double any_size = 3;

Separation separation_of(const Pair& pair, const std::vector<Forecast>& all,
                         const MatrixXd& common) {
  if (!pair.any_size) return {all[pair.a], all[pair.b], common};
  MatrixXd unknown(common.rows(), common.cols() + 1);
  unknown << common, any_size * (all[pair.b].mean - all.back().mean);
  return {all[pair.a], all[pair.b], unknown};
}

// Rows of one block of a forecast.
Forecast rows_of(const Forecast& forecast, Index first, Index count) {
  return {forecast.mean.segment(first, count), forecast.spread.middleRows(first, count)};
}

// What every block by itself would tell.
struct Prospects {
  std::vector<std::vector<Separation>> separations;  // block, pair; empty: not possible
  std::vector<MatrixXd> gains;                       // block; of the last model
};

Prospects prospects_of(const Task& task, DisplacementKind kind) {
  const Campaign planned = task.readings(kind, task.choices.blocks, task.options.minutes / 2);
  const std::vector<Forecast> all = task.forecasts(planned, task.models);
  const MatrixXd common =
      session_unknowns(task.campaign, planned, task.components, all.back().mean);
  Prospects prospects;
  prospects.separations.resize(task.choices.blocks.size());
  prospects.gains.resize(task.choices.blocks.size());
  Index first = 0;
  for (std::size_t b = 0; b < task.choices.blocks.size(); ++b) {
    const auto count =
        static_cast<Index>(task.choices.blocks[b].pattern->steps.size() * task.components.size());
    std::vector<Forecast> rows;
    for (const Forecast& f : all) rows.push_back(rows_of(f, first, count));
    const MatrixXd unknowns = common.middleRows(first, count);
    first += count;
    if (std::any_of(rows.begin(), rows.end(),
                    [](const Forecast& f) { return !f.mean.allFinite(); }))
      continue;
    for (const Pair& pair : task.pairs)
      prospects.separations[b].push_back(separation_of(pair, rows, unknowns));
    prospects.gains[b] = Knowledge::gain(rows.back(), unknowns);
  }
  return prospects;
}

// Blocks chosen one after the other, and what each was chosen for.
struct Batch {
  std::vector<std::size_t> blocks;  // in choices
  std::vector<std::string> why;
  double minutes = 0;
};

// Greedy choice by a gain per minute.
class Chooser {
 public:
  explicit Chooser(const Task& task) : task_(task), runs_(task.choices.blocks.size()) {}

  /// Cost of a block now [min]; infinite when it does not fit in any more.
  double cost(std::size_t b) const {
    const PlanBlock& block = task_.choices.blocks[b];
    const double move =
        postures_.contains(block.configuration) ? 0 : task_.options.measuring.minutes_per_pose;
    const double cost = block.minutes + move;
    const bool fits = batch_.minutes + cost <= task_.options.minutes && runs_[b] < most_runs &&
                      batch_.blocks.size() < most_blocks;
    return fits ? cost : std::numeric_limits<double>::infinity();
  }
  /// The block with the largest gain per minute; none where no gain is above `least`.
  std::optional<std::size_t> best(const std::vector<double>& gains, double least) const {
    std::optional<std::size_t> best;
    double most = 0;
    for (std::size_t b = 0; b < gains.size(); ++b) {
      const double rate = gains[b] / cost(b);
      if (gains[b] <= least || !(rate > most * (1 + 1e-9))) continue;
      most = rate;
      best = b;
    }
    return best;
  }
  void take(std::size_t b, std::string why) {
    batch_.minutes += cost(b);
    ++runs_[b];
    postures_.insert(task_.choices.blocks[b].configuration);
    batch_.blocks.push_back(b);
    batch_.why.push_back(std::move(why));
  }
  const Batch& batch() const { return batch_; }

 private:
  const Task& task_;
  std::vector<int> runs_;
  std::set<std::size_t> postures_;
  Batch batch_;
};

// Separations of all pairs, and the chance of a wrong name that is left.
struct State {
  std::vector<Separation> separations;

  double mistakes(const std::vector<Pair>& pairs) const {
    double sum = 0;
    for (std::size_t p = 0; p < pairs.size(); ++p)
      sum += pairs[p].weight * mistaken(separations[p].squared());
    return sum;
  }
};

Batch split(const Task& task, const Prospects& prospects) {
  const std::vector<Pair>& pairs = task.pairs;
  Chooser chooser(task);
  State state{std::vector<Separation>(pairs.size())};
  std::vector<double> gains(prospects.separations.size());
  const auto done = [&] {
    return std::all_of(state.separations.begin(), state.separations.end(),
                       [&](const Separation& s) {
                         return s.squared() >= task.options.wanted * task.options.wanted;
                       });
  };
  while (!done()) {
    const double before = state.mistakes(pairs);
    files::parallel_for(gains.size(), task.threads, "what to measure", task.progress,
                        [&](std::size_t b) {
                          gains[b] = 0;
                          if (prospects.separations[b].empty() || !std::isfinite(chooser.cost(b)))
                            return;
                          State next = state;
                          for (std::size_t p = 0; p < pairs.size(); ++p)
                            next.separations[p] += prospects.separations[b][p];
                          gains[b] = before - next.mistakes(pairs);
                        });
    const auto best = chooser.best(gains, 1e-4 * before);
    if (!best) break;
    std::size_t most = 0;
    double fall = -1, from = 0, to = 0;
    for (std::size_t p = 0; p < pairs.size(); ++p) {
      const double was = state.separations[p].squared();
      state.separations[p] += prospects.separations[*best][p];
      const double is = state.separations[p].squared();
      const double gain = pairs[p].weight * (mistaken(was) - mistaken(is));
      if (gain > fall) fall = gain, most = p, from = was, to = is;
    }
    chooser.take(*best,
                 fmt::format("{} from {}: d' {:.1f} to {:.1f}", task.models[pairs[most].a].name,
                             task.models[pairs[most].b].name, std::sqrt(from), std::sqrt(to)));
  }
  return chooser.batch();
}

// Postures and loads where the model is used, as readings that nobody takes.
MatrixXd work_spread(const Task& task) {
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
  const Campaign work =
      planned_readings(task.campaign, task.campaign.displacement, places.configurations, blocks,
                       translations, Vector6::Ones(), task.options.measuring);
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

Batch sharpen(const Task& task, const Prospects& prospects, Plan& plan) {
  const PlanModel& model = task.models.back();
  const MatrixXd spread = work_spread(task);
  Knowledge knowledge(model.root.cols());
  plan.work_before = rms_of(knowledge.mean_square(spread));
  Chooser chooser(task);
  std::vector<double> gains(prospects.gains.size());
  while (true) {
    const double before = knowledge.mean_square(spread);
    files::parallel_for(gains.size(), task.threads, "what to measure", task.progress,
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
void arrange(const Task& task, const Batch& batch, Plan& plan) {
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
std::string advice_for(const Task& task, const Pair& pair, const Campaign& readings) {
  const PlanModel &a = task.models[pair.a], &b = task.models[pair.b];
  const auto has = [&](const char* kind) {
    return a.name.starts_with(kind) || b.name.starts_with(kind);
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
                  "; these readings under known weights would tell them apart with d' {:.1f}", d));
  }
  if (a.on_sensor || b.on_sensor)
    return "one of them is an error of the instrument: read some of the postures with another "
           "instrument, or another target on the platform";
  if (has("thermal_expansion"))
    return "temperature is not in a plan: take the same readings warm and cold, with the column "
           "temperature";
  if (has("creep") || has("session_drift"))
    return "hold a load, and no load, for hours, with the column time";
  return "they do the same to the platform in all postures and under all loads that were tried: "
         "measure another point of the robot, between the two places";
}

void add_splits(const Task& task, const Prospects& prospects, Plan& plan) {
  const std::vector<Forecast> all = task.forecasts(plan.readings, task.models);
  const MatrixXd common =
      session_unknowns(task.campaign, plan.readings, task.components, all.back().mean);
  std::map<std::pair<std::size_t, std::size_t>, PlannedSplit> splits;  // both ways in one
  for (std::size_t p = 0; p < task.pairs.size(); ++p) {
    const Pair& pair = task.pairs[p];
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
    if (split.most < unsplit && split.advice.empty())
      split.advice = advice_for(task, pair, plan.readings);
  }
  for (auto& [key, split] : splits) plan.splits.push_back(std::move(split));
  std::stable_sort(plan.splits.begin(), plan.splits.end(),
                   [](const auto& x, const auto& y) { return x.separation < y.separation; });
}

double mistakes_of(const Task& task, const Batch& batch, const Prospects& prospects) {
  State state{std::vector<Separation>(task.pairs.size())};
  for (const std::size_t b : batch.blocks)
    for (std::size_t p = 0; p < task.pairs.size(); ++p)
      state.separations[p] += prospects.separations[b][p];
  return state.mistakes(task.pairs);
}

void plan_split(const Task& task, Plan& plan) {
  Prospects prospects = prospects_of(task, plan.displacement);
  Batch batch = split(task, prospects);
  if (plan.displacement == DisplacementKind::difference) {
    // What cancels in differences shows in poses.
    Prospects absolute = prospects_of(task, DisplacementKind::absolute);
    Batch other = split(task, absolute);
    const double before = mistakes_of(task, {}, prospects);
    const double left = mistakes_of(task, batch, prospects);
    const double left_by_poses = mistakes_of(task, other, absolute);
    if (left > 0.02 * before && left_by_poses < 0.8 * left) {
      plan.displacement = DisplacementKind::absolute;
      plan.asks_for_absolute = true;
      prospects = std::move(absolute);
      batch = std::move(other);
    }
  }
  arrange(task, batch, plan);
  add_splits(task, prospects, plan);
}

// Without any noise no reading weighs anything: the only thing to do is to repeat.
void plan_replicates(const Task& task, Plan& plan) {
  Batch batch;
  const auto& blocks = task.choices.blocks;
  const auto& pattern = load_patterns()[1];
  std::set<std::size_t> postures;
  for (std::size_t b = 0; b < blocks.size() && postures.size() < 3; ++b) {
    if (blocks[b].pattern != &pattern || !postures.insert(blocks[b].configuration).second) continue;
    for (int run = 0; run < most_runs; ++run) {
      batch.blocks.push_back(b);
      batch.why.emplace_back("repeated: nothing else tells how exact the readings are");
    }
    batch.minutes += task.options.measuring.minutes_per_pose + most_runs * blocks[b].minutes;
  }
  arrange(task, batch, plan);
}

bool is_friction(const PlanModel& model) { return model.name.starts_with("friction at "); }

// Friction is not named before some load has been taken back, whatever else may tell it.
void leave_out_one_way(Task& task) {
  if (std::none_of(task.models.begin(), task.models.end(), is_friction)) return;
  if (takes_loads_back(task.campaign)) return;
  std::erase_if(task.choices.blocks,
                [](const PlanBlock& block) { return !block.pattern->takes_back(); });
}

void require_choices(const Task& task) {
  if (!task.choices.blocks.empty()) return;
  throw files::NotIdentifiable(
      "there is nothing to choose from: no posture of the campaign can be reached");
}

}  // namespace

Plan plan(const vjm::Robot& robot, const Campaign& campaign, const PlanQuestion& question,
          const PlanOptions& options, int threads, files::Progress& progress) {
  Noise noise = noise_of(campaign, replicate_groups(campaign));
  Task task{robot, campaign, options, threads, progress, {}, {}, {}, {}, {}};
  task.choices =
      plan_choices(robot, campaign, options.work_at, options.measuring, threads, progress);
  require_choices(task);
  Plan plan;
  plan.displacement = campaign.displacement;
  plan.work_before = plan.work_after = std::numeric_limits<double>::quiet_NaN();
  plan.has_replicates = has_replicates(campaign);
  plan.notes = task.choices.left_out;
  if (noise.source != NoiseSource::unknown) noise = noise_of(robot, campaign, threads, progress);
  task.sigma = usual_noise(campaign, noise);
  task.components = components_of(task.sigma);
  if (noise.source == NoiseSource::unknown) {
    plan_replicates(task, plan);
    return plan;
  }
  task.models = plan_models(robot, campaign, noise, question, threads, progress);
  task.pairs = pairs_of(task.models, question.perhaps_nothing);
  if (!task.pairs.empty()) {
    leave_out_one_way(task);
    plan_split(task, plan);
  } else if (task.models.back().root.cols() == 0) {
    throw files::NotIdentifiable(
        "no rival is left, and nothing in the model is uncertain: there is nothing to sharpen. "
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
