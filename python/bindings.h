// The parts of the module kinetostat._core. Each adds its classes and functions.
#pragma once

#include <filesystem>
#include <pybind11/pybind11.h>
#include <string>

#include "kinetostat/calibration/campaign/campaign.h"
#include "kinetostat/vjm/io/robot_file.h"

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

/// Readings, and the robot that they are of.
struct CampaignValue {
  RobotValue robot;
  calibration::Campaign campaign;
};

/// A column for each quantity that the readings have, SI; what campaign_of() of Python takes back.
pybind11::dict columns_of(const CampaignValue& value);

/// JSON as Python's own values.
pybind11::object values_of(const std::string& json);

void add_errors(pybind11::module_& module);
void add_matrices(pybind11::module_& module);
void add_links(pybind11::module_& module);
void add_effects(pybind11::module_& module);
void add_robots(pybind11::module_& module);
void add_maps(pybind11::module_& module);
void add_readings(pybind11::module_& module);

}  // namespace kinetostat::python
