#include "kinetostat/report/screen/comparison.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <string_view>

#include <fmt/format.h>

#include "kinetostat/report/screen/bars.h"
#include "kinetostat/report/screen/wording.h"
#include "kinetostat/report/text/text.h"

namespace kinetostat::report {
namespace {

using calibration::Adequacy;
using calibration::Assessment;
using calibration::Campaign;
using calibration::Comparison;
using calibration::NoiseSource;
using calibration::ParameterEstimate;
using calibration::Pattern;
using calibration::ResidualStatistics;

constexpr std::size_t most_failures = 4;

bool has_noise(const Comparison& comparison) {
  return comparison.noise.source != NoiseSource::unknown && comparison.nominal.fit.values > 0;
}

// The chance that noise alone leaves as much, by the test that decides.
std::string chance_of(const Assessment& assessment) {
  double p = 1;
  if (assessment.chi_square) p = std::min(p, assessment.chi_square->p_value);
  if (assessment.lack_of_fit) p = std::min(p, assessment.lack_of_fit->p_value);
  return chance(p);
}

std::string without_noise(const Comparison& comparison) {
  std::string text =
      "Whether the model explains the readings is not known: their noise is neither stated nor "
      "shown by repeated readings.";
  const auto deviation = [](const Assessment& a) { return a.residual_deviation; };
  if (comparison.fitted && deviation(comparison.nominal) && deviation(*comparison.fitted) &&
      *deviation(comparison.nominal) > 0)
    text += fmt::format(
        " Fitting takes {} of its error.",
        short_percent(1 - *deviation(*comparison.fitted) / *deviation(comparison.nominal)));
  return text;
}

// What a fit changed, beyond its error and within, and what it could not determine.
struct FittedNames {
  std::vector<std::string> changed, within, confounded, kept, at_bound;
};

FittedNames fitted_names(const vjm::Robot& robot, const calibration::BaseFit& fit) {
  constexpr double beyond = 2;  // standard deviations
  FittedNames names;
  for (const ParameterEstimate& e : fit.parameters) {
    const std::string name = short_name(robot.without_effects(), e.parameter.name);
    const double from = e.parameter.is_logarithm() ? 0 : e.parameter.start;
    if (e.hit != calibration::BoundHit::none)
      (!e.parameter.is_held()      ? names.at_bound
       : e.parameter.is_confounded ? names.confounded
                                   : names.kept)
          .push_back(name);
    else if (std::abs(e.value - from) <= beyond * e.standard_error)
      names.within.push_back(name);
    else if (e.parameter.is_logarithm())
      names.changed.push_back(name + " " +
                              change(std::exp(e.value), std::exp(e.value) * e.standard_error));
    else
      names.changed.push_back(
          fmt::format("{} {} {}", name, with_error(e.value, e.standard_error), e.parameter.unit));
  }
  return names;
}

// One thing on which the error depends, and how much of the error is there.
struct Failure {
  double p_value = 1;
  std::string text, share;
};

// "arm.q1 = 10 deg" without the chain where there is only one.
std::string without_chain(const vjm::Robot& robot, std::string label) {
  const vjm::Manipulator& bare = robot.without_effects();
  if (bare.size() != 1) return label;
  const std::string chain = bare.chains().front().name() + ".";
  for (std::size_t at = label.find(chain); at != std::string::npos; at = label.find(chain, at))
    label.erase(at, chain.size());
  return label;
}

std::string group_in_words(const Pattern& pattern, const std::string& label) {
  if (pattern.factor == "direction of load") return "under loads along " + label;
  if (pattern.factor == "level of load") return "under loads of " + label;
  if (pattern.factor == "branch")
    return label == "unloading" ? "while the load comes down" : "while the load goes up";
  return fmt::format("{} {}", pattern.factor, label);
}

Failure failure_of(const vjm::Robot& robot, const Pattern& pattern) {
  const bool by_mean =
      pattern.bias && (!pattern.size || pattern.bias->holm_p_value <= pattern.size->holm_p_value);
  const auto worst = std::max_element(
      pattern.groups.begin(), pattern.groups.end(), [](const auto& a, const auto& b) {
        return a.share - a.share_of_values < b.share - b.share_of_values;
      });
  std::string text = group_in_words(pattern, without_chain(robot, worst->label));
  if (pattern.factor == "branch" && by_mean)
    text = "coming down differs from going up, along the load: looks like friction or play";
  else if (by_mean && pattern.is_trend)
    text = fmt::format("changes with {}, most at {}", pattern.factor, worst->label);
  return {pattern.holm_p_value(), text,
          fmt::format("{} on {} of the values", short_percent(worst->share),
                      short_percent(worst->share_of_values))};
}

std::string in_unit(const Campaign& campaign, Eigen::Index component, double si) {
  const std::string unit = campaign.unit_of(component);
  return number(si / spatial::parse_unit(unit).factor, 3) + " " + unit;
}

void add_loops(const Campaign& campaign, const calibration::Patterns& patterns,
               std::vector<Failure>& failures) {
  constexpr double level = calibration::significance_level;
  const auto& each = patterns.loops.each;
  if (patterns.loops.area && patterns.loops.area->holm_p_value < level) {
    const auto worst = std::max_element(each.begin(), each.end(), [](const auto& a, const auto& b) {
      return std::abs(a.measured - a.predicted) < std::abs(b.measured - b.predicted);
    });
    failures.push_back(
        {patterns.loops.area->holm_p_value,
         fmt::format("load cycles lose energy: {} J in cycle '{}', {} J by the model",
                     number(worst->measured, 2), worst->cycle, number(worst->predicted, 2)),
         ""});
  }
  if (!patterns.loops.return_to_zero || patterns.loops.return_to_zero->holm_p_value >= level)
    return;
  std::string text;
  double largest = -1;
  for (const calibration::Loop& loop : each)
    for (Eigen::Index k = 0; loop.return_to_zero && k < campaign.size(); ++k)
      if (const double off = std::abs((*loop.return_to_zero)[k]); off > largest) {
        largest = off;
        text = fmt::format("readings come back to another zero: {} of {} off in cycle '{}'",
                           in_unit(campaign, k, off), campaign.component(k).name, loop.cycle);
      }
  failures.push_back({patterns.loops.return_to_zero->holm_p_value, text, ""});
}

// The surest first.
std::vector<Failure> failures_of(const vjm::Robot& robot, const Campaign& campaign,
                                 const Assessment& assessment) {
  constexpr double level = calibration::significance_level;
  std::vector<Failure> failures;
  const calibration::Patterns& patterns = assessment.patterns;
  for (const Pattern& pattern : patterns.factors)
    if (pattern.holm_p_value() < level && !pattern.groups.empty())
      failures.push_back(failure_of(robot, pattern));
  if (patterns.reversal && patterns.reversal->test.holm_p_value < level)
    failures.push_back(
        {patterns.reversal->test.holm_p_value,
         patterns.reversal->odd_share > 0.5 ? "changes sign with the load"
                                            : "keeps its sign when the load is reversed",
         short_percent(std::max(patterns.reversal->odd_share, 1 - patterns.reversal->odd_share))});
  add_loops(campaign, patterns, failures);
  std::stable_sort(failures.begin(), failures.end(),
                   [](const Failure& a, const Failure& b) { return a.p_value < b.p_value; });
  return failures;
}

std::string failures_text(const vjm::Robot& robot, const Campaign& campaign,
                          const Comparison& comparison) {
  const Assessment& best = comparison.best();
  std::vector<Failure> failures = failures_of(robot, campaign, best);
  const char* which = comparison.fitted ? "fitted" : "nominal";
  if (failures.empty())
    return best.adequacy == Adequacy::inadequate
               ? "\n  the error depends on nothing that the readings state\n"
               : "";
  const std::size_t all = failures.size();
  failures.resize(std::min(all, most_failures));
  std::size_t width = 44;
  for (const Failure& f : failures) width = std::max(width, f.text.size());
  width = std::min<std::size_t>(width, 66);
  std::string text = fmt::format("\n  {:<{}}share of the error\n",
                                 fmt::format("where the {} model fails", which), width + 4);
  for (std::size_t i = 0; i < failures.size(); ++i) {
    const Failure& f = failures[i];
    if (f.text.size() > width || f.share.empty())
      text += wrapped(fmt::format("{} {}", i + 1, f.text), 2, 4) +
              (f.share.empty() ? "" : std::string(width + 6, ' ') + f.share + "\n");
    else
      text += fmt::format("  {} {:<{}}  {}\n", i + 1, f.text, width, f.share);
  }
  if (all > most_failures) text += fmt::format("  {} more with --verbose\n", all - most_failures);
  return text;
}

// Root mean square of the noise of the values in use.
double noise_of(const Campaign& campaign, const Comparison& comparison, Eigen::Index component) {
  double sum = 0;
  std::size_t count = 0;
  for (std::size_t i = 0; i < campaign.readings.size(); ++i)
    if (campaign.readings[i].uses(component)) {
      sum += std::pow(comparison.noise.sigma[i][component], 2);
      ++count;
    }
  return count == 0 ? 0 : std::sqrt(sum / static_cast<double>(count));
}

std::string errors_text(const Campaign& campaign, const Comparison& comparison) {
  std::vector<std::string> header{"error (rms)", "nominal"};
  if (comparison.fitted) header.emplace_back("fitted");
  if (has_noise(comparison)) header.emplace_back("noise");
  header.insert(header.end(), {"unit", "largest", "at reading"});
  Table table(header);
  const auto& best = comparison.best().by_component;
  for (std::size_t i = 0; i < best.size(); ++i) {
    const ResidualStatistics& s = best[i];
    const std::string unit = campaign.unit_of(s.component);
    const auto shown = [&](double si) { return number(si / spatial::parse_unit(unit).factor, 3); };
    std::vector<std::string> row{campaign.component(s.component).name,
                                 shown(comparison.nominal.by_component[i].rms)};
    if (comparison.fitted) row.push_back(shown(s.rms));
    if (has_noise(comparison)) row.push_back(shown(noise_of(campaign, comparison, s.component)));
    const calibration::Reading& worst = campaign.readings[s.worst_reading];
    row.insert(row.end(),
               {unit, shown(s.max),
                fmt::format("{}:{}", campaign.readings_file.filename().string(), worst.line)});
    table.add_row(row);
  }
  return "\n" + table.text();
}

// The best model on readings that were kept out of its fit.
std::string held_out_text(const Comparison& comparison) {
  std::string text;
  for (const calibration::HeldOutReadings& h : comparison.best().held_out) {
    if (!h.failure.empty() || h.values == 0 || !has_noise(comparison)) continue;
    text +=
        fmt::format("  readings kept out ({}): {} times the noise on {} values\n",
                    calibration::role_names[static_cast<std::size_t>(h.role)],
                    times(std::sqrt(h.squared_error / static_cast<double>(h.values))), h.values);
  }
  return text;
}

std::string counted(std::size_t count, const std::string& noun) {
  return fmt::format("{} {}{}", count, noun, count == 1 ? "" : "s");
}

// "joint q2: -95 to 95 N m at 6 postures", or why its stiffness cannot be determined.
std::string load_in_words(const calibration::JointLoad& joint) {
  if (!joint.is_loaded())
    return fmt::format("no load {} it: its stiffness cannot be determined",
                       joint.turns ? "turns" : "pushes");
  const std::string load =
      fmt::format("{:.3g} to {:.3g} {} at {}", joint.least, joint.largest,
                  joint.turns ? "N m" : "N", counted(joint.postures, "posture"));
  return joint.is_seen ? load : load + ", but no reading sees it move";
}

// The last stage of the model before, or after.
const calibration::WaterfallStage* last_of(const calibration::BeforeAfter& both,
                                           const char* which) {
  const calibration::WaterfallStage* found = nullptr;
  for (const calibration::WaterfallStage& stage : both.stages)
    if (stage.name.starts_with(which)) found = &stage;
  return found;
}

}  // namespace

std::string headline(const Comparison& comparison) {
  if (!comparison.unit_error.empty()) return comparison.unit_error;
  const Assessment &nominal = comparison.nominal, &best = comparison.best();
  if (best.is_exact) return "The model explains the readings to rounding.";
  if (!has_noise(comparison) || best.adequacy == Adequacy::not_evaluated)
    return without_noise(comparison);
  const std::string error = times(nominal.error_over_noise()),
                    after = times(best.error_over_noise());
  if (best.adequacy == Adequacy::inadequate)
    return fmt::format(
        "The model does not explain the readings: its error is {} times the noise{} "
        "(chance of that by noise alone: {}).",
        error,
        comparison.fitted
            ? fmt::format(", and {} times after its uncertain values are fitted", after)
            : "",
        chance_of(best));
  if (comparison.adequacy() == Adequacy::inconclusive)
    return fmt::format(
        "Inconclusive: the error is {} times the noise, but the readings leave open {}. A {} on "
        "'{}' would tell.",
        comparison.fitted ? after : error, listed(comparison.missing_sensor->open, "and"),
        comparison.missing_sensor->kind_in_words(), comparison.missing_sensor->place);
  if (!comparison.fitted || nominal.adequacy == Adequacy::adequate)
    return fmt::format("The model explains the readings: its error is {} times the noise{}.", error,
                       comparison.fitted ? fmt::format(" (fitted: {})", after) : "");
  return fmt::format(
      "Fitted, the model explains the readings: its error is {} times the noise, and "
      "{} times before its uncertain values were fitted.",
      after, error);
}

std::string fitted_in_words(const vjm::Robot& robot, const calibration::BaseFit& fit) {
  const FittedNames names = fitted_names(robot, fit);
  std::string text = listed(names.changed, "and");
  const auto add = [&text](const char* words, const std::vector<std::string>& listed_names) {
    if (listed_names.empty()) return;
    text += (text.empty() ? "" : "; ") + std::string(words) + listed(listed_names, "and");
  };
  add("within their error: ", names.within);
  add("confounded with these, kept: ", names.confounded);
  add("not determined, kept: ", names.kept);
  add("at a bound: ", names.at_bound);
  return text;
}

std::string changed_in_words(const vjm::Robot& robot, const calibration::BaseFit& fit) {
  const FittedNames names = fitted_names(robot, fit);
  std::string changed = listed(names.changed, "and");
  if (changed.empty() || names.confounded.empty()) return changed;
  return fmt::format("{}, not distinguished from {}", changed, listed(names.confounded, "and"));
}

std::string first_screen(const vjm::Robot& robot, const Campaign& campaign,
                         const Comparison& comparison, const std::string& next) {
  std::string text = wrapped(headline(comparison));
  if (comparison.noise_check) {
    const calibration::ChiSquareTest& test = *comparison.noise_check;
    if (2 * std::min(test.p_value, test.lower_p_value) < test.level)
      text +=
          wrapped(fmt::format("Repeated readings scatter {} times the stated noise: correct that "
                              "first.",
                              times(std::sqrt(test.reduced()))));
  }
  if (!comparison.refit_failure.empty()) text += wrapped("Not fitted: " + comparison.refit_failure);
  text += failures_text(robot, campaign, comparison) + errors_text(campaign, comparison) +
          held_out_text(comparison);
  if (comparison.fitted)
    if (const std::string fitted = fitted_in_words(robot, comparison.fitted->fit); !fitted.empty())
      text += wrapped("fitted: " + fitted, 2, 4);
  return text + (next.empty() ? "" : "\n" + next);
}

std::string headline(const calibration::BeforeAfter& both) {
  const auto *from = last_of(both, "before"), *to = last_of(both, "after");
  if (from == nullptr || to == nullptr)
    return "The noise of the readings is neither stated nor shown by repeated readings, so errors "
           "are "
           "not compared.";
  const double change = 1 - to->whitened / from->whitened;
  return fmt::format("The held-out error {} from {} to {} times the noise ({}).",
                     change > 0 ? "falls" : "RISES", times(from->whitened), times(to->whitened),
                     short_percent(std::abs(change)));
}

std::string first_screen(const calibration::BeforeAfter& both) {
  return wrapped(headline(both)) + "\n" + falling_error(both.stages, {});
}

std::string readings_in_words(const Campaign& campaign,
                              const std::vector<calibration::Observability>& checks) {
  const auto usable =
      static_cast<std::size_t>(std::count_if(campaign.readings.begin(), campaign.readings.end(),
                                             [](const auto& reading) { return !reading.masked; }));
  const bool has_noise = std::any_of(checks.begin(), checks.end(), [](const auto& c) {
    return c.topic == "noise" && c.observable;
  });
  return fmt::format("{} of {} usable, {}, {}, noise {}", usable,
                     counted(campaign.readings.size(), "reading"),
                     counted(campaign.configurations.size(), "posture"),
                     counted(campaign.sessions.size(), "session"),
                     campaign.noise_stated ? "stated"
                     : has_noise           ? "from repeated readings"
                                           : "not known");
}

// Of a first screen; of more only those whose stiffness cannot be determined are shown.
constexpr std::size_t most_joints = 7;

std::string joints_text(const std::vector<calibration::JointLoad>& joints) {
  std::string text;
  for (const calibration::JointLoad& joint : joints)
    text += labelled(joint.name, 36, load_in_words(joint));
  return text.empty() ? text
                      : "\n  joint                               what the loads do to it\n" + text;
}

namespace {

// Where there are many joints, those that are not observable.
std::vector<calibration::JointLoad> shown_of(std::vector<calibration::JointLoad> joints) {
  if (joints.size() > most_joints)
    std::erase_if(joints, [](const auto& joint) { return joint.is_observable(); });
  return joints;
}

}  // namespace

std::string first_screen(const Campaign& campaign,
                         const std::vector<calibration::Observability>& checks,
                         const std::vector<calibration::JointLoad>& joints,
                         const std::string& next) {
  std::vector<std::string> seen;
  std::string unseen;
  for (const calibration::Observability& check : checks) {
    if (check.observable)
      seen.push_back(check.effect);
    else
      unseen += labelled(check.effect, 36, check.cure);
  }
  std::string text = wrapped(readings_in_words(campaign, checks) + ".");
  if (!seen.empty()) text += wrapped("Observable: " + listed(seen, "and") + ".", 0, 2);
  if (!unseen.empty())
    text += "\n  not observable                      what would show it\n" + unseen;
  return text + joints_text(shown_of(joints)) + (next.empty() ? "" : "\n" + next);
}

}  // namespace kinetostat::report
