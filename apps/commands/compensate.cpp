// kinetostat compensate: commands along a path that take away the errors of a loaded, imperfect
// robot.
#include <algorithm>
#include <limits>
#include <memory>

#include <fmt/format.h>

#include "kinetostat/apps/cli/command.h"
#include "kinetostat/apps/cli/option_values.h"
#include "kinetostat/apps/cli/pose_list.h"
#include "kinetostat/apps/commands/commands.h"
#include "kinetostat/common/parallel.h"
#include "kinetostat/io/text_file.h"
#include "kinetostat/report/manipulators/compensation.h"
#include "kinetostat/report/screen/wording.h"
#include "kinetostat/vjm/workspace/compensation.h"

namespace kinetostat::apps {
namespace {

struct CompensateRequest {
  std::string robot_file, path, components;
  LoadRequest load;
  UncertaintyRequest uncertainty;
};

std::optional<vjm::Components> read_components(const std::string& text) {
  if (text.empty()) return std::nullopt;
  vjm::Components components{};
  for (const std::string& name : split(text)) {
    const auto* const at = std::find(vjm::pose_columns.begin(), vjm::pose_columns.end(), name);
    if (at == vjm::pose_columns.end())
      throw UsageError("--components", fmt::format("'{}' is none of x, y, z, rx, ry, rz", name),
                       "Write --components x,y,z");
    components[static_cast<std::size_t>(at - vjm::pose_columns.begin())] = true;
  }
  return components;
}

// Six numbers a pose: where a robot that is not quite the one of the file stands at the corrected
// commands, beside the target; none at poses that were not compensated.
Eigen::VectorXd errors_left(const vjm::Robot& robot, const vjm::PoseList& path,
                            const std::vector<vjm::Compensation>& points) {
  Eigen::VectorXd numbers = Eigen::VectorXd::Constant(static_cast<Eigen::Index>(6 * points.size()),
                                                      std::numeric_limits<double>::quiet_NaN());
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (points[i].status != vjm::CompensationStatus::converged) continue;
    const vjm::Equilibrium e =
        equilibrium_under_load(robot.manipulator, points[i].corrected, path.poses[i].load);
    if (e.status == vjm::EquilibriumStatus::converged)
      numbers.segment<6>(static_cast<Eigen::Index>(6 * i)) =
          spatial::pose_difference(path.poses[i].platform, e.platform);
  }
  return numbers;
}

io::Json compensate(const CompensateRequest& request, Run& run) {
  const vjm::Robot robot = vjm::read_robot(request.robot_file);
  const vjm::CompensationOptions options{.components = read_components(request.components)};
  const vjm::PoseList path = read_path(request.path, robot, request.load.load(robot));
  remark_on(path, run);
  std::vector<vjm::Compensation> points(path.poses.size());
  common::parallel_for(points.size(), run.threads(), "poses", run.progress(), [&](std::size_t i) {
    points[i] = vjm::compensate(robot.manipulator, path.poses[i], options);
  });
  const auto uncertainty = request.uncertainty.of(
      robot,
      [&](const vjm::Robot& other) { return std::optional(errors_left(other, path, points)); },
      run);
  const report::CompensatedPath result{robot, path, points, uncertainty};
  if (run.out()) io::write_atomically(*run.out(), report::csv(result));
  run.print(report::wrapped(report::headline(result)) + "\n" + report::text(result));
  run.draw(report::picture(result));
  for (std::size_t i = 0; i < points.size(); ++i)
    if (points[i].status != vjm::CompensationStatus::converged) {
      run.stop_short(fmt::format("pose {} of the path: {}", i + 1, points[i].reason));
      break;
    }
  return report::to_json(result);
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
      .type_name("FILE")
      .required();
  app.add_option("--components", request->components,
                 "Components to be met, of x,y,z,rx,ry,rz (default: all that the actuators "
                 "control, or the translations)")
      .type_name("NAMES");
  request->load.add_load_options(app);
  request->uncertainty.add_options(app);
}

}  // namespace kinetostat::apps
