#include "kinetostat/apps/cli/simulation_request.h"

#include <algorithm>
#include <sstream>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "kinetostat/apps/cli/command.h"
#include "kinetostat/apps/cli/option_values.h"
#include "kinetostat/io/largest_number.h"
#include "kinetostat/vjm/io/effect_file.h"

namespace kinetostat::apps {
namespace {

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
std::array<bool, 6> chosen(const SimulationRequest& request) {
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
std::string place_of(const SimulationRequest& request, std::size_t i,
                     const std::shared_ptr<const vjm::EffectKind>& kind,
                     const vjm::Manipulator& manipulator) {
  if (i < request.places.size()) return request.places[i];
  const std::vector<std::string> places = vjm::acting_places(kind, manipulator);
  if (places.size() == 1) return places[0];
  throw UsageError("--at", fmt::format("is missing for the effect '{}'", kind->name),
                   places.empty() ? "This robot has no place for it"
                                  : fmt::format("Choose among {}", fmt::join(places, ", ")));
}

std::vector<vjm::Effect> hidden_effects(const SimulationRequest& request, const vjm::Robot& robot) {
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
      hidden.push_back(vjm::effect_from_words(kind->name, place_of(request, i, kind, bare),
                                              request.sizes[i], robot.kinds(), bare,
                                              request.units_of_sizes.value_or(robot.units)));
    } catch (const std::invalid_argument& error) {
      throw UsageError("--effect", error.what(), "'kinetostat effect list ROBOT.yaml' names them");
    }
  }
  return hidden;
}

}  // namespace

std::string SimulationRequest::first_of_measuring() const {
  for (const auto& [option, text] : {std::pair("--noise-translation", &translation_noise),
                                     {"--noise-rotation", &rotation_noise},
                                     {"--noise-force", &force_noise},
                                     {"--noise-moment", &moment_noise},
                                     {"--noise-wrench", &wrench_share},
                                     {"--components", &components}})
    if (!text->empty()) return option;
  return absolute ? "--absolute" : "";
}

void SimulationRequest::add_options(OptionList& app) {
  app.add_option("--noise-translation", translation_noise,
                 "Standard deviation of one reading of dx, dy, dz, with its unit")
      .type_name("LENGTH");
  app.add_option("--noise-rotation", rotation_noise, "The same for rx, ry, rz").type_name("ANGLE");
  app.add_option("--noise-force", force_noise,
                 "Standard deviation of fx, fy, fz: the robot feels another force than is written")
      .type_name("FORCE");
  app.add_option("--noise-moment", moment_noise, "The same for mx, my, mz").type_name("MOMENT");
  app.add_option("--noise-wrench", wrench_share,
                 "The same as a share of each component, for example 0.5%")
      .type_name("SHARE");
  app.add_option("--components", components,
                 "What is measured: dx,dy,dz,rx,ry,rz (default: what a noise is stated for)")
      .type_name("LIST");
  app.add_option("--effect", effects,
                 "An effect that acts beside those of the robot file; may be repeated")
      .type_name("NAME");
  app.add_option("--at", places, "Where it acts; as often as --effect").type_name("PLACE");
  app.add_option("--size", sizes,
                 "Its first parameter with its unit, or NAME=VALUE,...; as often as --effect")
      .type_name("SIZE");
  app.add_flag("--absolute", absolute, "Poses instead of differences to no load");
  app.add_option("--seed", seed, "Of the random numbers").seed().show_default();
}

calibration::SimulationOptions SimulationRequest::options(const vjm::Robot& robot) const {
  using Kind = calibration::DisplacementKind;
  namespace dimension = spatial::dimension;
  return {
      .displacement = absolute ? Kind::absolute : Kind::difference,
      .translation_noise = deviation("--noise-translation", translation_noise, dimension::length),
      .rotation_noise = deviation("--noise-rotation", rotation_noise, dimension::angle),
      .force_noise = deviation("--noise-force", force_noise, dimension::force),
      .moment_noise = deviation("--noise-moment", moment_noise, dimension::moment),
      .wrench_share = deviation("--noise-wrench", wrench_share, dimension::none),
      .components = chosen(*this),
      .seed = seed,
      .hidden = hidden_effects(*this, robot)};
}

}  // namespace kinetostat::apps
