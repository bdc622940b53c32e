#include "kinetostat/report/simulation.h"

#include <fmt/format.h>

#include "kinetostat/report/manipulators/manipulator.h"
#include "kinetostat/report/text/text.h"

namespace kinetostat::report {
namespace {

using io::Json;

constexpr const char* warning =
    "These readings come from the model itself: that a fit of this model to them succeeds proves "
    "nothing about any machine.";

std::string effect_text(const vjm::Effect& effect) {
  return fmt::format(
      "Hidden effect {} at {}: {}.\n  law        {}\n  signature  {}\n  confounder {}\n",
      effect.kind->name, effect.at, effect.kind->summary, effect.kind->law, effect.kind->signature,
      effect.kind->confuser);
}

std::string trace_text(const Simulation& simulation) {
  Table table({"changes", "rms", "largest", "at reading", "unit"});
  for (const calibration::HiddenTrace& t : simulation.made.trace) {
    const double factor = spatial::parse_unit(t.unit).factor;
    table.add_row({t.component.name, number(t.rms / factor), number(t.max / factor),
                   t.worst_reading, t.unit});
  }
  std::string text = table.text();
  if (const std::optional<double>& size = simulation.made.detectability)
    text +=
        fmt::format("All that they change is {} times the noise (d'): {}.\n", number(*size, 3),
                    *size < 4 ? "too little to be distinguished from noise" : "it should be seen");
  return text;
}

Json effect_json(const vjm::Effect& effect) {
  Json values = Json::object();
  for (std::size_t p = 0; p < effect.kind->parameters.size(); ++p)
    values[effect.kind->parameters[p].name] = effect.values[static_cast<Eigen::Index>(p)];
  return {{"effect", effect.kind->name},
          {"at", effect.at},
          {"values", values},
          {"signature", effect.kind->signature},
          {"confuser", effect.kind->confuser}};
}

Json hidden_json(const Simulation& simulation) {
  Json effects = Json::array(), trace = Json::array();
  for (const vjm::Effect& effect : simulation.options.hidden)
    effects.push_back(effect_json(effect));
  for (const calibration::HiddenTrace& t : simulation.made.trace)
    trace.push_back({{"component", t.component.name},
                     {"unit", spatial::to_string(t.component.dimension)},
                     {"rms", t.rms},
                     {"max", t.max},
                     {"worst_reading", t.worst_reading}});
  Json json{{"effects", effects}, {"changes", trace}};
  if (simulation.made.detectability) json["detectability"] = *simulation.made.detectability;
  return json;
}

}  // namespace

std::string text(const Simulation& simulation) {
  std::string out;
  for (const vjm::Effect& effect : simulation.options.hidden) out += effect_text(effect);
  if (!simulation.options.hidden.empty()) out += "\n" + trace_text(simulation) + "\n";
  return out + fmt::format("Wrote {} and readings.csv beside it, seed {}.\n{}\n",
                           simulation.campaign().string(), simulation.options.seed, warning);
}

Json to_json(const Simulation& simulation) {
  const calibration::SimulationOptions& options = simulation.options;
  Json json{{"inputs", provenance(simulation.robot)},
            {"campaign", simulation.campaign().string()},
            {"readings", simulation.readings().string()},
            {"seed", options.seed},
            {"translation_noise", options.translation_noise},
            {"rotation_noise", options.rotation_noise},
            {"force_noise", options.force_noise},
            {"moment_noise", options.moment_noise},
            {"wrench_share", options.wrench_share},
            {"warning", warning}};
  if (!options.hidden.empty()) json["hidden"] = hidden_json(simulation);
  return json;
}

}  // namespace kinetostat::report
