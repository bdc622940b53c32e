// Critical forces: the U R R S chain, the straight column, the Orthoglide.
#include <cmath>
#include <optional>

#include <fmt/format.h>

#include "kinetostat/vjm/chain/chain_builder.h"
#include "kinetostat/vjm/continuation/path.h"
#include "kinetostat/vjm/manipulator/posture.h"

#include "tables.h"
#include "vjm/urrs.h"

namespace kinetostat::theory {
namespace {

using spatial::Vector3;
using spatial::Vector6;
using vjm::samples::k0;
using vjm::samples::length;
using vjm::samples::Shape;
using vjm::samples::Springs;

std::optional<vjm::PathPoint> first_critical(const vjm::Manipulator& robot,
                                             const vjm::Posture& posture,
                                             const Vector6& displacement, int points = 50) {
  vjm::PathTask task;
  task.displacement = displacement;
  vjm::PathOptions options;
  options.until_critical = true;
  options.points = points;
  common::Progress progress;
  const vjm::Path path = trace(robot, posture, task, options, progress);
  if (path.critical.empty()) return std::nullopt;
  return path.critical[0].point;
}

std::string critical_force(Springs springs, Shape shape) {
  const vjm::Manipulator robot = vjm::samples::urrs(springs);
  const auto point =
      first_critical(robot, vjm::samples::posture(robot, shape), -0.5 * length * Vector6::Unit(0));
  return point ? fmt::format("{:.4f}", point->along->force * length / k0) : "none";
}

// Three links in n planar cantilever springs each, pinned at both ends.
double column(int n) {
  constexpr double L = 0.3;
  const vjm::Material steel{210e9, 80e9, std::nullopt};
  vjm::Section section;
  section.area = 0.04;  // hardly compressible
  section.second_moment_y = 1e-6;
  section.second_moment_z = 1e-9;
  section.torsion_constant = 1e-8;
  const double unit = steel.young_modulus * section.second_moment_z / (L * L);
  const spatial::Compliance6 piece(
      beam_compliance(L / n, section, steel, vjm::BeamTheory::euler_bernoulli).matrix());
  vjm::ChainBuilder chain("column");
  chain.passive("first", vjm::Motion::rz);
  for (int i = 0; i < 3 * n; ++i)
    chain.link(fmt::format("l{}", i), spatial::Pose::translation({L / n, 0, 0}), piece);
  chain.passive("last", vjm::Motion::rz);
  const vjm::Manipulator robot("column", {chain.build()});
  // To twice the unit of force, in few steps.
  const double shift = -3 * L * 2 * unit / (steel.young_modulus * section.area);
  const auto point =
      first_critical(robot, posture_from_joints(robot, {}).posture, shift * Vector6::Unit(0), 4);
  return point ? point->along->force / unit : 0;
}

}  // namespace

std::string mmt11_urrs() {
  struct Row {
    const char* name;
    Springs springs;
    const char* paper[3];
  };
  const Row rows_of[] = {
      {"A: rotary springs in the actuators", Springs::actuators, {"1", "none", ""}},
      {"B: rotation and stretch apart", Springs::planar, {"1", "none", "1.07"}},
      {"C: rotations apart", Springs::spatial, {"0.16", "0.20", "0.17"}},
      {"B with full cantilever springs", Springs::planar_beam, {"", "", ""}},
      {"C with full cantilever springs", Springs::spatial_beam, {"", "", ""}}};
  std::vector<std::vector<std::string>> rows;
  for (const Row& row : rows_of) {
    std::vector<std::string> cells{row.name};
    const Shape shapes[] = {Shape::straight, Shape::bent, Shape::zigzag};
    for (int i = 0; i < 3; ++i) {
      const std::string ours = critical_force(row.springs, shapes[i]);
      cells.push_back(*row.paper[i] ? fmt::format("{} ({})", ours, row.paper[i]) : ours);
    }
    rows.push_back(cells);
  }
  return markdown({"springs", "S", "Pi", "Z"}, rows);
}

std::string straight_column() {
  std::vector<std::vector<std::string>> rows;
  const double exact = M_PI * M_PI / 9;
  double before = 0;
  for (const int n : {1, 2, 4, 8, 16}) {
    const double force = column(n);
    rows.push_back({fmt::format("{}", n), fmt::format("{:.4f}", force),
                    fmt::format("{:+.2f} %", 100 * (force / exact - 1)),
                    n == 1 ? "" : fmt::format("{:.4f}", force + (force - before) / 3)});
    before = force;
  }
  return markdown({"n", "critical force", "over Euler", "Richardson from n/2 and n"}, rows);
}

std::string mmt11_table_2_critical() {
  const double paper[][2] = {{4.65, 1.41}, {7.85, 0.48}, {2.24, 4.85}, {4.75, 0.48}, {2.78, 0.52}};
  const vjm::Robot robot = shipped("orthoglide.yaml");
  std::vector<std::vector<std::string>> rows;
  for (std::size_t i = 0; i < orthoglide_points.size(); ++i) {
    const NamedPoint& named = orthoglide_points[i];
    const vjm::Posture posture =
        posture_at(robot.manipulator, spatial::Pose::translation(named.position)).posture;
    Vector6 shift = Vector6::Zero();
    shift.head<3>() = Vector3::Constant(8e-3 / std::sqrt(3.0));
    const auto point = first_critical(robot.manipulator, posture, shift);
    rows.push_back({named.name, fmt::format("{:.2f}", paper[i][0]),
                    fmt::format("{:.2f}", paper[i][1]),
                    point ? fmt::format("{:.2f}", 1e-3 * point->along->force) : "none to 8 mm",
                    point ? fmt::format("{:.2f}", 1e3 * point->along->deflection) : ""});
  }
  return markdown({"point", "paper [kN]", "paper [mm]", "ours, 3-PUU [kN]", "ours [mm]"}, rows);
}

}  // namespace kinetostat::theory
