// What one spring per link is worth: results over the number of segments of the beams.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "kinetostat/vjm/equilibrium.h"

namespace kinetostat::vjm {

/// A result for several numbers of segments. A chain of lumped springs converges to the beam with
/// the square of the length of a segment.
struct SegmentStudy {
  std::vector<int> multiples;  // of the segments that the robot file gives, ascending
  std::vector<double> values;  // of the result

  /// Richardson's estimate of the limit from the last two. Throws std::logic_error with fewer.
  double extrapolated() const;
  /// Relative error of a value against that.
  double error(std::size_t i) const;
  /// Order of convergence seen in the last three, when their multiples double and the differences
  /// have one sign.
  std::optional<double> observed_order() const;
};

/// Stops at the first multiple for which there is no result.
SegmentStudy study_segments(const std::vector<int>& multiples,
                            const std::function<std::optional<double>(int)>& result);

/// Of the same robot and load, once as given and once with every beam in twice the segments.
/// Richardson's estimate of the relative error of the first: of the displacement of a free
/// platform, or of the force that holds it (of rotation or moment when there is none). The springs
/// of a straight unloaded beam are exact with any number; under load the difference is the share of
/// geometric stiffness that lumped springs miss. Nothing when either has not converged or nothing
/// moves.
std::optional<double> lumping_error(const Equilibrium& given, const Equilibrium& twice,
                                    bool platform_held);

}  // namespace kinetostat::vjm
