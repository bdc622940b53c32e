// Mass and inertia of bodies that are given by numbers, uniform within.
#pragma once

#include "kinetostat/vjm/exchange/robot_description.h"

namespace kinetostat::vjm {

/// Of a box, a cylinder, a capsule or a ball [m^3]; a ball may be scaled along its axes to an
/// ellipsoid. Requires a shape without a mesh.
double volume(const DescribedShape& shape);

/// Of the same with this mass [kg], in the frame that the shape's pose is in.
DescribedInertia uniform_inertia(const DescribedShape& shape, double mass);

/// Of two bodies that are one, in the frame of both.
DescribedInertia together(const DescribedInertia& one, const DescribedInertia& other);

}  // namespace kinetostat::vjm
