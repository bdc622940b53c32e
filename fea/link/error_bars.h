// Error of a flexibility matrix, estimated from a sequence of meshes: an error bar for every entry,
// and whether two independent estimates agree. The reasons are in docs/theory/link-accuracy.md.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace kinetostat::fea {

/// The outcome on one mesh of the sequence.
struct MeshOutcome {
  std::size_t unknowns = 0, elements = 0;
  Eigen::MatrixXd flexibility;          // symmetric
  Eigen::MatrixXd recovery_error;       // ErrorEstimate::total
  Eigen::MatrixXd geometry_error = {};  // ErrorEstimate::geometry
  /// Largest bar of a significant entry, relative to the entry, as it was judged on this mesh.
  double relative_error = 0;
};

struct ErrorBars {
  /// Entries with a relative bar: |C_ij| >= significance * sqrt(C_ii C_jj), a measure that no
  /// choice of units changes. The others are small by symmetry or nearly so: they have a bar, but
  /// no relative one.
  static constexpr double significance = 0.05;
  /// A bar is this times the recovery's estimate, enlarged by the calibration where that is above
  /// 1, and never below the extrapolation's ...
  static constexpr double safety = 2;
  /// ... plus this times the root of the estimates of the two diagonal entries: the estimate of an
  /// entry off the diagonal may be small by chance.
  static constexpr double cross_share = 0.1;
  /// ... plus the same of what the geometry may add, its calibration 1.
  /// Recoveries that fell more slowly from the mesh before than those of a crack (unknowns^-1/3)
  /// are enlarged by what they should have fallen, and by this at most.
  static constexpr double most_unseen = 10;
  /// Of convergence by unknowns: that of the strongest singularity of elasticity, a crack, on even
  /// meshes.
  static constexpr double slowest_rate = 1.0 / 3;
  /// Two estimates of the error agree when neither is more than this times the other. Where they
  /// differ more, the bars are enlarged by the excess, up to a difference of `most_difference`.
  static constexpr double agreement_factor = 3, most_difference = 10;

  Eigen::MatrixXd bar;            // half width, same units as the flexibility
  Eigen::MatrixXd geometry = {};  // what the geometry adds to it; empty: no CAD file
  Eigen::MatrixXd recovery;       // signed estimate of exact minus computed
  Eigen::MatrixXd extrapolation;  // the same from the sequence; empty for a single mesh
  Eigen::Matrix<bool, Eigen::Dynamic, Eigen::Dynamic> significant;
  double relative_error = 0;  // largest bar of a significant entry beside the entry

  /// Mean over all load cases: what the last change of the flexibility was, beside the fall of the
  /// recovery's estimate from the mesh before to the last one. Above 1 the recovery sees too little
  /// of the error. From two meshes on; not above 0 when the error did not fall.
  std::optional<double> calibration;
  /// The error falls as unknowns^-rate: as observed on the last three meshes, if there are three
  /// and they converge.
  std::optional<double> observed_rate;
  /// The rate that elements of this order can have where the stresses are smooth: 2/3 of the order.
  double best_rate = 0;
  /// Mean over all load cases, extrapolation beside recovery; 1 is perfect agreement.
  std::optional<double> agreement;
  /// A singular stress, at the edge of a held face or a re-entrant edge of the part, that the
  /// meshes do not resolve: the rate is under three quarters of the best one.
  bool convergence_is_slow() const { return observed_rate && *observed_rate < 0.75 * best_rate; }
  /// How many times the smaller estimate the larger one is; infinite without a second estimate, and
  /// where the error did not fall.
  double difference() const;
  bool estimates_agree() const { return difference() <= agreement_factor; }
  /// The bars take the difference into account.
  bool estimates_are_comparable() const { return difference() <= most_difference; }
};

/// For the last mesh of the sequence (one or more), of elements of this order. Requires positive
/// diagonals.
ErrorBars error_bars(const std::vector<MeshOutcome>& sequence, int order);

}  // namespace kinetostat::fea
