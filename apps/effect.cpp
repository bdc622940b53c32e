// kinetostat effect list, effect show: the catalogue of physical effects.
#include "kinetostat/vjm/effect.h"

#include <memory>
#include <stdexcept>

#include <fmt/format.h>

#include "kinetostat/apps/command.h"
#include "kinetostat/apps/commands.h"

namespace kinetostat::apps {
namespace {

std::string unit_of(const vjm::EffectParameter& parameter) {
  const std::string linear = spatial::to_string(parameter.linear);
  const std::string angular = spatial::to_string(parameter.angular);
  return linear == angular ? linear
                           : fmt::format("{}, or {} where the joint turns", linear, angular);
}

files::Json to_json(const vjm::EffectKind& kind) {
  files::Json parameters = files::Json::array();
  for (const vjm::EffectParameter& p : kind.parameters)
    parameters.push_back({{"name", p.name},
                          {"unit_linear", spatial::to_string(p.linear)},
                          {"unit_angular", spatial::to_string(p.angular)},
                          {"lower", p.lower},
                          {"upper", p.upper},
                          {"none", p.none},
                          {"required", p.required}});
  return {{"name", kind.name},
          {"summary", kind.summary},
          {"acts_on", vjm::to_string(kind.place)},
          {"law", kind.law},
          {"source", kind.source},
          {"signature", kind.signature},
          {"confuser", kind.confuser},
          {"parameters", parameters}};
}

files::Json list(Run& run) {
  files::Json kinds = files::Json::array();
  for (const vjm::EffectKind& kind : vjm::effect_kinds()) {
    run.print(
        fmt::format("{:<18} {:<10} {}\n", kind.name, vjm::to_string(kind.place), kind.summary));
    kinds.push_back(to_json(kind));
  }
  return {{"effects", kinds}};
}

const vjm::EffectKind& named(const std::string& name) {
  try {
    return vjm::effect_kind(name);
  } catch (const std::invalid_argument& error) {
    throw UsageError("NAME", error.what(), "'kinetostat effect list' names them");
  }
}

files::Json show(const std::string& name, Run& run) {
  const vjm::EffectKind& kind = named(name);
  run.print(
      fmt::format("{}: {}\n\n  acts on    {}\n  law        {}\n  source     {}\n"
                  "  signature  {}\n  confuser   {}\n\n",
                  kind.name, kind.summary, vjm::to_string(kind.place), kind.law, kind.source,
                  kind.signature, kind.confuser));
  for (const vjm::EffectParameter& p : kind.parameters)
    run.print(fmt::format("  {} [{}]: {:g} to {:g}, {:g} is no effect{}\n", p.name, unit_of(p),
                          p.lower, p.upper, p.none, p.required ? "" : " (and the default)"));
  return {{"effect", to_json(kind)}};
}

}  // namespace

void add_effect_list(Program& program) {
  program.add({.name = "effect list",
               .summary = "Physical effects that a robot file can have",
               .example = "kinetostat effect list"},
              [](Run& run) { return list(run); });
}

void add_effect_show(Program& program) {
  const auto name = std::make_shared<std::string>();
  CLI::App& app = program.add({.name = "effect show",
                               .summary = "Law, parameters and signature of one effect",
                               .example = "kinetostat effect show hardening"},
                              [name](Run& run) { return show(*name, run); });
  app.add_option("NAME", *name, "Name of the effect")->required();
}

}  // namespace kinetostat::apps
