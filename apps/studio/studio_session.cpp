#include "kinetostat/apps/studio/studio_session.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "kinetostat/apps/cli/write_robot.h"
#include "kinetostat/apps/studio/studio_files.h"
#include "kinetostat/calibration/comparison/compare.h"
#include "kinetostat/calibration/diagnosis/adoption.h"
#include "kinetostat/calibration/regression/evidence.h"
#include "kinetostat/calibration/regression/joint_scales.h"
#include "kinetostat/calibration/search/diagnosis_step.h"
#include "kinetostat/calibration/search/fit_starts.h"
#include "kinetostat/common/error.h"
#include "kinetostat/common/parallel.h"
#include "kinetostat/io/text_file.h"
#include "kinetostat/report/comparison.h"
#include "kinetostat/report/effect.h"
#include "kinetostat/report/manipulators/skeleton.h"
#include "kinetostat/report/readings_picture.h"
#include "kinetostat/report/screen/wording.h"
#include "kinetostat/spatial/units.h"
#include "kinetostat/vjm/manipulator/posture.h"

namespace kinetostat::apps {
namespace {

using calibration::BaseFit;
using calibration::Candidate;
using io::Json;

constexpr std::size_t most_effects = 5;
// Of the squared error, in units of the noise: a hundredth is no digit of what is shown.
constexpr double least_gain = 0.01;

std::vector<Eigen::VectorXd> residual_of(const calibration::Campaign& campaign,
                                         const BaseFit& fit) {
  std::vector<Eigen::VectorXd> residual;
  for (std::size_t i = 0; i < campaign.readings.size(); ++i)
    residual.push_back(campaign.readings[i].displacement - fit.predicted[i]);
  return residual;
}

void take_values(const BaseFit& fit, std::vector<Candidate>& added) {
  const std::vector<calibration::FittedValues> fitted = fitted_values(fit, added);
  for (std::size_t k = 0; k < added.size(); ++k) {
    added[k].effect.values = fitted[k].values;
    added[k].effect.deviations = fitted[k].deviations;
  }
}

double error_of(const BaseFit& fit) {
  return std::sqrt(fit.squared_error / static_cast<double>(fit.values));
}

// Against the model without the last effect, both alike beforehand. They share the exponent, as
// the candidates of a diagnosis do.
double probability_of(const BaseFit& with, const BaseFit& without) {
  const double exponent = std::max(exponent_of(with), exponent_of(without));
  const double gain =
      calibration::evidence(with, exponent).log - calibration::evidence(without, exponent).log;
  return 1 / (1 + std::exp(-calibration::learning_rate * gain));
}

// At a millionth of its usual distance from nothing it does nothing.
bool is_nothing(const Candidate& fitted, const Candidate& usual) {
  const double none = fitted.effect.kind->parameters.front().none;
  return std::abs(fitted.effect.values[0] - none) <= 1e-6 * std::abs(usual.effect.values[0] - none);
}

Json number_or_null(double value) { return std::isfinite(value) ? Json(value) : Json(); }

calibration::AdoptedEffect adopted_effect(const Candidate& candidate, const vjm::Robot& robot,
                                          const calibration::Campaign& campaign) {
  const vjm::EffectKind& kind = *candidate.effect.kind;
  const bool angular = turns(candidate.effect, robot.without_effects());
  calibration::AdoptedEffect adoption{
      .effect = kind.name, .at = candidate.effect.at, .values = {}, .reasons = {}};
  for (std::size_t k = 0; k < kind.parameters.size(); ++k) {
    const auto i = static_cast<Eigen::Index>(k);
    adoption.values.push_back({.name = kind.parameters[k].name,
                               .unit = report::unit_of(kind.parameters[k], angular),
                               .value = candidate.effect.values[i],
                               .deviation = candidate.effect.deviations[i]});
  }
  adoption.reasons = {
      fmt::format("chosen by hand in the studio, fitted to the campaign '{}', readings sha256 {}",
                  campaign.name, io::sha256(io::read_text(campaign.readings_file)))};
  return adoption;
}

// What was fitted beside the effects: without it the file would not have the error that was shown.
calibration::AdoptedParameter adopted_parameter(const calibration::ParameterEstimate& estimate,
                                                const vjm::Robot& robot) {
  const calibration::Parameter& parameter = estimate.parameter;
  const double deviation = estimate.hit == calibration::BoundHit::none
                               ? estimate.standard_error
                               : std::numeric_limits<double>::quiet_NaN();
  calibration::AdoptedParameter adopted;
  if (parameter.is_logarithm()) {
    const double factor = std::exp(estimate.value);
    adopted.stiffness = parameter.name;
    adopted.value = {"factor", "", factor, factor * deviation};
    return adopted;
  }
  const vjm::Effect& effect = robot.effects.at(parameter.effect);
  adopted.effect = effect.kind->name;
  adopted.at = effect.at;
  adopted.parameter = effect.kind->parameters[static_cast<std::size_t>(parameter.value)].name;
  adopted.value = {"value", parameter.unit, estimate.value, deviation};
  return adopted;
}

}  // namespace

StudioSession::StudioSession(vjm::Robot robot, calibration::Campaign campaign,
                             std::filesystem::path folder, int threads, common::Progress& progress)
    : robot_(std::move(robot)),
      campaign_(std::move(campaign)),
      training_(only(campaign_, {calibration::Role::fit})),
      folder_(std::move(folder)),
      threads_(threads) {
  const calibration::Comparison comparison =
      calibration::compare(robot_, campaign_, threads_, progress);
  noise_ = comparison.noise;
  if (noise_.source == calibration::NoiseSource::unknown)
    throw common::InputError(campaign_.file, "nothing says how exact the readings are",
                             "State a 'noise', or repeat readings");
  const calibration::Predictor nominal(robot_.without_effects(), robot_.effects, training_,
                                       threads_, progress);
  fitter_.emplace(robot_, training_, noise_, threads_, progress);
  models_[{}] = {{}, fitter_->fit({}, nullptr, progress)};
  candidates_ = calibration::candidates(
      robot_, {},
      calibration::joint_scales(nominal, robot_.without_effects(), training_, noise_,
                                models_.at({}).fit, progress));
  Json effects = Json::array();
  for (const Candidate& candidate : candidates_) effects.push_back(effect_json(candidate));
  opening_ = {{"result", report::to_json(campaign_, comparison)},
              {"readings", report::readings_picture(robot_, campaign_, noise_,
                                                    report::readings_models(comparison))},
              {"text", report::text(campaign_, comparison)},
              {"robot", {{"name", robot_.name}, {"file", robot_.file.string()}}},
              {"folder", folder_.string()},
              {"nominal", card({}, {{}, fitter_->as_fitted({}, {}, progress)})},
              {"fitted", card({}, models_.at({}))},
              {"effects", std::move(effects)}};
  opening_["result"]["command"] = "studio";
}

Json StudioSession::effect_json(const Candidate& candidate) const {
  const vjm::Manipulator& bare = robot_.without_effects();
  const vjm::EffectKind& kind = *candidate.effect.kind;
  const bool angular = turns(candidate.effect, bare);
  Json places = Json::array(), parameters = Json::array();
  for (const vjm::EffectSite& site : candidate.effect.sites)
    places.push_back(bare.chains()[site.chain].name() + "." + site.element);
  for (std::size_t k = 0; k < kind.parameters.size(); ++k) {
    const vjm::EffectParameter& p = kind.parameters[k];
    parameters.push_back({{"name", p.name},
                          {"unit", report::unit_of(p, angular)},
                          {"none", p.none},
                          {"lower", number_or_null(p.lower)},
                          {"upper", number_or_null(p.upper)},
                          {"usual", candidate.effect.values[static_cast<Eigen::Index>(k)]}});
  }
  return {{"name", candidate.name()},
          {"words", report::effect_in_words(bare, kind.name, candidate.effect.at)},
          {"kind", kind.name},
          {"at", candidate.effect.at},
          {"where", report::place_in_words(bare, candidate.effect.at)},
          {"acts_on", vjm::to_string(kind.place)},
          {"class", vjm::to_string(kind.effect_class)},
          {"summary", kind.summary},
          {"law", kind.law},
          {"signature", kind.signature},
          {"confounder", kind.confuser},
          {"places", std::move(places)},
          {"parameters", std::move(parameters)}};
}

const Candidate& StudioSession::candidate(const std::string& name) const {
  const auto found = std::find_if(candidates_.begin(), candidates_.end(),
                                  [&](const Candidate& c) { return c.name() == name; });
  if (found == candidates_.end())
    throw common::InputError("effects", "names an effect that is not in the list",
                             "Name effects of the list, each once");
  return *found;
}

std::vector<std::string> StudioSession::names_in(const Json& request) const {
  const auto refuse = [](const std::string& what) {
    throw common::InputError("effects", what, "Name effects of the list, each once");
  };
  const auto found = request.find("effects");
  if (found == request.end() || !found->is_array()) refuse("is not a list of names");
  if (found->size() > most_effects) refuse(fmt::format("has more than {} names", most_effects));
  std::vector<std::string> names;
  for (const Json& name : *found) {
    if (!name.is_string()) refuse("has something in it that is not a name");
    const auto text = name.get<std::string>();
    (void)candidate(text);
    if (std::find(names.begin(), names.end(), text) != names.end()) refuse("names an effect twice");
    names.push_back(text);
  }
  return names;
}

// Where a diagnosis would start its fits, and at the usual size.
std::vector<Candidate> StudioSession::starts_of(const Model& before, const Candidate& added,
                                                std::size_t most,
                                                common::Progress& progress) const {
  const calibration::FittedModel beside = fitter_->beside(before.effects, before.fit, {added});
  const calibration::CandidateSignatures signatures =
      fitter_->signatures_of(added, beside, progress);
  const calibration::ResidualSpace space(-before.fit.at.residual, before.fit.at.jacobian);
  const calibration::Screen screen(space, signatures.all);
  calibration::FitStarts starts(added, space, fitter_->bare());
  for (std::size_t i = 0; i < signatures.all.size(); ++i)
    starts.add(signatures.starts[i], signatures.all[i],
               screen.score(i, space.residual()).explained);
  starts.add_other_phases(*fitter_, beside, progress);
  std::vector<Candidate> best = starts.best(most);
  if (best.size() < most) best.push_back(added);
  return best;
}

// A thread each, since whoever looks on waits for the slowest; the best is first then. Those that
// cannot be fitted are left out.
void StudioSession::fit_further(std::vector<Trial>& trials, int evaluations,
                                common::Progress& progress) const {
  const int threads = trials.size() == 1 ? threads_ : 1;
  const calibration::FitEffort effort{.max_iterations = evaluations, .least_gain = least_gain};
  common::parallel_for(trials.size(), threads_, "fits", progress, [&](std::size_t k) {
    Trial& trial = trials[k];
    if (trial.is_settled) return;
    try {
      common::SilentPart silent(progress);
      auto& [effects, fit] = trial.model;
      fit = fitter_->fit_roughly(effects, fit, effort, threads, silent);
      take_values(fit, effects);
      trial.is_settled = fit.iterations < evaluations;
    } catch (const common::Cancelled&) {
      throw;
    } catch (const std::runtime_error& error) {
      trial.failure = error.what();
    }
  });
  const std::string name = trials.front().model.effects.back().name();
  const std::string failure = trials.back().failure;
  std::erase_if(trials, [](const Trial& trial) { return !trial.failure.empty(); });
  if (trials.empty()) throw common::InputError(name, "cannot be fitted: " + failure);
  std::stable_sort(trials.begin(), trials.end(), [](const Trial& a, const Trial& b) {
    return a.model.fit.squared_error < b.model.fit.squared_error;
  });
}

// Every start to the end where that is quick; else some steps of the best ones, and the best of
// these to the end: until no digit changes that is shown.
StudioSession::Model StudioSession::with(const Model& before, const Candidate& added,
                                         common::Progress& progress) const {
  struct Round {
    std::size_t trials;
    int evaluations;
  };
  constexpr Round all{16, 60}, first_look{4, 15}, to_the_end{1, 60};
  constexpr double quick = 2e5;  // equilibria of chains, about a second
  const double equilibria = static_cast<double>(all.trials) * all.evaluations *
                            static_cast<double>(training_.readings.size()) *
                            static_cast<double>(robot_.without_effects().chains().size());
  const std::vector<Round> rounds =
      equilibria < quick ? std::vector<Round>{all} : std::vector<Round>{first_look, to_the_end};
  std::vector<Trial> trials;
  for (const Candidate& start : starts_of(before, added, rounds.front().trials, progress)) {
    trials.push_back({before});
    trials.back().model.effects.push_back(start);
  }
  for (const auto& [most, evaluations] : rounds) {
    trials.resize(std::min(trials.size(), most));
    fit_further(trials, evaluations, progress);
  }
  return std::move(trials.front().model);
}

const StudioSession::Model& StudioSession::model(const std::vector<std::string>& names,
                                                 common::Progress& progress) {
  if (const auto known = models_.find(names); known != models_.end()) return known->second;
  const std::vector<std::string> before(names.begin(), names.end() - 1);
  Model found = with(model(before, progress), candidate(names.back()), progress);
  return models_[names] = std::move(found);
}

Json StudioSession::card(const std::vector<std::string>& names, const Model& model) const {
  Json effects = Json::array(), stiffnesses = Json::array();
  bool nothing = false;
  for (const Candidate& effect : model.effects) {
    const bool angular = turns(effect.effect, robot_.without_effects());
    Json parameters = Json::array();
    for (std::size_t k = 0; k < effect.effect.kind->parameters.size(); ++k) {
      const auto i = static_cast<Eigen::Index>(k);
      parameters.push_back({{"name", effect.effect.kind->parameters[k].name},
                            {"unit", report::unit_of(effect.effect.kind->parameters[k], angular)},
                            {"value", effect.effect.values[i]},
                            {"deviation", number_or_null(effect.effect.deviations[i])}});
    }
    effects.push_back({{"name", effect.name()}, {"parameters", std::move(parameters)}});
    nothing = nothing || is_nothing(effect, candidate(effect.name()));
  }
  for (const calibration::ParameterEstimate& estimate : model.fit.parameters)
    if (estimate.parameter.is_logarithm() && !estimate.parameter.is_held())
      stiffnesses.push_back(
          {{"name", estimate.parameter.name}, {"factor", std::exp(estimate.value)}});
  std::string name;
  for (const std::string& one : names) name += (name.empty() ? "" : " + ") + one;
  Json card{{"name", name},
            {"effects", std::move(effects)},
            {"stiffnesses", std::move(stiffnesses)},
            {"error", error_of(model.fit)},
            {"squared_error", model.fit.squared_error},
            {"degrees_of_freedom", model.fit.degrees_of_freedom()},
            {"nothing", nothing},
            {"probability", nullptr}};
  if (!names.empty())
    card["probability"] =
        probability_of(model.fit, models_.at({names.begin(), names.end() - 1}).fit);
  return card;
}

Json StudioSession::residuals(const std::string& name, const BaseFit& fit) const {
  return report::readings_picture(robot_, campaign_, noise_,
                                  {{name, residual_of(campaign_, fit)}})["models"][0];
}

Json StudioSession::fit(const Json& request, common::Progress& progress) {
  const std::vector<std::string> names = names_in(request);
  const Model& found = model(names, progress);
  Json fitted = card(names, found);
  const std::string name = names.empty() ? "fitted" : "with " + fitted["name"].get<std::string>();
  return {{"card", std::move(fitted)}, {"model", residuals(name, found.fit)}};
}

const StudioSession::Model& StudioSession::fitted_model(const Json& request) const {
  const auto found = models_.find(names_in(request));
  if (found == models_.end())
    throw common::InputError("effects", "this model is not fitted yet", "Fit it first");
  return found->second;
}

Json StudioSession::try_values(const Json& request, common::Progress& progress) const {
  const auto refuse = [](const std::string& what) {
    throw common::InputError("values", what, "Give a number for each value of each effect");
  };
  const Model& model = fitted_model(request);
  const Json values = request.value("values", Json());
  if (!values.is_array() || values.size() != model.effects.size())
    refuse("is not a list of one list for each effect");
  std::vector<Candidate> effects = model.effects;
  BaseFit held = model.fit;
  std::size_t at = held.parameters.size();
  for (const Candidate& effect : effects)
    at -= static_cast<std::size_t>(effect.effect.values.size());
  for (std::size_t e = 0; e < effects.size(); ++e) {
    const auto& parameters = effects[e].effect.kind->parameters;
    if (!values[e].is_array() || values[e].size() != parameters.size())
      refuse("has not as many numbers as the effect has values");
    for (std::size_t k = 0; k < parameters.size(); ++k) {
      if (!values[e][k].is_number()) refuse("has something in it that is not a number");
      const double value =
          std::clamp(values[e][k].get<double>(), parameters[k].lower, parameters[k].upper);
      effects[e].effect.values[static_cast<Eigen::Index>(k)] = value;
      held.parameters[at++].value = value;
    }
  }
  const BaseFit tried = fitter_->as_fitted(effects, held, progress);
  return {{"error", error_of(tried)}, {"model", residuals("by hand", tried)}};
}

vjm::Manipulator StudioSession::manipulator_of(const Model& model) const {
  vjm::Manipulator scaled = robot_.without_effects();
  for (const calibration::ParameterEstimate& estimate : model.fit.parameters)
    for (const vjm::UncertainStiffness& one : robot_.uncertain)
      if (estimate.parameter.is_logarithm() && one.name == estimate.parameter.name)
        scaled = vjm::with_scaled(scaled, one, std::exp(estimate.value));
  return vjm::with_effects(scaled, calibration::effects_with(robot_, model.effects));
}

Json StudioSession::posture(const Json& request) const {
  const Json pose = request.value("pose", Json());
  if (!pose.is_number_unsigned() || pose.get<std::size_t>() >= campaign_.configurations.size())
    throw common::InputError("pose", "is not the number of a posture of the campaign");
  const auto index = pose.get<std::size_t>();
  const calibration::Reading* largest = nullptr;
  for (const calibration::Reading& reading : campaign_.readings)
    if (reading.configuration == index && !reading.masked &&
        (largest == nullptr || reading.load.force.norm() > largest->load.force.norm()))
      largest = &reading;
  const calibration::Configuration& c = campaign_.configurations[index];
  const vjm::Manipulator& bare = robot_.without_effects();
  const vjm::PostureResult posture =
      c.target ? posture_at(bare, *c.target) : posture_from_joints(bare, c.joints);
  if (!posture.reached) return nullptr;
  Json skeletons = Json::array({report::named_skeleton(
      "unloaded", report::skeleton(bare.without_errors(), posture.posture))});
  if (largest == nullptr) return {{"skeletons", skeletons}, {"load", nullptr}};
  const vjm::Manipulator loaded = manipulator_of(fitted_model(request));
  const vjm::Equilibrium bent = equilibrium_under_load(loaded, posture.posture, largest->load);
  if (bent.status == vjm::EquilibriumStatus::converged)
    skeletons.push_back(report::named_skeleton("loaded", report::skeleton(loaded, bent)));
  return {{"skeletons", std::move(skeletons)},
          {"load",
           {{"at", io::to_json(bent.platform * largest->load.point_on_platform)},
            {"force", io::to_json(largest->load.force)}}}};
}

Json StudioSession::save(const Json& request) {
  const auto found = request.find("file");
  const std::string name =
      found != request.end() && found->is_string() ? found->get<std::string>() : std::string();
  if (!is_plain_name(name) || !name.ends_with(".yaml"))
    throw common::InputError(
        "file", "is not a plain file name that ends with .yaml",
        "Use letters, digits, '-', '_' and '.'; it goes into " + folder_.string());
  const Model& model = fitted_model(request);
  for (const Candidate& effect : model.effects)
    if (is_nothing(effect, candidate(effect.name())))
      throw common::InputError(effect.name(), "its best size is zero: there is nothing to save",
                               "Choose a model without it");
  const std::filesystem::path file = folder_ / name;
  const bool ours = std::find(saved_.begin(), saved_.end(), name) != saved_.end();
  calibration::Adoption adoption;
  for (const Candidate& effect : model.effects)
    adoption.effects.push_back(adopted_effect(effect, robot_, campaign_));
  const std::size_t uncertain = calibration::uncertain_parameters(robot_).size();
  for (std::size_t k = 0; k < uncertain; ++k)
    if (!model.fit.parameters[k].parameter.is_held())
      adoption.fitted.push_back(adopted_parameter(model.fit.parameters[k], robot_));
  if (adoption.effects.empty() && adoption.fitted.empty())
    throw common::InputError("effects", "nothing was added and nothing was fitted",
                             "Add an effect first");
  const std::string text = calibration::adopted(io::read_text(robot_.file), adoption);
  // Whoever may write to the folder may have put a link there since: nothing outside is written.
  if (!write_robot_in_place_of(ours ? io::Replace::entry : io::Replace::nothing, file, text))
    throw common::InputError("file", fmt::format("'{}' is there already", name),
                             "Choose another name");
  if (!ours) saved_.push_back(name);
  return {{"file", file.string()}};
}

}  // namespace kinetostat::apps
