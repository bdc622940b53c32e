// How an interface of a link is fastened to what is outside it.
#pragma once

#include <string>

#include "kinetostat/fea/interface/interface_selection.h"

namespace kinetostat::fea {

enum class Coupling {
  rigid,         // the interface follows a rigid body: upper bound of the stiffness
  distributing,  // its mean motion does, its shape is free: lower bound (average_motion.h)
  elastic,       // an elastic layer is between it and a rigid body (elastic_layer.h)
  body,          // the same, with a body of elements of a higher modulus on it (stiff_body.h)
};

/// "rigid", "distributing", "elastic", "body".
const char* name(Coupling coupling);

/// How stiff the body of a `body` coupling is beside the link.
inline constexpr double default_modulus_ratio = 1000;
/// Beyond, rounding in the stiff elements would show in the result.
inline constexpr double largest_modulus_ratio = 1e5;

/// Stiffness per area [N/m^3] of an elastic layer.
struct ElasticLayer {
  double normal = 0, tangential = 0;
};

/// An interface of the finite-element model. Its motion is [translation; rotation] at `point`.
struct CoupledInterface {
  std::string name;
  Interface geometry;
  Vector3 point;  // [m]
  Coupling coupling = Coupling::rigid;
  double modulus_ratio = default_modulus_ratio;  // of a `body`
  ElasticLayer layer = {};                       // of an `elastic` one
};

}  // namespace kinetostat::fea
