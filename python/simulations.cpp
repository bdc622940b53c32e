// Synthetic readings of a robot.
#include <map>
#include <optional>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>
#include <variant>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "kinetostat/apps/cli/command.h"
#include "kinetostat/apps/results/simulated_readings.h"
#include "kinetostat/calibration/campaign/campaign_file.h"
#include "kinetostat/python/bindings.h"
#include "kinetostat/python/robot_questions.h"
#include "kinetostat/report/simulation.h"

namespace kinetostat::python {
namespace {

namespace py = pybind11;
using Path = std::filesystem::path;
using GivenNumber = std::variant<double, std::string>;  // "5 um"
using GivenEffect = std::map<std::string, GivenNumber>;

struct SimulationValue {
  Path folder;
  RobotValue robot;
  std::string text = {}, json = {};
};

// A number is in the unit, none for one without: a text is as on the command line.
std::string words_of_number(const std::optional<GivenNumber>& given, const char* unit) {
  if (!given) return {};
  if (const auto* text = std::get_if<std::string>(&*given)) return *text;
  return fmt::format("{} {}", std::get<double>(*given), unit);
}

// As in robot files: {"effect": "clearance", "at": "x.rho", "rho": "20 um"}.
void add_effect(const GivenEffect& given, apps::SimulationRequest& request) {
  std::vector<std::string> sizes;
  for (const auto& [key, value] : given) {
    const auto* text = std::get_if<std::string>(&value);
    const std::string words = text != nullptr ? *text : fmt::format("{}", std::get<double>(value));
    if (key == "effect")
      request.effects.push_back(words);
    else if (key == "at")
      request.places.push_back(words);
    else
      sizes.push_back(key + "=" + words);
  }
  request.sizes.push_back(fmt::format("{}", fmt::join(sizes, ",")));
}

void add_effects_to(const std::vector<GivenEffect>& effects, apps::SimulationRequest& request) {
  for (const GivenEffect& effect : effects) {
    if (!effect.contains("effect") || !effect.contains("at"))
      throw py::value_error(
          "each of the effects is a dict with 'effect', 'at' and the values of its parameters");
    add_effect(effect, request);
  }
}

SimulationValue simulate(const RobotValue& robot, const Path& folder,
                         const apps::SimulateRequest& request, int threads,
                         const py::object& progress) {
  if (!is_in_its_file(robot))
    throw py::value_error(
        fmt::format("{} has not the robot that is simulated: write() that, and simulate what is "
                    "read from it",
                    robot.robot.file.string()));
  SimulationValue value{folder, robot};
  run_command(threads, progress, [&](apps::Run& run) {
    const apps::SimulatedReadings made =
        apps::write_simulated_readings(robot.robot, request, folder, run);
    const report::Simulation result{robot.robot, made.options, made.made, folder};
    value.text = report::text(result);
    value.json = io::to_text(report::to_json(result));
  });
  return value;
}

std::shared_ptr<CampaignValue> campaign_of(const SimulationValue& value) {
  calibration::Campaign campaign =
      calibration::read_campaign(value.folder / "campaign.yaml", value.robot.robot.manipulator);
  return std::make_shared<CampaignValue>(CampaignValue{value.robot, std::move(campaign)});
}

}  // namespace

void add_simulation(py::module_& module) {
  py::class_<SimulationValue>(module, "Simulation", "Synthetic readings in a folder.")
      .def_property_readonly("text", [](const SimulationValue& v) { return v.text; })
      .def_property_readonly("result", [](const SimulationValue& v) { return values_of(v.json); })
      .def_property_readonly("folder", [](const SimulationValue& v) { return v.folder.string(); })
      .def_property_readonly("campaign", &campaign_of)
      .def("to_json", [](const SimulationValue& v) { return v.json; })
      .def("__repr__", [](const SimulationValue& v) {
        return fmt::format("Simulation: readings of {} in {}", v.robot.robot.name,
                           v.folder.string());
      });
  module.def(
      "simulate",
      [](const RobotValue& robot, const Path& folder, const std::optional<Path>& plan,
         const std::optional<Path>& like, const std::optional<GivenNumber>& noise_translation,
         const std::optional<GivenNumber>& noise_rotation,
         const std::optional<GivenNumber>& noise_force,
         const std::optional<GivenNumber>& noise_moment,
         const std::optional<GivenNumber>& noise_wrench, const std::vector<std::string>& components,
         const std::vector<GivenEffect>& effects, bool absolute, std::uint64_t seed, int threads,
         const py::object& progress) {
        apps::SimulateRequest request{plan.value_or("").string(), like.value_or("").string(), {}};
        apps::SimulationRequest& asked = request.simulation;
        asked.translation_noise = words_of_number(noise_translation, "m");
        asked.rotation_noise = words_of_number(noise_rotation, "rad");
        asked.force_noise = words_of_number(noise_force, "N");
        asked.moment_noise = words_of_number(noise_moment, "N m");
        asked.wrench_share = words_of_number(noise_wrench, "");
        asked.components = fmt::format("{}", fmt::join(components, ","));
        asked.absolute = absolute;
        asked.seed = seed;
        asked.units_of_sizes = spatial::UnitSystem();
        add_effects_to(effects, asked);
        return simulate(robot, folder, request, threads, progress);
      },
      py::arg("robot"), py::arg("folder"), py::arg("plan") = py::none(), py::kw_only(),
      py::arg("like") = py::none(), py::arg("noise_translation") = py::none(),
      py::arg("noise_rotation") = py::none(), py::arg("noise_force") = py::none(),
      py::arg("noise_moment") = py::none(), py::arg("noise_wrench") = py::none(),
      py::arg("components") = std::vector<std::string>(),
      py::arg("effects") = std::vector<GivenEffect>(), py::arg("absolute") = false,
      py::arg("seed") = 1, py::arg("threads") = 0, py::arg("progress") = py::none(),
      "What the robot would read, written to `folder` as campaign.yaml and readings.csv: in the "
      "rows of `plan`, a table of readings to take, or `like` a campaign. Noise [m, rad, N, N m, "
      "or `noise_wrench` as a share] is the standard deviation of one reading. `effects` act "
      "beside those of the robot file: dicts with 'effect', 'at' and the values of parameters, "
      "in SI or with a unit.");
}

}  // namespace kinetostat::python
