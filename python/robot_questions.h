// What callers in Python ask of a robot in a posture under a load, in the words of the commands.
#pragma once

#include <functional>
#include <map>
#include <pybind11/pybind11.h>
#include <string>
#include <variant>
#include <vector>

#include "kinetostat/apps/cli/robot_request.h"
#include "kinetostat/python/bindings.h"

namespace kinetostat::python {

/// Numbers in SI, or a text as on the command line, in the units of the robot file.
using GivenNumbers = std::variant<std::string, Eigen::VectorXd>;

/// Three or six numbers: the latter half may be left out.
struct NumbersAsked {
  const char* unit;
  const char* unit_of_rest;  // nullptr: three numbers alone
  const char* wanted;        // "a wrench is Fx, Fy, Fz, ...", for a py::value_error
};
std::string words_of(const GivenNumbers& given, const NumbersAsked& asked);
/// [N, N m]
std::string wrench_words(const GivenNumbers& wrench);

/// What acts on a robot. Empty texts: nothing of the kind.
struct GivenLoad {
  GivenNumbers wrench, point;                 // [N, N m] base axes; [m] on the platform
  std::map<std::string, GivenNumbers> nodes;  // [N, N m] base axes, by the names of nodes
  GivenNumbers move = {};                     // displacement instead [m, rad], base axes
};
apps::LoadRequest load_request(const GivenLoad& given);

/// `robot` must outlive it. None: home.
apps::PostureRequest posture_request(const RobotValue& robot, const PostureValue* posture);

/// Warnings of Python. Throws py::error_already_set where Python makes errors of them.
void warn_of(const std::vector<std::string>& sentences);

/// Does what a command does, as run_long() does its work. What the command warns of, and why its
/// result is only a part of what was asked for, are warnings of Python.
void run_command(int threads, const pybind11::object& progress,
                 const std::function<void(apps::Run&)>& action);

}  // namespace kinetostat::python
