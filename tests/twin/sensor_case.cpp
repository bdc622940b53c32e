#include "sensor_case.h"

#include <cmath>
#include <numbers>
#include <stdexcept>
#include <vector>

#include <fmt/format.h>

#include "campaign_text.h"
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

void write_foundation(const FoundationCase& spec, const std::filesystem::path& folder) {
  RobotSpec robot = arm_3r();
  for (Item& item : robot.chains[0].items)
    if (item.name == "q2" || item.name == "q3") item.stiffness *= spec.softer;
  Random random(spec.seed);
  std::string table, head;
  int id = 0;
  const double postures[][3] = {
      {0, -40, 70}, {50, -20, 40}, {-70, -60, 100}, {110, -30, 30}, {20, -75, 90}};
  for (const auto& q : postures) {
    const Posture posture = posture_of(robot, degree * Vector3(q[0], q[1], q[2]));
    Built built = build(robot, posture, {.factors = {}, .elements = 8});
    Structure& s = built.structure;
    Matrix6& mount = s.coupling(built.mounts[0]).stiffness;
    mount.diagonal().tail<3>().setConstant(1 / spec.foundation);
    const std::vector<int>& upper = built.beams_bodies.at("upper");
    const Mark flange = built.link_starts.at("fore");
    const Marks marks{s.coupling(built.mounts[0]).b,
                      s.mark(built.beams_bodies.at("fore").back(), posture.platform),
                      s.mark(upper.back(), s.pose_of(flange)), built.platform};
    if (!s.settle({})) throw std::runtime_error("the twin finds no equilibrium");
    const std::vector<Reading> zero = all_readings(spec, s, marks);
    for (const double weight : {12.0, 24.0, 36.0}) {
      if (!s.settle({{built.platform, Vector3(0, 0, -weight), Vector3::Zero()}}))
        throw std::runtime_error("the twin finds no equilibrium");
      const std::vector<Reading> loaded = all_readings(spec, s, marks);
      table += fmt::format("w{},{:g},{:g},{:g},{:g}", ++id, q[0], q[1], q[2], -weight);
      head = "id,q1 [deg],q2 [deg],q3 [deg],fz [N]";
      for (std::size_t k = 0; k < zero.size(); ++k) {
        const double error = zero[k].noise * random.normal();
        if (!is_wanted(spec, zero[k].name)) continue;
        const double read = loaded[k].value - zero[k].value + error;
        const bool turns = zero[k].name.find('.') != std::string::npos;
        head += fmt::format(",{} [{}]", zero[k].name, turns ? "urad" : "um");
        table += fmt::format(",{:.6f}", read / zero[k].unit);
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
                 sensor_lines(spec) + "readings: readings.csv\n");
}

}  // namespace twin
