#include "sensor_case.h"

#include <cmath>
#include <numbers>
#include <stdexcept>
#include <vector>

#include <fmt/format.h>

#include "campaign_text.h"
#include "hidden_effect.h"
#include "random.h"
#include "robot.h"

namespace twin {
namespace {

// What a level reads: the angles between the vertical and its own axes.
struct Level {
  double x = 0, y = 0;
};
Level level_of(const Pose& pose) {
  const Vector3 up = pose.R.transpose() * Vector3::UnitZ();
  return {std::atan2(up.y(), up.z()), std::atan2(-up.x(), up.z())};
}

struct Reading {
  std::string name;
  double value = 0, noise = 0;  // SI
  double unit = 1;
};

// The marks that the sensors look at.
struct Marks {
  Mark base, fore, elbow, tool;
};

std::vector<Reading> all_readings(const FoundationCase& spec, const Structure& s,
                                  const Marks& marks) {
  const Level base = level_of(s.pose_of(marks.base)), tool = level_of(s.pose_of(marks.fore));
  const Vector3 elbow = s.pose_of(marks.elbow).x, tip = s.pose_of(marks.tool).x;
  const double tilt = spec.tilt_noise, length = spec.length_noise;
  return {{"base_level.rx", base.x, tilt, 1e-6},
          {"base_level.ry", base.y, tilt, 1e-6},
          {"tool_level.rx", tool.x, tilt, 1e-6},
          {"tool_level.ry", tool.y, tilt, 1e-6},
          {"bent.rx", tool.x - base.x, tilt, 1e-6},
          {"bent.ry", tool.y - base.y, tilt, 1e-6},
          {"dial_z", elbow.z(), length, 1e-6},
          {"dial_side", elbow.dot(Vector3(0.6, 0.8, 0)), length, 1e-6},
          {"ballbar", (tip - Vector3(0.9, 0.3, 0)).norm(), length, 1e-6}};
}

bool is_wanted(const FoundationCase& spec, const std::string& column) {
  const std::string sensor =
      column.starts_with("dial") ? "dial" : column.substr(0, column.find('.'));
  return ("," + spec.sensors + ",").find("," + sensor + ",") != std::string::npos;
}

std::string sensor_lines(const FoundationCase& spec) {
  const auto line = [&](const std::string& sensor, const std::string& text) {
    return is_wanted(spec, sensor) ? "  " + text + "\n" : std::string();
  };
  const std::string level = fmt::format("noise: {:g} urad", spec.tilt_noise * 1e6);
  const std::string length = fmt::format("noise: {:g} um", spec.length_noise * 1e6);
  const bool bent = is_wanted(spec, "bent");
  std::string lines = "sensors:\n";
  if (is_wanted(spec, "base_level") || bent)
    lines += fmt::format("  base_level: {{kind: tilt, on: arm.base, {}}}\n", level);
  lines += line("tool_level", fmt::format("tool_level: {{kind: tilt, on: fore, {}}}", level));
  lines +=
      line("bent", fmt::format("bent: {{kind: tilt, on: fore, minus: base_level, {}}}", level));
  lines += line("dial",
                fmt::format("dial_z: {{kind: gauge, on: upper, direction: [0, 0, 1], {}}}\n"
                            "  dial_side: {{kind: gauge, on: upper, direction: [0.6, 0.8, 0], {}}}",
                            length, length));
  lines += line("ballbar", fmt::format("ballbar: {{kind: distance, on: platform, from: {{on: base, "
                                       "at: [900, 300, 0]}}, {}}}",
                                       length));
  return lines;
}

// The arm as its owner knows it.
std::string owners_file(const FoundationCase& spec, const RobotSpec& robot) {
  std::vector<double> believed;
  for (const std::string& spring : robot.springs())
    believed.push_back(spring == "q2" || spring == "q3" ? 1 / spec.softer : 1);
  std::string text = robot_file(robot, believed);
  text = text.substr(0, text.find("uncertain:"));
  if (spec.foundation_in_file)
    text += fmt::format(
        "effects:\n  - {{effect: base_compliance, at: arm.base, rotation: {:g} "
        "rad/(N m)}}\n",
        spec.believed);
  text +=
      "uncertain:\n  - {stiffness: q2, between: [0.3, 3]}\n  - {stiffness: q3, between: [0.3, "
      "3]}\n";
  if (spec.foundation_in_file)
    text += "  - {effect: base_compliance, at: arm.base, parameter: rotation}\n";
  return text;
}

}  // namespace

namespace {

// Where cylinders push: what they are on, and from where.
struct CylinderEnds {
  Mark on, from;
};

std::vector<DeadLoad> push(const Structure& at_rest, const CylinderEnds& ends, double force) {
  const Vector3 way = (at_rest.pose_of(ends.on).x - at_rest.pose_of(ends.from).x).normalized();
  std::vector<DeadLoad> loads = {{ends.on, force * way, Vector3::Zero()}};
  if (ends.from.body != ground) loads.push_back({ends.from, -force * way, Vector3::Zero()});
  return loads;
}

CylinderEnds cylinder_ends(const FoundationCase& spec, const Structure& at_rest, const Marks& marks,
                           const Pose& platform) {
  const Pose corner{Vector3(0.3, 0.2, 0), Matrix3::Identity()};
  if (spec.cylinder != "bodies") return {marks.elbow, {ground, corner}};
  const Pose fore{platform.x - platform.R * Vector3(0.05, 0, 0), platform.R};
  return {at_rest.mark(marks.fore.body, fore), at_rest.mark(marks.base.body, corner)};
}

std::string cylinder_lines(const std::string& cylinder) {
  if (cylinder.empty()) return {};
  return fmt::format("cylinders:\n  push: {{on: {}, from: {{on: {}, at: [300, 200, 0]}}}}\n",
                     cylinder == "ground" ? "upper" : "fore",
                     cylinder == "ground" ? "base" : "arm.base");
}

}  // namespace

namespace {

std::vector<double> foundation_weights(const FoundationCase& spec) {  // [N]
  if (spec.light) return {1.2, 2.4, 3.6};
  return {12, 24, 36};
}

// Everything that is read without load, then under each weight, of a robot whose joints are held
// by directions of this stiffness.
std::vector<std::vector<Reading>> seen_of_foundation(const FoundationCase& spec,
                                                     const RobotSpec& robot, const Posture& posture,
                                                     double rigid) {
  const BuildOptions options{.factors = {}, .elements = 8, .rigid = rigid};
  Built built = build(robot, posture, options);
  Structure& s = built.structure;
  Matrix6& mount = s.coupling(built.mounts[0]).stiffness;
  mount.diagonal().tail<3>().setConstant(1 / spec.foundation);
  const std::vector<int>& upper = built.beams_bodies.at("upper");
  const Mark flange = built.link_starts.at("fore");
  const Marks marks{s.coupling(built.mounts[0]).b,
                    s.mark(built.beams_bodies.at("fore").back(), posture.platform),
                    s.mark(upper.back(), s.pose_of(flange)), built.platform};
  // Of a robot that nothing has bent yet: the line of a cylinder is that without load.
  const Structure at_rest = build(robot, posture, options).structure;
  const CylinderEnds ends = cylinder_ends(spec, at_rest, marks, posture.platform);
  std::vector<std::vector<Reading>> seen;
  const auto settle = [&](const std::vector<DeadLoad>& loads) {
    constexpr int more = 3;
    if (!s.settle(loads, more)) throw std::runtime_error("the twin finds no equilibrium");
    seen.push_back(all_readings(spec, s, marks));
  };
  settle({});
  for (const double weight : foundation_weights(spec))
    if (spec.cylinder.empty())
      settle({{built.platform, Vector3(0, 0, -weight), Vector3::Zero()}});
    else
      settle(push(at_rest, ends, weight));
  return seen;
}

// The same with what the stiff directions give extrapolated away: stiff ones of 1e12 N/m would
// leave rounding of 1e-9 m in the soft ones.
std::vector<std::vector<Reading>> exact_readings(const FoundationCase& spec, const RobotSpec& robot,
                                                 const Posture& posture) {
  constexpr double rigid = 1e-2;
  const auto once = seen_of_foundation(spec, robot, posture, rigid);
  auto result = seen_of_foundation(spec, robot, posture, 2 * rigid);
  for (std::size_t i = 0; i < result.size(); ++i)
    for (std::size_t k = 0; k < result[i].size(); ++k)
      result[i][k].value = 2 * result[i][k].value - once[i][k].value;
  return result;
}

}  // namespace

void write_foundation(const FoundationCase& spec, const std::filesystem::path& folder) {
  RobotSpec robot = arm_3r();
  for (Item& item : robot.chains[0].items)
    if (item.name == "q2" || item.name == "q3") item.stiffness *= spec.softer;
  Random random(spec.seed);
  const std::vector<double> weights = foundation_weights(spec);
  std::string table, head;
  int id = 0;
  const double postures[][3] = {
      {0, -40, 70}, {50, -20, 40}, {-70, -60, 100}, {110, -30, 30}, {20, -75, 90}};
  for (const auto& q : postures) {
    const Posture posture = posture_of(robot, degree * Vector3(q[0], q[1], q[2]));
    const std::vector<std::vector<Reading>> seen = exact_readings(spec, robot, posture);
    const std::vector<Reading>& zero = seen[0];
    for (std::size_t w = 0; w < weights.size(); ++w) {
      const std::vector<Reading>& loaded = seen[w + 1];
      const double written = spec.cylinder.empty() ? -weights[w] : weights[w];
      table += fmt::format("w{},{:g},{:g},{:g},{:g}", ++id, q[0], q[1], q[2], written);
      head = fmt::format("id,q1 [deg],q2 [deg],q3 [deg],{} [N]",
                         spec.cylinder.empty() ? "fz" : "push");
      for (std::size_t k = 0; k < zero.size(); ++k) {
        const double error = zero[k].noise * random.normal();
        if (!is_wanted(spec, zero[k].name)) continue;
        const double read = loaded[k].value - zero[k].value + error;
        const bool turns = zero[k].name.find('.') != std::string::npos;
        head += fmt::format(",{} [{}]", zero[k].name, turns ? "urad" : "um");
        table += fmt::format(",{:.{}f}", read / zero[k].unit, spec.light ? 9 : 6);
      }
      table += "\n";
    }
  }
  std::filesystem::create_directories(folder);
  write_text(folder / "robot.yaml", owners_file(spec, robot));
  write_text(folder / "readings.csv", head + "\n" + table);
  write_text(folder / "campaign.yaml",
             "# Made by tests/twin, a simulator that shares no code with the product.\n"
             "kinetostat: 1\ncampaign: arm on a foundation\norigin: simulated\nrobot: robot.yaml\n"
             "units: {length: mm, force: N, angle: deg}\ndisplacement: difference\n"
             "datum_noise: {translation: 0 um, rotation: 0 urad}\nwrench_point: reference\n" +
                 sensor_lines(spec) + cylinder_lines(spec.cylinder) + "readings: readings.csv\n");
}

namespace {

// A tracker that stands anywhere, and a target somewhere on the flange.
const Pose tracker{Vector3(2.4, -1.1, 0.3), rotation_of(Vector3(0.3, -0.2, 2.1))};
const Vector3 target(0.045, -0.030, 0.085), payload_at(0.1, 0, 0.05);  // platform axes [m]

std::string tracker_robot(const TrackerCase& spec, const RobotSpec& robot) {
  std::vector<double> believed;
  for (const std::string& spring : robot.springs())
    believed.push_back(spring == "q2" || spring == "q3" ? 1 / spec.softer : 1);
  const std::string text = robot_file(robot, believed);
  return text.substr(0, text.find("uncertain:")) +
         "uncertain:\n  - {stiffness: q2, between: [0.3, 3]}\n  - {stiffness: q3, between: [0.3, "
         "3]}\n";
}

}  // namespace

void write_tracker(const TrackerCase& spec, const std::filesystem::path& folder) {
  RobotSpec robot = arm_6r();
  for (Item& item : robot.chains[0].items)
    if (item.name == "q2" || item.name == "q3") item.stiffness *= spec.softer;
  Random random(spec.seed);
  std::string table =
      "id,q1 [deg],q2 [deg],q3 [deg],q4 [deg],q5 [deg],q6 [deg],payload [kg],dx [mm],dy [mm],dz "
      "[mm]\n";
  const Vector6 middle = (Vector6() << 0, -20, 30, 0, 40, 0).finished();
  const Vector6 span = (Vector6() << 110, 45, 50, 90, 60, 120).finished();
  for (int i = 0; i < 30; ++i) {
    Vector6 q = middle;
    for (Eigen::Index k = 0; k < 6; ++k) q[k] += span[k] * (2 * random.uniform() - 1);
    Built built = build(robot, posture_of(robot, degree * q), {.factors = {}, .elements = 8});
    Structure& s = built.structure;
    const auto on_flange = [&](const Vector3& at) {
      const Pose flange = s.pose_of(built.platform);
      return s.mark(built.platform.body, {flange.x + flange.R * at, flange.R});
    };
    const Mark seen = on_flange(target), hung = on_flange(payload_at);
    if (!s.settle({{hung, Vector3(0, 0, -9.80665 * spec.payload), Vector3::Zero()}}))
      throw std::runtime_error("the twin finds no equilibrium");
    const Vector3 read = tracker.R.transpose() * (s.pose_of(seen).x - tracker.x);
    table += fmt::format("p{}", i + 1);
    for (const double angle : q) table += fmt::format(",{:.10g}", angle);
    table += fmt::format(",{:g}", spec.payload);
    for (const double value : read)
      table += fmt::format(",{:.7f}", 1e3 * (value + spec.noise * random.normal()));
    table += "\n";
  }
  std::filesystem::create_directories(folder);
  write_text(folder / "robot.yaml", tracker_robot(spec, robot));
  write_text(folder / "readings.csv", table);
  write_text(folder / "campaign.yaml",
             fmt::format("# Made by tests/twin, a simulator that shares no code with the product.\n"
                         "kinetostat: 1\ncampaign: tracker and payload\norigin: simulated\nrobot: "
                         "robot.yaml\nunits: {{length: mm, force: N, angle: deg}}\ndisplacement: "
                         "absolute\nsession_frame: estimate\ntarget_pose: estimate\nweights: "
                         "{{payload: {{on: platform, at: [100, 0, 50]}}}}\nnoise: {{translation: "
                         "{:g} um}}\nreadings: readings.csv\n",
                         1e6 * spec.noise));
}

namespace {

const Vector3 corners[] = {{0.1, 0.4, 0}, {0.1, -0.4, 0}, {-0.1, -0.4, 0}, {-0.1, 0.4, 0}};  // [m]

struct Hung {
  int cycle;
  double left, right;  // [kg], half a metre from the axis
};

std::vector<Hung> weights_of_frame() {
  std::vector<Hung> result;
  for (int cycle = 1; cycle <= 4; ++cycle)
    for (const double mass : {10, 20, 40, 60, 40, 20, 10})
      result.push_back({cycle, cycle % 2 == 1 ? mass : 0, cycle % 2 == 0 ? mass : 0});
  return result;
}

std::string frame_campaign(const FrameCase& spec) {
  std::string gauges;
  for (int i = 0; i < 4; ++i)
    gauges += fmt::format(
        "  dial_{}: {{kind: gauge, on: platform, at: [{:g}, {:g}, 0], direction: [0, 0, 1], noise: "
        "{:g} um}}\n",
        i + 1, 1e3 * corners[i].x(), 1e3 * corners[i].y(), 1e6 * spec.noise);
  return "# Made by tests/twin, a simulator that shares no code with the product.\n"
         "kinetostat: 1\ncampaign: frame in torsion\norigin: simulated\nrobot: robot.yaml\n"
         "units: {length: mm, force: N, angle: deg}\ndisplacement: difference\n"
         "datum_noise: 0\nweights:\n  left: {on: platform, at: [0, 500, 0]}\n"
         "  right: {on: platform, at: [0, -500, 0]}\nsensors:\n" +
         gauges + "readings: readings.csv\n";
}

}  // namespace

void write_frame(const FrameCase& spec, const std::filesystem::path& folder) {
  RobotSpec robot = frame();
  const std::string owners = robot_file(robot, {1, 1});
  robot.chains[0].items[0].stiffness *= spec.softer;
  const Posture posture = posture_of(robot, Eigen::VectorXd::Zero(1));
  Built built = build(robot, posture, {.factors = {}, .elements = 8});
  if (spec.play > 0)
    apply_to_structure({.name = "clearance", .at = "bolts", .size = spec.play}, robot, posture,
                       built);
  Structure& s = built.structure;
  const Pose plate = s.pose_of(built.platform);
  const auto on_plate = [&](const Vector3& at) {
    return s.mark(built.platform.body, {plate.x + plate.R * at, plate.R});
  };
  const Mark left = on_plate({0, 0.5, 0}), right = on_plate({0, -0.5, 0});
  std::vector<Mark> gauges;
  for (const Vector3& corner : corners) gauges.push_back(on_plate(corner));
  Random random(spec.seed);
  std::string table =
      "id,cycle,step,q,left [kg],right [kg],dial_1 [um],dial_2 [um],dial_3 [um],dial_4 [um]\n";
  int id = 0;
  const auto heights = [&](double mass_left, double mass_right) {
    const auto weight = [](double mass) { return Vector3(0, 0, -9.80665 * mass); };
    if (!s.settle({{left, weight(mass_left), Vector3::Zero()},
                   {right, weight(mass_right), Vector3::Zero()}}))
      throw std::runtime_error("the twin finds no equilibrium");
    std::vector<double> result;
    for (const Mark& gauge : gauges) result.push_back(s.pose_of(gauge).x.z());
    return result;
  };
  const std::vector<double> zero = heights(0, 0);
  for (const Hung& hung : weights_of_frame()) {
    const std::vector<double> loaded = heights(hung.left, hung.right);
    ++id;
    table += fmt::format("w{0},{1},{0},0,{2:g},{3:g}", id, hung.cycle, hung.left, hung.right);
    for (std::size_t i = 0; i < zero.size(); ++i)
      table += fmt::format(",{:.6f}", 1e6 * (loaded[i] - zero[i] + spec.noise * random.normal()));
    table += "\n";
  }
  std::filesystem::create_directories(folder);
  write_text(folder / "robot.yaml", owners.substr(0, owners.find("uncertain:")) +
                                        "uncertain:\n  - {stiffness: bolts, between: [0.3, 3]}\n");
  write_text(folder / "readings.csv", table);
  write_text(folder / "campaign.yaml", frame_campaign(spec));
}

}  // namespace twin
