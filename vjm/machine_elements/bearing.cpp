#include "kinetostat/vjm/machine_elements/bearing.h"

#include <cmath>
#include <numbers>
#include <stdexcept>

namespace kinetostat::vjm {
namespace {

using spatial::Matrix6;
using spatial::Vector3;

// Parts of a roller: ISO/TS 16281 wants 30 or more.
constexpr int slices = 31;

// One rolling element at zero angle, in the plane x-z: its deflection along its contact normal.
struct Contact {
  double deflection, apart;  // delta, s
  Vector3 normal, across;

  Contact(const BearingRow& row, double radial, double axial) {
    const double c = std::cos(row.contact_angle), s = std::sin(row.contact_angle);
    normal = {c, 0, s};
    apart = row.centres_apart;
    deflection = c * radial + s * axial;
    if (apart > 0) {
      const Vector3 centres = apart * normal + Vector3(radial, 0, axial);
      deflection = centres.norm() - apart;
      normal = centres.normalized();
      apart = centres.norm();
    }
    deflection = std::max(deflection, 0.0);
    across = {-normal.z(), 0, normal.x()};
  }
};

Matrix6 stiffness_of(const BearingRow& row, const Contact& contact, double phi) {
  const Eigen::AngleAxisd turn(phi, Vector3::UnitZ());
  const Vector3 normal = turn * contact.normal, across = turn * contact.across;
  const double load = row.constant * std::pow(contact.deflection, row.power);
  spatial::Matrix3 stiffness = spatial::Matrix3::Zero();
  if (contact.deflection > 0)
    stiffness = row.power * load / contact.deflection * normal * normal.transpose();
  if (contact.apart > 0) stiffness += load / contact.apart * across * across.transpose();
  const int parts = row.length > 0 ? slices : 1;
  Matrix6 sum = Matrix6::Zero();
  for (int i = 0; i < parts; ++i) {
    const double along = row.length * ((i + 0.5) / parts - 0.5);
    const Vector3 place =
        turn * Vector3(row.radius, 0, row.position) + (parts > 1 ? along : 0) * across;
    Eigen::Matrix<double, 3, 6> motion;
    motion << spatial::Matrix3::Identity(), -spatial::skew(place);
    sum += motion.transpose() * stiffness * motion / parts;
  }
  return sum;
}

}  // namespace

BearingRow ball_row(int count, double ball_diameter, double pitch_diameter, double contact_angle,
                    double inner_conformity, double outer_conformity, double position,
                    const ContactMaterial& material) {
  const double behind = (inner_conformity - 0.5) * ball_diameter;
  return {.count = count,
          .contact_angle = contact_angle,
          .radius = pitch_diameter / 2 + behind * std::cos(contact_angle),
          .position = position + behind * std::sin(contact_angle),
          .constant = ball_between_races(ball_diameter, pitch_diameter, contact_angle,
                                         inner_conformity, outer_conformity, material),
          .centres_apart = (inner_conformity + outer_conformity - 1) * ball_diameter};
}

BearingRow roller_row(int count, double length, double pitch_diameter, double contact_angle,
                      double position) {
  return {.count = count,
          .contact_angle = contact_angle,
          .radius = pitch_diameter / 2,
          .position = position,
          .constant = roller_between_races(length),
          .power = 10.0 / 9,
          .length = length};
}

double axial_force(const BearingRow& row, double displacement) {
  const Contact contact(row, 0, displacement);
  return row.count * row.constant * std::pow(contact.deflection, row.power) * contact.normal.z();
}

double axial_approach(const BearingRow& row, double force) {
  const double sign = row.contact_angle < 0 ? -1 : 1;
  if (row.contact_angle == 0 || sign * force < 0)
    throw std::invalid_argument("this row of a bearing bears no such axial force");
  double lower = 0, upper = 1e-9;
  while (std::abs(axial_force(row, sign * upper)) < std::abs(force)) upper *= 2;
  for (int i = 0; i < 200 && upper - lower > 1e-15 * upper; ++i) {
    const double middle = (lower + upper) / 2;
    (std::abs(axial_force(row, sign * middle)) < std::abs(force) ? lower : upper) = middle;
  }
  return sign * upper;
}

Matrix6 bearing_stiffness(const std::vector<PreloadedRow>& rows) {
  Matrix6 sum = Matrix6::Zero();
  for (const auto& [row, approach] : rows) {
    const bool is_radial = row.contact_angle == 0;
    const Contact contact(row, is_radial ? approach : 0, is_radial ? 0 : approach);
    for (int i = 0; i < row.count; ++i)
      sum += stiffness_of(row, contact, 2 * std::numbers::pi * i / row.count);
  }
  sum.row(5).setZero();
  sum.col(5).setZero();
  return (sum + sum.transpose()) / 2;
}

}  // namespace kinetostat::vjm
