#include "kinetostat/report/screen/effect.h"

#include <algorithm>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "kinetostat/report/effect.h"
#include "kinetostat/report/screen/wording.h"

namespace kinetostat::report {
namespace {

std::string units_of(const vjm::EffectParameter& parameter) {
  const std::string linear = spatial::to_string(parameter.linear);
  const std::string angular = spatial::to_string(parameter.angular);
  return linear == angular ? linear
                           : fmt::format("{}, or {} where the joint turns", linear, angular);
}

std::string parameter_text(const vjm::EffectParameter& p, bool leading) {
  const std::string given = !p.required ? fmt::format("{:g} unless given", p.none)
                            : leading   ? fmt::format("{:g} is no effect", p.none)
                                        : std::string("to be given");
  const std::string prior = p.prior_unit == vjm::PriorUnit::absolute ? "" : " " + prior_unit(p);
  return wrapped(fmt::format("{} [{}]: {:g} to {:g}, {}; prior +- {:g}{}", p.name, units_of(p),
                             p.lower, p.upper, given, p.prior_sd, prior),
                 2, 4);
}

}  // namespace

std::string line(const vjm::EffectKind& kind) {
  return labelled(fmt::format("{:<21} {}", kind.name, vjm::to_string(kind.place)), 33,
                  kind.summary);
}

std::string first_screen(const vjm::EffectKinds& kinds) {
  std::vector<std::pair<std::string, std::vector<std::string>>> by_place;
  for (const auto& kind : kinds) {
    const std::string place = vjm::to_string(kind->place);
    auto at = std::find_if(by_place.begin(), by_place.end(),
                           [&](const auto& entry) { return entry.first == place; });
    if (at == by_place.end()) at = by_place.insert(at, {place, {}});
    at->second.push_back(kind->name);
  }
  std::string text =
      fmt::format("{} effects that a robot file can have, by where they act:\n\n", kinds.size());
  for (const auto& [place, names] : by_place)
    text += labelled(place, 11, fmt::format("{}", fmt::join(names, ", ")));
  return text + next_step("kinetostat effect show clearance",
                          "law, size and signature; --verbose: all in a line each");
}

std::string text(const vjm::EffectKind& kind) {
  std::string text = wrapped(fmt::format("{}: {}", kind.name, kind.summary)) + "\n";
  for (const auto& [label, words] :
       {std::pair<const char*, std::string>{"acts on", vjm::to_string(kind.place)},
        {"law", kind.law},
        {"source", kind.source},
        {"signature", kind.signature},
        {"confounder", kind.confuser}})
    text += labelled(label, 11, words);
  text += "\n";
  for (const vjm::EffectParameter& p : kind.parameters)
    text += parameter_text(p, &p == &kind.parameters.front());
  return text;
}

}  // namespace kinetostat::report
