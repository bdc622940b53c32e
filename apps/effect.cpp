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

// What a prior width is counted in.
std::string prior_unit(const vjm::EffectParameter& parameter) {
  switch (parameter.prior_unit) {
    case vjm::PriorUnit::stiffness:
      return "times the stiffness of the joint's spring";
    case vjm::PriorUnit::compliance:
      return "over the stiffness of the joint's spring";
    default:
      return "SI";
  }
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
                          {"prior_sd", p.prior_sd},
                          {"prior_unit", prior_unit(p)},
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
  for (const auto& pointer : vjm::effect_kinds()) {
    const vjm::EffectKind& kind = *pointer;
    run.print(
        fmt::format("{:<18} {:<10} {}\n", kind.name, vjm::to_string(kind.place), kind.summary));
    kinds.push_back(to_json(kind));
  }
  return {{"effects", kinds}};
}

std::shared_ptr<const vjm::EffectKind> named(const std::string& name) {
  try {
    return vjm::effect_kind(name);
  } catch (const std::invalid_argument& error) {
    throw UsageError("NAME", error.what(), "'kinetostat effect list' names them");
  }
}

files::Json show(const std::string& name, Run& run) {
  const std::shared_ptr<const vjm::EffectKind> named_kind = named(name);
  const vjm::EffectKind& kind = *named_kind;
  run.print(
      fmt::format("{}: {}\n\n  acts on    {}\n  law        {}\n  source     {}\n"
                  "  signature  {}\n  confuser   {}\n\n",
                  kind.name, kind.summary, vjm::to_string(kind.place), kind.law, kind.source,
                  kind.signature, kind.confuser));
  for (const vjm::EffectParameter& p : kind.parameters)
    run.print(fmt::format(
        "  {} [{}]: {:g} to {:g}, {}; prior +- {:g}{}\n", p.name, unit_of(p), p.lower, p.upper,
        p.required ? (&p == &kind.parameters[0] ? fmt::format("{:g} is no effect", p.none)
                                                : std::string("to be given"))
                   : fmt::format("{:g} unless given", p.none),
        p.prior_sd, p.prior_unit == vjm::PriorUnit::absolute ? "" : " " + prior_unit(p)));
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
