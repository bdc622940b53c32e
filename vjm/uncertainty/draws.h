// Uncertainties by Monte Carlo on the nonlinear model (GUM supplement 1).
#pragma once

#include <map>
#include <optional>
#include <vector>

#include "kinetostat/vjm/uncertainty/propagation.h"

namespace kinetostat::vjm {

/// Values of all sources, one column a draw: a Latin hypercube, in which every source has one value
/// in each of `count` ranges of the same probability. The same for the same seed.
/// Where sources are correlated, so are the normal numbers from which their values follow.
Eigen::MatrixXd drawn_values(const Robot& robot, std::size_t count, std::uint64_t seed);

/// Whether robots with other values of the sources stand otherwise at the same pose or the same
/// joint values: some length is a source.
bool have_other_postures(const Robot& robot);

/// What was computed of the robots that were drawn.
struct Draws {
  std::size_t count = 0;  // that were drawn
  std::uint64_t seed = 1;
  Eigen::MatrixXd numbers;  // one column a draw for which there is an equilibrium

  std::size_t failed() const { return count - static_cast<std::size_t>(numbers.cols()); }
  double mean(Eigen::Index number) const;
  double deviation(Eigen::Index number) const;
  /// The value below which the share `p` of the draws lies, linear between them; those that
  /// have no such number left out, NaN where none has.
  double quantile(Eigen::Index number, double p) const;
};

/// What was computed of robots that were drawn, by their numbers: none of those whose values do not
/// go together, or that stand in no equilibrium.
using DrawnNumbers = std::map<std::size_t, std::optional<Eigen::VectorXd>>;

/// Computes the numbers of some of `count` robots drawn from what is possible.
DrawnNumbers compute_draws(const Robot& robot, const Computation& compute, std::size_t count,
                           std::uint64_t seed, const std::vector<std::size_t>& wanted, int threads,
                           common::Progress& progress);
/// Of all of them. Throws common::NoConvergence where less than half of them could be computed.
Draws draws_of(std::size_t count, std::uint64_t seed, const DrawnNumbers& all);

/// Computes the numbers of `count` robots drawn from what is possible. Those whose values do not go
/// together, or that stand in no equilibrium, count as failed. Throws common::NoConvergence where
/// less than half of them can be computed.
Draws draw(const Robot& robot, const Computation& compute, std::size_t count, std::uint64_t seed,
           int threads, common::Progress& progress);

/// A result whose robot has sources of uncertainty.
struct Uncertainty {
  Propagation first_order;
  std::optional<Draws> draws = {};  // where asked for
};

}  // namespace kinetostat::vjm
