#include "kinetostat/apps/studio/studio_session.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "kinetostat/apps/cli/write_robot.h"
#include "kinetostat/calibration/diagnosis/adoption.h"
#include "kinetostat/calibration/regression/joint_scales.h"
#include "kinetostat/common/error.h"
#include "kinetostat/io/text_file.h"
#include "kinetostat/report/comparison.h"
#include "kinetostat/report/effect.h"
#include "kinetostat/report/readings_picture.h"
#include "kinetostat/spatial/units.h"

namespace kinetostat::apps {
namespace {

using calibration::BaseFit;
using calibration::Candidate;
using io::Json;

constexpr std::size_t most_effects = 5;
constexpr std::size_t longest_name = 100;

// Letters, digits, '-', '_' and '.', not hidden: no way out of the folder.
bool is_plain_yaml_name(const std::string& name) {
  return name.size() > 5 && name.size() <= longest_name && name.ends_with(".yaml") &&
         name.front() != '.' && std::all_of(name.begin(), name.end(), [](unsigned char c) {
           return std::isalnum(c) != 0 || c == '-' || c == '_' || c == '.';
         });
}

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
      fitted_(only(campaign_, {calibration::Role::fit})),
      folder_(std::move(folder)),
      threads_(threads) {
  const calibration::Predictor nominal(robot_.without_effects(), robot_.effects, fitted_, threads_,
                                       progress);
  candidates_ = calibration::candidates(
      robot_, {}, calibration::joint_scales(nominal, robot_.without_effects(), fitted_, progress));
  const calibration::Comparison comparison =
      calibration::compare(robot_, campaign_, threads_, progress);
  noise_ = comparison.noise;
  if (noise_.source == calibration::NoiseSource::unknown)
    throw common::InputError(campaign_.file, "nothing says how exact the readings are",
                             "State a 'noise', or repeat readings");
  Json names = Json::array();
  for (const Candidate& candidate : candidates_) names.push_back(candidate.name());
  opening_ = {
      .result = report::to_json(campaign_, comparison),
      .picture = {{"readings", report::readings_picture(robot_, campaign_, noise_,
                                                        report::readings_models(comparison))},
                  {"studio", {{"effects", std::move(names)}}}},
      .text = report::text(campaign_, comparison)};
  opening_.result["command"] = "studio";
}

std::vector<Candidate> StudioSession::chosen(const Json& request) const {
  const auto refuse = [](const std::string& what) {
    throw common::InputError("effects", what, "Name effects of the list, each once");
  };
  const auto found = request.find("effects");
  if (found == request.end() || !found->is_array()) refuse("is not a list of names");
  if (found->size() > most_effects) refuse(fmt::format("has more than {} names", most_effects));
  std::vector<Candidate> effects;
  for (const Json& name : *found) {
    if (!name.is_string()) refuse("has something in it that is not a name");
    const auto text = name.get<std::string>();
    const auto is_it = [&](const Candidate& c) { return c.name() == text; };
    const auto candidate = std::find_if(candidates_.begin(), candidates_.end(), is_it);
    if (candidate == candidates_.end()) refuse("names an effect that is not in the list");
    if (std::any_of(effects.begin(), effects.end(), is_it)) refuse("names an effect twice");
    effects.push_back(*candidate);
  }
  return effects;
}

// From the usual size of the last effect and from the sizes that its signatures were looked at
// with.
BaseFit StudioSession::best_fit(std::vector<Candidate>& effects, common::Progress& progress) const {
  const calibration::CandidateFitter fitter(robot_, fitted_, noise_, threads_, progress);
  BaseFit fit = fitter.fit({}, nullptr, progress);
  std::vector<Candidate> present;
  for (const Candidate& effect : effects) {
    std::vector<Candidate> starts = fitter.signatures_of(effect, present, fit, progress).starts;
    starts.push_back(effect);
    std::optional<BaseFit> best;
    std::string reason;
    for (const Candidate& start : starts) {
      std::vector<Candidate> added = present;
      added.push_back(start);
      try {
        BaseFit found = fitter.fit(added, &fit, progress);
        if (!best || found.squared_error < best->squared_error) best = std::move(found);
      } catch (const common::Cancelled&) {
        throw;
      } catch (const std::runtime_error& error) {
        reason = error.what();
      }
    }
    if (!best) throw common::InputError(effect.name(), "cannot be fitted: " + reason);
    fit = std::move(*best);
    present.push_back(effect);
    take_values(fit, present);
  }
  effects = present;
  return fit;
}

Json StudioSession::fit(const Json& request, common::Progress& progress) {
  std::vector<Candidate> effects = chosen(request);
  const BaseFit found = best_fit(effects, progress);
  last_ = effects;
  const std::size_t uncertain = calibration::uncertain_parameters(robot_).size();
  fitted_beside_.assign(found.parameters.begin(),
                        found.parameters.begin() + static_cast<std::ptrdiff_t>(uncertain));
  Json values = Json::array();
  std::string name = effects.empty() ? "fitted" : "with";
  for (const Candidate& effect : effects) {
    const bool angular = turns(effect.effect, robot_.without_effects());
    Json parameters = Json::array();
    for (std::size_t k = 0; k < effect.effect.kind->parameters.size(); ++k) {
      const auto i = static_cast<Eigen::Index>(k);
      const double deviation = effect.effect.deviations[i];
      parameters.push_back({{"name", effect.effect.kind->parameters[k].name},
                            {"unit", report::unit_of(effect.effect.kind->parameters[k], angular)},
                            {"value", effect.effect.values[i]},
                            {"deviation", std::isnan(deviation) ? Json() : Json(deviation)}});
    }
    values.push_back({{"name", effect.name()}, {"parameters", std::move(parameters)}});
    name += (name == "with" ? " " : " and ") + effect.name();
  }
  const Json picture =
      report::readings_picture(robot_, campaign_, noise_, {{name, residual_of(campaign_, found)}});
  return {{"model", picture["models"][0]},
          {"effects", values},
          {"squared_error", found.squared_error},
          {"degrees_of_freedom", found.degrees_of_freedom()}};
}

Json StudioSession::save(const Json& request) {
  const auto found = request.find("file");
  if (found == request.end() || !found->is_string() ||
      !is_plain_yaml_name(found->get<std::string>()))
    throw common::InputError(
        "file", "is not a plain file name that ends with .yaml",
        "Use letters, digits, '-', '_' and '.'; it goes into " + folder_.string());
  if (last_.empty())
    throw common::InputError("effects", "none is switched on", "Switch one on first");
  const auto name = found->get<std::string>();
  const std::filesystem::path file = folder_ / name;
  const bool ours = std::find(saved_.begin(), saved_.end(), name) != saved_.end();
  std::string text = io::read_text(robot_.file);
  calibration::Adoption adoption;
  for (const Candidate& effect : last_)
    adoption.effects.push_back(adopted_effect(effect, robot_, campaign_));
  for (const calibration::ParameterEstimate& estimate : fitted_beside_)
    if (!estimate.parameter.is_held())
      adoption.fitted.push_back(adopted_parameter(estimate, robot_));
  text = calibration::adopted(text, adoption);
  // Whoever may write to the folder may have put a link there since: nothing outside is written.
  if (!write_robot_in_place_of(ours ? io::Replace::entry : io::Replace::nothing, file, text))
    throw common::InputError("file", fmt::format("'{}' is there already", name),
                             "Choose another name");
  if (!ours) saved_.push_back(name);
  return {{"file", file.string()}};
}

}  // namespace kinetostat::apps
