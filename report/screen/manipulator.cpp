#include "kinetostat/report/screen/manipulator.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include <Eigen/Eigenvalues>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "kinetostat/report/screen/uncertainty.h"
#include "kinetostat/report/screen/wording.h"
#include "kinetostat/report/text/text.h"
#include "kinetostat/vjm/uncertainty/deflection_numbers.h"
#include "kinetostat/vjm/uncertainty/stiffness_numbers.h"

namespace kinetostat::report {
namespace {

using spatial::Vector3;

constexpr std::size_t most_springs = 6;

double length_of(const vjm::Robot& robot) { return spatial::parse_unit(robot.units.length).factor; }
double force_of(const vjm::Robot& robot) { return spatial::parse_unit(robot.units.force).factor; }
double angle_of(const vjm::Robot& robot) { return spatial::parse_unit(robot.units.angle).factor; }

// Components without the rounding beside the largest.
std::string components(const Vector3& v, int digits) {
  std::vector<std::string> parts;
  const double largest = v.cwiseAbs().maxCoeff();
  for (const double x : v) parts.push_back(std::abs(x) < 1e-3 * largest ? "0" : number(x, digits));
  return fmt::format("({})", fmt::join(parts, ", "));
}

std::string stiffness_unit(const vjm::Robot& robot) {
  return robot.units.force + "/" + robot.units.length;
}

double in_stiffness_unit(const vjm::Robot& robot, double si) {
  return si * length_of(robot) / force_of(robot);
}

// `along`: " along x" where the direction is one of many.
std::string shares_sentence(const std::vector<std::pair<std::string, double>>& places,
                            const std::string& along) {
  constexpr double worth_a_word = 0.1;
  std::vector<std::string> words;
  for (const auto& [place, share] : places)
    if (words.size() < 3 && share >= worth_a_word)
      words.push_back(fmt::format("{} {}", short_percent(share), place));
  return words.empty() ? "" : " Where it yields" + along + ": " + listed(words, "and") + ".";
}

std::string free_sentence(const vjm::UnloadedStiffness& stiffness) {
  std::string text = "The platform has no stiffness in some direction:";
  const std::vector<std::string>& sentences = stiffness.free.sentences;
  for (std::size_t i = 0; i < sentences.size(); ++i) text += (i == 0 ? " " : "; ") + sentences[i];
  return text + ".";
}

std::string joints_in_words(const vjm::Robot& robot, const vjm::Posture& posture) {
  std::vector<std::string> names, values;
  for (std::size_t c = 0; c < robot.manipulator.size(); ++c) {
    const vjm::Chain& chain = robot.manipulator.chains()[c];
    const Eigen::VectorXd x = posture.coordinates_of(chain, c);
    for (Eigen::Index k = 0; k < chain.size(); ++k) {
      const vjm::Coordinate& coordinate = chain.coordinates()[static_cast<std::size_t>(k)];
      if (coordinate.role != vjm::Role::actuated) continue;
      const double unit = is_rotation(coordinate.motion) ? angle_of(robot) : length_of(robot);
      names.push_back(short_name(robot.manipulator, chain.name() + "." + coordinate.name));
      values.push_back(number(std::abs(x[k] / unit) < 1e-9 ? 0 : x[k] / unit, 4));
    }
  }
  if (names.empty() || names.size() > 8) return {};
  return fmt::format("({}) = ({})", fmt::join(names, ", "), fmt::join(values, ", "));
}

// "5170 N/mm +- 9 %", the file's value beside it where the estimate is another one.
std::string stiffness_in_words(const vjm::Robot& robot, double compliance,
                               const std::optional<vjm::Uncertainty>& uncertainty) {
  const auto shown = [&](double c) {
    return fmt::format("{} {}", figure(in_stiffness_unit(robot, 1 / c), 3), stiffness_unit(robot));
  };
  constexpr Eigen::Index along = vjm::StiffnessNumbers::along;
  if (!uncertainty) return shown(compliance);
  const std::string spread = spread_in_words(*uncertainty, along);
  if (!is_off_estimate(*uncertainty, along)) return shown(compliance) + spread;
  return fmt::format("{}{}, however the links are clamped; {} as their files have it",
                     shown(uncertainty->first_order.estimate[along]), spread, shown(compliance));
}

// Without rotations; where these are rigid in some direction, without moments.
std::optional<spatial::Matrix3> translational_stiffness(const vjm::UnloadedStiffness& unloaded) {
  if (unloaded.stiffness)
    return spatial::Matrix3(unloaded.stiffness->matrix().topLeftCorner<3, 3>());
  if (!unloaded.compliance) return std::nullopt;
  const spatial::Matrix3 compliance = unloaded.compliance->matrix().topLeftCorner<3, 3>();
  constexpr double rigid = 1e-12;  // of the softest direction
  Eigen::FullPivLU<spatial::Matrix3> factors(compliance);
  factors.setThreshold(rigid);
  return factors.isInvertible() ? std::optional(spatial::Matrix3(factors.inverse())) : std::nullopt;
}

// Rows of the translational stiffness, the springs that yield most beside them.
std::string stiffness_table(const vjm::Robot& robot, const vjm::UnloadedStiffness& stiffness,
                            const std::vector<std::pair<std::string, double>>& places) {
  const std::optional<spatial::Matrix3> found = translational_stiffness(stiffness);
  const std::string heading =
      !found ? ""
             : fmt::format("{} [{}]  x         y         z",
                           stiffness.stiffness ? "stiffness" : "no moment", stiffness_unit(robot));
  std::string text = fmt::format("  {:<48}  {}\n", heading,
                                 places.empty() ? "" : "yields along the softest direction");
  const std::size_t rows = std::max<std::size_t>(3, std::min(places.size(), most_springs));
  const spatial::Matrix3 k = found.value_or(spatial::Matrix3::Zero());
  const double largest = k.cwiseAbs().maxCoeff();
  for (std::size_t i = 0; i < rows; ++i) {
    std::string left;
    if (i < 3 && found) {
      left = fmt::format("{:>14}  ", std::string(1, "xyz"[i]));
      for (int j = 0; j < 3; ++j) {
        const double value = k(static_cast<Eigen::Index>(i), j);
        left += fmt::format("{:<9} ", std::abs(value) < 1e-9 * largest
                                          ? "0"
                                          : figure(in_stiffness_unit(robot, value), 3));
      }
    }
    std::string right;
    if (i < std::min(places.size(), most_springs))
      right = fmt::format("{:<20} {:<12} {:>11}", places[i].first, bar(places[i].second, 12),
                          short_percent(places[i].second));
    std::string line = fmt::format("  {:<48}  {}", left, right);
    line.erase(line.find_last_not_of(' ') + 1);
    text += line + "\n";
  }
  return text;
}

}  // namespace

SoftestDirection softest_direction(const spatial::Compliance6& compliance) {
  constexpr double alike = 1e-3;  // below it two directions are as soft as each other
  const spatial::Matrix3 block = compliance.matrix().topLeftCorner<3, 3>();
  const Eigen::SelfAdjointEigenSolver<spatial::Matrix3> solver(
      spatial::Matrix3(0.5 * (block + block.transpose())));
  const Vector3& values = solver.eigenvalues();
  SoftestDirection softest{solver.eigenvectors().col(2), values[2], 0};
  spatial::Matrix3 projector = spatial::Matrix3::Zero();
  for (int k = 0; k < 3; ++k)
    if (values[k] >= (1 - alike) * values[2]) {
      const Vector3 v = solver.eigenvectors().col(k);
      projector += v * v.transpose();
      ++softest.dimensions;
    }
  // Of many, the one nearest to a base axis; rounding must not choose.
  if (softest.dimensions > 1) {
    int nearest = 0;
    for (int k = 1; k < 3; ++k)
      if (projector(k, k) > projector(nearest, nearest) + 1e-6) nearest = k;
    softest.direction = Vector3(projector.col(nearest)).normalized();
  }
  Eigen::Index largest = 0;
  softest.direction.cwiseAbs().maxCoeff(&largest);
  if (softest.direction[largest] < 0) softest.direction = -softest.direction;
  return softest;
}

std::vector<std::pair<std::string, double>> by_place(const vjm::Robot& robot,
                                                     const std::vector<vjm::SpringShare>& shares) {
  std::vector<std::pair<std::string, double>> places;
  constexpr double worth_a_row = 0.005;
  for (const vjm::SpringShare& s : shares) {
    if (s.share < worth_a_row) continue;
    places.emplace_back(place_in_words(robot.manipulator, name_of(robot.manipulator, s)), s.share);
  }
  std::stable_sort(places.begin(), places.end(),
                   [](const auto& a, const auto& b) { return a.second > b.second; });
  return places;
}

std::string direction_in_words(const Vector3& v) {
  for (int k = 0; k < 3; ++k)
    if (std::abs(v[k]) > 0.9999) return std::string(v[k] < 0 ? "-" : "") + "xyz"[k];
  return components(v, 2);
}

std::string headline(const vjm::Robot& robot, const vjm::UnloadedStiffness& stiffness,
                     const std::vector<vjm::SpringShare>& shares,
                     const std::optional<vjm::Uncertainty>& uncertainty) {
  if (!stiffness.compliance) return free_sentence(stiffness);
  const SoftestDirection softest = softest_direction(*stiffness.compliance);
  if (!(softest.compliance > 0)) return "The platform does not yield to any force.";
  const std::string direction = direction_in_words(softest.direction);
  return fmt::format("{}: {}.{}{}",
                     softest.dimensions == 3   ? "Equally stiff in all directions"
                     : softest.dimensions == 2 ? "Softest in a plane, along " + direction
                                               : "Softest along " + direction,
                     stiffness_in_words(robot, softest.compliance, uncertainty),
                     shares_sentence(by_place(robot, shares),
                                     softest.dimensions == 3 ? " along " + direction : ""),
                     uncertainty ? blame_sentence(*uncertainty, vjm::StiffnessNumbers::along) : "");
}

std::string first_screen(const vjm::Robot& robot, const vjm::Posture& posture,
                         const vjm::UnloadedStiffness& stiffness,
                         const std::vector<vjm::SpringShare>& shares,
                         const std::optional<vjm::Uncertainty>& uncertainty) {
  std::string text = wrapped(headline(robot, stiffness, shares, uncertainty)) + "\n";
  const std::string joints = joints_in_words(robot, posture);
  text += wrapped(fmt::format("platform at {} {}{}, base axes",
                              components(posture.platform.position() / length_of(robot), 5),
                              robot.units.length, joints.empty() ? "" : ", " + joints),
                  2, 4);
  if (stiffness.compliance)
    text += stiffness_table(robot, stiffness, by_place(robot, shares)) +
            "  rotations, coupling and compliance: --verbose\n";
  if (stiffness.compliance && uncertainty)
    text +=
        budget_text(*uncertainty, vjm::StiffnessNumbers::along,
                    {"that stiffness", in_stiffness_unit(robot, 1), stiffness_unit(robot), true});
  return text;
}

io::Json to_json(const vjm::Robot& robot, const std::vector<vjm::SpringShare>& shares) {
  io::Json list = io::Json::array();
  for (const vjm::SpringShare& s : shares)
    list.push_back({{"spring", name_of(robot.manipulator, s)}, {"share", s.share}});
  return list;
}

std::string spread(const std::optional<vjm::Uncertainty>& uncertainty, Eigen::Index number) {
  return uncertainty ? spread_in_words(*uncertainty, number) : "";
}

// The number that an equilibrium is asked for: the force that holds a displacement, else that.
Eigen::Index asked_for(const vjm::Uncertainty& uncertainty) {
  return uncertainty.first_order.is_uncertain(vjm::DeflectionNumbers::moved)
             ? vjm::DeflectionNumbers::moved
             : vjm::DeflectionNumbers::force;
}

// Rounding alone, beside what the platform moves.
bool is_nothing(const spatial::Wrench& wrench, const vjm::Equilibrium& e) {
  constexpr double rounding = 1e-9;
  if (!e.compliance) return wrench.coordinates().isZero(0);
  const spatial::Vector6 moved = e.compliance->matrix() * wrench.coordinates();
  return moved.head<3>().norm() <= rounding * e.displacement.translation.norm() &&
         moved.tail<3>().norm() <= rounding * e.displacement.rotation.norm();
}

// "217 N along x", "35 N m about z and its weight", or what acts without either.
std::string load_in_words(const vjm::Robot& robot, const vjm::Equilibrium& e,
                          const std::optional<vjm::Uncertainty>& uncertainty) {
  const bool is_heavy = !robot.without_effects().gravity().isZero(0) &&
                        !robot.without_effects().is_relaxed_when_unloaded();
  std::vector<std::string> acting;
  if (is_heavy) acting.emplace_back("its weight");
  if (e.has_inner_loads) acting.emplace_back("the loads at nodes and joints");
  if (is_nothing(e.wrench, e))
    return acting.empty() ? "Without a wrench" : "By " + listed(acting, "and");
  const double force = e.wrench.force.norm(), moment = e.wrench.moment.norm();
  const std::string wrench =
      force > 0
          ? fmt::format("{} {}{} along {}", figure(force / force_of(robot), 4), robot.units.force,
                        spread(uncertainty, vjm::DeflectionNumbers::force),
                        direction_in_words(e.wrench.force / force))
          : fmt::format("{} {} {}{} about {}",
                        figure(moment / (force_of(robot) * length_of(robot)), 4), robot.units.force,
                        robot.units.length, spread(uncertainty, vjm::DeflectionNumbers::moment),
                        direction_in_words(e.wrench.moment / moment));
  acting.insert(acting.begin(), wrench);
  return listed(acting, "and");
}

// "162 um +- 9 %", the file's value beside it where the estimate is another one.
std::string distance_in_words(const vjm::Robot& robot, const vjm::Equilibrium& e,
                              const std::optional<vjm::Uncertainty>& uncertainty) {
  constexpr Eigen::Index moved = vjm::DeflectionNumbers::moved;
  const std::string distance =
      length_in_words(e.displacement.translation.norm(), robot.units.length);
  if (!uncertainty || !is_off_estimate(*uncertainty, moved))
    return distance + spread(uncertainty, moved);
  return fmt::format("{}{}, however the links are clamped; {} as their files have it",
                     length_in_words(uncertainty->first_order.estimate[moved], robot.units.length),
                     spread(uncertainty, moved), distance);
}

std::string headline(const vjm::Robot& robot, const vjm::Equilibrium& e,
                     const std::optional<vjm::Uncertainty>& uncertainty) {
  if (e.status != vjm::EquilibriumStatus::converged)
    return fmt::format("No equilibrium: {} of the load was reached. {}", short_percent(e.reached),
                       e.reason);
  constexpr double rounding = 1e-14;  // [m, rad]
  const double distance = e.displacement.translation.norm(), turn = e.displacement.rotation.norm();
  const std::string unit = length_unit_for(distance, robot.units.length);
  const Vector3 moved = e.displacement.translation / spatial::parse_unit(unit).factor;
  const std::string way =
      distance < rounding
          ? fmt::format("0 {}", robot.units.length)
          : fmt::format("{} {}", distance_in_words(robot, e, uncertainty), components(moved, 3));
  const std::string turned =
      turn < rounding ? fmt::format("0 {}", robot.units.angle)
                      : fmt::format("{} {}{}", number(turn / angle_of(robot), 3), robot.units.angle,
                                    spread(uncertainty, vjm::DeflectionNumbers::turned));
  return fmt::format("{}: the platform moves {} and turns {}. {}{}",
                     load_in_words(robot, e, uncertainty), way, turned,
                     e.free.stable() ? "Stable." : "It would not stay there: unstable.",
                     uncertainty ? blame_sentence(*uncertainty, asked_for(*uncertainty)) : "");
}

namespace {

std::string stiffness_there(const vjm::Robot& robot, const vjm::Equilibrium& e) {
  const double force = e.wrench.force.norm();
  if (!e.compliance || !(force > 0) || is_nothing(e.wrench, e)) return {};
  const Vector3 n = e.wrench.force / force;
  const double along = n.dot(e.compliance->matrix().topLeftCorner<3, 3>() * n);
  const SoftestDirection softest = softest_direction(*e.compliance);
  if (!(along > 0 && softest.compliance > 0)) return {};
  return fmt::format(
      "\n  stiffness along the load, there  {} {}\n"
      "  softest along {}  {} {}\n",
      figure(in_stiffness_unit(robot, 1 / along), 3), stiffness_unit(robot),
      direction_in_words(softest.direction),
      figure(in_stiffness_unit(robot, 1 / softest.compliance), 3), stiffness_unit(robot));
}

}  // namespace

std::string displacement_budget(const vjm::Robot& robot, const vjm::Uncertainty& uncertainty) {
  const Eigen::Index number = asked_for(uncertainty);
  return number == vjm::DeflectionNumbers::moved
             ? budget_text(uncertainty, number,
                           {"displacement", 1 / length_of(robot), robot.units.length})
             : budget_text(uncertainty, number, {"force", 1 / force_of(robot), robot.units.force});
}

std::string first_screen(const vjm::Robot& robot, const vjm::Equilibrium& e,
                         const std::optional<vjm::Uncertainty>& uncertainty) {
  std::string text = wrapped(headline(robot, e, uncertainty));
  if (e.status != vjm::EquilibriumStatus::converged) return text;
  text += stiffness_there(robot, e);
  text += fmt::format(
      "  elastic energy {} J; wrench, tangent stiffness and what each chain carries: "
      "--verbose\n",
      number(e.energy, 3));
  return uncertainty ? text + displacement_budget(robot, *uncertainty) : text;
}

std::string path_budget(const vjm::Robot& robot, const vjm::PathTask& task,
                        const vjm::Uncertainty& uncertainty, Eigen::Index number,
                        bool is_critical) {
  const double length = length_of(robot), force = force_of(robot);
  const std::string place =
      is_critical ? " at the first critical point" : " at the end of the path";
  if (number == 0)
    return vjm::turns(task)
               ? budget_text(uncertainty, 0,
                             {"moment" + place, 1 / (force * length),
                              robot.units.force + " " + robot.units.length})
               : budget_text(uncertainty, 0, {"force" + place, 1 / force, robot.units.force});
  return vjm::turns(task)
             ? budget_text(uncertainty, 1,
                           {"rotation" + place, 1 / angle_of(robot), robot.units.angle})
             : budget_text(uncertainty, 1,
                           {"displacement" + place, 1 / length, robot.units.length});
}

std::string headline(const vjm::Robot& robot, const vjm::Assembly& assembly) {
  const vjm::Equilibrium& e = assembly.assembled;
  if (e.status != vjm::EquilibriumStatus::converged)
    return fmt::format("The chains do not close: {}", e.reason);
  std::string most = "none";
  double force = 0;
  for (std::size_t c = 0; c < e.chains.size(); ++c)
    if (const double size = e.chains[c].wrench.force.norm(); size > force) {
      force = size;
      most = robot.manipulator.chains()[c].name();
    }
  return fmt::format(
      "Assembled, the platform is off by {} and {} {}; the largest internal force is {} {}, in "
      "chain {}.",
      length_in_words(e.displacement.translation.norm(), robot.units.length),
      number(e.displacement.rotation.norm() / angle_of(robot), 3), robot.units.angle,
      figure(force / force_of(robot)), robot.units.force, most);
}

std::string first_screen(const vjm::Robot& robot, const vjm::Assembly& assembly) {
  const vjm::Equilibrium& e = assembly.assembled;
  std::string text = wrapped(headline(robot, assembly));
  if (e.status != vjm::EquilibriumStatus::converged) return text;
  const std::string moment = robot.units.force + " " + robot.units.length;
  Table table({"chain", "internal force " + robot.units.force,
               "moment about the reference point " + moment});
  std::vector<std::pair<double, std::size_t>> order;
  for (std::size_t c = 0; c < e.chains.size(); ++c)
    order.emplace_back(-e.chains[c].wrench.force.norm(), c);
  std::sort(order.begin(), order.end());
  constexpr std::size_t most_chains = 12;
  for (std::size_t i = 0; i < std::min(order.size(), most_chains); ++i) {
    const auto& [force, c] = order[i];
    table.add_row(
        {robot.manipulator.chains()[c].name(), figure(-force / force_of(robot), 4),
         number(e.chains[c].wrench.moment.norm() / (force_of(robot) * length_of(robot)), 4)});
  }
  text +=
      fmt::format("\n  platform  moved {} {}, turned {} {}\n",
                  components(e.displacement.translation / length_of(robot), 4), robot.units.length,
                  components(e.displacement.rotation / angle_of(robot), 4), robot.units.angle);
  return text + "\n" + table.text() +
         fmt::format("  elastic energy {} J; components and joints: --verbose\n",
                     number(e.energy, 3));
}

}  // namespace kinetostat::report
