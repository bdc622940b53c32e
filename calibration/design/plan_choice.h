// The choice of load cycles for a plan: the information that each would give, and which to take.
#pragma once

#include <limits>
#include <set>
#include <string>
#include <vector>

#include "kinetostat/calibration/design/discrimination.h"
#include "kinetostat/calibration/design/plan_models.h"
#include "kinetostat/calibration/design/plan_options.h"

namespace kinetostat::calibration {

/// Two models: the second may have any size, where nothing is known of it.
struct ModelPair {
  std::size_t a = 0, b = 0;
  bool any_size = false;
  double weight = 0;
};

/// The last model adds nothing: it is one of the candidates, or only what they are compared with.
/// Candidates of which nothing is known are paired both ways: each at its usual size with the other
/// at any. A confounder of a candidate is paired with the candidates. Laws of one class at one
/// place are paired only where there is nothing else to distinguish.
std::vector<ModelPair> pairs_of(const std::vector<PlanModel>& models, bool perhaps_nothing);

/// Inputs of every step of a plan.
struct PlanTask {
  const vjm::Robot& robot;
  const Campaign& campaign;
  const PlanOptions& options;
  int threads;
  common::Progress& progress;
  PlanChoices choices;
  Eigen::VectorXd sigma;
  std::vector<Eigen::Index> components;
  std::vector<PlanModel> models;
  std::vector<ModelPair> pairs;

  Campaign readings(DisplacementKind kind, const std::vector<PlanBlock>& blocks,
                    std::optional<double> each_at = {}) const;
  /// Absolute readings after differences are a campaign of their own, in which what is uncertain is
  /// fitted.
  bool in_own_campaign(DisplacementKind kind) const { return kind != campaign.displacement; }
  std::vector<PlanModel> models_for(DisplacementKind kind) const;
  std::vector<Forecast> forecasts(const Campaign& planned, const std::vector<PlanModel>& of) const;
};

/// Takes what planned readings share by their datums out of forecasts of them and of the unknowns
/// of their session.
void whiten(const Campaign& planned, std::vector<Forecast>& all, Eigen::MatrixXd& common);

Separation separation_of(const ModelPair& pair, const std::vector<Forecast>& all,
                         const Eigen::MatrixXd& common);

/// Information that every block would give by itself.
struct Prospects {
  std::vector<std::vector<Separation>> separations;  // block, pair; empty: not possible
  std::vector<Eigen::MatrixXd> gains;                // block; of the last model
  /// Block, candidate: information [as Knowledge has it] on all that the candidate leaves unknown
  /// and on what the session brings along.
  std::vector<std::vector<Eigen::MatrixXd>> information;
};
Prospects prospects_of(const PlanTask& task, DisplacementKind kind);

/// Blocks chosen one after the other, and what each was chosen for.
struct Batch {
  std::vector<std::size_t> blocks;  // in choices
  std::vector<std::string> why;
  double minutes = 0;
};

inline constexpr int most_runs = 3;  // of one block

/// Greedy choice by a gain per minute. Keeps a reference.
class Chooser {
 public:
  explicit Chooser(const PlanTask& task) : task_(task), runs_(task.choices.blocks.size()) {}

  /// Cost of a block now [min]; infinite when it does not fit in any more.
  double cost(std::size_t block) const;
  /// Cost of several blocks at different postures.
  double cost(const std::vector<std::size_t>& blocks) const;
  /// The block with the largest gain per minute; none where no gain is above `least`.
  std::optional<std::size_t> best(const std::vector<double>& gains, double least) const;
  void take(std::size_t block, std::string why);
  void keep_first(std::size_t count);
  const Batch& batch() const { return batch_; }
  const std::set<std::size_t>& postures() const { return postures_; }

 private:
  const PlanTask& task_;
  std::vector<int> runs_;
  std::set<std::size_t> postures_;
  Batch batch_;
};

inline constexpr double unsplit = 2;  // d' of all that is measured: no use to try

/// The blocks that distinguish the pairs, but for those that all the time would not distinguish;
/// no more of them than bring something. In a campaign of its own they do so, to the d' that names
/// an effect, without any one of their postures, too, and determine the fitted parameters so well
/// that they predict that posture: a result that rests on one posture is not believed.
Batch split(const PlanTask& task, const Prospects& prospects, bool in_own_campaign);

/// Chance that the verdict after a batch is one answer, and the true one. Model m, with the weight
/// w_m that the verdict so far gives it, is distinguished from n when
///
///   log(w_m / (sum of all others)) + exponent * g >= log(level / (1 - level)),
///   g ~ N(d'^2 / 2, d'^2)
///
/// with the level and the exponent of the verdict (DecisionRules) and the d' of m and n; of its
/// pairs the worst counts.
double chance_of_answer(const PlanTask& task, const Batch& batch, const Prospects& prospects);

/// Chance of a wrong name that a batch leaves, over all pairs.
double mistakes_left(const PlanTask& task, const Batch& batch, const Prospects& prospects);

}  // namespace kinetostat::calibration
