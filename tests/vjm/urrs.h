// The U R R S chain of MMT11 section 6.1: three links of equal length, its end held on the x axis.
#pragma once

#include <cmath>
#include <numbers>
#include <optional>
#include <string>

#include "kinetostat/vjm/chain/beam.h"
#include "kinetostat/vjm/chain/chain_builder.h"
#include "kinetostat/vjm/manipulator/posture.h"

namespace kinetostat::vjm::samples {

inline constexpr double length = 0.3, k0 = 393.75;  // 70 GPa, 15 x 6 mm

enum class Springs { actuators, planar, spatial, planar_beam, spatial_beam };
enum class Shape { straight, bent, zigzag };

// Springs at the end of a link.
inline void add_link(ChainBuilder& chain, Springs springs, int number) {
  const std::string n = std::to_string(number);
  const spatial::Pose offset = spatial::Pose::translation({length, 0, 0});
  Section section = Section::rectangle(0.015, 0.006, 0.3);
  const Material material{70e9, 70e9 / 2.66, std::nullopt};
  const double torsion = material.shear_modulus * section.torsion_constant / length;
  const double axial = 70e9 * section.area / length;
  switch (springs) {
    case Springs::actuators:
      chain.offset(offset);
      return;
    case Springs::planar:
      chain.offset(offset).passive("s" + n, Motion::tx, axial, 0, 0);
      chain.passive("b" + n, Motion::rz, k0, 0, 0);
      return;
    case Springs::spatial:
      chain.offset(offset).passive("t" + n, Motion::rx, torsion, 0, 0);
      chain.passive("c" + n, Motion::ry, 0.16 * k0, 0, 0);
      chain.passive("b" + n, Motion::rz, k0, 0, 0);
      return;
    case Springs::planar_beam:
      section.second_moment_y *= 1e6;  // stays in its plane
      section.torsion_constant *= 1e6;
      [[fallthrough]];
    case Springs::spatial_beam:
      chain.link(
          "l" + n, offset,
          spatial::Compliance6(
              beam_compliance(length, section, material, BeamTheory::euler_bernoulli).matrix()));
  }
}

inline Manipulator urrs(Springs springs) {
  const bool planar = springs == Springs::planar || springs == Springs::planar_beam;
  const std::optional<double> actuator =
      springs == Springs::actuators ? std::optional(k0) : std::nullopt;
  ChainBuilder chain("urrs");
  chain.passive("u", Motion::rz);
  if (!planar) chain.passive("u2", Motion::ry);
  add_link(chain, springs, 1);
  chain.actuator("a1", Motion::rz, actuator);
  add_link(chain, springs, 2);
  chain.actuator("a2", Motion::rz, actuator);
  add_link(chain, springs, 3);
  if (!planar) chain.passive("s.Rx", Motion::rx).passive("s.Ry", Motion::ry);
  chain.passive("s.Rz", Motion::rz);
  return {"urrs", {chain.build()}};
}

inline Posture posture(const Manipulator& robot, Shape shape) {
  const double bend = std::numbers::pi / 6;
  switch (shape) {
    case Shape::straight:
      return posture_from_joints(robot, {}).posture;
    case Shape::bent:
      return posture_from_joints(robot, {{"u", bend}, {"a1", -bend}, {"a2", -bend}}).posture;
    case Shape::zigzag:
      break;
  }
  // 2 sin(u) + sin(u + bend) = 0: both ends on the x axis.
  const double u = -std::atan2(std::sin(bend), 2 + std::cos(bend));
  return posture_from_joints(robot, {{"u", u}, {"a1", bend}, {"a2", -bend}}).posture;
}

}  // namespace kinetostat::vjm::samples
