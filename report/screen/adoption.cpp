#include "kinetostat/report/screen/adoption.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "kinetostat/report/screen/wording.h"

namespace kinetostat::report {
namespace {

using calibration::AdoptedParameter;

std::string value_in_words(const vjm::Robot& robot, const AdoptedParameter& p) {
  if (!p.effect.empty())
    return fmt::format("{} of {} {}{}{}", p.parameter,
                       effect_in_words(robot.without_effects(), p.effect, p.at),
                       with_error(p.value.value, p.value.deviation),
                       p.value.unit.empty() ? "" : " ", p.value.unit);
  const std::string name = short_name(robot.without_effects(), p.stiffness);
  if (std::isfinite(p.value.deviation) && p.value.deviation > 0)
    return name + " " + change(p.value.value, p.value.deviation);
  return fmt::format("{} {:+.3g} %", name, 100 * (p.value.value - 1));
}

// The largest changes first come to mind; the file has them all.
std::string fit_in_words(const vjm::Robot& robot, const std::vector<AdoptedParameter>& fitted) {
  constexpr std::size_t most = 4;
  std::vector<std::string> words;
  for (const AdoptedParameter& p : fitted) {
    if (words.size() == most) {
      words.emplace_back("...");
      break;
    }
    words.push_back(value_in_words(robot, p));
  }
  return fmt::format("{} fitted value{} ({})", fitted.size(), fitted.size() == 1 ? "" : "s",
                     fmt::join(words, ", "));
}

std::string error_sentence(const AdoptionSummary& a) {
  if (!std::isnan(a.as_written))
    return fmt::format("Error with this file as written: {} times the noise{}.",
                       times(a.as_written),
                       std::isnan(a.nominal) ? "" : fmt::format(" (was {})", times(a.nominal)));
  if (!std::isnan(a.before) && !std::isnan(a.after))
    return fmt::format(
        "With it the error on readings kept out of the fit goes {} -> {} times the "
        "noise.",
        times(a.before), times(a.after));
  return {};
}

}  // namespace

std::string headline(const vjm::Robot& robot, const AdoptionSummary& a) {
  std::vector<std::string> what = a.effects;
  if (!a.fitted.empty()) what.push_back(fit_in_words(robot, a.fitted));
  return fmt::format("{}: {}{}.", a.file.string(), listed(what, "and"),
                     a.fitted.empty() ? "" : "; old values are kept as comments");
}

std::string first_screen(const vjm::Robot& robot, const AdoptionSummary& a,
                         const std::string& next) {
  std::string text = wrapped(headline(robot, a)) + wrapped(error_sentence(a));
  for (const std::string& one : a.reservations) text += wrapped(capitalised(one) + ".", 0, 2);
  return text + wrapped("Take back: kinetostat revert " + quoted(a.file)) +
         (next.empty() ? "" : "\n" + next);
}

}  // namespace kinetostat::report
