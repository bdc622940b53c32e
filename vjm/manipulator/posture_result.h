// A posture: how it is sought, and what is found.
#pragma once

#include <string>

#include "kinetostat/vjm/manipulator/manipulator.h"

namespace kinetostat::vjm {

struct PostureOptions {
  /// Largest position error that counts as reached [m]; the rotation error is this over the reach.
  double tolerance = 1e-12;
  int max_iterations = 200;
  /// Further starting points tried when the home values do not lead there; deterministic.
  int restarts = 20;
};

struct PostureResult {
  bool reached = false;
  Posture posture;  // the nearest found when not reached
  /// [translation m; rotation rad] still missing, worst chain.
  spatial::Vector6 error = spatial::Vector6::Zero();
  std::string reason;  // empty when reached; otherwise a sentence with chain and distances
};

}  // namespace kinetostat::vjm
