// kinetostat simulate: synthetic readings of a plan.
#include "kinetostat/calibration/simulate.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <sstream>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "kinetostat/apps/command.h"
#include "kinetostat/apps/commands.h"
#include "kinetostat/files/text_file.h"
#include "kinetostat/report/manipulator.h"

namespace kinetostat::apps {
namespace {

constexpr const char* warning =
    "These readings come from the model itself: that a fit of this model to them succeeds proves "
    "nothing about any machine.";

struct SimulateRequest {
  std::string robot, plan, translation_noise, rotation_noise, components;
  bool absolute = false;
  std::uint64_t seed = 1;
};

double deviation(const char* option, const std::string& text, const spatial::Dimension& dimension) {
  if (text.empty()) return 0;
  try {
    const double value = spatial::parse_quantity(text, dimension);
    if (std::isfinite(value) && value >= 0) return value;
  } catch (const std::invalid_argument& error) {
    throw UsageError(option, error.what());
  }
  throw UsageError(option, fmt::format("'{}' is not a standard deviation", text),
                   "Give a finite quantity that is not negative");
}

std::array<bool, 6> chosen(const std::string& list) {
  std::array<bool, 6> result{};
  if (list.empty()) result.fill(true);
  std::stringstream words(list);
  for (std::string word; std::getline(words, word, ',');) {
    const auto& names = calibration::component_names;
    const auto found = std::find(names.begin(), names.end(), word);
    if (found == names.end())
      throw UsageError("--components", fmt::format("'{}' is not a component", word),
                       fmt::format("Choose among {}", fmt::join(names, ", ")));
    result[static_cast<std::size_t>(found - names.begin())] = true;
  }
  return result;
}

files::Json simulate(const SimulateRequest& request, Run& run) {
  if (!run.out())
    throw UsageError("--out", "is missing", "Name a folder for campaign.yaml and readings.csv");
  const std::filesystem::path folder = *run.out();
  const vjm::Robot robot = vjm::read_robot(request.robot);
  using Kind = calibration::DisplacementKind;
  const calibration::SimulationOptions options{
      .displacement = request.absolute ? Kind::absolute : Kind::difference,
      .translation_noise =
          deviation("--noise-translation", request.translation_noise, spatial::dimension::length),
      .rotation_noise =
          deviation("--noise-rotation", request.rotation_noise, spatial::dimension::angle),
      .components = chosen(request.components),
      .seed = request.seed,
      .threads = run.threads()};
  const std::filesystem::path named = std::filesystem::proximate(
      std::filesystem::absolute(robot.file), std::filesystem::absolute(folder));
  const calibration::SimulatedCampaign made =
      calibration::simulate(robot, named.string(), request.plan, options, run.progress());
  files::write_atomically(folder / "readings.csv", made.readings);
  files::write_atomically(folder / "campaign.yaml", made.yaml);
  run.print(fmt::format("Wrote {} and readings.csv beside it, seed {}.\n{}\n",
                        (folder / "campaign.yaml").string(), request.seed, warning));
  return {{"inputs", report::provenance(robot)},
          {"campaign", (folder / "campaign.yaml").string()},
          {"readings", (folder / "readings.csv").string()},
          {"seed", request.seed},
          {"translation_noise", options.translation_noise},
          {"rotation_noise", options.rotation_noise},
          {"warning", warning}};
}

}  // namespace

void add_simulate(Program& program) {
  const auto request = std::make_shared<SimulateRequest>();
  CLI::App& app =
      program.add({.name = "simulate",
                   .summary = "Synthetic readings of a plan, with a stated noise",
                   .example = "kinetostat simulate data/robots/orthoglide.yaml --plan "
                              "data/measurements/plans/orthoglide.csv --noise-translation 5um "
                              "--noise-rotation 20urad --out synthetic",
                   .out = "Folder for campaign.yaml and readings.csv"},
                  [request](Run& run) { return simulate(*request, run); });
  app.add_option("robot", request->robot, "Robot file")->type_name("ROBOT")->required();
  app.add_option("--plan", request->plan,
                 "Readings to take, without displacements, in the robot file's units")
      ->type_name("PLAN.csv")
      ->required();
  app.add_option("--noise-translation", request->translation_noise,
                 "Standard deviation of one reading of dx, dy, dz, with its unit");
  app.add_option("--noise-rotation", request->rotation_noise, "The same for rx, ry, rz");
  app.add_option("--components", request->components, "What is measured: dx,dy,dz,rx,ry,rz")
      ->type_name("LIST");
  app.add_flag("--absolute", request->absolute, "Poses instead of differences to no load");
  app.add_option("--seed", request->seed, "Of the random numbers")->capture_default_str();
}

}  // namespace kinetostat::apps
