#include "kinetostat/report/manipulators/compensation.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "kinetostat/io/csv.h"
#include "kinetostat/report/manipulators/manipulator.h"
#include "kinetostat/report/manipulators/pose.h"
#include "kinetostat/report/manipulators/uncertainty.h"
#include "kinetostat/report/text/text.h"

namespace kinetostat::report {
namespace {

using io::Json;
using spatial::Vector6;
using vjm::Compensation;
using vjm::CompensationStatus;

std::string status_name(CompensationStatus status) {
  switch (status) {
    case CompensationStatus::converged:
      return "converged";
    case CompensationStatus::unreachable:
      return "unreachable";
    case CompensationStatus::no_equilibrium:
      return "no equilibrium";
    case CompensationStatus::not_converged:
      break;
  }
  return "not converged";
}

bool has_converged(const Compensation& point) {
  return point.status == CompensationStatus::converged;
}

// Of the six components of what is left at a pose.
Vector6 expanded(const vjm::Uncertainty& uncertainty, std::size_t pose) {
  Vector6 result;
  for (Eigen::Index i = 0; i < 6; ++i)
    result[i] = uncertainty.first_order.expanded(6 * static_cast<Eigen::Index>(pose) + i);
  return result;
}

// Columns and cells of the table, in the units of the robot file.
class PathTable {
 public:
  PathTable(const vjm::Robot& robot, const std::optional<vjm::Uncertainty>& uncertainty)
      : robot_(robot), uncertainty_(uncertainty) {
    const spatial::UnitSystem& u = robot.units;
    units_ = {u.length, u.angle, u.force, fmt::format("{} {}", u.force, u.length)};
    for (std::size_t i = 0; i < 4; ++i) factors_[i] = spatial::parse_unit(units_[i]).factor;
  }

  std::vector<std::string> headings() const {
    std::vector<std::string> result;
    const auto six = [&](const std::string& prefix, const auto& names, std::size_t first_unit) {
      for (std::size_t i = 0; i < 6; ++i)
        result.push_back(fmt::format("{}{} [{}]", prefix, names[i], units_[first_unit + i / 3]));
    };
    six("", vjm::pose_columns, 0);
    six("", vjm::wrench_columns, 2);
    result.emplace_back("state");
    six("error_", vjm::pose_columns, 0);
    six("command_", vjm::pose_columns, 0);
    add_actuator_headings(result);
    six("residual_", vjm::pose_columns, 0);
    if (uncertainty_) six("uncertainty_", vjm::pose_columns, 0);
    return result;
  }
  void add_actuator_headings(std::vector<std::string>& result) const {
    for_actuators([&](std::size_t c, Eigen::Index, const vjm::Coordinate& coordinate) {
      const std::string name = robot_.manipulator.chains()[c].name() + "." + coordinate.name;
      const std::string& unit = units_[is_rotation(coordinate.motion) ? 1 : 0];
      result.push_back(io::csv_cell(fmt::format("{} nominal [{}]", name, unit)));
      result.push_back(io::csv_cell(fmt::format("{} [{}]", name, unit)));
    });
  }

  // `number`: of the pose.
  std::vector<std::string> row(const vjm::TargetPose& target, const Compensation& point,
                               std::size_t number) const {
    std::vector<std::string> cells;
    const bool known = point.status != CompensationStatus::unreachable &&
                       point.status != CompensationStatus::no_equilibrium;
    const auto six = [&](const Vector6& values, std::size_t first_unit, bool given) {
      for (Eigen::Index i = 0; i < 6; ++i)
        cells.push_back(
            given ? cell(values[i] / factors_[first_unit + static_cast<std::size_t>(i / 3)]) : "");
    };
    six(coordinates_of(target.platform), 0, true);
    six(target.load.at_reference_point(target.platform), 2, true);
    cells.push_back(status_name(point.status));
    six(point.error, 0, known);
    six(known ? coordinates_of(point.corrected.platform) : Vector6::Zero(), 0, known);
    for_actuators([&](std::size_t c, Eigen::Index k, const vjm::Coordinate& coordinate) {
      const double factor = factors_[is_rotation(coordinate.motion) ? 1 : 0];
      for (const vjm::Posture* posture : {&point.nominal, &point.corrected})
        cells.push_back(known ? cell(posture->coordinates[c][k] / factor) : "");
    });
    six(point.residual, 0, known);
    if (uncertainty_)
      six(expanded(*uncertainty_, number), 0, point.status == CompensationStatus::converged);
    return cells;
  }

 private:
  // Rounding of the model is not printed as a figure.
  static std::string cell(double value) {
    return fmt::format("{:.12g}", std::abs(value) < 1e-12 ? 0 : value);
  }

  template <class Use>
  void for_actuators(const Use& use) const {
    for (std::size_t c = 0; c < robot_.manipulator.size(); ++c) {
      const auto& coordinates = robot_.manipulator.chains()[c].coordinates();
      for (std::size_t k = 0; k < coordinates.size(); ++k)
        if (coordinates[k].role == vjm::Role::actuated)
          use(c, static_cast<Eigen::Index>(k), coordinates[k]);
    }
  }

  const vjm::Robot& robot_;
  const std::optional<vjm::Uncertainty>& uncertainty_;
  std::array<std::string, 4> units_;
  std::array<double, 4> factors_{};
};

// Largest and root mean square size of the translational (or rotational) half of an error [m; rad],
// over the poses that were compensated.
struct ErrorSize {
  double largest = 0, rms = 0;
};

ErrorSize size_of(const std::vector<Compensation>& points, Vector6 Compensation::*error,
                  Eigen::Index half) {
  double squares = 0;
  std::size_t count = 0;
  ErrorSize result;
  for (const Compensation& point : points) {
    if (!has_converged(point)) continue;
    ++count;
    const double size = (point.*error).segment<3>(3 * half).norm();
    result.largest = std::max(result.largest, size);
    squares += size * size;
  }
  if (count > 0) result.rms = std::sqrt(squares / static_cast<double>(count));
  return result;
}

Json sizes_json(const std::vector<Compensation>& points, Vector6 Compensation::*error) {
  const ErrorSize translation = size_of(points, error, 0), rotation = size_of(points, error, 1);
  return {{"largest_translation", translation.largest},
          {"rms_translation", translation.rms},
          {"largest_rotation", rotation.largest},
          {"rms_rotation", rotation.rms}};
}

std::string met_text(const Compensation& point) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < 6; ++i)
    if (point.components[i]) names.emplace_back(vjm::pose_columns[i]);
  return fmt::format("{}", fmt::join(names, ", "));
}

// The largest of a half of what is left, by what is not known of the robot.
double largest_uncertainty(const CompensatedPath& result, Eigen::Index half) {
  double largest = 0;
  for (std::size_t i = 0; i < result.points.size(); ++i)
    if (has_converged(result.points[i]))
      largest = std::max(largest, expanded(*result.uncertainty, i).segment<3>(3 * half).norm());
  return largest;
}

std::string uncertainty_text(const CompensatedPath& result) {
  const spatial::UnitSystem& units = result.robot.units;
  return fmt::format(
      "\nAs far as the numbers of the robot are known, the platform may be off by {} {} and {} {} "
      "more (k = 2).\n",
      number(largest_uncertainty(result, 0) / spatial::parse_unit(units.length).factor, 3),
      units.length,
      number(largest_uncertainty(result, 1) / spatial::parse_unit(units.angle).factor, 3),
      units.angle);
}

Json uncertainty_json(const CompensatedPath& result) {
  Json json = settings_json(*result.uncertainty);
  json["largest_translation"] = largest_uncertainty(result, 0);
  json["largest_rotation"] = largest_uncertainty(result, 1);
  json["budget"] =
      mean_budget_json(*result.uncertainty, 0, static_cast<Eigen::Index>(6 * result.points.size()));
  for (std::size_t i = 0; i < result.points.size(); ++i)
    json["expanded"].push_back(io::numbers(expanded(*result.uncertainty, i)));
  return json;
}

// What is left of an error, in units of `factor`; nothing where it is rounding.
std::string left(double after, double before, double factor) {
  return after < 1e-9 * before ? "0" : number(after / factor);
}

Json point_json(const Compensation& point) {
  const auto six = [](const Vector6& v) { return Json(std::vector<double>(v.begin(), v.end())); };
  Json json{{"state", status_name(point.status)}};
  if (!point.reason.empty()) json["reason"] = point.reason;
  if (!has_converged(point)) return json;
  json["error"] = six(point.error);
  json["command"] = to_json(point.corrected.platform);
  json["residual"] = six(point.residual);
  json["corrections"] = point.iterations;
  return json;
}

// What is taken from its position may turn it further.
std::string turns_more(const CompensatedPath& result) {
  const ErrorSize before = size_of(result.points, &Compensation::error, 1);
  const ErrorSize after = size_of(result.points, &Compensation::residual, 1);
  constexpr double rounding = 1e-9;  // [rad]
  if (!(after.largest > 1.01 * before.largest + rounding)) return {};
  const std::string& unit = result.robot.units.angle;
  const double factor = spatial::parse_unit(unit).factor;
  return fmt::format(" It is turned by {} {} at most, instead of {}.",
                     number(after.largest / factor, 3), unit, number(before.largest / factor, 3));
}

}  // namespace

std::string headline(const CompensatedPath& result) {
  const std::vector<Compensation>& points = result.points;
  if (std::none_of(points.begin(), points.end(), has_converged))
    return fmt::format("None of {} poses can be compensated.", points.size());
  const std::string& unit = result.robot.units.length;
  const double factor = spatial::parse_unit(unit).factor;
  const ErrorSize before = size_of(points, &Compensation::error, 0);
  const ErrorSize after = size_of(points, &Compensation::residual, 0);
  return fmt::format(
             "With the corrected targets the platform is off by {} {} at most, instead of {} {}.",
             left(after.largest, before.largest, factor), unit, number(before.largest / factor, 3),
             unit) +
         turns_more(result);
}

std::string text(const CompensatedPath& result) {
  const std::vector<Compensation>& points = result.points;
  const auto first = std::find_if(points.begin(), points.end(), has_converged);
  std::string out = fmt::format("{}: {} poses, {} compensated", result.robot.name, points.size(),
                                std::count_if(points.begin(), points.end(), has_converged));
  if (first == points.end()) return out + "\n";
  out += fmt::format(" in {}\n\n", met_text(*first));
  Table table({"error of the platform", "unit", "largest", "rms", "largest left", "rms left"});
  const auto add = [&](const std::string& name, const std::string& unit, Eigen::Index half) {
    const double factor = spatial::parse_unit(unit).factor;
    const ErrorSize before = size_of(points, &Compensation::error, half);
    const ErrorSize after = size_of(points, &Compensation::residual, half);
    table.add_row({name, unit, number(before.largest / factor), number(before.rms / factor),
                   left(after.largest, before.largest, factor),
                   left(after.rms, before.largest, factor)});
  };
  add("translation", result.robot.units.length, 0);
  add("rotation", result.robot.units.angle, 1);
  return out + table.text() + (result.uncertainty ? uncertainty_text(result) : "");
}

Json to_json(const CompensatedPath& result) {
  Json json{{"inputs", provenance(result.robot)},
            {"headline", headline(result)},
            {"error", sizes_json(result.points, &Compensation::error)},
            {"residual", sizes_json(result.points, &Compensation::residual)},
            {"points", Json::array()}};
  if (result.uncertainty) json["uncertainty"] = uncertainty_json(result);
  for (const Compensation& point : result.points) json["points"].push_back(point_json(point));
  return json;
}

std::string csv(const CompensatedPath& result) {
  const PathTable table(result.robot, result.uncertainty);
  std::string out = fmt::format("{}\n", fmt::join(table.headings(), ","));
  for (std::size_t i = 0; i < result.points.size(); ++i)
    out +=
        fmt::format("{}\n", fmt::join(table.row(result.path.poses[i], result.points[i], i), ","));
  return out;
}

Json picture(const CompensatedPath& result) {
  Json positions = Json::array();
  for (const vjm::TargetPose& pose : result.path.poses)
    positions.push_back(io::to_json(pose.platform.position()));
  return {{"positions", positions}};
}

}  // namespace kinetostat::report
