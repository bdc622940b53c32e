// Ball screws: the axial stiffness of shaft, nut and bearings where the nut stands.
#pragma once

namespace kinetostat::vjm {

/// A screw shaft between two ends, the nut on it, and the bearings that hold it along its axis.
struct BallScrew {
  double shaft_area = 0;         // of the core [m^2]
  double young_modulus = 206e9;  // [Pa]
  double length = 0;             // between the ends [m]
  double nut = 0;                // stiffness of balls and nut [N/m]
  double bearing = 0;            // of the bearing at the first end [N/m]
  double other_bearing = 0;      // at the other end [N/m]; 0: it does not hold the shaft
};

/// Stiffness along the axis with the nut at `place` from the first end [m], ISO 3408-4:
///
///   1/k = 1/nut + 1/(k_1 + k_2),   1/k_1 = place/(E A) + 1/bearing,
///   1/k_2 = (length - place)/(E A) + 1/other_bearing.
///
/// Throws std::invalid_argument for a place that is not on the shaft.
double axial_stiffness(const BallScrew& screw, double place);

}  // namespace kinetostat::vjm
