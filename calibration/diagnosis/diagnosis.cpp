#include "kinetostat/calibration/diagnosis/diagnosis.h"

#include <algorithm>
#include <cmath>
#include <map>

#include <fmt/format.h>

#include "kinetostat/calibration/campaign/load_history.h"
#include "kinetostat/calibration/campaign/noise_estimate.h"
#include "kinetostat/calibration/campaign/pure_error.h"
#include "kinetostat/calibration/campaign/replicates.h"
#include "kinetostat/calibration/comparison/column_error.h"
#include "kinetostat/calibration/comparison/missing_sensor.h"
#include "kinetostat/calibration/comparison/unit_error.h"
#include "kinetostat/calibration/diagnosis/decision.h"
#include "kinetostat/calibration/diagnosis/growth.h"
#include "kinetostat/calibration/diagnosis/judgement.h"
#include "kinetostat/calibration/regression/campaign_noise.h"
#include "kinetostat/calibration/regression/evidence.h"
#include "kinetostat/calibration/regression/joint_scales.h"
#include "kinetostat/calibration/regression/undetermined.h"
#include "kinetostat/calibration/search/outliers.h"
#include "kinetostat/calibration/search/repeated_outliers.h"
#include "kinetostat/common/error.h"

namespace kinetostat::calibration {
namespace {

constexpr double most_outliers = 0.04;  // of all values: more are something that is not known

// Where no load is taken back or reversed, friction only takes up a part of the load, as a gap
// takes up a part of the way; the details of either law are no evidence.
void doubt_friction(const Campaign& campaign, Diagnosis& d) {
  if (takes_loads_back(campaign)) return;
  for (FoundEffect& found : d.found) {
    const vjm::Effect& friction = found.candidate.effect;
    if (friction.kind->effect_class != vjm::EffectClass::friction) continue;
    const auto is_gap_there = [&](const Candidate& other) {
      return other.effect.kind->effect_class == vjm::EffectClass::backlash &&
             other.effect.at == friction.at;
    };
    if (std::none_of(found.instead.begin(), found.instead.end(), is_gap_there))
      found.instead.push_back({.effect = {.kind = vjm::effect_kind("clearance"),
                                          .at = friction.at,
                                          .sites = friction.sites,
                                          .values = {}},
                               .deviations = {}});
    d.missing.push_back(
        "loads that are taken back or reversed: without them friction looks like a clearance");
  }
}

// Whether there is something more beside all that was found: of the round that looked for it.
void take_rest(Diagnosis& d) {
  const DiagnosisStep* step = round_beside(d.found, d.steps);
  if (step == nullptr) return;
  d.rest_p_value = step->max_score.p_value;
  if (is_rest_of_laws(d.found, *step)) d.rest_of_laws = step->ranking[0].candidate.name();
}

// Values and deviations of all that was found, from the fit that has all of it.
void take_values(const std::vector<FittedValues>& fitted, std::vector<FoundEffect>& found) {
  for (std::size_t k = 0; k < found.size(); ++k) {
    found[k].candidate.effect.values = fitted[k].values;
    found[k].deviations = fitted[k].deviations;
  }
}

std::optional<ChiSquareTest> test_of(const BaseFit& fit, const Noise& noise) {
  if (noise.source == NoiseSource::unknown || fit.degrees_of_freedom() < 1) return std::nullopt;
  return misfit_test(fit.squared_error, fit.degrees_of_freedom(), noise.degrees_of_freedom);
}

// Readings of some values, masked.
Campaign without(const Campaign& campaign, const std::vector<Value>& values,
                 const std::vector<std::size_t>& outliers, std::vector<std::string>& said) {
  Campaign result = campaign;
  for (const std::size_t v : outliers) {
    Reading& reading = result.readings[values[v].reading];
    if (reading.masked) continue;
    reading.masked = true;
    reading.mask_reason = fmt::format(
        "more than {:g} standard deviations from what any effect explains, to first order",
        outlying);
    said.push_back(fmt::format("reading '{}' ({}:{}): {}", reading.id,
                               campaign.readings_file.filename().string(), reading.line,
                               reading.mask_reason));
  }
  return result;
}

void list_ambiguous(Diagnosis& d) {
  for (const FoundEffect& found : d.found) {
    if (found.instead.empty() && found.decision.is_identified && !d.or_something_else) continue;
    d.ambiguous.push_back(found.candidate.name());
    for (const Candidate& other : found.instead) d.ambiguous.push_back(other.name());
  }
}

Diagnosis cannot_tell_without_noise() {
  Diagnosis d;
  d.missing.push_back(
      "how exact the readings are: state the instrument's noise in the campaign file, or repeat "
      "readings under the same load; noise is never taken from the misfit of the model itself");
  return d;
}

/// The readings that are fitted, with the model that is there before anything is added.
class Baseline {
 public:
  Baseline(const vjm::Robot& robot, const Campaign& whole, const Noise& noise,
           const DiagnosisOptions& options, int threads, common::Progress& progress)
      : noise_(noise),
        given_(only(whole, {Role::fit, Role::select})),
        all_(robot, given_, noise, threads, progress, options.journal),
        fit_(with_hint_of_unit_error(all_.predictor(), given_, progress,
                                     [&] { return all_.fit({}, nullptr, progress); })),
        scales_(
            joint_scales(all_.predictor(), robot.without_effects(), given_, noise, fit_, progress)),
        tried_(candidates(robot, options.kinds, scales_)),
        whole_search_(all_, tried_, options, threads, progress),
        campaign_(without_outliers()),
        fitter_(robot, campaign_, noise, threads, progress, options.journal),
        search_(fitter_, tried_, options, threads, progress) {
    search_.take_signatures(whole_search_);
    if (!set_aside_.empty()) fit_ = fitter_.fit({}, &fit_, progress);
    search_.prepare_free_form(fit_);
  }
  Baseline(const Baseline&) = delete;
  Baseline& operator=(const Baseline&) = delete;

  const Noise& noise() const { return noise_; }
  const Campaign& campaign() const { return campaign_; }  // without what was set aside
  const CandidateFitter& fitter() const { return fitter_; }
  const CandidateFitter& fitter_of_all() const { return all_; }
  Search& search() { return search_; }
  const Search& search_in_all() const { return whole_search_; }
  const BaseFit& fit() const { return fit_; }
  const vjm::ReadingScales& scales() const { return scales_; }
  const std::vector<std::string>& set_aside() const { return set_aside_; }
  std::size_t far_values() const { return far_values_; }

  /// What the fit hardly knows, in sentences.
  std::vector<std::string> weak() const {
    std::vector<std::string> weak = fitter_.kept_nominal();
    const std::vector<std::string> cautions = cautions_about(fit_);
    weak.insert(weak.end(), cautions.begin(), cautions.end());
    weak.insert(weak.end(), fit_.weak.begin(), fit_.weak.end());
    return weak;
  }

 private:
  Campaign without_outliers() {
    whole_search_.screen({}, fit_);
    std::vector<std::size_t> outliers = without_repeated(
        given_, whole_search_.values(), fit_.at.residual, whole_search_.outliers(fit_));
    if (static_cast<double>(outliers.size()) >
        most_outliers * static_cast<double>(whole_search_.values().size())) {
      far_values_ = outliers.size();
      outliers.clear();
    }
    return without(given_, whole_search_.values(), outliers, set_aside_);
  }

  std::vector<std::string> set_aside_;
  std::size_t far_values_ = 0;
  const Noise& noise_;
  Campaign given_;
  CandidateFitter all_;
  BaseFit fit_;
  vjm::ReadingScales scales_;
  std::vector<Candidate> tried_;
  Search whole_search_;
  Campaign campaign_;
  CandidateFitter fitter_;
  Search search_;
};

Diagnosis of_baseline(const Baseline& base) {
  Diagnosis d;
  d.noise = base.noise().source;
  d.noise_without_load = base.noise().only_unloaded;
  d.set_aside = base.set_aside();
  d.far_values = base.far_values();
  d.before = test_of(base.fit(), base.noise());
  d.noise_check = test_of_stated_noise(
      pure_error(base.campaign(), replicate_groups(base.campaign()), base.noise()), base.noise());
  d.weak = base.weak();
  d.fitted_without = base.fit().parameters;
  d.correlation_without = correlation_of(base.fit());
  return d;
}

/// Held-out error of one model after the other.
class Waterfall {
 public:
  Waterfall(const Campaign& whole, Baseline& base, const HeldOutRefit& refit,
            const DiagnosisOptions& options, common::Progress& progress)
      : base_(base),
        refit_(refit),
        kept_(only(whole, {Role::confirm})),
        has_kept_(has_role(whole, Role::confirm)),
        seed_(options.seed),
        progress_(progress) {}

  void add(const std::string& name, const BaseFit& fit, const std::vector<Candidate>& added) {
    const Search& search = base_.search();
    stages_.push_back(
        waterfall_stage(name, fit, kept_, search.values(), base_.noise(), search.groups(), seed_));
    // By the linear model about the fit, perhaps.
    if (!fit.parameters.empty() && is_much_worse_than(fit))
      if (const auto error = refit_.error(added, fit, progress_))
        stages_.back() = waterfall_stage(name, *error, kept_, search.values(), base_.noise(),
                                         search.groups(), seed_);
    if (has_kept_) stages_.back().confirmed = base_.fitter().error_on(kept_, fit, added, progress_);
  }

  void add(const Model& model) {
    for (std::size_t n = 0; n < model.stages.size(); ++n)
      if (model.stages[n])
        add("+ " + model.present[n].name(), *model.stages[n],
            {model.present.begin(), model.present.begin() + static_cast<std::ptrdiff_t>(n) + 1});
  }

  // The model that is written, against all readings, those that were set aside included.
  void add_as_adopted(const Model& model, const BaseFit& designed) {
    const auto on_all = [&](const std::vector<Candidate>& added, const BaseFit& fit) {
      return if_possible([&] { return base_.fitter_of_all().as_fitted(added, fit, progress_); });
    };
    const std::optional<BaseFit> written = on_all(model.present, model.fit);
    const Search& all = base_.search_in_all();
    if (!written) return;
    stages_.push_back(waterfall_stage(as_adopted, -written->at.residual, kept_, all.values(),
                                      base_.noise(), all.groups(), seed_));
    if (const std::optional<BaseFit> before = on_all({}, designed))
      stages_.back().before =
          std::sqrt(before->squared_error / static_cast<double>(before->values));
  }

  std::vector<WaterfallStage> result() && {
    stages_.push_back(noise_floor(kept_, base_.search().values(), base_.noise()));
    return std::move(stages_);
  }

 private:
  // On readings that were left out than on those that were fitted.
  bool is_much_worse_than(const BaseFit& fit) const {
    constexpr double much = 1.5;
    const double fitted = std::sqrt(fit.squared_error / static_cast<double>(fit.values));
    return stages_.back().whitened > much * fitted;
  }

  Baseline& base_;
  const HeldOutRefit& refit_;
  Campaign kept_;
  bool has_kept_;
  std::uint64_t seed_;
  common::Progress& progress_;
  std::vector<WaterfallStage> stages_;
};

// What was found, and how well it does beside an unmodelled smooth error and against what is left.
void take_growth(const Search& search, const Noise& noise, Growth& growth, Diagnosis& d) {
  d.steps = std::move(growth.steps);
  d.found = std::move(growth.found);
  d.doubted = std::move(growth.doubted);
  const Model& model = growth.model;
  d.after = test_of(model.fit, noise);
  const CorrelatedNoise& correlated = search.correlated_noise();
  const std::optional<std::size_t> way = correlated.prevailing(model.fit);
  if (way) d.correlated_noise = correlated.what(*way);
  if (d.after)
    d.misfit = correlated.squared_error_where_shared(model.fit, way) /
               static_cast<double>(d.after->degrees_of_freedom);
  if (!d.found.empty()) {
    d.above_free_form = above_free_form(model, d.found, search, d.free_form);
    take_rest(d);
    d.or_something_else = (d.rest_p_value < level_of_rest && d.rest_of_laws.empty()) ||
                          d.is_left_open() || d.predicts_no_better();
    const auto own = d.fitted_without.size();
    d.fitted_beside.assign(model.fit.parameters.begin(),
                           model.fit.parameters.begin() + static_cast<std::ptrdiff_t>(own));
    d.correlation_beside = correlation_of(model.fit);
  }
  take_values(fitted_values(model.fit, model.present), d.found);
  d.left = smooth_error_beside(model.fit, search);
}

// Several errors of the geometry, and what moves the target as they do, and nothing else, which
// leave more.
bool is_geometry_in_part(const Diagnosis& d) {
  return d.or_something_else && d.found.size() > 1 &&
         std::all_of(d.found.begin(), d.found.end(), [](const FoundEffect& one) {
           return shown_class(*one.candidate.effect.kind) == vjm::EffectClass::geometry;
         });
}

// What is missing, or left, comes and goes with time or temperature: errors of geometry stay as
// they are.
bool varies_with_conditions(const Diagnosis& d) {
  const auto varies = [](const FreeFormEvidence& error) {
    return error.over == SmoothOver::time || error.over == SmoothOver::temperature;
  };
  return (d.above_free_form < beaten_by_free_form && varies(d.free_form)) ||
         (d.left.log > 0 && varies(d.left));
}

// Poses of a robot that was never calibrated: its errors of geometry hide all others.
void ask_for_kinematics(double share, Diagnosis& d) {
  constexpr double most_of_it = 0.5;
  if (share < most_of_it || varies_with_conditions(d) ||
      (d.verdict != Verdict::unexplained && !is_geometry_in_part(d)))
    return;
  d.by_kinematics = share;
  d.verdict = Verdict::unexplained;
  d.missing.push_back(fmt::format(
      "a calibration of the kinematics: geometric errors of all joints and links "
      "together explain {:.0f} % of the misfit; 'kinetostat calibrate' identifies them, "
      "what is left then shows stiffness and other effects",
      100 * share));
}

// Effects that leave more than noise do not stand beside readings in other units, and none beside a
// column that is another one: it would only make up for that.
void ask_for_units(bool is_column, Diagnosis& d) {
  constexpr double more_than_noise = 4;
  if (d.unit_error.empty()) return;
  if (!is_column && (!d.after || d.after->reduced() < more_than_noise)) return;
  d.verdict = Verdict::unexplained;
  d.missing.insert(d.missing.begin(), "readings in the units and with the signs that are stated");
}

void take_judgement(double share_left, Diagnosis& d) {
  Judgement judgement = judge(d, share_left);
  d.verdict = judgement.verdict;
  d.missing.insert(d.missing.end(), judgement.missing.begin(), judgement.missing.end());
  if (d.verdict != Verdict::inconclusive) d.common_cause.reset();
}

// Where readings do not distinguish what is uncertain, or that from one common cause.
void ask_for_sensor(const vjm::Robot& robot, const Campaign& campaign, const Noise& noise,
                    int threads, common::Progress& progress, Diagnosis& d) {
  if (d.verdict == Verdict::identified || d.verdict == Verdict::unexplained) return;
  std::vector<vjm::Effect> effects = robot.effects;
  std::vector<Parameter> parameters = uncertain_parameters(robot);
  if (d.common_cause) {
    effects.push_back(d.common_cause->candidate.effect);
    parameters.push_back(effect_parameter(effects, effects.size() - 1, 0, robot.without_effects()));
  }
  if (const auto sensor =
          missing_sensor(robot, effects, parameters, campaign, noise, threads, progress))
    d.missing.push_back(sensor->phrase());
}

}  // namespace

Diagnosis diagnose(const vjm::Robot& robot, const Campaign& whole, const DiagnosisOptions& options,
                   int threads, common::Progress& progress) {
  const Noise noise = noise_of(robot, whole, threads, progress);
  if (noise.source == NoiseSource::unknown) return cannot_tell_without_noise();
  Baseline base(robot, whole, noise, options, threads, progress);
  const BaseFit& fit = base.fit();
  const CandidateFitter& fitter = base.fitter();
  Diagnosis d = of_baseline(base);
  d.without_place = kinds_without_place(robot, options.kinds, base.scales());
  d.held_out = base.search().groups().what;
  const BaseFit nominal = fit_base(fitter.predictor(), base.campaign(), noise, {}, progress);
  d.unit_error = unit_error(base.campaign(), nominal.predicted);
  const bool is_of_units = !d.unit_error.empty();
  if (!is_of_units)
    d.unit_error = column_error(robot, base.campaign(), nominal.predicted, threads, progress);
  const std::vector<Candidate> like_the_fit = refutes_nominal(nominal, fit)
                                                  ? base.search().like_the_fit(nominal, fit)
                                                  : std::vector<Candidate>();
  const HeldOutRefit refit(robot, fitter, base.search().groups(), threads);
  // In differences the geometry cancels, and what units or signs do is none of it.
  const bool may_be_kinematics =
      whole.displacement == DisplacementKind::absolute && d.unit_error.empty();
  const double by_kinematics = may_be_kinematics ? base.search().explained_by_kinematics(fit) : 0.0;
  if (options.signatures) d.signatures = base.search().signature_table(fit);
  Growth growth = grow(fitter, refit, base.search(), options, fit, progress);
  const Model& model = growth.model;
  Waterfall waterfall(whole, base, refit, options, progress);
  waterfall.add("as designed", nominal, {});
  if (!fit.parameters.empty()) waterfall.add("refitted", fit, {});
  waterfall.add(model);
  if (!growth.found.empty()) waterfall.add_as_adopted(model, nominal);
  if (growth.found.empty())
    d.common_cause = common_cause(robot, base.campaign(), noise, fit, nominal, like_the_fit,
                                  threads, progress, options.journal);
  take_growth(base.search(), base.noise(), growth, d);
  doubt_friction(base.campaign(), d);
  list_ambiguous(d);
  d.waterfall = std::move(waterfall).result();
  take_judgement(base.search().correlated_noise().share_left(model.without, model.fit), d);
  ask_for_kinematics(by_kinematics, d);
  ask_for_units(!is_of_units, d);
  ask_for_sensor(robot, base.campaign(), noise, threads, progress, d);
  if (options.profiles > 0)
    d.profiles = profiles(fitter, model.present, model.fit, options.profiles, progress);
  return d;
}

}  // namespace kinetostat::calibration
