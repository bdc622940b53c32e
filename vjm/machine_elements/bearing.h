// Rolling bearings: the 6x6 stiffness between their rings under preload.
#pragma once

#include <vector>

#include "kinetostat/spatial/linear_algebra.h"
#include "kinetostat/vjm/machine_elements/rolling_contact.h"

namespace kinetostat::vjm {

/// Equal rolling elements about the axis z of a bearing, each of which bears Q = K delta^p of its
/// rings' approach along its contact normal (cos a cos phi, cos a sin phi, sin a).
struct BearingRow {
  int count = 0;
  double contact_angle = 0;  // a [rad]; negative: bears a push of the inner ring along -z
  double radius = 0;         // of the inner ring's centres of curvature, or of the rollers [m]
  double position = 0;       // of these along z [m]
  double constant = 0;       // K [N/m^p]
  double power = 1.5;        // p
  double centres_apart = 0;  // of both grooves without load [m]; 0: the normal does not turn
  double length = 0;         // of rollers, along which their load may differ [m]
};

/// Balls: geometry as in ball_between_races(), `position` of the balls' centres along z [m].
BearingRow ball_row(int count, double ball_diameter, double pitch_diameter, double contact_angle,
                    double inner_conformity = 0.52, double outer_conformity = 0.52,
                    double position = 0, const ContactMaterial& material = {});
/// Rollers of steel of an effective length [m].
BearingRow roller_row(int count, double length, double pitch_diameter, double contact_angle,
                      double position = 0);

/// Push along z of the inner ring of a row that is displaced by so much along it [N].
double axial_force(const BearingRow& row, double displacement);
/// The displacement under which that is so much, both of the sign of the contact angle. Throws
/// std::invalid_argument for a row that bears none.
double axial_approach(const BearingRow& row, double force);

/// A row, and how it is preloaded: [m] along z for one that bears along it, else in all radial
/// directions, by rings that are made that much too close.
struct PreloadedRow {
  BearingRow row;
  double approach = 0;
};

/// Stiffness d[F; M]/d[u; theta] of the inner rings against the outer ones, at the origin, axis z
/// (ISO/TS 16281's model, derivatives in closed form): the sum over all rolling elements of
///
///   G' (p K delta^(p-1) n n' + K delta^p / s t t') G,   G = [I, -[r]x],
///
/// n the contact normal, t across it in the plane of the axis, s how far the centres of curvature
/// are apart. Rolling elements do not resist a turn about z: its row and column are zero.
spatial::Matrix6 bearing_stiffness(const std::vector<PreloadedRow>& rows);

}  // namespace kinetostat::vjm
