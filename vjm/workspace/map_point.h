// One pose of a map.
#pragma once

#include <vector>

namespace kinetostat::vjm {

enum class MapState {
  reached,
  free_motion,     // some motion meets no resistance: the indices that it spoils are 0 or infinite
  unstable,        // the equilibrium under the load would not last
  no_equilibrium,  // the load cannot be carried up to its full size
  unreachable,     // the chains do not reach the pose, or a drive would leave its range
};
struct MapPoint {
  MapState state = MapState::unreachable;
  /// One value per index; NaN where the state allows none.
  std::vector<double> values;
};

}  // namespace kinetostat::vjm
