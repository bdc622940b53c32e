// kinetostat simulate: synthetic readings of a plan.
#include "kinetostat/calibration/regression/simulate.h"

#include <algorithm>
#include <memory>
#include <sstream>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "kinetostat/apps/cli/command.h"
#include "kinetostat/apps/cli/option_values.h"
#include "kinetostat/apps/commands/commands.h"
#include "kinetostat/io/largest_number.h"
#include "kinetostat/io/text_file.h"
#include "kinetostat/report/manipulator.h"
#include "kinetostat/report/text.h"
#include "kinetostat/vjm/io/effect_file.h"

namespace kinetostat::apps {
namespace {

constexpr const char* warning =
    "These readings come from the model itself: that a fit of this model to them succeeds proves "
    "nothing about any machine.";

struct SimulateRequest {
  std::string robot, plan, translation_noise, rotation_noise, components;
  std::string force_noise, moment_noise, wrench_share;
  std::vector<std::string> effects, places, sizes;
  bool absolute = false;
  std::uint64_t seed = 1;
};

double deviation(const char* option, const std::string& text, const spatial::Dimension& dimension) {
  if (text.empty()) return 0;
  try {
    const double value = spatial::parse_quantity(text, dimension);
    if (value >= 0 && value <= io::largest_number) return value;
  } catch (const std::invalid_argument& error) {
    throw UsageError(option, error.what());
  }
  throw UsageError(option, fmt::format("'{}' is not a standard deviation", text),
                   "Give a finite quantity that is not negative");
}

// Without a list: what a noise is stated for, or all when there is none at all.
std::array<bool, 6> chosen(const SimulateRequest& request) {
  std::array<bool, 6> result{};
  if (request.components.empty())
    for (std::size_t k = 0; k < 6; ++k) {
      const bool rotation = calibration::is_rotation(static_cast<Eigen::Index>(k));
      const std::string& other = rotation ? request.translation_noise : request.rotation_noise;
      result[k] =
          !(rotation ? request.rotation_noise : request.translation_noise).empty() || other.empty();
    }
  std::stringstream words(request.components);
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

// The place may be left out where there is only one.
std::string place_of(const SimulateRequest& request, std::size_t i, const vjm::EffectKind& kind,
                     const vjm::Manipulator& manipulator) {
  if (i < request.places.size()) return request.places[i];
  const std::vector<std::string> places = vjm::effect_places(kind, manipulator);
  if (places.size() == 1) return places[0];
  throw UsageError("--at", fmt::format("is missing for the effect '{}'", kind.name),
                   places.empty() ? "This robot has no place for it"
                                  : fmt::format("Choose among {}", fmt::join(places, ", ")));
}

std::vector<vjm::Effect> hidden_effects(const SimulateRequest& request, const vjm::Robot& robot) {
  if (request.sizes.size() != request.effects.size())
    throw UsageError("--size", "must be given once for each --effect",
                     "For example --effect clearance --at x.rho --size 20um");
  if (request.places.size() > request.effects.size())
    throw UsageError("--at", "is given more often than --effect");
  std::vector<vjm::Effect> hidden;
  for (std::size_t i = 0; i < request.effects.size(); ++i) {
    try {
      const auto kind = vjm::effect_kind(request.effects[i], robot.kinds());
      const vjm::Manipulator& bare = robot.without_effects();
      hidden.push_back(vjm::effect_from_words(kind->name, place_of(request, i, *kind, bare),
                                              request.sizes[i], robot.kinds(), bare, robot.units));
    } catch (const std::invalid_argument& error) {
      throw UsageError("--effect", error.what(), "'kinetostat effect list ROBOT.yaml' names them");
    }
  }
  return hidden;
}

std::string effect_text(const vjm::Effect& effect) {
  return fmt::format(
      "Hidden effect {} at {}: {}.\n  law        {}\n  signature  {}\n  confounder {}\n",
      effect.kind->name, effect.at, effect.kind->summary, effect.kind->law, effect.kind->signature,
      effect.kind->confuser);
}

// Where and how the hidden effects show in these readings.
std::string trace_text(const calibration::SimulatedCampaign& made, const vjm::Robot& robot) {
  report::Table table({"changes", "rms", "largest", "at reading", "unit"});
  for (const calibration::HiddenTrace& t : made.trace) {
    const std::string& unit =
        calibration::is_rotation(t.component) ? robot.units.angle : robot.units.length;
    const double factor = spatial::parse_unit(unit).factor;
    table.add_row({calibration::component_names[static_cast<std::size_t>(t.component)],
                   report::number(t.rms / factor, 4), report::number(t.max / factor, 4),
                   t.worst_reading, unit});
  }
  std::string text = table.text();
  if (made.detectability)
    text += fmt::format("All that they change is {} times the noise (d'): {}.\n",
                        report::number(*made.detectability, 3),
                        *made.detectability < 4 ? "too little to be distinguished from noise"
                                                : "it should be seen");
  return text;
}

io::Json trace_json(const calibration::SimulatedCampaign& made,
                    const std::vector<vjm::Effect>& hidden) {
  io::Json effects = io::Json::array(), trace = io::Json::array();
  for (const vjm::Effect& effect : hidden) {
    io::Json values = io::Json::object();
    for (std::size_t p = 0; p < effect.kind->parameters.size(); ++p)
      values[effect.kind->parameters[p].name] = effect.values[static_cast<Eigen::Index>(p)];
    effects.push_back({{"effect", effect.kind->name},
                       {"at", effect.at},
                       {"values", values},
                       {"signature", effect.kind->signature},
                       {"confuser", effect.kind->confuser}});
  }
  for (const calibration::HiddenTrace& t : made.trace)
    trace.push_back(
        {{"component", calibration::component_names[static_cast<std::size_t>(t.component)]},
         {"unit", calibration::is_rotation(t.component) ? "rad" : "m"},
         {"rms", t.rms},
         {"max", t.max},
         {"worst_reading", t.worst_reading}});
  io::Json json{{"effects", effects}, {"changes", trace}};
  if (made.detectability) json["detectability"] = *made.detectability;
  return json;
}

// Simulated readings replace simulated ones, and no others: those cannot be had again.
void require_no_measurements(const std::filesystem::path& folder) {
  const std::filesystem::path campaign = folder / "campaign.yaml";
  if (std::filesystem::exists(campaign) &&
      io::read_text(campaign).find("\norigin: synthetic") != std::string::npos)
    return;
  for (const std::filesystem::path& file : {campaign, folder / "readings.csv"})
    if (std::filesystem::exists(file))
      throw common::InputError(file, "is there already, and was not made by 'simulate'",
                               "Name another folder with --out");
}

io::Json simulate(const SimulateRequest& request, Run& run) {
  if (!run.out())
    throw UsageError("--out", "is missing", "Name a folder for campaign.yaml and readings.csv");
  const std::filesystem::path folder = *run.out();
  require_no_measurements(folder);
  const vjm::Robot robot = vjm::read_robot(request.robot);
  using Kind = calibration::DisplacementKind;
  const calibration::SimulationOptions options{
      .displacement = request.absolute ? Kind::absolute : Kind::difference,
      .translation_noise =
          deviation("--noise-translation", request.translation_noise, spatial::dimension::length),
      .rotation_noise =
          deviation("--noise-rotation", request.rotation_noise, spatial::dimension::angle),
      .force_noise = deviation("--noise-force", request.force_noise, spatial::dimension::force),
      .moment_noise = deviation("--noise-moment", request.moment_noise, spatial::dimension::moment),
      .wrench_share = deviation("--noise-wrench", request.wrench_share, spatial::dimension::none),
      .components = chosen(request),
      .seed = request.seed,
      .threads = run.threads(),
      .hidden = hidden_effects(request, robot)};
  const std::filesystem::path named = std::filesystem::proximate(
      std::filesystem::absolute(robot.file), std::filesystem::absolute(folder));
  const calibration::SimulatedCampaign made =
      calibration::simulate(robot, named.string(), request.plan, options, run.progress());
  for (const std::string& sentence : made.warnings) run.warn(sentence);
  io::write_atomically(folder / "readings.csv", made.readings);
  io::write_atomically(folder / "campaign.yaml", made.yaml);
  for (const vjm::Effect& effect : options.hidden) run.print(effect_text(effect));
  if (!options.hidden.empty()) run.print("\n" + trace_text(made, robot) + "\n");
  run.print(fmt::format("Wrote {} and readings.csv beside it, seed {}.\n{}\n",
                        (folder / "campaign.yaml").string(), request.seed, warning));
  io::Json json{{"inputs", report::provenance(robot)},
                {"campaign", (folder / "campaign.yaml").string()},
                {"readings", (folder / "readings.csv").string()},
                {"seed", request.seed},
                {"translation_noise", options.translation_noise},
                {"rotation_noise", options.rotation_noise},
                {"force_noise", options.force_noise},
                {"moment_noise", options.moment_noise},
                {"wrench_share", options.wrench_share},
                {"warning", warning}};
  if (!options.hidden.empty()) json["hidden"] = trace_json(made, options.hidden);
  return json;
}

}  // namespace

void add_simulate(Program& program) {
  const auto request = std::make_shared<SimulateRequest>();
  OptionList app =
      program.add({.name = "simulate",
                   .summary = "Synthetic readings of a plan, with a stated noise",
                   .example = "kinetostat simulate data/robots/orthoglide.yaml --plan "
                              "data/measurements/plans/orthoglide.csv --noise-translation 5um "
                              "--noise-rotation 20urad --out synthetic",
                   .out = "Folder for campaign.yaml and readings.csv",
                   .out_is_folder = true},
                  [request](Run& run) { return simulate(*request, run); });
  app.add_option("robot", request->robot, "Robot file").type_name("ROBOT").required();
  app.add_option("--plan", request->plan,
                 "Readings to take, without displacements, in the robot file's units")
      .type_name("PLAN.csv")
      .required();
  app.add_option("--noise-translation", request->translation_noise,
                 "Standard deviation of one reading of dx, dy, dz, with its unit");
  app.add_option("--noise-rotation", request->rotation_noise, "The same for rx, ry, rz");
  app.add_option("--noise-force", request->force_noise,
                 "Standard deviation of fx, fy, fz: the robot feels another force than is written");
  app.add_option("--noise-moment", request->moment_noise, "The same for mx, my, mz");
  app.add_option("--noise-wrench", request->wrench_share,
                 "The same as a share of each component, for example 0.5%");
  app.add_option("--components", request->components,
                 "What is measured: dx,dy,dz,rx,ry,rz (default: what a noise is stated for)")
      .type_name("LIST");
  app.add_option("--effect", request->effects,
                 "An effect that acts beside those of the robot file; may be repeated")
      .type_name("NAME");
  app.add_option("--at", request->places, "Where it acts; as often as --effect").type_name("PLACE");
  app.add_option("--size", request->sizes,
                 "Its first parameter with its unit, or NAME=VALUE,...; as often as --effect")
      .type_name("SIZE");
  app.add_flag("--absolute", request->absolute, "Poses instead of differences to no load");
  app.add_option("--seed", request->seed, "Of the random numbers").seed().show_default();
}

}  // namespace kinetostat::apps
