// kinetostat compensate: commands along a path that take away the errors of a loaded, imperfect
// robot.
#include <algorithm>
#include <cmath>
#include <memory>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "kinetostat/apps/cli/command.h"
#include "kinetostat/apps/cli/option_values.h"
#include "kinetostat/apps/cli/pose_list.h"
#include "kinetostat/apps/commands/commands.h"
#include "kinetostat/common/parallel.h"
#include "kinetostat/common/spelling.h"
#include "kinetostat/io/csv.h"
#include "kinetostat/io/text_file.h"
#include "kinetostat/report/manipulator.h"
#include "kinetostat/report/text.h"
#include "kinetostat/spatial/rotation.h"
#include "kinetostat/vjm/workspace/compensation.h"

namespace kinetostat::apps {
namespace {

using spatial::Vector6;
using vjm::Compensation;
using vjm::CompensationStatus;

struct CompensateRequest {
  std::string robot_file, path, components;
  LoadRequest load;
};

std::optional<vjm::Components> read_components(const std::string& text) {
  if (text.empty()) return std::nullopt;
  vjm::Components components{};
  for (const std::string& name : split(text)) {
    const auto* const at = std::find(pose_columns.begin(), pose_columns.end(), name);
    if (at == pose_columns.end())
      throw UsageError("--components", fmt::format("'{}' is none of x, y, z, rx, ry, rz", name),
                       "Write --components x,y,z");
    components[static_cast<std::size_t>(at - pose_columns.begin())] = true;
  }
  return components;
}

Vector6 coordinates_of(const spatial::Pose& pose) {
  Vector6 c;
  c << pose.position(), spatial::log_rotation(pose.rotation());
  return c;
}

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

// Columns and cells of the table, in the units of the robot file.
class PathTable {
 public:
  PathTable(const vjm::Robot& robot, const PoseList& list) : robot_(robot), list_(list) {
    const spatial::UnitSystem& u = robot.units;
    units_ = {u.length, u.angle, u.force, fmt::format("{} {}", u.force, u.length)};
    for (std::size_t i = 0; i < 4; ++i) factors_[i] = spatial::parse_unit(units_[i]).factor;
  }

  std::string text(const std::vector<Compensation>& points) const {
    std::string out = fmt::format("{}\n", fmt::join(headings(), ","));
    for (std::size_t i = 0; i < points.size(); ++i)
      out += fmt::format("{}\n", fmt::join(row(list_.poses[i], points[i]), ","));
    return out;
  }

 private:
  std::vector<std::string> headings() const {
    std::vector<std::string> result;
    const auto six = [&](const std::string& prefix, const auto& names, std::size_t first_unit) {
      for (std::size_t i = 0; i < 6; ++i)
        result.push_back(fmt::format("{}{} [{}]", prefix, names[i], units_[first_unit + i / 3]));
    };
    six("", pose_columns, 0);
    six("", wrench_columns, 2);
    result.emplace_back("state");
    six("error_", pose_columns, 0);
    six("command_", pose_columns, 0);
    for_actuators([&](std::size_t c, Eigen::Index k, const vjm::Coordinate& coordinate) {
      static_cast<void>(k);
      const std::string name = robot_.manipulator.chains()[c].name() + "." + coordinate.name;
      const std::string& unit = units_[is_rotation(coordinate.motion) ? 1 : 0];
      result.push_back(io::csv_cell(fmt::format("{} nominal [{}]", name, unit)));
      result.push_back(io::csv_cell(fmt::format("{} [{}]", name, unit)));
    });
    six("residual_", pose_columns, 0);
    return result;
  }

  std::vector<std::string> row(const vjm::TargetPose& target, const Compensation& point) const {
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
    return cells;
  }

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
  const PoseList& list_;
  std::array<std::string, 4> units_;
  std::array<double, 4> factors_{};
};

// Largest and root mean square of the components that were to be met, translation and rotation.
io::Json statistics(const std::vector<Compensation>& points, Vector6 Compensation::*what) {
  double worst[2] = {0, 0}, squares[2] = {0, 0};
  std::size_t count = 0;
  for (const Compensation& point : points) {
    if (point.status != CompensationStatus::converged) continue;
    ++count;
    for (int block = 0; block < 2; ++block) {
      const double size = (point.*what).segment<3>(3 * block).norm();
      worst[block] = std::max(worst[block], size);
      squares[block] += size * size;
    }
  }
  const auto rms = [count](double sum) {
    return count > 0 ? std::sqrt(sum / static_cast<double>(count)) : 0;
  };
  return {{"largest_translation", worst[0]},
          {"rms_translation", rms(squares[0])},
          {"largest_rotation", worst[1]},
          {"rms_rotation", rms(squares[1])}};
}

std::string met_text(const Compensation& point) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < 6; ++i)
    if (point.components[i]) names.push_back(pose_columns[i]);
  return fmt::format("{}", fmt::join(names, ", "));
}

std::string summary(const vjm::Robot& robot, const std::vector<Compensation>& points,
                    const io::Json& before, const io::Json& after) {
  const auto first = std::find_if(points.begin(), points.end(), [](const Compensation& p) {
    return p.status == CompensationStatus::converged;
  });
  const auto count = std::count_if(points.begin(), points.end(), [](const Compensation& p) {
    return p.status == CompensationStatus::converged;
  });
  std::string out = fmt::format("{}: {} poses, {} compensated", robot.name, points.size(), count);
  if (first == points.end()) return out + "\n";
  out += fmt::format(" in {}\n\n", met_text(*first));
  report::Table table(
      {"error of the platform", "unit", "largest", "rms", "largest left", "rms left"});
  const auto row = [&](const std::string& name, const std::string& unit) {
    const double factor = spatial::parse_unit(unit).factor;
    const auto shown = [&](const io::Json& json, const std::string& statistic) {
      return report::number(json[statistic + name].get<double>() / factor, 4);
    };
    table.add_row({name.substr(1), unit, shown(before, "largest"), shown(before, "rms"),
                   shown(after, "largest"), shown(after, "rms")});
  };
  row("_translation", robot.units.length);
  row("_rotation", robot.units.angle);
  return out + table.text();
}

io::Json point_json(const Compensation& point) {
  const auto pose = [](const spatial::Pose& p) {
    return io::Json{{"position", io::to_json(p.position())},
                    {"rotation_vector", io::to_json(spatial::log_rotation(p.rotation()))}};
  };
  const auto six = [](const Vector6& v) {
    return io::Json(std::vector<double>(v.begin(), v.end()));
  };
  io::Json json{{"state", status_name(point.status)}};
  if (!point.reason.empty()) json["reason"] = point.reason;
  if (point.status != CompensationStatus::converged) return json;
  json["error"] = six(point.error);
  json["command"] = pose(point.corrected.platform);
  json["residual"] = six(point.residual);
  json["corrections"] = point.iterations;
  return json;
}

io::Json compensate(const CompensateRequest& request, Run& run) {
  const vjm::Robot robot = vjm::read_robot(request.robot_file);
  const vjm::CompensationOptions options{.components = read_components(request.components)};
  const PoseList list = read_path(request.path, robot, request.load.load(robot));
  std::vector<Compensation> points(list.poses.size());
  common::parallel_for(points.size(), run.threads(), "poses", run.progress(), [&](std::size_t i) {
    points[i] = vjm::compensate(robot.manipulator, list.poses[i], options);
  });
  if (run.out()) io::write_atomically(*run.out(), PathTable(robot, list).text(points));
  const io::Json before = statistics(points, &Compensation::error);
  const io::Json after = statistics(points, &Compensation::residual);
  run.print(summary(robot, points, before, after));
  io::Json json{{"inputs", report::provenance(robot)},
                {"error", before},
                {"residual", after},
                {"points", io::Json::array()}};
  for (const Compensation& point : points) json["points"].push_back(point_json(point));
  io::Json positions = io::Json::array();
  for (const vjm::TargetPose& pose : list.poses)
    positions.push_back(io::to_json(pose.platform.position()));
  run.draw({{"positions", positions}});
  for (std::size_t i = 0; i < points.size(); ++i)
    if (points[i].status != CompensationStatus::converged) {
      run.stop_short(fmt::format("pose {} of the path: {}", i + 1, points[i].reason));
      break;
    }
  return json;
}

}  // namespace

void add_compensate(Program& program) {
  const auto request = std::make_shared<CompensateRequest>();
  OptionList app = program.add(
      {.name = "compensate",
       .summary = "Commands along a path that take away compliance and assembly errors",
       .example = "kinetostat compensate data/robots/orthoglide_errors.yaml "
                  "--path data/paths/orthoglide_milling.csv",
       .out = "Write one row a pose (CSV): errors, modified targets, actuators, what is left"},
      [request](Run& run) { return compensate(*request, run); });
  app.add_option("ROBOT", request->robot_file, "Robot file (YAML)").required();
  app.add_option("--path", request->path,
                 "Targets from a CSV file with columns x,y,z,rx,ry,rz and loads fx,fy,fz,mx,my,mz")
      .required();
  app.add_option("--components", request->components,
                 "Components to be met, of x,y,z,rx,ry,rz (default: all that the actuators "
                 "control, or the translations)");
  request->load.add_load_options(app);
}

}  // namespace kinetostat::apps
