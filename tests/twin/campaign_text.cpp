#include "campaign_text.h"

#include <fstream>
#include <numbers>
#include <stdexcept>

#include <fmt/format.h>

namespace twin {
namespace {

constexpr double degree = std::numbers::pi / 180;

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
      cells += fmt::format(",{:.3f}", posture.q[0][k] / (axis < 3 ? 1e-3 : degree));
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

void write_campaign(const std::string& name, const RobotSpec& robot, const Plan& plan,
                    const Eigen::Matrix<double, 6, Eigen::Dynamic>& read,
                    const Eigen::Matrix<double, 6, Eigen::Dynamic>& noise, Random& random,
                    const std::filesystem::path& folder) {
  write_text(folder / "campaign.yaml",
             fmt::format("kinetostat: 1\ncampaign: {}\norigin: simulated\nrobot: robot.yaml\n"
                         "units: {{length: mm, force: N, angle: deg, time: s, temperature: degC}}\n"
                         "displacement: {}\n{}wrench_point: reference\nreadings: readings.csv\n",
                         name, plan.absolute ? "absolute" : "difference",
                         plan.absolute ? "session_frame: estimate\n" : ""));
  std::string table = head(robot, plan);
  double humidity = 45;
  int person = 1;
  const int components = plan.rotations ? 6 : 3;
  for (std::size_t i = 0; i < plan.rows.size(); ++i) {
    const Row& row = plan.rows[i];
    humidity += random.normal();
    if (row.starts) person = 1 + random.below(2);
    table += fmt::format("{},{},{},{},{:.0f},{:.2f},{:.1f},{}", i + 1, row.session, row.cycle,
                         row.step, row.time, row.temperature, humidity, person);
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
  write_text(folder / "readings.csv", table);
}

}  // namespace twin
