// Readings that a model was not fitted to, predicted by a new fit without them.
#include "kinetostat/calibration/search/held_out_refit.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "kinetostat/calibration/campaign/noise_estimate.h"
#include "kinetostat/calibration/campaign/replicates.h"
#include "kinetostat/calibration/diagnosis/diagnosis.h"

#include "calibration/laboratory.h"

namespace kinetostat::calibration::held_out_refit_test {
namespace {

using test::Laboratory;

const std::string slide =
    "kinetostat: 1\nname: bench\nunits: {length: mm, force: N, angle: deg}\n"
    "chain_types:\n  cell:\n    - actuator: {name: q, axis: Tz, stiffness: 1000}\n"
    "manipulator: {chain: cell}\nuncertain:\n  - {stiffness: q}\n";

// Cycles of different size, up and down and back.
std::string cycles(const std::vector<double>& sizes) {
  std::string csv = "id,session,cycle,step,time,fz\n";
  int n = 0;
  for (std::size_t c = 0; c < sizes.size(); ++c)
    for (const double level : {0.5, 1.0, 0.5, 0.0, -0.5, -1.0, -0.5, 0.0}) {
      ++n;
      csv += fmt::format("r{0},day,c{1},{0},{2},{3}\n", n, c, 30 * n, level * sizes[c]);
    }
  return csv;
}

// A stiffness acts on readings in proportion, nearly: the step in closed form is as good.
TEST(HeldOutRefit, IsTheClosedFormWhereTheModelIsLinear) {
  Laboratory laboratory(slide);
  laboratory.options().translation_noise = 3e-7;
  const Campaign campaign = laboratory.measure(cycles({50, 100, 200, 300, 250}));
  common::Progress silent;
  const Noise noise = noise_of(campaign, replicate_groups(campaign));
  const CandidateFitter fitter(laboratory.robot(), campaign, noise, 1, silent);
  const BaseFit fit = fitter.fit({}, nullptr, silent);
  const HeldOutGroups groups = held_out_groups(campaign, values_in_use(campaign));
  const HeldOutRefit refit(laboratory.robot(), fitter, groups, 1);
  const auto error = refit.error({}, fit, silent);
  ASSERT_TRUE(error);
  const Eigen::VectorXd closed = held_out(fit.at, prior_information(fit), groups, 1).error;
  EXPECT_LT((*error - closed).norm(), 1e-3 * closed.norm());
}

// Only one cycle pushes the second joint: without it that joint's stiffness stays at its nominal
// value, though the fit of all readings knows better, and the cycle is predicted with it.
TEST(HeldOutRefit, KeepsWhatTheRestDoesNotDetermine) {
  Laboratory laboratory(
      "kinetostat: 1\nname: bench\nunits: {length: mm, force: N, angle: deg}\n"
      "chain_types:\n  cell:\n    - actuator: {name: q, axis: Tz, stiffness: 1000}\n"
      "    - actuator: {name: p, axis: Tx, stiffness: 800}\n"
      "manipulator: {chain: cell}\nuncertain:\n  - {stiffness: q}\n  - {stiffness: p}\n");
  laboratory.options().components = {true, false, true, false, false, false};
  laboratory.options().translation_noise = 3e-7;
  laboratory.hide("joint_compliance", "p", "c=0.00025 mm/N");  // 1.2 times its compliance
  std::string csv = "id,session,cycle,step,time,fz,fx\n";
  for (int n = 0; n < 40; ++n) {
    const double level = 100 * std::sin(std::numbers::pi / 4 * n);
    csv += fmt::format("r{0},day,c{1},{0},{2},{3},{4}\n", n, n / 8, 30 * n, n < 32 ? level : 0,
                       n < 32 ? 0 : level);
  }
  const Campaign campaign = laboratory.measure(csv);
  common::Progress silent;
  const Noise noise = noise_of(campaign, replicate_groups(campaign));
  const CandidateFitter fitter(laboratory.robot(), campaign, noise, 1, silent);
  const BaseFit fit = fitter.fit({}, nullptr, silent);
  const std::vector<Value> values = values_in_use(campaign);
  const auto error = HeldOutRefit(laboratory.robot(), fitter, held_out_groups(campaign, values), 1)
                         .error({}, fit, silent);
  ASSERT_TRUE(error);
  double largest = 0;
  for (std::size_t v = 0; v < values.size(); ++v)
    if (values[v].component == 0)
      largest = std::max(largest, std::abs((*error)[static_cast<Eigen::Index>(v)]));
  EXPECT_NEAR(largest, 100 * 0.00025e-3 / 3e-7, 5);  // [standard deviations]
}

// Half of the cycles hardly slip, and one step from the fit of all of them leads far beyond what
// they say: the error seemed to rise by friction, which is all that is missing.
TEST(HeldOutRefit, FrictionPredictsCyclesThatItWasNotFittedTo) {
  Laboratory laboratory(slide);
  laboratory.options().translation_noise = 3e-7;
  laboratory.hide("friction", "q", "force=120 N,presliding=2 um");
  const Diagnosis d = laboratory.diagnose(laboratory.measure(cycles({50, 100, 200, 800})), {});
  ASSERT_EQ(d.found.size(), 1u);
  EXPECT_EQ(d.found[0].candidate.effect.kind->name, "friction");
  EXPECT_EQ(d.verdict, Verdict::identified);
  const auto bar = [&](const std::string& start) {
    for (const WaterfallStage& stage : d.waterfall)
      if (stage.name.starts_with(start)) return stage.whitened;
    ADD_FAILURE() << start;
    return 0.0;
  };
  EXPECT_LT(bar("+ friction"), 0.5 * bar("refitted"));
}

}  // namespace
}  // namespace kinetostat::calibration::held_out_refit_test
