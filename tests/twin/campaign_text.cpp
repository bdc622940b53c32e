#include "campaign_text.h"

#include <fstream>
#include <numbers>
#include <stdexcept>

#include <fmt/format.h>

namespace twin {
namespace {

using Readings = Eigen::Matrix<double, 6, Eigen::Dynamic>;

std::string head(const RobotSpec& robot, const Plan& plan) {
  std::string line = "id,session,cycle,step,time,temperature,humidity,operator";
  if (robot.serial) {
    for (const Item& item : robot.chains[0].items)
      if (item.kind == Item::actuator) line += "," + item.name;
  } else {
    line += ",x,y,z";
  }
  line += ",fx,fy,fz,direction,dx,dy,dz";
  if (plan.rotations) line += ",rx,ry,rz";
  line += ",sigma_dx,sigma_dy,sigma_dz";
  return line + (plan.rotations ? ",sigma_rx,sigma_ry,sigma_rz\n" : "\n");
}

std::string posture_cells(const RobotSpec& robot, const Posture& posture) {
  std::string cells;
  if (!robot.serial) {
    for (int i = 0; i < 3; ++i) cells += fmt::format(",{:.6f}", posture.platform.x[i] * 1e3);
    return cells;
  }
  Eigen::Index k = 0;
  for (const Item& item : robot.chains[0].items)
    for (const int axis : item.axes) {
      cells += fmt::format(",{:.9g}", posture.q[0][k] / (axis < 3 ? 1e-3 : degree));
      ++k;
    }
  return cells;
}

}  // namespace

void write_text(const std::filesystem::path& path, const std::string& text) {
  std::ofstream file(path);
  if (!(file << text) || !file.flush())
    throw std::runtime_error(fmt::format("cannot write {}", path.string()));
}

namespace {

// `prefix` makes ids and cycles that no other session has.
std::string rows_of(const RobotSpec& robot, const Plan& plan, const Readings& read,
                    const Readings& noise, const std::string& prefix, Random& random) {
  std::string table;
  double humidity = 45;
  int person = 1;
  const int components = plan.rotations ? 6 : 3;
  for (std::size_t i = 0; i < plan.rows.size(); ++i) {
    const Row& row = plan.rows[i];
    humidity += random.normal();
    if (row.starts) person = 1 + random.below(2);
    table +=
        fmt::format("{0}{1},{2},{0}{3},{4},{5:.0f},{6:.2f},{7:.1f},{8}", prefix, i + 1, row.session,
                    row.cycle, row.step, row.time, row.temperature, humidity, person);
    table += posture_cells(robot, plan.postures[static_cast<std::size_t>(row.posture)]);
    table += fmt::format(",{:.3f},{:.3f},{:.3f},{}", row.force.x(), row.force.y(), row.force.z(),
                         row.unloading ? "unloading" : "loading");
    const auto column = static_cast<Eigen::Index>(i);
    for (int c = 0; c < components; ++c)
      table += fmt::format(",{:.8f}", read(c, column) * (c < 3 ? 1e3 : 1 / degree));
    for (int c = 0; c < components; ++c)
      table += fmt::format(",{:.3g}", noise(c, column) * (c < 3 ? 1e3 : 1 / degree));
    table += "\n";
  }
  return table;
}

std::string displacement_line(bool absolute) {
  return absolute ? "displacement: absolute\nsession_frame: estimate\n"
                  : "displacement: difference\n";
}

std::string campaign_text(const std::string& name, bool absolute) {
  return fmt::format(
      "kinetostat: 1\ncampaign: {}\norigin: simulated\nrobot: robot.yaml\n"
      "units: {{length: mm, force: N, angle: deg, time: s, temperature: degC}}\n"
      "{}wrench_point: reference\nreadings: readings.csv\n",
      name, displacement_line(absolute));
}

std::string content_of(const std::filesystem::path& path) {
  std::ifstream file(path);
  std::string text{std::istreambuf_iterator<char>(file), {}};
  if (!file) throw std::runtime_error(fmt::format("cannot read {}", path.string()));
  return text;
}

}  // namespace

void write_campaign(const std::string& name, const RobotSpec& robot, const Plan& plan,
                    const Readings& read, const Readings& noise, Random& random,
                    const std::filesystem::path& folder) {
  write_text(folder / "campaign.yaml", campaign_text(name, plan.absolute));
  write_text(folder / "readings.csv",
             head(robot, plan) + rows_of(robot, plan, read, noise, "", random));
}

void add_session(const std::filesystem::path& from, bool known_loads, const RobotSpec& robot,
                 const Plan& plan, const Readings& read, const Readings& noise, Random& random,
                 const std::filesystem::path& folder) {
  const std::string& session = plan.rows.front().session;
  std::string campaign = content_of(from / "campaign.yaml"),
              readings = content_of(from / "readings.csv");
  if (plan.absolute && campaign.find(displacement_line(true)) == std::string::npos) {
    campaign = campaign_text("planned", true);
    readings = head(robot, plan);
  }
  if (known_loads) {
    const std::string key = "known_loads: [";
    const std::size_t before = campaign.find(key);
    if (before == std::string::npos)
      campaign += fmt::format("{}{}]\n", key, session);
    else
      campaign.insert(before + key.size(), session + ", ");
  }
  write_text(folder / "campaign.yaml", campaign);
  write_text(folder / "readings.csv",
             readings + rows_of(robot, plan, read, noise, session + "-", random));
}

}  // namespace twin
