#include "kinetostat/report/manipulators/manipulator.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "kinetostat/io/text_file.h"
#include "kinetostat/report/manipulators/pose.h"
#include "kinetostat/report/text/text.h"
#include "kinetostat/spatial/rotation.h"

namespace kinetostat::report {
namespace {

using io::Json;
using spatial::Vector3;
using vjm::Chain;
using vjm::Equilibrium;
using vjm::EquilibriumStatus;
using vjm::Robot;
using vjm::Stability;
using vjm::UnloadedStiffness;

double unit(const std::string& name) { return spatial::parse_unit(name).factor; }

std::string vector_text(const Vector3& v, double factor, double negligible) {
  const auto shown = [&](double x) { return number(std::abs(x) < negligible ? 0 : x / factor, 7); };
  return fmt::format("({}, {}, {})", shown(v.x()), shown(v.y()), shown(v.z()));
}

// Joint values that a posture chooses, "rho = -449.5 mm".
std::vector<std::string> joint_values(const Robot& robot, const Chain& chain,
                                      const Eigen::VectorXd& x) {
  std::vector<std::string> values;
  for (const Eigen::Index k : chain.posture_coordinates()) {
    const vjm::Coordinate& c = chain.coordinates()[static_cast<std::size_t>(k)];
    const std::string& u = is_rotation(c.motion) ? robot.units.angle : robot.units.length;
    const double value = std::abs(x[k]) < 1e-12 ? 0 : x[k] / unit(u);
    values.push_back(fmt::format("{} = {} {}", c.name, number(value, 7), u));
  }
  return values;
}

template <class Matrix>
Json matrix_json(const Matrix& matrix, const char* key) {
  const Json keyed = io::to_json(matrix);
  Json json{{"matrix", nullptr}};
  for (const auto& [name, value] : keyed.items()) json[name == key ? "matrix" : name] = value;
  return json;
}

Json optional_json(const std::optional<spatial::Stiffness6>& m) {
  return m ? matrix_json(*m, "stiffness") : Json();
}
Json optional_json(const std::optional<spatial::Compliance6>& m) {
  return m ? matrix_json(*m, "compliance") : Json();
}

std::string matrices_text(const Robot& robot, const std::optional<spatial::Stiffness6>& stiffness,
                          const std::optional<spatial::Compliance6>& compliance) {
  std::string out;
  if (stiffness) out += text(*stiffness, robot.units) + "\n";
  if (compliance) out += text(*compliance, robot.units) + "\n";
  return out;
}

Json coordinates_json(const Chain& chain, const Eigen::VectorXd& x) {
  Json json = Json::object();
  for (Eigen::Index k = 0; k < chain.size(); ++k)
    json[chain.coordinates()[static_cast<std::size_t>(k)].name] = x[k];
  return json;
}

// K_q and K_theta (MMT11 eq. 29): how the coordinates of a chain change with the displacement of
// its end, those of perfect passive joints and those with a spring (or held by a drive). Null when
// some chain is rigid in some direction.
Json motion_json(const Chain& chain, const vjm::ChainEquilibrium& state) {
  if (state.motion.rows() == 0) return nullptr;
  const spatial::Wrench& at = state.wrench;
  Json passive = Json::object(), sprung = Json::object(), units = Json::object();
  for (Eigen::Index k = 0; k < chain.size(); ++k) {
    const vjm::Coordinate& c = chain.coordinates()[static_cast<std::size_t>(k)];
    const bool is_free = c.role == vjm::Role::passive && chain.stiffness()(k, k) == 0;
    std::array<double, 6> row{};
    for (Eigen::Index j = 0; j < 6; ++j) row[static_cast<std::size_t>(j)] = state.motion(k, j);
    (is_free ? passive : sprung)[c.name] = row;
    units[c.name] = is_rotation(c.motion) ? "rad" : "m";
  }
  return {{"K_q", passive},
          {"K_theta", sprung},
          {"order", {"tx", "ty", "tz", "rx", "ry", "rz"}},
          {"units", units},
          {"point", io::to_json(at.frame.point)},
          {"axes", io::rows(at.frame.axes.transpose())}};
}

Json stability_json(const Stability& s) {
  // JSON has no infinity: no margin means that no motion is left to be unstable.
  return {{"stable", s.stable()},
          {"unstable_directions", s.unstable},
          {"neutral_directions", s.neutral},
          {"margin", std::isfinite(s.margin) ? Json(s.margin) : Json()}};
}

std::string stability_text(const Stability& s) {
  std::string out = s.stable() ? "stable"
                               : fmt::format("unstable in {} direction{}", s.unstable,
                                             s.unstable == 1 ? "" : "s");
  if (s.neutral > 0)
    out += fmt::format(", {} motion{} cost{} nothing", s.neutral, s.neutral == 1 ? "" : "s",
                       s.neutral == 1 ? "s" : "");
  return out;
}

std::string status_name(EquilibriumStatus status) {
  switch (status) {
    case EquilibriumStatus::converged:
      return "converged";
    case EquilibriumStatus::rigid:
      return "rigid";
    case EquilibriumStatus::unsupported:
      return "unsupported";
    case EquilibriumStatus::not_converged:
      break;
  }
  return "not converged";
}

// One row a chain: its wrench in the units of the file, and a last column.
std::string wrench_table(const Robot& robot, const std::vector<spatial::Wrench>& wrenches,
                         const std::string& last_heading, const std::vector<std::string>& last) {
  const double force = unit(robot.units.force), length = unit(robot.units.length);
  double size = 0;
  for (const spatial::Wrench& w : wrenches)
    size = std::max({size, w.force.norm(), w.moment.norm() / length});
  const auto shown = [size](double v, double factor) {
    return number(std::abs(v) <= 1e-12 * size * factor ? 0 : v / factor, 6);
  };
  Table table({"wrench on chain", "Fx", "Fy", "Fz", "Mx", "My", "Mz", last_heading});
  for (std::size_t c = 0; c < wrenches.size(); ++c) {
    std::vector<std::string> row{robot.manipulator.chains()[c].name()};
    for (int i = 0; i < 3; ++i) row.push_back(shown(wrenches[c].force[i], force));
    for (int i = 0; i < 3; ++i) row.push_back(shown(wrenches[c].moment[i], force * length));
    row.push_back(last[c]);
    table.add_row(row);
  }
  return table.text();
}

std::string chain_wrenches_text(const Robot& robot, const Equilibrium& equilibrium) {
  std::vector<spatial::Wrench> wrenches;
  std::vector<std::string> held;
  for (const vjm::ChainEquilibrium& chain : equilibrium.chains) {
    wrenches.push_back(chain.wrench);
    held.push_back(stability_text(chain.held));
  }
  return fmt::format(
      "Wrenches on the chains, moments about the platform's reference point, base axes [{}; {} {}]:"
      "\n{}",
      robot.units.force, robot.units.force, robot.units.length,
      wrench_table(robot, wrenches, "held", held));
}

}  // namespace

std::string text(const Robot& robot, const vjm::Posture& posture) {
  const double length = unit(robot.units.length), angle = unit(robot.units.angle);
  std::string out =
      fmt::format("Platform at {} {}, rotation vector {} {}\n",
                  vector_text(posture.platform.position(), length, 1e-12), robot.units.length,
                  vector_text(spatial::log_rotation(posture.platform.rotation()), angle, 1e-12),
                  robot.units.angle);
  for (std::size_t c = 0; c < robot.manipulator.size(); ++c) {
    const Chain& chain = robot.manipulator.chains()[c];
    if (robot.manipulator.is_within_elastic_body(c)) continue;
    out += fmt::format("  chain {}: {}\n", chain.name(),
                       fmt::join(joint_values(robot, chain, posture.coordinates[c]), ", "));
  }
  return out + "\n";
}

Json to_json(const Robot& robot, const vjm::Posture& posture) {
  Json json = to_json(posture.platform);
  for (std::size_t c = 0; c < robot.manipulator.size(); ++c) {
    const Chain& chain = robot.manipulator.chains()[c];
    Json joints = Json::object();
    for (const Eigen::Index k : chain.posture_coordinates())
      joints[chain.coordinates()[static_cast<std::size_t>(k)].name] = posture.coordinates[c][k];
    json["joints"][chain.name()] = joints;
  }
  return json;
}

Json inputs_and_posture(const Robot& robot, const vjm::Posture& posture) {
  return {{"inputs", provenance(robot)}, {"posture", to_json(robot, posture)}};
}

namespace {

std::string ranks_of_chains(const Robot& robot, const UnloadedStiffness& s) {
  std::string out;
  for (std::size_t c = 0; c < s.per_chain.size(); ++c) {
    if (robot.manipulator.is_within_elastic_body(c)) continue;
    out += fmt::format("  chain {} alone: ", robot.manipulator.chains()[c].name());
    out += s.per_chain[c] ? fmt::format("rank {}\n", s.free_per_chain[c].rank)
                          : "rigid in some direction\n";
  }
  return out;
}

}  // namespace

std::string text(const Robot& robot, const UnloadedStiffness& s) {
  std::string out = matrices_text(robot, s.stiffness, s.compliance);
  if (!s.stiffness && !s.compliance)
    out += "Some motions are free and others rigid: neither matrix exists.\n";
  out += fmt::format("Rank {}.\n", s.stiffness ? s.free.rank : s.rigid.rank);
  for (const std::string& sentence : s.free.sentences) out += "  " + sentence + "\n";
  for (const std::string& sentence : s.rigid.sentences) out += "  " + sentence + "\n";
  if (s.per_chain.size() > 1) out += ranks_of_chains(robot, s);
  if (robot.manipulator.has_errors())
    out +=
        "That is the nominal robot: its chains do not close with their geometric errors, unless "
        "they\nstrain each other. As it is assembled it stands under Loaded.\n";
  return out;
}

Json to_json(const Robot& robot, const UnloadedStiffness& s) {
  Json json{{"stiffness", optional_json(s.stiffness)},
            {"compliance", optional_json(s.compliance)},
            {"rank", s.stiffness ? s.free.rank : s.rigid.rank},
            {"free_motions", s.free.sentences},
            {"rigid_directions", s.rigid.sentences},
            {"chains", Json::array()}};
  for (std::size_t c = 0; c < s.per_chain.size(); ++c)
    json["chains"].push_back({{"name", robot.manipulator.chains()[c].name()},
                              {"stiffness", optional_json(s.per_chain[c])},
                              {"rank", s.per_chain[c] ? Json(s.free_per_chain[c].rank) : Json()},
                              {"free_motions", s.free_per_chain[c].sentences}});
  return json;
}

std::string text(const Robot& robot, const Equilibrium& e) {
  std::string out;
  if (e.status != EquilibriumStatus::converged)
    out += fmt::format("NOT REACHED: {}.\nThe last equilibrium on the way, at {:.4g} %:\n\n",
                       e.reason, 100 * e.reached);
  out += text(e.displacement, robot.units);
  out += text(e.wrench, robot.units) + "\n";
  out += matrices_text(robot, e.stiffness, e.compliance);
  out += chain_wrenches_text(robot, e);
  out += fmt::format("Platform held: {}. Platform free under the dead load: {}.\n",
                     stability_text(e.held), stability_text(e.free));
  out += fmt::format("Elastic energy {} J. {} load step{}, last Newton corrections {:.1e}.\n",
                     number(e.energy, 6), e.steps, e.steps == 1 ? "" : "s",
                     fmt::join(e.corrections, ", "));
  return out;
}

Json to_json(const Robot& robot, const Equilibrium& e) {
  Json json{
      {"status", status_name(e.status)},
      {"reason", e.reason},
      {"reached", e.reached},
      {"platform", to_json(e.platform)},
      {"displacement", io::to_json(e.displacement)},
      {"wrench", io::to_json(e.wrench)},
      {"stiffness", optional_json(e.stiffness)},
      {"compliance", optional_json(e.compliance)},
      {"stability",
       {{"platform_held", stability_json(e.held)}, {"platform_free", stability_json(e.free)}}},
      {"energy", e.energy},
      {"load_steps", e.steps},
      {"newton_corrections", e.corrections},
      {"chains", Json::array()}};
  for (std::size_t c = 0; c < e.chains.size(); ++c) {
    const Chain& chain = robot.manipulator.chains()[c];
    json["chains"].push_back({{"name", chain.name()},
                              {"wrench", io::to_json(e.chains[c].wrench)},
                              {"stiffness", optional_json(e.chains[c].stiffness)},
                              {"stability", stability_json(e.chains[c].held)},
                              {"coordinates", coordinates_json(chain, e.chains[c].coordinates)},
                              {"coordinates_by_displacement", motion_json(chain, e.chains[c])}});
  }
  return json;
}

namespace {

spatial::Twist displacement_of(const vjm::Posture& posture, const vjm::FixedPoint& f) {
  return spatial::Twist::from_coordinates(spatial::pose_difference(posture.platform, f.platform),
                                          {f.platform.position()});
}

}  // namespace

std::string text(const Robot& robot, const vjm::Posture& posture, const vjm::FixedPoint& f) {
  std::string out;
  if (!f.converged)
    out += fmt::format("NOT CONVERGED: {}. The state below is reached at {} %.\n\n", f.reason,
                       number(100 * f.reached, 4));
  out += text(displacement_of(posture, f), robot.units) + text(f.wrench, robot.units);
  out += fmt::format("Fixed-point iteration: eq. 10 was solved {} times, changes {:.1e}.\n",
                     f.iterations, fmt::join(f.changes, ", "));
  return out;
}

Json to_json(const Robot& robot, const vjm::Posture& posture, const vjm::FixedPoint& f) {
  Json json{{"converged", f.converged},
            {"reason", f.reason},
            {"reached", f.reached},
            {"platform", to_json(f.platform)},
            {"displacement", io::to_json(displacement_of(posture, f))},
            {"wrench", io::to_json(f.wrench)},
            {"iterations", f.iterations},
            {"changes", f.changes},
            {"chains", Json::array()}};
  for (std::size_t c = 0; c < f.coordinates.size(); ++c) {
    const Chain& chain = robot.manipulator.chains()[c];
    json["chains"].push_back(
        {{"name", chain.name()}, {"coordinates", coordinates_json(chain, f.coordinates[c])}});
  }
  return json;
}

std::string text(const Robot& robot, const vjm::Assembly& a) {
  std::string out;
  if (a.assembled.status != EquilibriumStatus::converged)
    out += fmt::format("NOT ASSEMBLED: {}.\n", a.assembled.reason);
  out += "To first order\n" + text(a.linear_shift, robot.units);
  out += "On the full equations\n" + text(a.assembled.displacement, robot.units) + "\n";
  out += chain_wrenches_text(robot, a.assembled);
  out += fmt::format("Elastic energy {} J. Platform: {}.\n", number(a.assembled.energy, 6),
                     stability_text(a.assembled.free));
  return out;
}

Json to_json(const Robot& robot, const vjm::Assembly& a) {
  Json json{{"linear_shift", io::to_json(a.linear_shift)}, {"linear_wrenches", Json::array()}};
  for (std::size_t c = 0; c < a.linear_wrenches.size(); ++c)
    json["linear_wrenches"].push_back({{"name", robot.manipulator.chains()[c].name()},
                                       {"wrench", io::to_json(a.linear_wrenches[c])}});
  json["assembled"] = to_json(robot, a.assembled);
  return json;
}

Json provenance(const Robot& robot) {
  const auto sha256_of = [](const std::filesystem::path& file) {
    return io::sha256(io::read_text(file));
  };
  const auto entry = [](const std::filesystem::path& file, const std::string& sha256) {
    return Json{{"file", file.string()}, {"sha256", sha256}};
  };
  Json json{
      {"name", robot.name},
      {"robot", entry(robot.file, robot.sha256.empty() ? sha256_of(robot.file) : robot.sha256)},
      {"links", Json::array()}};
  for (const auto& file : robot.link_files) json["links"].push_back(entry(file, sha256_of(file)));
  return json;
}

}  // namespace kinetostat::report
