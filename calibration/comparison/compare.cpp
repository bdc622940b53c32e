#include "kinetostat/calibration/comparison/compare.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "kinetostat/calibration/campaign/datum.h"
#include "kinetostat/calibration/campaign/noise_estimate.h"
#include "kinetostat/calibration/campaign/pure_error.h"
#include "kinetostat/calibration/comparison/column_error.h"
#include "kinetostat/calibration/comparison/unit_error.h"
#include "kinetostat/calibration/regression/datum_noise.h"
#include "kinetostat/calibration/regression/undetermined.h"
#include "kinetostat/calibration/regression/wrench_noise.h"
#include "kinetostat/common/error.h"

namespace kinetostat::calibration {
namespace {

using Eigen::VectorXd;

// Groups of replicates: how many there are, and those that have any.
struct Groups {
  std::size_t count = 0;
  std::vector<ReplicateGroup> repeated = {};
  bool mixes_kinds = false;  // of all
};

// What all assessments of one campaign share.
struct Evidence {
  const Campaign& campaign;  // with readings of other roles masked
  Groups groups;
  Noise noise;
  PureError pure;  // whitened by `noise`
};

ResidualStatistics statistics(const Evidence& evidence, const Assessment& assessment,
                              Eigen::Index component, std::optional<std::size_t> session) {
  ResidualStatistics s{.component = component, .session = session};
  double squares = 0, whitened = 0;
  for (std::size_t i = 0; i < evidence.campaign.readings.size(); ++i) {
    const Reading& reading = evidence.campaign.readings[i];
    if (!reading.uses(component) || (session && reading.session != *session)) continue;
    const double r = assessment.residual[i][component];
    ++s.count;
    s.bias += r;
    squares += r * r;
    whitened += std::pow(assessment.whitened[i][component], 2);
    if (s.count == 1 || std::abs(r) > s.max) {
      s.max = std::abs(r);
      s.worst_reading = i;
    }
  }
  if (s.count == 0) return s;
  s.bias /= static_cast<double>(s.count);
  s.rms = std::sqrt(squares / static_cast<double>(s.count));
  const double total = assessment.fit.squared_error;
  s.share = total > 0 ? whitened / total : 0;
  return s;
}

void add_statistics(const Evidence& evidence, Assessment& assessment) {
  const std::size_t sessions = evidence.campaign.sessions.size();
  for (Eigen::Index k = 0; k < evidence.campaign.size(); ++k) {
    const ResidualStatistics all = statistics(evidence, assessment, k, std::nullopt);
    if (all.count == 0) continue;
    assessment.by_component.push_back(all);
    for (std::size_t session = 0; sessions > 1 && session < sessions; ++session)
      if (const auto s = statistics(evidence, assessment, k, session); s.count > 0)
        assessment.by_session.push_back(s);
  }
}

void add_residuals(const Evidence& evidence, Assessment& assessment) {
  for (std::size_t i = 0; i < evidence.campaign.readings.size(); ++i) {
    const Reading& reading = evidence.campaign.readings[i];
    const VectorXd residual = reading.displacement - assessment.fit.predicted[i];
    assessment.residual.push_back(residual);
    VectorXd whitened = residual.cwiseQuotient(evidence.noise.sigma[i]);
    if (const auto used = components_in_use(reading); !used.empty()) {
      Eigen::MatrixXd column = residual(used);
      evidence.noise.whiten(i, used, column);
      whitened(used) = column;
    }
    assessment.whitened.push_back(whitened);
  }
  const std::vector<Value> values = values_in_use(evidence.campaign);
  Eigen::MatrixXd column(values.size(), 1);
  for (std::size_t v = 0; v < values.size(); ++v)
    column(static_cast<Eigen::Index>(v), 0) =
        assessment.whitened[values[v].reading][values[v].component];
  SharedNoise(evidence.noise, values).whiten(column);
  for (std::size_t v = 0; v < values.size(); ++v)
    assessment.whitened[values[v].reading][values[v].component] =
        column(static_cast<Eigen::Index>(v), 0);
}

bool is_exact(const Evidence& evidence, const Assessment& assessment) {
  double size = 0;
  for (const Value& value : values_in_use(evidence.campaign))
    size += std::pow(evidence.campaign.readings[value.reading].displacement[value.component] /
                         evidence.noise.sigma[value.reading][value.component],
                     2);
  return !(assessment.fit.squared_error > 1e-18 * size);
}

// Only a sum over quantities of one kind has a unit.
std::optional<double> residual_deviation(const Campaign& campaign, const Assessment& assessment) {
  if (assessment.fit.degrees_of_freedom() <= 0) return std::nullopt;
  double squares = 0;
  for (const ResidualStatistics& s : assessment.by_component) {
    if (campaign.component(s.component).dimension !=
        campaign.component(assessment.by_component[0].component).dimension)
      return std::nullopt;
    squares += static_cast<double>(s.count) * s.rms * s.rms;
  }
  return std::sqrt(squares / static_cast<double>(assessment.fit.degrees_of_freedom()));
}

// The noise comes from `evidence`, which has not seen any residual.
void add_tests(const Evidence& evidence, Assessment& assessment) {
  const BaseFit& fit = assessment.fit;
  const auto lack = static_cast<Eigen::Index>(evidence.groups.count) - fit.estimated;
  const bool by_stated_noise =
      evidence.noise.source == NoiseSource::stated && fit.degrees_of_freedom() > 0;
  const bool by_replicates = evidence.noise.comparable && evidence.pure.degrees_of_freedom > 0 &&
                             evidence.pure.sum > 0 && lack > 0;
  if (!by_stated_noise && !by_replicates) return;
  const double level = significance_level / (by_stated_noise + by_replicates);
  bool fails = false;
  if (by_stated_noise) {
    assessment.chi_square = chi_square_test(fit.squared_error, fit.degrees_of_freedom(), level);
    fails = assessment.chi_square->p_value < level;
  }
  if (by_replicates) {
    assessment.lack_of_fit =
        lack_of_fit_test(std::max(0.0, fit.squared_error - evidence.pure.sum), lack,
                         evidence.pure.sum, evidence.pure.degrees_of_freedom, level);
    fails = fails || assessment.lack_of_fit->p_value < level;
  }
  assessment.adequacy = fails ? Adequacy::inadequate : Adequacy::adequate;
}

// Predictions of a model for readings that were kept out of its fit. Their predictions take the
// place of those that were made without the zero offsets and frames of their sessions.
HeldOutReadings predict_held_out(const Predictor& predictor, const Campaign& others, Role role,
                                 const Evidence& evidence, common::Progress& progress,
                                 Assessment& assessment) {
  HeldOutReadings result;
  result.role = role;
  const Evidence own{others, {}, evidence.noise, {}};
  Assessment alone;
  try {
    alone.fit = predict_others(predictor, others, evidence.noise, assessment.fit, progress);
  } catch (const common::NotIdentifiable& error) {
    result.values = static_cast<Eigen::Index>(values_in_use(others).size());
    result.failure = error.what();
    return result;
  }
  result.values = alone.fit.values;
  result.estimated = alone.fit.estimated;
  result.squared_error = alone.fit.squared_error;
  add_residuals(own, alone);
  for (Eigen::Index k = 0; k < others.size(); ++k)
    if (const auto s = statistics(own, alone, k, std::nullopt); s.count > 0)
      result.by_component.push_back(s);
  if (evidence.noise.source != NoiseSource::unknown && alone.fit.degrees_of_freedom() > 0)
    result.chi_square = chi_square_test(alone.fit.squared_error, alone.fit.degrees_of_freedom());
  for (std::size_t i = 0; i < others.readings.size(); ++i)
    if (!others.readings[i].masked) {
      assessment.fit.predicted[i] = alone.fit.predicted[i];
      assessment.fit.work[i] = alone.fit.work[i];
    }
  return result;
}

void add_held_out(const Predictor& predictor, const Campaign& whole, const Evidence& evidence,
                  common::Progress& progress, Assessment& assessment) {
  for (const Role role : {Role::select, Role::confirm})
    if (has_role(whole, role))
      assessment.held_out.push_back(
          predict_held_out(predictor, only(whole, {role}), role, evidence, progress, assessment));
}

Assessment assess(const Predictor& predictor, const Campaign& whole, const Evidence& evidence,
                  BaseFit fit, common::Progress& progress) {
  Assessment assessment;
  assessment.fit = std::move(fit);
  assessment.fit.model = {};  // its states are most of the memory of a long table
  add_held_out(predictor, whole, evidence, progress, assessment);
  add_residuals(evidence, assessment);
  add_statistics(evidence, assessment);
  assessment.residual_deviation = residual_deviation(evidence.campaign, assessment);
  assessment.is_exact = is_exact(evidence, assessment);
  add_tests(evidence, assessment);
  assessment.patterns = find_patterns(
      evidence.campaign, assessment.residual, assessment.whitened, assessment.fit.work,
      static_cast<Eigen::Index>(assessment.fit.parameters.size()), evidence.noise);
  return assessment;
}

Groups groups_of(const Campaign& campaign, std::vector<ReplicateGroup> groups) {
  const auto kind_of = [&](const ReplicateGroup& group) {
    const Component& component = campaign.component(group.component);
    return std::pair(component.sensor, component.dimension);
  };
  Groups result{.count = groups.size()};
  result.mixes_kinds = std::any_of(groups.begin(), groups.end(), [&](const auto& group) {
    return kind_of(group) != kind_of(groups.front());
  });
  for (ReplicateGroup& group : groups)
    if (group.readings.size() > 1) result.repeated.push_back(std::move(group));
  return result;
}

// Why a test was not made.
void add_notes(const Evidence& evidence, std::vector<std::string>& result) {
  const bool stated = evidence.noise.source == NoiseSource::stated;
  if (!stated) result.push_back("No noise is stated, so there is no chi-square test.");
  if (evidence.pure.degrees_of_freedom == 0)
    result.push_back("No reading is repeated, so there is no lack-of-fit test.");
  else if (!(evidence.pure.sum > 0))
    result.push_back(
        "Repeated readings are equal to the last digit: they say nothing about the noise, so "
        "there is no lack-of-fit test.");
  if (evidence.noise.only_unloaded)
    result.push_back(
        "Only readings without load are repeated, and the noise under load may be larger: repeat "
        "some of those, or state 'noise'.");
  if (evidence.noise.source == NoiseSource::replicates && evidence.groups.mixes_kinds)
    result.push_back(
        "Translations and rotations are weighted by the scatter of their own replicates, so the F "
        "distribution of the lack-of-fit test is approximate. State 'noise' for an exact test.");
  if (!stated && evidence.noise.source == NoiseSource::unknown)
    result.push_back(
        "Adequacy is not evaluated: the noise is known from nothing but the residual. State "
        "'noise' in the campaign file, or repeat readings.");
}

// What a reader should know of fitted stiffnesses, in sentences.
std::vector<std::string> doubts_about(const BaseFit& fit) {
  std::vector<std::string> doubts;
  for (const auto& [parameter, value, error, hit] : fit.parameters)
    if (parameter.is_logarithm() && std::abs(value) > std::log(doubtful_factor))
      doubts.push_back(
          fmt::format("{} is fitted to {:.3g} times its nominal value: check units and the robot "
                      "file, or the model lacks an effect ('diagnose').",
                      parameter.phrase(), std::exp(value)));
  if (std::string common = common_factor(fit.parameters); !common.empty())
    doubts.push_back(std::move(common));
  const std::vector<std::string> more = cautions_about(fit);
  doubts.insert(doubts.end(), more.begin(), more.end());
  return doubts;
}

// The best so far where a fit does not come to rest, unless readings in other units are why.
BaseFit fit_as_far_as_it_goes(const Predictor& predictor, const Campaign& campaign,
                              const Noise& noise, const std::vector<Parameter>& parameters,
                              Loss loss, common::Progress& progress) {
  BaseFitOptions options{.loss = loss, .few_states = true};
  const auto fit = [&] {
    return fit_base(predictor, campaign, noise, parameters, progress, options);
  };
  try {
    return with_hint_of_unit_error(predictor, campaign, progress, fit);
  } catch (const common::NoConvergence&) {
    if (!unit_error(campaign, predictor, progress).empty()) throw;
    options.accept_unsettled = true;
    return fit();
  }
}

std::string unit_or_column_error(const vjm::Robot& robot, const Campaign& campaign,
                                 const Assessment& nominal, int threads,
                                 common::Progress& progress) {
  std::string of_units = unit_error(campaign, nominal.fit.predicted);
  if (!of_units.empty()) return of_units;
  return column_error(robot, campaign, nominal.fit.predicted, threads, progress);
}

// What would determine it, where the readings do not determine what is uncertain.
void add_missing_sensor(const vjm::Robot& robot, const Campaign& campaign, const Noise& noise,
                        int threads, common::Progress& progress, Comparison& result) {
  if (result.fitted && result.fitted->fit.weak.empty() && result.notes.empty()) return;
  const auto& sensor = result.missing_sensor = missing_sensor(
      robot, robot.effects, uncertain_parameters(robot), campaign, noise, threads, progress);
  if (!sensor) return;
  const std::string sentence = "What is missing: " + sensor->phrase() + ".";
  if (result.refit_failure.empty())
    result.notes.push_back(sentence);
  else
    result.refit_failure += " " + sentence;
}

bool is_all_held(const std::vector<Parameter>& parameters) {
  return std::all_of(parameters.begin(), parameters.end(),
                     [](const Parameter& p) { return p.is_held(); });
}

// Fits what the robot file declares uncertain, as far as the readings determine it.
template <class Fit>
std::optional<BaseFit> refit(const vjm::Robot& robot, const Predictor& predictor,
                             const Evidence& evidence, const Fit& fit, common::Progress& progress,
                             Comparison& result) {
  const std::vector<Parameter> declared = uncertain_parameters(robot);
  if (declared.empty()) return std::nullopt;
  std::vector<Parameter> uncertain = declared;
  std::vector<std::string> said =
      keep_undetermined(predictor, evidence.campaign, evidence.noise, uncertain, progress);
  const bool nothing_seen = is_all_held(uncertain);
  if (nothing_seen) {  // the fit says why
    uncertain = declared;
    said.clear();
  }
  const auto may_believe = [&] {
    return !nothing_seen && evidence.noise.source != NoiseSource::unknown &&
           result.unit_error.empty();
  };
  try {
    BaseFit fitted = fit_near_design(uncertain, fit, may_believe);
    const std::vector<std::string> doubts = doubts_about(fitted);
    said.insert(said.end(), doubts.begin(), doubts.end());
    result.notes = std::move(said);
    return fitted;
  } catch (const common::NotIdentifiable& error) {
    result.refit_failure = error.what();
    return std::nullopt;
  }
}

}  // namespace

Comparison compare(const vjm::Robot& robot, const Campaign& campaign, int threads,
                   common::Progress& progress, const CompareOptions& options) {
  const Loss loss = options.loss;
  const bool has_others = has_role(campaign, Role::select) || has_role(campaign, Role::confirm);
  std::optional<Campaign> part;
  if (has_others) part = only(campaign, {Role::fit});
  const Campaign& to_fit = has_others ? *part : campaign;
  std::vector<ReplicateGroup> groups = replicate_groups(to_fit);
  Noise noise =
      with_datums_seen(noise_of(campaign, has_others ? replicate_groups(campaign) : groups), robot,
                       campaign, threads, progress);
  // Whitened by what they share, one gross error would be in many readings.
  if (loss != Loss::squares) noise.datums.clear();
  std::optional<Noise> stated;  // without that of the wrenches, where these have any
  if (!campaign.wrench_covariance.empty()) stated = noise;
  Evidence evidence{to_fit, groups_of(to_fit, std::move(groups)), std::move(noise), {}};
  const Predictor predictor(robot.without_effects(), robot.effects, campaign, threads, progress);
  const auto know = [&](const std::vector<Parameter>& parameters, const BaseFit* found) {
    const Eigen::VectorXd values = found == nullptr ? Eigen::VectorXd() : values_of(*found);
    if (stated)
      evidence.noise =
          with_wrench_noise(*stated, campaign, predictor, parameters, values, progress, found);
    evidence.pure = pure_error(to_fit, evidence.groups.repeated, evidence.noise);
  };
  const auto fit = [&](const std::vector<Parameter>& parameters) {
    know({}, nullptr);
    const auto once = [&] {
      return fit_as_far_as_it_goes(predictor, to_fit, evidence.noise, parameters, loss, progress);
    };
    BaseFit result = once();
    // What the noise of the wrenches does depends on the compliance that was fitted, and on where
    // it is looked at.
    const bool moved = !parameters.empty() || !result.targets.empty() || !result.frames.empty();
    if (moved && stated) {
      know(parameters, &result);
      result = once();
    }
    return result;
  };
  const auto assessed = [&](BaseFit found) {
    if (!options.keep_equations) found.at = {};
    return assess(predictor, campaign, evidence, std::move(found), progress);
  };
  Comparison result;
  result.groups = static_cast<Eigen::Index>(evidence.groups.count);
  result.nominal = assessed(fit({}));
  result.unit_error = unit_or_column_error(robot, to_fit, result.nominal, threads, progress);
  if (std::optional<BaseFit> found = refit(robot, predictor, evidence, fit, progress, result))
    result.fitted = assessed(*std::move(found));
  add_missing_sensor(robot, to_fit, evidence.noise, threads, progress, result);
  if (evidence.pure.degrees_of_freedom > 0) result.replicates = evidence.pure;
  result.noise_check = test_of_stated_noise(evidence.pure, evidence.noise);
  add_notes(evidence, result.notes);
  result.noise = std::move(evidence.noise);
  return result;
}

}  // namespace kinetostat::calibration
