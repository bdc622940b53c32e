// Where fits start, and what they promise, by signatures whose least squares are known.
#include "kinetostat/calibration/search/fit_starts.h"

#include <algorithm>

#include <gtest/gtest.h>

#include "calibration/laboratory.h"

namespace kinetostat::calibration::fit_starts_test {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

const test::Laboratory& laboratory() {
  static const test::Laboratory laboratory(
      "kinetostat: 1\nname: bench\nunits: {length: mm, force: N, angle: deg}\n"
      "chain_types:\n  cell:\n    - actuator: {name: q, axis: Tz, stiffness: 1000}\n"
      "manipulator: {chain: cell}\n");
  return laboratory;
}

Candidate find(const std::string& name) {
  const std::vector<Candidate> all = candidates(laboratory().robot(), {});
  return *std::find_if(all.begin(), all.end(),
                       [&](const Candidate& c) { return c.name() == name; });
}

// One value a column, each seen in a value of its own.
struct Look {
  double promised = 0;
  Candidate first;

  Look(const std::string& name, const VectorXd& residual) : first(at_size(find(name), 1, 1)) {
    const ResidualSpace space(residual, MatrixXd(residual.size(), 0));
    FitStarts starts(first, space, laboratory().robot().without_effects());
    const Signature signature{MatrixXd::Identity(residual.size(), first.effect.values.size())};
    starts.add(first, signature, residual.squaredNorm());
    promised = starts.promised();
    first = starts.best().front();
  }
};

// A payload of 2.5 times the usual mass explains what it does; its opposite, nothing.
TEST(FitStarts, WhatOnlyGrowsDoesNotPromiseItsOpposite) {
  const Look heavier("payload at platform", 2.5 * VectorXd::Unit(6, 0));
  EXPECT_NEAR(heavier.promised, 6.25, 1e-9);
  const double usual = find("payload at platform").deviations[0];
  EXPECT_NEAR(heavier.first.effect.values[0], 2.5 * usual, 1e-9 * usual);
  EXPECT_EQ(Look("payload at platform", -2.5 * VectorXd::Unit(6, 0)).promised, 0);
  EXPECT_NEAR(Look("preload at cell.q", -2.5 * VectorXd::Unit(6, 0)).promised, 6.25, 1e-9);
}

// r = (1, 5): of the usual mass, with its centre z standard deviations of its prior aside,
// (5 - z)^2 + z^2 is least at z = 2.5. Of four times that, r = (4, 5): (5 - 4 z)^2 + z^2 at 20/17.
TEST(FitStarts, WhereAMassIsIsAsFarAsItsPriorAllows) {
  for (const auto& [size, z] : {std::pair(1., 2.5), {4., 20. / 17}}) {
    const Look look("payload at platform", size * VectorXd::Unit(6, 0) + 5 * VectorXd::Unit(6, 1));
    const double left = (5 - size * z) * (5 - size * z) + z * z;
    EXPECT_NEAR(look.promised, size * size + 25 - left, 1e-9);
    const Candidate usual = find("payload at platform");
    EXPECT_NEAR(look.first.effect.values[0] / usual.deviations[0], size, 1e-9);
    EXPECT_NEAR(look.first.effect.values[1] / usual.deviations[1], z, 1e-9);
  }
}

}  // namespace
}  // namespace kinetostat::calibration::fit_starts_test
