#include "kinetostat/calibration/design/plan_choice.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include <fmt/format.h>

#include "kinetostat/calibration/campaign/datum.h"
#include "kinetostat/calibration/campaign/noise_estimate.h"
#include "kinetostat/calibration/diagnosis/decision.h"
#include "kinetostat/calibration/search/ranking.h"
#include "kinetostat/common/parallel.h"

namespace kinetostat::calibration {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

constexpr std::size_t most_blocks = 60;
constexpr double sure_enough = 0.95;  // chance of an answer with which a batch is complete
constexpr double hopeless = 0.25;     // chance below which two models are not worth the time

// Bound of the chance to mistake one model of a pair for the other.
double mistaken(double squared_separation) { return std::exp(-squared_separation / 8); }

double normal_distribution(double x) { return 0.5 * std::erfc(-x / std::numbers::sqrt2); }

// Chance that readings which separate the true model by d' from the others, now together 1 / `odds`
// times as probable, give it the level of a verdict: log evidence grows by d'^2/2 +- d', and a
// verdict counts a share of it.
double chance_of_level(double odds, double separation) {
  const DecisionRules rules;
  const double wanted = std::log(rules.level / (1 - rules.level) / odds) / rules.exponent;
  if (separation == 0) return wanted <= 0 ? 1 : 0;
  return normal_distribution(separation / 2 - wanted / separation);
}

// Rows of one block of a forecast.
Forecast rows_of(const Forecast& forecast, Index first, Index count) {
  return {forecast.mean.segment(first, count), forecast.spread.middleRows(first, count),
          forecast.forms.middleRows(first, count)};
}

// On all that a model leaves unknown, and on what the session brings along.
MatrixXd information(const Forecast& forecast, const MatrixXd& common) {
  MatrixXd unknown(forecast.mean.size(),
                   forecast.spread.cols() + forecast.forms.cols() + common.cols());
  unknown << forecast.spread, forecast.forms, common;
  return unknown.transpose() * unknown;
}

// Separations of all pairs by some blocks, and the chance of a wrong name that is left.
class State {
 public:
  State(const PlanTask& task, const Prospects& prospects)
      : task_(&task), prospects_(&prospects), separations_(task.pairs.size()) {}

  double separation(std::size_t pair) const { return std::sqrt(separations_[pair].squared()); }
  double mistakes() const {
    double sum = 0;
    for (std::size_t p = 0; p < separations_.size(); ++p)
      sum += task_->pairs[p].weight * mistaken(separations_[p].squared());
    return sum;
  }
  // That the verdict then is one answer, the true one, by the pair that is worst for each model; of
  // all pairs, or of those that are not given up.
  double chance_of_answer(bool with_given_up) const {
    std::vector<double> least(task_->models.size(), 1);
    double all = 0, sum = 0;
    for (std::size_t p = 0; p < separations_.size(); ++p) {
      const ModelPair& pair = task_->pairs[p];
      if (pair.weight == 0 && !with_given_up) continue;
      for (const std::size_t truth : {pair.a, pair.b})
        least[truth] = std::min(least[truth], chance_of(p, truth));
    }
    for (std::size_t m = 0; m < least.size(); ++m) {
      if (task_->models[m].is_look_alike || !is_paired(m)) continue;
      all += task_->models[m].weight;
      sum += task_->models[m].weight * least[m];
    }
    return all > 0 ? sum / all : 1;
  }
  // Of the likelier of the two distinguished from the other, if it is true.
  double chance(std::size_t pair) const {
    const ModelPair& models = task_->pairs[pair];
    return std::max(chance_of(pair, models.a), chance_of(pair, models.b));
  }
  State with(const std::vector<std::size_t>& blocks) const {
    State next = *this;
    for (const std::size_t b : blocks)
      for (std::size_t p = 0; p < separations_.size(); ++p)
        next.separations_[p] += prospects_->separations[b][p];
    return next;
  }
  /// Of a batch without one of its postures.
  State without(const Batch& batch, std::size_t posture) const {
    std::vector<std::size_t> kept;
    for (const std::size_t b : batch.blocks)
      if (task_->choices.blocks[b].configuration != posture) kept.push_back(b);
    return State(*task_, *prospects_).with(kept);
  }

 private:
  // As if all others were as near to the truth as the other of the pair.
  double chance_of(std::size_t pair, std::size_t truth) const {
    double others = 0;
    for (std::size_t m = 0; m < task_->models.size(); ++m)
      if (m != truth && !task_->models[m].is_look_alike) others += task_->models[m].weight;
    return chance_of_level(task_->models[truth].weight / others, separation(pair));
  }
  bool is_paired(std::size_t model) const {
    return std::any_of(task_->pairs.begin(), task_->pairs.end(), [model](const ModelPair& pair) {
      return pair.a == model || pair.b == model;
    });
  }

  const PlanTask* task_;
  const Prospects* prospects_;
  std::vector<Separation> separations_;
};

class Splitter {
 public:
  Splitter(const PlanTask& task, const Prospects& prospects)
      : task_(task), prospects_(prospects), chooser_(task), state_(task, prospects) {}

  // Until the pairs are apart, or the rest of the time would bring next to nothing.
  void distinguish() {
    while (least_of(state_, 0) < task_.options.wanted &&
           state_.chance_of_answer(false) < sure_enough) {
      const std::vector<std::size_t> next = best_beside(state_, {});
      if (next.empty() || is_idle(next)) break;
      take(next, what_falls(state_, state_.with(next)));
    }
  }

  // The last cycles are left out, as far as the verdict hardly needs them.
  void shorten() {
    constexpr double hardly = 0.03;  // of the chance of an answer
    const Batch& batch = chooser_.batch();
    const double whole = state_.chance_of_answer(false);
    State state(task_, prospects_);
    std::size_t count = 0;
    while (count < batch.blocks.size() && state.chance_of_answer(false) < whole - hardly)
      state = state.with({batch.blocks[count++]});
    chooser_.keep_first(count);
    state_ = state;
  }

  // Postures without load that tell something together only, as in a frame that is not known; best
  // taken before any that tells a little by itself.
  void take_together() {
    const std::vector<std::size_t> next = best_together(state_, {}, 1e-4 * state_.mistakes());
    if (!next.empty() && !is_idle(next)) take(next, what_falls(state_, state_.with(next)));
  }

  double mistakes() const { return state_.mistakes(); }
  double chance(std::size_t pair) const { return state_.chance(pair); }

  // One posture may have been read wrongly.
  void distinguish_without_any_posture() {
    serve_worst_posture([&](std::size_t posture) {
      const State state = state_.without(chooser_.batch(), posture);
      if (least_of(state, discriminable_from) >= discriminable_from) return Need{};
      const std::vector<std::size_t> next = best_beside(state, posture);
      if (next.empty()) return Need{};
      return Need{discriminable_from / least_of(state, discriminable_from), next,
                  what_falls(state, state.with(next)) + ", without another posture"};
    });
  }

  // A fit is tested by postures that it has not seen: what a candidate leaves unknown must be known
  // without each.
  void predict_any_posture() {
    constexpr double exact = 1;  // mean variance of what is predicted, over that of the noise
    serve_worst_posture([&](std::size_t posture) {
      Need worst;
      for (std::size_t s = 0; s < prospects_.information[chooser_.batch().blocks[0]].size(); ++s) {
        const LeftOut left_out = leave_out(posture, s);
        const double before = left_out.unsure(left_out.others);
        if (before <= std::max(exact, worst.size)) continue;
        const auto best = chooser_.best(gains_elsewhere(posture,
                                                        [&](std::size_t b) {
                                                          Knowledge next = left_out.others;
                                                          next.add(prospects_.information[b][s]);
                                                          return before - left_out.unsure(next);
                                                        }),
                                        0.05 * before);
        if (best)
          worst = {before, {*best}, "the fitted parameters are known without another posture"};
      }
      return worst;
    });
  }

  const Batch& batch() const { return chooser_.batch(); }

 private:
  // What a posture lacks that is left out, and what would bring it. Nothing: it lacks nothing.
  struct Need {
    double size = 0;
    std::vector<std::size_t> blocks = {};
    std::string why = {};
  };

  // What the other postures know of a candidate, and what that means for one that is left out.
  struct LeftOut {
    Knowledge others;
    MatrixXd here;
    double values = 0;

    double unsure(const Knowledge& k) const {
      return k.covariance().cwiseProduct(here).sum() / values;
    }
  };
  LeftOut leave_out(std::size_t posture, std::size_t candidate) const {
    const Index n = prospects_.information[chooser_.batch().blocks[0]][candidate].rows();
    LeftOut result{Knowledge(n), MatrixXd::Zero(n, n)};
    for (const std::size_t b : chooser_.batch().blocks) {
      const MatrixXd& of_block = prospects_.information[b][candidate];
      const PlanBlock& block = task_.choices.blocks[b];
      if (block.configuration != posture) {
        result.others.add(of_block);
        continue;
      }
      result.here += of_block;
      result.values += static_cast<double>(block.pattern->steps.size() * task_.components.size());
    }
    return result;
  }

  // Serves the largest need of all postures until there is none.
  template <class NeedOf>
  void serve_worst_posture(const NeedOf& need_of) {
    while (true) {
      Need worst;
      for (const std::size_t posture : chooser_.postures())
        if (Need need = need_of(posture); need.size > worst.size) worst = std::move(need);
      if (worst.blocks.empty()) return;
      take(worst.blocks, worst.why);
    }
  }

  // Gains of all blocks that are possible, at any posture but one.
  template <class GainOf>
  std::vector<double> gains_elsewhere(std::optional<std::size_t> posture,
                                      const GainOf& gain_of) const {
    std::vector<double> gains(prospects_.separations.size());
    common::parallel_for(
        gains.size(), task_.threads, "what to measure", task_.progress, [&](std::size_t b) {
          if (prospects_.separations[b].empty() || !std::isfinite(chooser_.cost(b)) ||
              posture == task_.choices.blocks[b].configuration)
            return;
          gains[b] = gain_of(b);
        });
    return gains;
  }

  // Of those pairs that the batch as a whole distinguishes so well.
  double least_of(const State& state, double by_all) const {
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t p = 0; p < task_.pairs.size(); ++p)
      if (task_.pairs[p].weight > 0 && state_.separation(p) >= by_all)
        least = std::min(least, state.separation(p));
    return least;
  }

  // All the time that is left, spent as well as on these blocks, would hardly lessen the mistakes.
  bool is_idle(const std::vector<std::size_t>& next) const {
    constexpr double hardly = 0.1;
    const double before = state_.mistakes(), gain = before - state_.with(next).mistakes();
    const double left = task_.options.minutes - chooser_.batch().minutes;
    return gain * left < hardly * before * chooser_.cost(next);
  }

  // The block with the largest gain per minute, at any posture but one; else several postures.
  std::vector<std::size_t> best_beside(const State& state,
                                       std::optional<std::size_t> posture) const {
    const double before = state.mistakes(), least = 1e-4 * before;
    const auto gains = gains_elsewhere(
        posture, [&](std::size_t b) { return before - state.with({b}).mistakes(); });
    if (const auto best = chooser_.best(gains, least)) return {*best};
    return best_together(state, posture, least);
  }

  // Where no cycle tells anything by itself, as one or two postures say nothing in a frame that is
  // not known: the two or three postures without load that do together, by their gain per minute.
  std::vector<std::size_t> best_together(const State& state, std::optional<std::size_t> posture,
                                         double least) const {
    const std::vector<std::vector<std::size_t>> sets = unloaded_sets(posture);
    const double before = state.mistakes();
    std::vector<double> rates(sets.size());
    common::parallel_for(sets.size(), task_.threads, "what to measure together", task_.progress,
                         [&](std::size_t s) {
                           const double cost = chooser_.cost(sets[s]);
                           if (!std::isfinite(cost)) return;
                           const double gain = before - state.with(sets[s]).mistakes();
                           if (gain > least) rates[s] = gain / cost;
                         });
    const auto best = std::max_element(rates.begin(), rates.end());
    if (best == rates.end() || *best <= 0) return {};
    return sets[static_cast<std::size_t>(best - rates.begin())];
  }

  std::vector<std::vector<std::size_t>> unloaded_sets(std::optional<std::size_t> posture) const {
    std::vector<std::size_t> unloaded;
    for (std::size_t b = 0; b < task_.choices.blocks.size(); ++b)
      if (task_.choices.blocks[b].direction.empty() && !prospects_.separations[b].empty() &&
          posture != task_.choices.blocks[b].configuration)
        unloaded.push_back(b);
    std::vector<std::vector<std::size_t>> sets;
    for (std::size_t i = 0; i < unloaded.size(); ++i)
      for (std::size_t j = i + 1; j < unloaded.size(); ++j) {
        sets.push_back({unloaded[i], unloaded[j]});
        for (std::size_t k = j + 1; k < unloaded.size(); ++k)
          sets.push_back({unloaded[i], unloaded[j], unloaded[k]});
      }
    return sets;
  }

  // The pair that is served most.
  std::string what_falls(const State& from, const State& to) const {
    std::size_t most = 0;
    double fall = -1;
    for (std::size_t p = 0; p < task_.pairs.size(); ++p) {
      const double was = from.separation(p), is = to.separation(p);
      const double gain = task_.pairs[p].weight * (mistaken(was * was) - mistaken(is * is));
      if (gain > fall) fall = gain, most = p;
    }
    const ModelPair& pair = task_.pairs[most];
    return fmt::format("{} from {}: d' {:.1f} to {:.1f}", task_.models[pair.a].name,
                       task_.models[pair.b].name, from.separation(most), to.separation(most));
  }

  void take(const std::vector<std::size_t>& blocks, const std::string& why) {
    for (const std::size_t b : blocks)
      chooser_.take(b, blocks.size() == 1
                           ? why
                           : fmt::format("{}, {} postures together", why, blocks.size()));
    state_ = state_.with(blocks);
  }

  const PlanTask& task_;
  const Prospects& prospects_;
  Chooser chooser_;
  State state_;
};

}  // namespace

namespace {

bool are_laws_of_one_answer(const PlanModel& a, const PlanModel& b) {
  return !a.family.empty() && a.family == b.family && a.place == b.place && !b.is_look_alike;
}

std::vector<ModelPair> pairs_of(const std::vector<PlanModel>& models, bool perhaps_nothing,
                                bool with_laws) {
  std::vector<ModelPair> pairs;
  const std::size_t nothing = models.size() - 1;
  for (std::size_t a = 0; a < models.size(); ++a)
    for (std::size_t b = a + 1; b < models.size(); ++b) {
      if (models[a].is_look_alike || (b == nothing && !perhaps_nothing)) continue;
      if (!with_laws && are_laws_of_one_answer(models[a], models[b])) continue;
      const double weight = models[a].weight * models[b].weight;
      pairs.push_back({a, b, models[b].any_size, weight});
      if (models[a].any_size && b != nothing && !models[b].is_look_alike)
        pairs.push_back({b, a, true, weight});
    }
  return pairs;
}

}  // namespace

std::vector<ModelPair> pairs_of(const std::vector<PlanModel>& models, bool perhaps_nothing) {
  std::vector<ModelPair> pairs = pairs_of(models, perhaps_nothing, false);
  return pairs.empty() ? pairs_of(models, perhaps_nothing, true) : pairs;
}

Campaign PlanTask::readings(DisplacementKind kind, const std::vector<PlanBlock>& blocks,
                            std::optional<double> each_at) const {
  return planned_readings(campaign, kind, choices.configurations, blocks, components, sigma,
                          options.measuring, each_at);
}

std::vector<PlanModel> PlanTask::models_for(DisplacementKind kind) const {
  std::vector<PlanModel> result = models;
  if (in_own_campaign(kind))
    for (PlanModel& model : result) model = fitted_alone(std::move(model));
  return result;
}

std::vector<Forecast> PlanTask::forecasts(const Campaign& planned,
                                          const std::vector<PlanModel>& of) const {
  std::vector<Forecast> result;
  for (std::size_t m = 0; m < of.size(); ++m) {
    progress.report("forecasts", static_cast<double>(m) / static_cast<double>(of.size()));
    common::SilentPart silent(progress);
    result.push_back(forecast(robot, of[m], planned, components, threads, silent));
  }
  return result;
}

void whiten(const Campaign& planned, std::vector<Forecast>& all, MatrixXd& common) {
  const SharedNoise shared(noise_of(planned, {}), values_in_use(planned));
  for (Forecast& f : all) {
    shared.whiten(f.mean);
    shared.whiten(f.spread);
    shared.whiten(f.forms);
  }
  shared.whiten(common);
}

Separation separation_of(const ModelPair& pair, const std::vector<Forecast>& all,
                         const MatrixXd& common) {
  return separation_of(all[pair.a], all[pair.b], pair.any_size, all.back(), common);
}

Prospects prospects_of(const PlanTask& task, DisplacementKind kind) {
  const Campaign planned = task.readings(kind, task.choices.blocks, task.options.minutes / 2);
  std::vector<Forecast> all = task.forecasts(planned, task.models_for(kind));
  MatrixXd common = session_unknowns(task.campaign, planned, task.components, all.back());
  whiten(planned, all, common);
  Prospects prospects;
  prospects.separations.resize(task.choices.blocks.size());
  prospects.gains.resize(task.choices.blocks.size());
  prospects.information.resize(task.choices.blocks.size());
  Index first = 0;
  for (std::size_t b = 0; b < task.choices.blocks.size(); ++b) {
    const auto count =
        static_cast<Index>(task.choices.blocks[b].pattern->steps.size() * task.components.size());
    std::vector<Forecast> rows;
    rows.reserve(all.size());
    for (const Forecast& f : all) rows.push_back(rows_of(f, first, count));
    const MatrixXd unknowns = common.middleRows(first, count);
    first += count;
    if (std::any_of(rows.begin(), rows.end(),
                    [](const Forecast& f) { return !f.mean.allFinite(); }))
      continue;
    for (const ModelPair& pair : task.pairs)
      prospects.separations[b].push_back(separation_of(pair, rows, unknowns));
    prospects.gains[b] = Knowledge::gain(rows.back(), unknowns);
    for (std::size_t m = 0; m + 1 < task.models.size(); ++m)
      if (!task.models[m].is_look_alike)
        prospects.information[b].push_back(information(rows[m], unknowns));
  }
  return prospects;
}

double Chooser::cost(std::size_t b) const {
  const PlanBlock& block = task_.choices.blocks[b];
  const double move =
      postures_.contains(block.configuration) ? 0 : task_.options.measuring.minutes_per_pose;
  const double cost = block.minutes + move;
  const bool fits = batch_.minutes + cost <= task_.options.minutes && runs_[b] < most_runs &&
                    batch_.blocks.size() < most_blocks;
  return fits ? cost : std::numeric_limits<double>::infinity();
}

double Chooser::cost(const std::vector<std::size_t>& blocks) const {
  double sum = 0;
  for (const std::size_t b : blocks) sum += cost(b);
  const bool fits = batch_.minutes + sum <= task_.options.minutes &&
                    batch_.blocks.size() + blocks.size() <= most_blocks;
  return fits ? sum : std::numeric_limits<double>::infinity();
}

std::optional<std::size_t> Chooser::best(const std::vector<double>& gains, double least) const {
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

void Chooser::take(std::size_t b, std::string why) {
  batch_.minutes += cost(b);
  ++runs_[b];
  postures_.insert(task_.choices.blocks[b].configuration);
  batch_.blocks.push_back(b);
  batch_.why.push_back(std::move(why));
}

void Chooser::keep_first(std::size_t count) {
  const Batch all = std::exchange(batch_, {});
  postures_.clear();
  std::fill(runs_.begin(), runs_.end(), 0);
  for (std::size_t k = 0; k < count; ++k) take(all.blocks[k], all.why[k]);
}

namespace {

// With and without postures that are taken together first: whichever leaves fewer mistakes, or as
// few in less time.
Splitter distinguished(const PlanTask& task, const Prospects& prospects) {
  Splitter one_by_one(task, prospects), together(task, prospects);
  one_by_one.distinguish();
  together.take_together();
  if (together.batch().blocks.empty()) return one_by_one;
  together.distinguish();
  constexpr double as_few = 1.05;
  const double a = one_by_one.mistakes(), b = together.mistakes();
  const bool quicker = together.batch().minutes < one_by_one.batch().minutes;
  return b * as_few < a || (b < a * as_few && quicker) ? together : one_by_one;
}

// Those that all the time does not distinguish are given up: it is better spent on the others.
bool give_up_hopeless(const Splitter& splitter, PlanTask& task) {
  bool some = false;
  for (std::size_t p = 0; p < task.pairs.size(); ++p) {
    if (task.pairs[p].weight == 0 || splitter.chance(p) >= hopeless) continue;
    task.pairs[p].weight = 0;
    some = true;
  }
  return some;
}

}  // namespace

Batch split(const PlanTask& all, const Prospects& prospects, bool in_own_campaign) {
  PlanTask task = all;
  std::optional<Splitter> splitter(distinguished(task, prospects));
  while (give_up_hopeless(*splitter, task)) {
    if (std::none_of(task.pairs.begin(), task.pairs.end(),
                     [](const ModelPair& pair) { return pair.weight > 0; }))
      return {};
    splitter.emplace(distinguished(task, prospects));
  }
  splitter->shorten();
  if (splitter->batch().blocks.empty()) return {};
  if (in_own_campaign) {
    splitter->distinguish_without_any_posture();
    splitter->predict_any_posture();
  }
  return splitter->batch();
}

double chance_of_answer(const PlanTask& task, const Batch& batch, const Prospects& prospects) {
  return State(task, prospects).with(batch.blocks).chance_of_answer(true);
}

double mistakes_left(const PlanTask& task, const Batch& batch, const Prospects& prospects) {
  return State(task, prospects).with(batch.blocks).mistakes();
}

}  // namespace kinetostat::calibration
