// What one spring per link is worth: results over the number of segments of the beams.
#pragma once

#include <functional>
#include <optional>
#include <vector>

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

}  // namespace kinetostat::vjm
