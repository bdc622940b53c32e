// The parts of the module kinetostat._core. Each adds its classes and functions.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <pybind11/pybind11.h>
#include <string>

#include "kinetostat/calibration/campaign/campaign.h"
#include "kinetostat/vjm/io/robot_file.h"
#include "kinetostat/vjm/manipulator/posture.h"

namespace kinetostat::python {

/// A robot as its file has it.
struct RobotValue {
  vjm::Robot robot;
  std::string text;             // of the file, or what it would be
  vjm::EffectKinds kinds = {};  // functions of Python that the text may name
};

RobotValue robot_from(const std::filesystem::path& file, const vjm::EffectKinds& kinds = {});

/// Writes the file unless it would not be read there, as where it names files beside another one.
RobotValue write_robot(const std::filesystem::path& file, const std::string& text,
                       const vjm::EffectKinds& kinds);

/// Whether the file of a robot has it as it is.
bool is_in_its_file(const RobotValue& robot);

/// Where a robot stands with all springs relaxed.
struct PostureValue {
  vjm::Posture posture;
  std::map<std::string, double> joints;  // [m or rad] of the drives
  /// How it was asked for, in the words of --at and --joints; both empty: home.
  std::string at = {}, joint_values = {};
};

/// Throws py::value_error for a posture of another robot.
void require_own(const RobotValue& robot, const PostureValue& posture);

/// Readings, and the robot that they are of.
struct CampaignValue {
  RobotValue robot;
  calibration::Campaign campaign;
};

/// A column for each quantity that the readings have, SI; what campaign_of() of Python takes back.
pybind11::dict columns_of(const CampaignValue& value);

using CampaignPointer = std::shared_ptr<const CampaignValue>;

/// JSON as Python's own values.
pybind11::object values_of(const std::string& json);

void add_import(pybind11::class_<RobotValue>& robot);
void add_errors(pybind11::module_& module);
void add_matrices(pybind11::module_& module);
void add_links(pybind11::module_& module);
void add_effects(pybind11::module_& module);
void add_robots(pybind11::module_& module);
void add_maps(pybind11::module_& module);
void add_readings(pybind11::module_& module);
void add_robot_results(pybind11::module_& module);
void add_calibration(pybind11::module_& module);
void add_simulation(pybind11::module_& module);

}  // namespace kinetostat::python
