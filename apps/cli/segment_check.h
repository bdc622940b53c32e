// Whether the segments of the beams are enough for a loaded equilibrium.
#pragma once

#include <optional>
#include <string>

#include "kinetostat/apps/cli/robot_request.h"
#include "kinetostat/io/json.h"

namespace kinetostat::apps {

/// Segment check of a loaded equilibrium of a robot with beams; nullopt without beams or
/// equilibrium.
struct SegmentCheck {
  static constexpr int stability_multiple = 8;  // segments by which stability is judged

  std::optional<double> lumping_error;  // vjm::lumping_error() against twice the segments
  bool hidden_buckling = false;         // stable as given, unstable with the finer beams

  /// Sentences, each on a line of its own.
  std::string text(const vjm::Robot& robot) const;
  void add_to(io::Json& json) const;
};

/// Solves again with every beam in two and eight times the segments. `found` takes over the
/// stability of the finer beams where that is less (vjm::take_stability()).
SegmentCheck check_segments(const vjm::Robot& robot, const PostureRequest& posture,
                            const LoadRequest& load, vjm::Equilibrium& found);

}  // namespace kinetostat::apps
