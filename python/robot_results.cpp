// Results of commands on robots: modes, paths, uncertainties, files for simulators.
#include <algorithm>
#include <complex>
#include <limits>
#include <optional>
#include <pybind11/complex.h>
#include <pybind11/eigen.h>
#include <pybind11/numpy.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "kinetostat/apps/results/robot_modes.h"
#include "kinetostat/apps/results/simulator_file.h"
#include "kinetostat/apps/results/traced_path.h"
#include "kinetostat/common/error.h"
#include "kinetostat/io/text_file.h"
#include "kinetostat/python/bindings.h"
#include "kinetostat/python/robot_questions.h"
#include "kinetostat/report/manipulators/path.h"
#include "kinetostat/report/manipulators/uncertainty.h"
#include "kinetostat/report/screen/manipulator.h"

namespace kinetostat::python {
namespace {

namespace py = pybind11;
using Eigen::Index;
using Eigen::VectorXd;
using Path = std::filesystem::path;
using GivenNodes = std::map<std::string, GivenNumbers>;

// What every result has: a sentence, the report for people, and JSON as the command writes it.
struct RobotResult {
  std::string headline, text;
  io::Json json;

  std::string json_text() const { return io::to_text(json); }
};

template <class Value>
py::class_<Value> result_of_robot(py::module_& module, const char* name, const char* doc) {
  py::class_<Value> added(module, name, doc);
  added.def_property_readonly("headline", [](const Value& v) { return v.headline; })
      .def_property_readonly("text", [](const Value& v) { return v.text; })
      .def_property_readonly("result", [](const Value& v) { return values_of(v.json_text()); })
      .def("to_json", [](const Value& v) { return v.json_text(); })
      .def("__repr__", [name](const Value& v) { return fmt::format("{}: {}", name, v.headline); });
  return added;
}

apps::UncertaintyRequest uncertainty_request(bool wanted, int draws, std::uint64_t seed) {
  if (draws != 0 && (draws < 2 || draws > 1'000'000))
    throw py::value_error(fmt::format("draws: {} is neither 0 nor from 2 to 1000000", draws));
  if (draws != 0 && !wanted)
    throw py::value_error("draws are of an uncertainty that is not wanted");
  apps::UncertaintyRequest request;
  request.draws = draws;
  request.seed = seed;
  request.none = !wanted;
  return request;
}

// --- modes ------------------------------------------------------------------

struct ModesValue : RobotResult {
  report::RobotModes modes;
};

struct GivenVibration {
  int modes;
  bool weight;
  std::string response;
  std::optional<double> damping, loss_factor;
};

void require_valid(const GivenVibration& given) {
  if (given.modes < 1 || given.modes > 200)
    throw py::value_error(fmt::format("modes: {} is not from 1 to 200", given.modes));
  if (given.damping && given.loss_factor)
    throw py::value_error("damping and loss_factor exclude each other");
  for (const auto& [name, value] :
       {std::pair("damping", given.damping), std::pair("loss_factor", given.loss_factor)})
    if (value && !(*value >= 0 && *value <= 1))
      throw py::value_error(fmt::format("{}: {} is not from 0 to 1", name, *value));
}

ModesValue modes(const RobotValue& robot, const PostureValue* posture, const GivenVibration& given,
                 const GivenLoad& load, const apps::UncertaintyRequest& uncertainty, int threads,
                 const py::object& progress) {
  require_valid(given);
  apps::RobotModesRequest request;
  request.robot = posture_request(robot, posture);
  request.load = load_request(load);
  request.uncertainty = uncertainty;
  request.weight = given.weight;
  request.modes = given.modes;
  request.response = given.response;
  request.damping = given.damping;
  request.loss_factor = given.loss_factor;
  ModesValue value;
  run_command(threads, progress, [&](apps::Run& run) {
    apps::RobotModesResult found = apps::modes_of_robot(request, run);
    value.headline = report::headline(found.robot, found.modes);
    value.text = report::first_screen(found.robot, found.modes);
    value.json = apps::to_json(found);
    value.modes = std::move(found.modes);
  });
  return value;
}

VectorXd frequencies(const ModesValue& value) {
  VectorXd all(std::ssize(value.modes.found.modes));
  for (Index k = 0; k < all.size(); ++k)
    all[k] = value.modes.found.modes[static_cast<std::size_t>(k)].frequency;
  return all;
}

Eigen::MatrixXd shapes(const ModesValue& value) {
  Eigen::MatrixXd all(std::ssize(value.modes.found.modes), 6);
  for (Index k = 0; k < all.rows(); ++k)
    all.row(k) = value.modes.found.modes[static_cast<std::size_t>(k)].platform.transpose();
  return all;
}

std::optional<VectorXd> expanded(const vjm::Uncertainty& uncertainty) {
  VectorXd all(uncertainty.first_order.value.size());
  for (Index k = 0; k < all.size(); ++k) all[k] = uncertainty.first_order.expanded(k);
  return all;
}

py::object receptance(const ModesValue& value) {
  if (!value.modes.response) return py::none();
  const auto& matrices = value.modes.response->receptance;
  py::array_t<std::complex<double>> all({std::ssize(matrices), Index{6}, Index{6}});
  auto entry = all.mutable_unchecked<3>();
  for (Index f = 0; f < std::ssize(matrices); ++f)
    for (Index i = 0; i < 6; ++i)
      for (Index j = 0; j < 6; ++j) entry(f, i, j) = matrices[static_cast<std::size_t>(f)](i, j);
  return all;
}

void add_modes(py::module_& module) {
  result_of_robot<ModesValue>(module, "Modes",
                              "Natural frequencies [Hz] and modes of a robot in a posture.")
      .def_property_readonly("frequencies", &frequencies)
      .def_property_readonly("expanded",
                             [](const ModesValue& v) {
                               return v.modes.uncertainty ? expanded(*v.modes.uncertainty)
                                                          : std::nullopt;
                             })
      .def_property_readonly("shapes", &shapes)
      .def_property_readonly("free_motions",
                             [](const ModesValue& v) { return v.modes.found.free_motions; })
      .def_property_readonly("mass", [](const ModesValue& v) { return v.modes.found.mass; })
      .def_property_readonly("response_frequencies",
                             [](const ModesValue& v) -> std::optional<std::vector<double>> {
                               if (!v.modes.response) return std::nullopt;
                               return v.modes.response->frequencies;
                             })
      .def_property_readonly("receptance", &receptance)
      .def(
          "write",
          [](const ModesValue& v, const Path& file) { io::write_atomically(file, v.json_text()); },
          py::arg("file"))
      .def("__len__", [](const ModesValue& v) { return v.modes.found.modes.size(); });
  module.def(
      "modes",
      [](const RobotValue& robot, const PostureValue* posture, int count, bool weight,
         const GivenNumbers& wrench, const GivenNumbers& point, const GivenNodes& node_loads,
         const std::string& response, std::optional<double> damping,
         std::optional<double> loss_factor, bool uncertainty, int draws, std::uint64_t seed,
         int threads, const py::object& progress) {
        return modes(robot, posture, {count, weight, response, damping, loss_factor},
                     {wrench, point, node_loads}, uncertainty_request(uncertainty, draws, seed),
                     threads, progress);
      },
      py::arg("robot"), py::arg("posture") = py::none(), py::kw_only(),
      py::arg("modes") = apps::RobotModesRequest().modes, py::arg("weight") = false,
      py::arg("wrench") = "", py::arg("point") = "", py::arg("node_loads") = GivenNodes(),
      py::arg("response") = "", py::arg("damping") = py::none(),
      py::arg("loss_factor") = py::none(), py::arg("uncertainty") = true, py::arg("draws") = 0,
      py::arg("seed") = 1, py::arg("threads") = 0, py::arg("progress") = py::none(),
      "Natural frequencies [Hz] and modes about a posture (home unless given), or with `weight` or "
      "a load about the equilibrium under it. Rows of `shapes` are [translation m; rotation rad] "
      "of the platform at its reference point, base axes, for a modal mass of 1. `response`: "
      "'FROM:TO[:STEPS]' [Hz], with `damping`, the ratio of every mode, or `loss_factor`; then "
      "`receptance` has the displacement over a wrench there, complex, 6 x 6 each.");
}

// --- trace ------------------------------------------------------------------

struct TraceValue : RobotResult {
  apps::TracedPath traced;

  std::string csv() const { return report::csv(traced.robot, traced.task, traced.path); }
};

void require_valid(const apps::TraceRequest& request) {
  if (request.path.points < 1 || request.path.points > 100'000)
    throw py::value_error(fmt::format("points: {} is not from 1 to 100000", request.path.points));
  if (request.path.most_points < 2 || request.path.most_points > 1'000'000)
    throw py::value_error(
        fmt::format("most_points: {} is not from 2 to 1000000", request.path.most_points));
  for (const int multiple : request.segments)
    if (multiple < 1 || multiple > 1000)
      throw py::value_error(fmt::format("segments: {} is not from 1 to 1000", multiple));
}

TraceValue trace(const apps::TraceRequest& request, int threads, const py::object& progress) {
  require_valid(request);
  std::optional<TraceValue> value;
  run_command(threads, progress, [&](apps::Run& run) {
    const apps::TracedPath& traced =
        value.emplace(TraceValue{{}, traced_path(request, run)}).traced;
    value->json = apps::to_json(traced);
    value->headline = report::headline(traced.robot, traced.task, traced.path);
    value->text = report::text(traced.robot, traced.task, traced.path);
  });
  return std::move(*value);
}

struct TracePoint {
  std::size_t branch;
  const vjm::PathPoint* point;
};

std::vector<TracePoint> points_of(const vjm::Path& path) {
  std::vector<TracePoint> all;
  for (std::size_t b = 0; b < path.branches.size(); ++b)
    for (const vjm::PathPoint& point : path.branches[b].points) all.push_back({b, &point});
  return all;
}

// What pandas.DataFrame() takes; SI. Not a number where a path has no such value.
py::dict columns_of_trace(const TraceValue& value) {
  const std::vector<TracePoint> points = points_of(value.traced.path);
  py::dict table;
  const auto add = [&](const char* name, const auto& number) {
    VectorXd column(std::ssize(points));
    for (Index i = 0; i < column.size(); ++i)
      column[i] = number(*points[static_cast<std::size_t>(i)].point);
    table[name] = column;
  };
  const double none = std::numeric_limits<double>::quiet_NaN();
  std::vector<std::size_t> branches;
  std::vector<bool> stable;
  for (const TracePoint& p : points) {
    branches.push_back(p.branch);
    stable.push_back(p.point->stability(value.traced.task).stable());
  }
  table["branch"] = branches;
  add("parameter", [](const vjm::PathPoint& p) { return p.parameter; });
  add("deflection", [&](const auto& p) { return p.along ? p.along->deflection : none; });
  add("force", [&](const auto& p) { return p.along ? p.along->force : none; });
  add("stiffness",
      [&](const auto& p) { return p.along ? p.along->stiffness.value_or(none) : none; });
  const char* const displacements[] = {"dx", "dy", "dz", "rx", "ry", "rz"};
  for (Index k = 0; k < 6; ++k)
    add(displacements[k],
        [k](const auto& p) { return p.equilibrium.displacement.coordinates()[k]; });
  const char* const loads[] = {"fx", "fy", "fz", "mx", "my", "mz"};
  for (Index k = 0; k < 6; ++k)
    add(loads[k], [k](const auto& p) {
      const spatial::Wrench& wrench = p.equilibrium.wrench;
      return k < 3 ? wrench.force[k] : wrench.moment[k - 3];
    });
  table["stable"] = stable;
  return table;
}

void add_trace(py::module_& module) {
  result_of_robot<TraceValue>(module, "Trace",
                              "Force against deflection along a path of equilibria.")
      .def_property_readonly(
          "critical_points",
          [](const TraceValue& v) {
            return py::object(values_of(io::to_text(v.json["path"]["critical_points"])));
          })
      .def("columns", &columns_of_trace)
      .def("to_csv", &TraceValue::csv)
      .def(
          "write",
          [](const TraceValue& v, const Path& file) { io::write_atomically(file, v.csv()); },
          py::arg("file"))
      .def("__len__", [](const TraceValue& v) { return points_of(v.traced.path).size(); });
  module.def(
      "trace",
      [](const RobotValue& robot, const PostureValue* posture, const GivenNumbers& along,
         const GivenNumbers& wrench, const GivenNumbers& point, const GivenNodes& node_loads,
         bool hold, bool branches, int points, int most_points, double lowest, double highest,
         const std::vector<int>& segments, bool uncertainty, int draws, std::uint64_t seed,
         int threads, const py::object& progress) {
        apps::TraceRequest request;
        request.posture = posture_request(robot, posture);
        request.load = load_request({wrench, point, node_loads, along});
        request.uncertainty = uncertainty_request(uncertainty, draws, seed);
        request.path.branches = branches;
        request.path.points = points;
        request.path.most_points = most_points;
        request.path.lowest = lowest;
        request.path.highest = highest;
        request.segments = segments;
        request.hold = hold;
        return trace(request, threads, progress);
      },
      py::arg("robot"), py::arg("posture") = py::none(), py::kw_only(), py::arg("along") = "",
      py::arg("wrench") = "", py::arg("point") = "", py::arg("node_loads") = GivenNodes(),
      py::arg("hold") = false, py::arg("branches") = false,
      py::arg("points") = vjm::PathOptions().points,
      py::arg("most_points") = vjm::PathOptions().most_points,
      py::arg("lowest") = vjm::PathOptions().lowest,
      py::arg("highest") = vjm::PathOptions().highest,
      py::arg("segments") = apps::TraceRequest().segments, py::arg("uncertainty") = true,
      py::arg("draws") = 0, py::arg("seed") = 1, py::arg("threads") = 0,
      py::arg("progress") = py::none(),
      "Equilibria while a displacement `along` [m, rad], a `wrench` [N, N m] or `node_loads` grow "
      "from nothing (parameter 0) to what is given (1), base axes: past limit points, and with "
      "`branches` through bifurcations. `lowest` and `highest` are --from and --to.");
}

// --- uncertainty ------------------------------------------------------------

struct UncertaintyValue : RobotResult {
  vjm::Uncertainty found;
  std::vector<std::string> names;  // of the numbers
};

// "compliance[0,1]", row by row.
void add_names(const char* name, std::vector<std::string>& names) {
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 6; ++j) names.push_back(fmt::format("{}[{},{}]", name, i, j));
}

// In the order of vjm::StiffnessNumbers.
std::vector<std::string> names_of_stiffness() {
  std::vector<std::string> names{"compliance_along"};
  add_names("compliance", names);
  add_names("stiffness", names);
  return names;
}

// In the order of vjm::DeflectionNumbers.
std::vector<std::string> names_of_deflection() {
  std::vector<std::string> names{"moved", "turned"};
  for (int k = 0; k < 6; ++k) names.push_back(fmt::format("displacement[{}]", k));
  names.insert(names.end(), {"force", "moment"});
  for (int k = 0; k < 6; ++k) names.push_back(fmt::format("wrench[{}]", k));
  return names;
}

// Under a load or a displacement.
void take_deflection(const apps::PostureRequest& posture, const apps::LoadRequest& load,
                     const apps::UncertaintyRequest& asked, apps::Run& run,
                     UncertaintyValue& value) {
  const vjm::Robot robot = posture.read();
  const vjm::Posture at = posture.posture(robot);
  warn_beyond_ranges(robot, at, run);
  vjm::Equilibrium found = load.solve(robot, at);
  if (found.status != vjm::EquilibriumStatus::converged) throw common::NoConvergence(found.reason);
  (void)check_segments(robot, posture, load, found);  // whether it lasts with finer beams, too
  value.found = asked.of(robot, posture, at, load, found, run).value();
  value.names = names_of_deflection();
  value.headline = report::headline(robot, found, value.found);
  value.text = report::first_screen(robot, found, value.found);
  value.json = report::deflection_json(value.found);
}

// Of the unloaded robot, along the direction in which it is softest.
void take_stiffness(const apps::PostureRequest& posture, const apps::UncertaintyRequest& asked,
                    apps::Run& run, UncertaintyValue& value) {
  const vjm::Robot robot = posture.read();
  const vjm::Posture at = posture.posture(robot);
  warn_beyond_ranges(robot, at, run);
  const vjm::UnloadedStiffness found = unloaded_stiffness(robot.manipulator, at);
  if (!found.compliance)
    throw common::NoConvergence("some motion of the platform meets no resistance");
  const spatial::Vector3 softest = report::softest_direction(*found.compliance).direction;
  const auto shares = vjm::spring_shares(robot.manipulator, at, softest);
  value.found = asked.of(robot, posture, at, softest, run).value();
  value.names = names_of_stiffness();
  value.headline = report::headline(robot, found, shares, value.found);
  value.text = report::first_screen(robot, at, found, shares, value.found);
  value.json = report::stiffness_json(value.found, softest);
}

UncertaintyValue uncertainty(const RobotValue& robot, const PostureValue* posture,
                             const GivenLoad& given, apps::UncertaintyRequest asked, int threads,
                             const py::object& progress) {
  const apps::PostureRequest request = posture_request(robot, posture);
  const apps::LoadRequest load = load_request(given);
  asked.required = true;
  UncertaintyValue value;
  run_command(threads, progress, [&](apps::Run& run) {
    if (load.given())
      take_deflection(request, load, asked, run, value);
    else
      take_stiffness(request, asked, run, value);
  });
  return value;
}

VectorXd standard(const UncertaintyValue& value) {
  VectorXd all(value.found.first_order.value.size());
  for (Index k = 0; k < all.size(); ++k) all[k] = value.found.first_order.deviation(k);
  return all;
}

Index number_named(const UncertaintyValue& value, const std::string& name) {
  const auto found = std::find(value.names.begin(), value.names.end(), name);
  if (found == value.names.end())
    throw py::value_error(fmt::format("there is no number '{}': see names", name));
  return found - value.names.begin();
}

std::optional<Eigen::MatrixXd> drawn(const UncertaintyValue& value) {
  if (!value.found.draws) return std::nullopt;
  return value.found.draws->numbers.transpose();
}

void add_uncertainty(py::module_& module) {
  result_of_robot<UncertaintyValue>(
      module, "Uncertainty", "How uncertain a stiffness or a deflection is, and what makes it so.")
      .def_readonly("names", &UncertaintyValue::names)
      .def_property_readonly(
          "values", [](const UncertaintyValue& v) { return VectorXd(v.found.first_order.value); })
      .def_property_readonly("standard", &standard)
      .def_property_readonly("expanded",
                             [](const UncertaintyValue& v) { return expanded(v.found); })
      .def_property_readonly(
          "covariance", [](const UncertaintyValue& v) { return v.found.first_order.covariance(); })
      .def_property_readonly("draws", &drawn)
      .def(
          "budget",
          [](const UncertaintyValue& v, const std::string& name) {
            return values_of(io::to_text(report::budget_json(v.found, number_named(v, name))));
          },
          py::arg("name"))
      .def(
          "write",
          [](const UncertaintyValue& v, const Path& file) {
            io::write_atomically(file, v.json_text());
          },
          py::arg("file"));
  module.def(
      "uncertainty",
      [](const RobotValue& robot, const PostureValue* posture, const GivenNumbers& wrench,
         const GivenNumbers& point, const GivenNodes& node_loads, const GivenNumbers& move,
         int draws, std::uint64_t seed, int threads, const py::object& progress) {
        return uncertainty(robot, posture, {wrench, point, node_loads, move},
                           uncertainty_request(true, draws, seed), threads, progress);
      },
      py::arg("robot"), py::arg("posture") = py::none(), py::kw_only(), py::arg("wrench") = "",
      py::arg("point") = "", py::arg("node_loads") = GivenNodes(), py::arg("move") = "",
      py::arg("draws") = 0, py::arg("seed") = 1, py::arg("threads") = 0,
      py::arg("progress") = py::none(),
      "Uncertainties that follow from those of the robot file, to first order (GUM) and by as many "
      "`draws`. Without a load of the stiffness [N, m, rad] at the reference point, base axes; "
      "under a `wrench` [N, N m], `node_loads` or a displacement `move` [m, rad] of the "
      "deflection and what holds it.");
}

// --- export -----------------------------------------------------------------

apps::SimulatorFile export_robot(const RobotValue& robot, const std::optional<Path>& file,
                                 const std::string& format, const PostureValue* posture,
                                 double damping) {
  const std::vector<std::string>& known = apps::simulator_formats();
  if (!format.empty() && std::find(known.begin(), known.end(), format) == known.end())
    throw py::value_error(
        fmt::format("format: '{}' is none of {}", format, fmt::join(known, ", ")));
  if (!(damping >= 0 && damping <= 10))
    throw py::value_error(fmt::format("damping: {} is not from 0 to 10", damping));
  const apps::ExportRequest request{
      .robot = posture_request(robot, posture), .format = format, .damping = damping, .file = file};
  std::optional<apps::SimulatorFile> made;
  run_command(1, py::none(), [&](apps::Run& run) { made = apps::simulator_file(request, run); });
  if (file) io::write_atomically(*file, made->text);
  return std::move(*made);
}

void add_export(py::module_& module) {
  py::class_<apps::SimulatorFile>(module, "SimulatorFile", "A robot as a file for simulators.")
      .def_readonly("headline", &apps::SimulatorFile::headline)
      .def_readonly("format", &apps::SimulatorFile::format)
      .def_readonly("text", &apps::SimulatorFile::text)
      .def_readonly("lost", &apps::SimulatorFile::lost)
      .def_property_readonly(
          "result",
          [](const apps::SimulatorFile& v) { return values_of(io::to_text(apps::to_json(v))); })
      .def(
          "write",
          [](const apps::SimulatorFile& v, const Path& file) {
            io::write_atomically(file, v.text);
          },
          py::arg("file"))
      .def("__repr__", [](const apps::SimulatorFile& v) { return "SimulatorFile: " + v.headline; });
  module.def("export", &export_robot, py::arg("robot"), py::arg("file") = py::none(),
             py::arg("format") = "", py::kw_only(), py::arg("posture") = py::none(),
             py::arg("damping") = 0.0,
             "The robot with its springs and masses for MuJoCo ('mjcf'), as 'urdf' or 'sdf', in "
             "'modelica' or for 'matlab': written to `file`, whose extension says the format "
             "unless `format` does, or only as `text` where there is no file. `damping`: ratio to "
             "critical damping beside the springs. `lost`: what the format cannot hold.");
}

}  // namespace

void add_robot_results(py::module_& module) {
  add_modes(module);
  add_trace(module);
  add_uncertainty(module);
  add_export(module);
}

}  // namespace kinetostat::python
