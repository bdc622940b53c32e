#include "kinetostat/python/robot_questions.h"

#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "kinetostat/apps/cli/command.h"
#include "kinetostat/python/long_call.h"

namespace kinetostat::python {

namespace py = pybind11;

std::string words_of(const GivenNumbers& given, const NumbersAsked& asked) {
  if (const auto* text = std::get_if<std::string>(&given)) return *text;
  const auto& numbers = std::get<Eigen::VectorXd>(given);
  const bool has_rest = asked.unit_of_rest != nullptr && numbers.size() == 6;
  if ((numbers.size() != 3 && !has_rest) || !numbers.allFinite())
    throw py::value_error(asked.wanted);
  std::vector<std::string> parts;
  for (Eigen::Index i = 0; i < numbers.size(); ++i)
    parts.push_back(fmt::format("{} {}", numbers[i], i < 3 ? asked.unit : asked.unit_of_rest));
  return fmt::format("{}", fmt::join(parts, ","));
}

std::string wrench_words(const GivenNumbers& wrench) {
  return words_of(wrench,
                  {"N", "N m", "a wrench is Fx, Fy, Fz, or Fx, Fy, Fz, Mx, My, Mz [N, N m]"});
}

apps::LoadRequest load_request(const GivenLoad& given) {
  apps::LoadRequest load;
  load.wrench = wrench_words(given.wrench);
  load.point = words_of(given.point, {"m", nullptr, "a point is x, y, z on the platform [m]"});
  for (const auto& [node, wrench] : given.nodes)
    load.node_loads.push_back(node + "=" + wrench_words(wrench));
  load.move = words_of(given.move, {"m", "rad",
                                    "a displacement is dx, dy, dz, or dx, dy, dz and a rotation "
                                    "vector [m, rad]"});
  if (!load.point.empty() && load.wrench.empty())
    throw py::value_error("a point is where a wrench acts: give that, too");
  if (!load.move.empty() && !load.wrench.empty())
    throw py::value_error("give either a wrench or a displacement");
  return load;
}

apps::PostureRequest posture_request(const RobotValue& robot, const PostureValue* posture) {
  apps::PostureRequest request;
  request.robot_file = robot.robot.file.string();
  request.source = [&robot](const vjm::LinkOptions& options) {
    vjm::LinkOptions own = options;
    own.kinds = robot.kinds;
    return vjm::parse_robot(robot.text, robot.robot.file, own);
  };
  if (posture == nullptr) return request;
  require_own(robot, *posture);
  request.at = posture->at;
  request.joints = posture->joint_values;
  return request;
}

void warn_of(const std::vector<std::string>& sentences) {
  for (const std::string& sentence : sentences)
    if (PyErr_WarnEx(PyExc_UserWarning, sentence.c_str(), 1) != 0) throw py::error_already_set();
}

void run_command(int threads, const py::object& progress,
                 const std::function<void(apps::Run&)>& action) {
  apps::CommonOptions options;
  options.threads = thread_count(threads);
  options.quiet = true;
  std::vector<std::string> said;
  const auto keep = [&said](std::string_view sentence) {
    constexpr std::string_view mark = "warning: ";
    said.emplace_back(sentence.substr(sentence.starts_with(mark) ? mark.size() : 0));
  };
  run_long(progress, [&](common::Progress& shown) {
    apps::Run run(
        options, io::Json::object(), shown, [](std::string_view) {}, keep);
    action(run);
    if (!run.shortfall().empty()) said.push_back(run.shortfall());
  });
  warn_of(said);
}

}  // namespace kinetostat::python
