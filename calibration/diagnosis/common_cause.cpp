#include "kinetostat/calibration/diagnosis/common_cause.h"

#include <algorithm>

namespace kinetostat::calibration {
namespace {

constexpr double as_well = 0.05;  // chance of a misfit as large, of a model that does as well

// Chance that noise makes a model with fewer unknowns this much worse; nothing where it has no
// fewer.
std::optional<double> p_value_beside(const BaseFit& fewer, const BaseFit& with_all) {
  const auto n = static_cast<double>(fewer.degrees_of_freedom() - with_all.degrees_of_freedom());
  const auto rest = static_cast<double>(with_all.degrees_of_freedom());
  if (n < 1 || rest < 1) return std::nullopt;
  const double noise = std::max(1.0, with_all.squared_error / rest);
  const double f = (fewer.squared_error - with_all.squared_error) / n / noise;
  return f > 0 ? chance_of_larger_f(f, n, rest) : 1;
}

bool is_at(const Parameter& parameter, const vjm::Effect& effect, const vjm::Manipulator& bare) {
  return std::any_of(effect.sites.begin(), effect.sites.end(), [&](const vjm::EffectSite& site) {
    return std::any_of(
        parameter.springs.begin(), parameter.springs.end(), [&](const vjm::SpringParameter& p) {
          if (p.chain != site.chain) return false;
          const vjm::Chain& chain = bare.chains()[p.chain];
          for (const vjm::Spring& spring : chain.springs())
            if (spring.name == p.spring &&
                chain.coordinates()[static_cast<std::size_t>(spring.first)].name == site.element)
              return true;
          return p.spring == site.element;
        });
  });
}

}  // namespace

bool refutes_nominal(const BaseFit& nominal, const BaseFit& with_all) {
  return p_value_beside(nominal, with_all).value_or(1) <= certain_level;
}

std::optional<CommonCause> common_cause(const vjm::Robot& robot, const Campaign& campaign,
                                        const Noise& noise, const BaseFit& with_all,
                                        const BaseFit& nominal,
                                        const std::vector<Candidate>& candidates, int threads,
                                        common::Progress& progress, FitJournal* journal) {
  if (candidates.empty() || !refutes_nominal(nominal, with_all)) return std::nullopt;
  const std::vector<Parameter> uncertain = uncertain_parameters(robot);
  const Predictor predictor(robot.without_effects(), robot.effects, campaign, threads, progress);
  const auto is_enough = [&](const std::vector<Parameter>& some) {
    const auto fit =
        if_possible([&] { return fit_base(predictor, campaign, noise, some, progress); });
    return fit && p_value_beside(*fit, with_all).value_or(1) > certain_level;
  };
  for (const Parameter& one : uncertain)
    if (is_enough({one})) return std::nullopt;

  vjm::Robot all_known = robot;
  all_known.uncertain.clear();
  all_known.uncertain_values.clear();
  const CandidateFitter fitter(all_known, campaign, noise, threads, progress, journal);
  std::optional<CommonCause> best;
  for (const Candidate& candidate : candidates) {
    const auto fit = if_possible([&] { return fitter.fit({candidate}, nullptr, progress); });
    if (!fit || p_value_beside(*fit, with_all).value_or(0) <= as_well) continue;
    const ChiSquareTest test =
        misfit_test(fit->squared_error, fit->degrees_of_freedom(), noise.degrees_of_freedom);
    if (test.p_value < certain_level) continue;
    if (best && best->test.statistic <= fit->squared_error) continue;
    std::vector<Parameter> own;
    std::copy_if(uncertain.begin(), uncertain.end(), std::back_inserter(own),
                 [&](const Parameter& parameter) {
                   return is_at(parameter, candidate.effect, robot.without_effects());
                 });
    if (!own.empty() && is_enough(own)) continue;
    const FittedValues fitted = fitted_values(*fit, {candidate}).front();
    best = {candidate, fitted.deviations, test};
    best->candidate.effect.values = fitted.values;
  }
  return best;
}

}  // namespace kinetostat::calibration
