// Orthoglide: the published tables beside ours. Figures of the papers are typed from them.
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "kinetostat/io/text_file.h"
#include "kinetostat/vjm/manipulator/posture.h"
#include "kinetostat/vjm/statics/assembly.h"
#include "kinetostat/vjm/statics/equilibrium.h"
#include "kinetostat/vjm/statics/stiffness.h"

#include "support/temporary_folder.h"
#include "tables.h"

namespace kinetostat::theory {

const std::vector<NamedPoint> orthoglide_points = {{"Q0", {0, 0, 0}},
                                                   {"Q1", {0.12635, 0.12635, 0.12635}},
                                                   {"Q2", {-0.07365, -0.07365, -0.07365}},
                                                   {"Q3", {0.12635, 0.12635, -0.07365}},
                                                   {"Q4", {-0.07365, -0.07365, 0.12635}}};

namespace {

using spatial::Matrix6;
using spatial::Pose;
using spatial::Vector3;
using spatial::Vector6;

vjm::Posture posture_of(const vjm::Manipulator& manipulator, const Vector3& point) {
  return posture_at(manipulator, Pose::translation(point)).posture;
}

// Rounded, without a sign on zero.
std::string shown(double value, int decimals) {
  const double unit = std::pow(10.0, -decimals);
  const double rounded = std::round(value / unit) * unit;
  return fmt::format("{:.{}f}", rounded == 0 ? 0.0 : rounded, decimals);
}

std::string pair(double ours, double paper, int decimals) {
  return fmt::format("{} ({})", shown(ours, decimals), shown(paper, decimals));
}

// Blocks of a compliance in the units of JAMRIS09: 1e-4 mm/N and 1e-7 rad/(N mm).
struct Blocks {
  double translation, translation_coupling, rotation, rotation_coupling;
};
Blocks blocks(const Matrix6& c) {
  return {c(0, 0) / 1e-7, c(0, 1) / 1e-7, c(3, 3) / 1e-4, c(3, 4) / 1e-4};
}

struct JamrisRow {
  const char* point;  // JAMRIS09 names
  double coordinate;
  Blocks unloaded, loaded;
  double force, moment;
};

}  // namespace

std::string jamris_table_1_and_3() {
  const JamrisRow paper[] = {
      {"Q0", 0, {2.78, 0, 20.9, 0}, {2.74, -0.02, 16.7, -0.02}, 1823, -101},
      {"Q1", -0.07365, {10.9, 5.5, 24.1, 7.5}, {10.5, 5.3, 22.0, 6.0}, 234, 524},
      {"Q2", 0.12635, {71.3, -35.0, 25.8, -7.4}, {39.1, -18.9, 15.4, -0.7}, 4104, -2525}};
  const vjm::Robot robot = shipped("orthoglide.yaml");
  std::vector<std::vector<std::string>> rows;
  for (const JamrisRow& row : paper) {
    const vjm::Posture posture = posture_of(robot.manipulator, Vector3::Constant(row.coordinate));
    const Blocks u = blocks(unloaded_stiffness(robot.manipulator, posture).compliance->matrix());
    const vjm::Equilibrium e = equilibrium_at_pose(
        robot.manipulator, posture,
        spatial::displaced(posture.platform, Vector6{5e-4, 5e-4, 5e-4, 0, 0, 0}));
    const Blocks l = blocks(e.compliance->matrix());
    const auto four = [](const Blocks& ours, const Blocks& theirs) {
      return std::vector<std::string>{
          pair(ours.translation, theirs.translation, 2),
          pair(ours.translation_coupling, theirs.translation_coupling, 2),
          pair(ours.rotation, theirs.rotation, 1),
          pair(ours.rotation_coupling, theirs.rotation_coupling, 2)};
    };
    std::vector<std::string> cells{row.point, "unloaded"};
    for (const std::string& c : four(u, row.unloaded)) cells.push_back(c);
    cells.insert(cells.end(), {"", ""});
    rows.push_back(cells);
    cells = {"", "0.5 mm each way"};
    for (const std::string& c : four(l, row.loaded)) cells.push_back(c);
    cells.push_back(pair(e.wrench.force.x(), row.force, 0));
    cells.push_back(pair(1e3 * e.wrench.moment.x(), row.moment, 0));
    rows.push_back(cells);
  }
  return markdown({"point", "", "c_t", "c_t coupling", "c_r", "c_r coupling", "F [N]", "M [N mm]"},
                  rows);
}

std::string jamris_table_2() {
  const JamrisRow paper[] = {{"Q0", 0, {2.78, 0, 1.94, 0}, {}, 0, 0},
                             {"Q1", -0.07365, {9.86, 5.80, 2.06, -0.32}, {}, 0, 0},
                             {"Q2", 0.12635, {21.2, -10.2, 2.65, 1.14}, {}, 0, 0}};
  const vjm::Robot robot = shipped("orthoglide_prpar.yaml");
  std::vector<std::vector<std::string>> rows;
  for (const JamrisRow& row : paper) {
    const vjm::Posture posture = posture_of(robot.manipulator, Vector3::Constant(row.coordinate));
    const Blocks c = blocks(unloaded_stiffness(robot.manipulator, posture).compliance->matrix());
    rows.push_back({row.point, pair(c.translation, row.unloaded.translation, 2),
                    pair(c.translation_coupling, row.unloaded.translation_coupling, 2),
                    pair(c.rotation, row.unloaded.rotation, 2),
                    pair(c.rotation_coupling, row.unloaded.rotation_coupling, 2)});
  }
  return markdown({"point", "c_t", "c_t coupling", "c_r", "c_r coupling"}, rows);
}

namespace {

// A shipped robot with a piece of its text replaced everywhere.
vjm::Robot variant(const std::string& name, const std::string& from, const std::string& to) {
  std::string text = io::read_text(std::string(KINETOSTAT_SOURCE_DIR) + "/data/robots/" + name);
  for (std::size_t at = text.find(from); at != std::string::npos;
       at = text.find(from, at + to.size()))
    text.replace(at, from.size(), to);
  const test::TemporaryFolder folder;
  io::write_atomically(folder.path() / name, text);
  return vjm::read_robot(folder.path() / name);
}

std::string three(const Vector3& ours, const Vector3& paper, int decimals) {
  const auto list = [decimals](const Vector3& v) {
    return fmt::format("{}, {}, {}", shown(v.x(), decimals), shown(v.y(), decimals),
                       shown(v.z(), decimals));
  };
  return fmt::format("{} ({})", list(ours), list(paper));
}

}  // namespace

std::string nonperf_table_1() {
  const Vector3 paper[] = {Vector3::Constant(1),
                           Vector3::Constant(0.50),
                           Vector3::Constant(2.02),
                           {0.73, 0.73, 0.27},
                           {0.56, 0.56, 1.28}};
  const vjm::Robot robot =
      variant("orthoglide_errors.yaml", "rotation_vector: [1, 0, 0]", "point: [1, 0, 0]");
  std::vector<std::vector<std::string>> rows;
  for (std::size_t i = 0; i < orthoglide_points.size(); ++i) {
    const vjm::Assembly a =
        assemble(robot.manipulator, posture_of(robot.manipulator, orthoglide_points[i].position));
    double largest = 0;
    for (const vjm::ChainEquilibrium& chain : a.assembled.chains)
      largest = std::max(largest, chain.wrench.force.norm());
    rows.push_back({orthoglide_points[i].name, three(1e3 * a.linear_shift.translation, paper[i], 2),
                    three(1e3 * a.assembled.displacement.translation, paper[i], 2),
                    largest < 1e-6 ? "0" : fmt::format("{:.2g} N", largest)});
  }
  return markdown({"point", "linear shift [mm]", "nonlinear shift [mm]", "internal forces"}, rows);
}

std::string nonperf_table_2() {
  struct Row {
    Vector3 shift, turn;  // [mm], [deg]
    double moment;        // [N m]
  };
  const Row paper[] = {{Vector3::Constant(0), Vector3::Constant(0.03), 2.09},
                       {Vector3::Constant(0.41), Vector3::Constant(-0.62), 8.91},
                       {Vector3::Constant(-0.96), Vector3::Constant(0.21), 1.48},
                       {{-0.91, 1.31, 0.58}, {-0.19, -0.49, 0.44}, 4.33},
                       {{0.93, -0.10, -0.25}, {0.33, 0.22, -0.31}, 2.98}};
  const vjm::Robot robot = shipped("orthoglide_errors.yaml");
  std::vector<std::vector<std::string>> rows;
  for (std::size_t i = 0; i < orthoglide_points.size(); ++i) {
    const vjm::Assembly a =
        assemble(robot.manipulator, posture_of(robot.manipulator, orthoglide_points[i].position));
    double largest = 0;
    for (std::size_t c = 0; c < robot.manipulator.size(); ++c)
      if (robot.manipulator.span(c).to == vjm::Span::platform)
        largest = std::max(largest, a.linear_wrenches[c].moment.norm());
    rows.push_back({orthoglide_points[i].name,
                    three(1e3 * a.linear_shift.translation, paper[i].shift, 2),
                    three(180 / M_PI * a.linear_shift.rotation, paper[i].turn, 2),
                    pair(largest, paper[i].moment, 2)});
  }
  return markdown({"point", "shift [mm]", "rotation [deg]", "largest moment on a chain [N m]"},
                  rows);
}

std::string mmt11_table_2_unloaded() {
  const double paper[] = {3.23, 16.60, 0.42, 9.95, 5.41};
  const auto along_diagonal = [](const std::string& file, const Vector3& point) {
    const vjm::Robot robot = shipped(file);
    const vjm::UnloadedStiffness u =
        unloaded_stiffness(robot.manipulator, posture_of(robot.manipulator, point));
    // Orientation held: the translational block of the stiffness.
    const Matrix6 k = u.stiffness ? u.stiffness->matrix() : u.compliance->inverse().matrix();
    return (k.topLeftCorner<3, 3>() * Vector3::Constant(1 / std::sqrt(3.0))).norm() / 1e6;
  };
  std::vector<std::vector<std::string>> rows;
  for (std::size_t i = 0; i < orthoglide_points.size(); ++i) {
    const NamedPoint& point = orthoglide_points[i];
    rows.push_back({point.name, shown(paper[i], 2),
                    shown(along_diagonal("orthoglide_prpar.yaml", point.position), 2),
                    shown(along_diagonal("orthoglide.yaml", point.position), 2)});
  }
  return markdown({"point", "paper [kN/mm]", "ours, 3-PRPaR", "ours, 3-PUU"}, rows);
}

}  // namespace kinetostat::theory
