// Lumping error of one spring per link: results over the number of segments of the beams.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "kinetostat/vjm/statics/equilibrium.h"

namespace kinetostat::vjm {

/// A result for several numbers of segments. A chain of lumped springs converges to the beam with
/// the square of the length of a segment.
struct SegmentStudy {
  std::vector<int> multiples;     // of the segments that the robot file gives, ascending
  std::vector<double> values;     // of the result
  std::vector<int> without = {};  // multiples below those, for which there is no result

  /// Richardson's estimate of the limit from the last two. Throws std::logic_error with fewer.
  double extrapolated() const;
  /// Relative error of a value against that.
  double error(std::size_t i) const;
  /// Order of convergence seen in the last three, when their multiples double and the differences
  /// have one sign.
  std::optional<double> observed_order() const;
};

/// Passes over multiples without a result up to the first that has one (a single spring hides the
/// buckling of its own beam), and stops at the next without.
SegmentStudy study_segments(const std::vector<int>& multiples,
                            const std::function<std::optional<double>(int)>& result);

/// Richardson's estimate of the relative error of `given`, from the same robot and load with every
/// beam in twice the segments. The error is that of the displacement of a free platform, or of the
/// force that holds it (of rotation or moment when there is none). The springs of a straight
/// unloaded beam are exact with any number; under load the difference is the share of geometric
/// stiffness that lumped springs miss. nullopt when either has not converged or nothing moves.
std::optional<double> lumping_error(const Equilibrium& given, const Equilibrium& twice,
                                    bool platform_held);

/// The stability of an equilibrium as the same one with finer beams shows it: a single spring does
/// not feel a compression bend its own beam. Where the finer model is less stable, or has no
/// equilibrium at all, `given` takes that over; says whether it did.
bool take_stability(const Equilibrium& finer, bool platform_held, Equilibrium& given);

/// A loaded equilibrium beside the same one with finer beams.
struct SegmentCheck {
  static constexpr int stability_multiple = 8;  // segments by which stability is judged

  std::optional<double> lumping_error;  // against twice the segments; none without beams or
                                        // equilibrium
  bool hidden_buckling = false;         // stable as given, unstable with the finer beams
};

}  // namespace kinetostat::vjm
