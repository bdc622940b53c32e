#include "kinetostat/apps/results/robot_modes.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "kinetostat/apps/cli/command.h"
#include "kinetostat/apps/cli/option_values.h"
#include "kinetostat/common/error.h"
#include "kinetostat/report/manipulators/manipulator.h"

namespace kinetostat::apps {
namespace {

bool is_loaded(const RobotModesRequest& request) { return request.weight || request.load.given(); }

vjm::NaturalModes modes_in_posture(const RobotModesRequest& request, const vjm::Robot& robot,
                                   const vjm::Posture& posture) {
  return is_loaded(request)
             ? natural_modes(robot.manipulator, posture, request.load.load(robot), request.modes)
             : natural_modes(robot.manipulator, posture, request.modes);
}

vjm::SmallMotions motions_in_posture(const RobotModesRequest& request, const vjm::Robot& robot,
                                     const vjm::Posture& posture) {
  return is_loaded(request) ? small_motions(robot.manipulator, posture, request.load.load(robot))
                            : small_motions(robot.manipulator, posture);
}

// The largest change of a frequency with finer beams, beside it.
std::optional<double> lumping_error(const RobotModesRequest& request,
                                    const vjm::NaturalModes& given) {
  const vjm::Robot robot = request.robot.read({.segment_multiple = 2});
  const vjm::NaturalModes finer = modes_in_posture(request, robot, request.robot.posture(robot));
  double most = 0;
  for (std::size_t k = 0; k < std::min(given.modes.size(), finer.modes.size()); ++k)
    most = std::max(most, std::abs(given.modes[k].frequency / finer.modes[k].frequency - 1));
  return most;
}

// Of the frequencies, in their order.
std::optional<vjm::Uncertainty> uncertainty_of(const RobotModesRequest& request,
                                               const vjm::Robot& robot, const vjm::Posture& posture,
                                               const vjm::NaturalModes& given, Run& run) {
  if (given.modes.empty()) return std::nullopt;
  const auto frequencies = [&](const vjm::Robot& other) -> std::optional<Eigen::VectorXd> {
    const auto own = request.robot.posture_like(posture, robot, other);
    if (!own) return std::nullopt;
    try {
      const vjm::NaturalModes found = modes_in_posture(request, other, *own);
      if (found.modes.size() != given.modes.size()) return std::nullopt;
      Eigen::VectorXd numbers(std::ssize(found.modes));
      for (std::size_t k = 0; k < found.modes.size(); ++k)
        numbers[static_cast<Eigen::Index>(k)] = found.modes[k].frequency;
      return numbers;
    } catch (const common::NoConvergence&) {
      return std::nullopt;
    }
  };
  return request.uncertainty.of(robot, frequencies, run);
}

// "1:500" or "1:500:400".
std::vector<double> frequencies_of(const std::string& text, const vjm::NaturalModes& found) {
  const std::vector<std::string> parts = split(text, ':');
  std::vector<double> values;
  values.reserve(parts.size() + 1);
  for (const std::string& part : parts)
    values.push_back(quantity("--response", part, spatial::dimension::none, {}));
  constexpr double usual = 200, most = 5000;
  if (values.size() == 2) values.push_back(usual);
  if (values.size() != 3 || !(values[0] > 0) || !(values[1] > values[0]) || !(values[2] >= 2) ||
      values[2] > most || values[2] != std::floor(values[2]))
    throw UsageError("--response", fmt::format("'{}' is no range of frequencies", text),
                     "Write --response 1:500, or with a number of steps up to 5000, 1:500:400");
  std::vector<double> peaks;
  for (const vjm::ManipulatorMode& mode : found.modes) peaks.push_back(mode.frequency);
  return vjm::response_frequencies(values[0], values[1], static_cast<int>(values[2]), peaks);
}

vjm::Damping damping_of(const RobotModesRequest& request) {
  if (request.loss_factor) return {vjm::Damping::Kind::structural, *request.loss_factor};
  if (request.damping) return {vjm::Damping::Kind::modal, *request.damping};
  throw UsageError("--response", "no damping is stated, and no model knows it",
                   "Add --damping 0.02, the damping ratio of every mode, or --loss-factor 0.04");
}

void add_response(const RobotModesRequest& request, const vjm::Robot& robot,
                  const vjm::Posture& posture, report::RobotModes& modes) {
  if (request.response.empty()) return;
  modes.damping = damping_of(request);
  modes.response = frequency_response(motions_in_posture(request, robot, posture), modes.damping,
                                      frequencies_of(request.response, modes.found));
}

}  // namespace

RobotModesResult modes_of_robot(const RobotModesRequest& request, Run& run) {
  vjm::Robot robot = request.robot.read();
  vjm::Posture posture = request.robot.posture(robot);
  warn_beyond_ranges(robot, posture, run);
  report::RobotModes modes{.found = modes_in_posture(request, robot, posture),
                           .is_loaded = is_loaded(request)};
  if (!(modes.found.mass > 0))
    throw common::InputError(robot.file, "nothing in this robot has a mass",
                             "Write 'mass: {mass: 12 kg, center: [0, 0, 100]}' in a link, or a "
                             "'mass' between the elements of a chain");
  if (robot.has_beams) modes.lumping_error = lumping_error(request, modes.found);
  add_response(request, robot, posture, modes);
  modes.uncertainty = uncertainty_of(request, robot, posture, modes.found, run);
  return {std::move(robot), std::move(posture), std::move(modes)};
}

io::Json to_json(const RobotModesResult& result) {
  io::Json json = report::inputs_and_posture(result.robot, result.posture);
  json["headline"] = report::headline(result.robot, result.modes);
  json.update(report::to_json(result.robot, result.modes));
  return json;
}

}  // namespace kinetostat::apps
