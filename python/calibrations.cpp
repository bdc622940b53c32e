// Kinematic calibration: the geometry of a robot from readings of its pose.
#include <memory>
#include <optional>
#include <pybind11/eigen.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <fmt/format.h>

#include "kinetostat/apps/cli/campaign_request.h"
#include "kinetostat/apps/results/calibrated_robot.h"
#include "kinetostat/apps/results/results.h"
#include "kinetostat/common/error.h"
#include "kinetostat/python/bindings.h"
#include "kinetostat/python/long_call.h"
#include "kinetostat/report/kinematics.h"
#include "kinetostat/report/screen/kinematics.h"

namespace kinetostat::python {
namespace {

namespace py = pybind11;
using calibration::CalibratedGeometry;
using Path = std::filesystem::path;
using GivenTolerance = std::optional<std::pair<double, double>>;  // length [m], angle [rad]

struct CalibrationValue {
  CampaignPointer campaign;
  calibration::KinematicCalibration found = {};
  std::string headline = {}, text = {}, json = {};
  std::optional<std::string> robot_text = {};  // none where nothing was found

  // Of each parameter that was found.
  Eigen::VectorXd numbers(double CalibratedGeometry::*number) const {
    Eigen::VectorXd all(std::ssize(found.geometry));
    for (Eigen::Index k = 0; k < all.size(); ++k)
      all[k] = found.geometry[static_cast<std::size_t>(k)].*number;
    return all;
  }
};

calibration::KinematicOptions options_of(int hold_out, const GivenTolerance& tolerance, bool prior,
                                         const std::string& robust) {
  if (hold_out < 0 || hold_out > 1000)
    throw py::value_error(fmt::format("hold_out: {} is not from 0 to 1000", hold_out));
  if (!robust.empty() && robust != "huber" && robust != "cauchy")
    throw py::value_error("robust: '" + robust + "' is neither 'huber' nor 'cauchy'");
  calibration::KinematicOptions options;
  options.folds = hold_out;
  options.prior = prior;
  options.loss = apps::loss_of(robust);
  if (!tolerance) return options;
  options.tolerance = {tolerance->first, tolerance->second};
  if (!(tolerance->first > 0 && tolerance->second > 0))
    throw py::value_error("tolerance is a length [m] and an angle [rad], both above 0");
  return options;
}

CalibrationValue calibrate(const CampaignPointer& given,
                           const calibration::KinematicOptions& options, int threads,
                           const py::object& progress) {
  CalibrationValue value{given};
  run_long(progress, [&](common::Progress& shown) {
    const vjm::Robot& robot = given->robot.robot;
    const calibration::Campaign& campaign = given->campaign;
    value.found =
        calibration::calibrate_kinematics(robot, campaign, options, thread_count(threads), shown);
    value.headline = report::headline(campaign, value.found);
    value.text = report::first_screen(robot, campaign, value.found, "") + "\n" +
                 report::text(campaign, value.found);
    value.json = io::to_text(apps::calibration_result(robot, campaign, value.found));
    if (!value.found.geometry.empty())
      value.robot_text = apps::calibrated_robot(robot, given->robot.text, campaign, value.found);
  });
  return value;
}

// The robot file with what was found, as if it stood in the place of that which was calibrated.
std::optional<RobotValue> calibrated(const CalibrationValue& value) {
  if (!value.robot_text) return std::nullopt;
  const RobotValue& before = value.campaign->robot;
  return RobotValue{vjm::parse_robot(*value.robot_text, before.robot.file, {.kinds = before.kinds}),
                    *value.robot_text, before.kinds};
}

RobotValue write_calibrated(const CalibrationValue& value, const Path& file) {
  if (!value.robot_text)
    throw common::NotIdentifiable("no error of the geometry was found: there is nothing to write");
  return write_robot(file, *value.robot_text, value.campaign->robot.kinds);
}

std::vector<std::string> names_of(const CalibrationValue& value) {
  std::vector<std::string> all;
  for (const CalibratedGeometry& g : value.found.geometry) all.push_back(g.what.phrase());
  return all;
}

void add_class(py::module_& module) {
  py::class_<CalibrationValue>(module, "Calibration", "The geometry of a robot from readings.")
      .def_property_readonly("headline", [](const CalibrationValue& v) { return v.headline; })
      .def_property_readonly("text", [](const CalibrationValue& v) { return v.text; })
      .def_property_readonly("campaign",
                             [](const CalibrationValue& v) {
                               return std::const_pointer_cast<CampaignValue>(v.campaign);
                             })
      .def_property_readonly("result", [](const CalibrationValue& v) { return values_of(v.json); })
      .def_property_readonly("names", &names_of)
      .def_property_readonly(
          "values", [](const CalibrationValue& v) { return v.numbers(&CalibratedGeometry::value); })
      .def_property_readonly(
          "deviations",
          [](const CalibrationValue& v) { return v.numbers(&CalibratedGeometry::deviation); })
      .def_property_readonly("correlation",
                             [](const CalibrationValue& v) { return v.found.correlation; })
      .def_property_readonly("robot", &calibrated)
      .def("to_json", [](const CalibrationValue& v) { return v.json; })
      .def("write", &write_calibrated, py::arg("file"))
      .def("__repr__", [](const CalibrationValue& v) { return "Calibration: " + v.headline; });
}

}  // namespace

void add_calibration(py::module_& module) {
  add_class(module);
  module.def(
      "calibrate",
      [](const CampaignPointer& campaign, int hold_out, const GivenTolerance& tolerance, bool prior,
         const std::string& robust, int threads, const py::object& progress) {
        return calibrate(campaign, options_of(hold_out, tolerance, prior, robust), threads,
                         progress);
      },
      py::arg("campaign").none(false), py::kw_only(),
      py::arg("hold_out") = calibration::KinematicOptions().folds,
      py::arg("tolerance") = py::none(), py::arg("prior") = false, py::arg("robust") = "",
      py::arg("threads") = 0, py::arg("progress") = py::none(),
      "Joint offsets, link geometry, base and tool that the readings determine, as shifts [m] and "
      "turns [rad] of the frames behind joints, in their axes. Poses are held out in `hold_out` "
      "parts to judge by. `tolerance`: (length [m], angle [rad]) not worth knowing; `prior`: every "
      "error is 0 to within it. `write` writes the robot file with values and standard "
      "deviations.");
}

}  // namespace kinetostat::python
