#include "kinetostat/calibration/design/plan_models.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "kinetostat/calibration/diagnosis/decision.h"
#include "kinetostat/calibration/regression/session_frame.h"
#include "kinetostat/calibration/search/candidate_fitter.h"
#include "kinetostat/spatial/decomposition.h"

namespace kinetostat::calibration {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using spatial::Vector6;

// How much more than the noise of one reading an unknown of a session may be.
constexpr double unknown_width = 1e4;
// A candidate that is improbable by the readings so far still has to be distinguished from the
// others.
constexpr double least_weight = 0.05;

bool names_readings(const vjm::Effect& effect, Index value) {
  return effect.kind->parameters[static_cast<std::size_t>(value)].names_readings !=
         vjm::NamesReadings::no;
}

// What is of readings that were taken is of no planned one.
void name_no_readings(PlanModel& model) {
  for (vjm::Effect& effect : model.effects)
    for (Index v = 0; v < effect.values.size(); ++v)
      if (names_readings(effect, v)) effect.values[v] = 0;
  for (std::size_t p = 0; p < model.parameters.size(); ++p) {
    const Parameter& parameter = model.parameters[p];
    if (!parameter.is_logarithm() &&
        names_readings(model.effects[parameter.effect], parameter.value))
      model.values[static_cast<Index>(p)] = 0;
  }
}

PlanModel model_of(const vjm::Robot& robot, const std::vector<Candidate>& added,
                   const BaseFit& fit) {
  PlanModel model;
  model.effects = effects_with(robot, added);
  for (const ParameterEstimate& estimate : fit.parameters)
    model.parameters.push_back(estimate.parameter);
  model.values = values_of(fit);
  name_no_readings(model);
  const Index n = model.values.size();
  model.root = root_of(fit.covariance.topLeftCorner(n, n));
  return model;
}

void add_open_candidate(const vjm::Robot& robot, const CandidateFitter& fitter,
                        const PlanQuestion& question, const BaseFit& base,
                        const OpenCandidate& open, common::Progress& progress,
                        std::vector<PlanModel>& models) {
  std::vector<Candidate> added = question.present;
  added.push_back(open.candidate);
  PlanModel model = model_of(robot, added, base);
  model.any_size = !open.is_fitted;
  if (model.any_size) {
    model.own = fitter.own_parameters(added);
  } else {
    try {
      model = model_of(robot, added, fitter.fit(added, &base, progress));
    } catch (const common::Cancelled&) {
      throw;
    } catch (const std::runtime_error&) {
      // Then with the values of the diagnosis, as they are.
    }
  }
  model.name = open.candidate.name();
  model.kind = open.candidate.effect.kind->name;
  model.effect_class = open.candidate.effect.kind->effect_class;
  model.family = family_of(*open.candidate.effect.kind);
  model.place = open.candidate.effect.at;
  model.weight = open.probability;
  model.log_evidence = open.log_evidence;
  model.on_load = open.candidate.effect.kind->place == vjm::EffectPlace::load;
  model.on_sensor = open.candidate.effect.kind->place == vjm::EffectPlace::sensor;
  models.push_back(std::move(model));
}

// What the readings so far make of the uncertain values when a candidate is there at its usual
// size: they take up what they can of it, so that new readings show only the rest.
void take_up(const CandidateFitter& fitter, const PlanQuestion& question, const BaseFit& base,
             const Candidate& candidate, common::Progress& progress, PlanModel& model) {
  if (model.parameters.empty()) return;
  const CandidateFitter::Signatures signatures =
      fitter.signatures_of(candidate, question.present, base, progress);
  if (signatures.all.empty()) return;
  const Signature& signature = signatures.all.front();
  const VectorXd at_usual_size = signature.columns.col(0) / signature.growth[0];
  const VectorXd change = spatial::least_squares_solution(base.at.jacobian, -at_usual_size);
  for (std::size_t k = 0; k < model.parameters.size(); ++k) {
    const Parameter& parameter = model.parameters[k];
    double& value = model.values[static_cast<Index>(k)];
    value = std::clamp(value + change[static_cast<Index>(k)], parameter.lower, parameter.upper);
  }
}

// Values that design fixes have no range: they are as they are.
std::vector<Parameter> free_ones(const std::vector<Parameter>& own) {
  std::vector<Parameter> result;
  for (const Parameter& p : own)
    if (p.lower < p.upper && p.prior) result.push_back(p);
  return result;
}

// Rows where some model has no equilibrium.
void leave_out_failures(std::vector<Forecast>& forecasts, MatrixXd& common) {
  for (Index row = 0; row < common.rows(); ++row) {
    if (std::all_of(forecasts.begin(), forecasts.end(),
                    [&](const Forecast& f) { return std::isfinite(f.mean[row]); }))
      continue;
    common.row(row).setZero();
    for (Forecast& f : forecasts) {
      f.mean[row] = 0;
      f.spread.row(row).setZero();
      f.forms.row(row).setZero();
    }
  }
}

// How much of a candidate's d' from nothing is lost when this model may be what shows: 0 to 1.
double likeness(const Forecast& open, const Forecast& other, const Forecast& nothing,
                const MatrixXd& common) {
  const double alone = separation_of(open, nothing, false, nothing, common).squared();
  const double beside = separation_of(open, other, true, nothing, common).squared();
  return alone > 0 ? 1 - beside / alone : 0;
}

}  // namespace

Separation separation_of(const Forecast& a, const Forecast& b, bool b_has_any_size,
                         const Forecast& nothing, const MatrixXd& common) {
  if (!b_has_any_size) return {a, b, common};
  MatrixXd unknown(common.rows(), common.cols() + 1 + b.forms.cols());
  unknown << common, any_size * (b.mean - nothing.mean), b.forms;
  return {a, b, unknown};
}

std::vector<PlanModel> with_look_alikes(const std::vector<PlanModel>& models,
                                        std::vector<Forecast> forecasts, MatrixXd common) {
  constexpr std::size_t most = 8;  // kinds
  constexpr double visible = 1;    // d' from nothing, in all these readings
  leave_out_failures(forecasts, common);
  const Forecast& nothing = forecasts.back();
  std::map<std::string, std::pair<double, std::size_t>> nearest;  // of each kind
  for (std::size_t m = 0; m + 1 < models.size(); ++m) {
    if (!models[m].is_look_alike) continue;
    const Separation seen = separation_of(forecasts[m], nothing, false, nothing, common);
    if (!(seen.squared() > visible * visible)) continue;
    double like = 0;
    for (std::size_t s = 0; s + 1 < models.size(); ++s)
      if (!models[s].is_look_alike)
        like = std::max(like, likeness(forecasts[s], forecasts[m], nothing, common));
    const auto [found, fresh] = nearest.try_emplace(models[m].kind, like, m);
    if (!fresh && like > found->second.first) found->second = {like, m};
  }
  std::vector<std::pair<double, std::size_t>> order;
  order.reserve(nearest.size());
  for (const auto& [kind, place] : nearest) order.push_back(place);
  std::stable_sort(order.begin(), order.end(),
                   [](const auto& a, const auto& b) { return a.first > b.first; });
  order.resize(std::min(order.size(), most));
  std::vector<PlanModel> kept;
  for (std::size_t m = 0; m < models.size(); ++m)
    if (!models[m].is_look_alike ||
        std::any_of(order.begin(), order.end(), [&](const auto& o) { return o.second == m; }))
      kept.push_back(models[m]);
  return kept;
}

std::vector<PlanModel> plan_models(const vjm::Robot& robot, const Campaign& campaign,
                                   const Noise& noise, const PlanQuestion& question, int threads,
                                   common::Progress& progress) {
  const CandidateFitter fitter(robot, campaign, noise, threads, progress);
  const BaseFit plain = fitter.fit({}, nullptr, progress);
  const BaseFit base =
      question.present.empty() ? plain : fitter.fit(question.present, &plain, progress);
  std::vector<PlanModel> models;
  common::SilentPart silent(progress);
  for (std::size_t s = 0; s < question.open.size(); ++s) {
    progress.report("candidate models",
                    static_cast<double>(s) / static_cast<double>(question.open.size()));
    add_open_candidate(robot, fitter, question, base, question.open[s], silent, models);
    if (models.back().any_size)
      take_up(fitter, question, base, question.open[s].candidate, silent, models.back());
  }
  for (const Candidate& candidate : question.unseen) {
    add_open_candidate(robot, fitter, question, base, {.candidate = candidate, .log_evidence = {}},
                       silent, models);
    models.back().is_look_alike = true;
  }
  models.push_back(model_of(robot, question.present, base));
  models.back().name = "nothing more";
  models.back().weight = question.nothing;
  const double least = least_weight / static_cast<double>(models.size());
  for (PlanModel& model : models) model.weight = std::max(model.weight, least);
  return models;
}

namespace {

// Of a planned campaign, as they are stated.
std::vector<TargetOffset> unknown_targets_of(const Campaign& planned) {
  std::vector<TargetOffset> targets;
  for (std::size_t sensor = 0; sensor < planned.sensors.size(); ++sensor)
    if (planned.estimates_target(sensor))
      targets.push_back(
          {.sensor = sensor,
           .differentiated = planned.displacement == DisplacementKind::absolute ? 6 : 3});
  return targets;
}

}  // namespace

Forecast forecast(const vjm::Robot& robot, const PlanModel& model, const Campaign& planned,
                  const std::vector<Index>& components, int threads, common::Progress& progress) {
  Campaign silent = planned;
  // So that one reading without an equilibrium does not end the others.
  for (Reading& reading : silent.readings) reading.masked = true;
  const Predictor predictor(robot.without_effects(), model.effects, silent, threads, progress);
  const std::vector<Parameter> own = free_ones(model.own);
  std::vector<Parameter> parameters = model.parameters;
  parameters.insert(parameters.end(), own.begin(), own.end());
  const Index known = model.values.size(), forms = std::ssize(own);
  VectorXd values(known + forms), widths(forms);
  values << model.values, starts_of(own);
  for (Index k = 0; k < forms; ++k) widths[k] = own[static_cast<std::size_t>(k)].prior->deviation;
  const std::vector<TargetOffset> targets = unknown_targets_of(planned);
  const Predictions predictions =
      predictor.predict(parameters, values, parameters, progress, {.targets = targets});
  Index target_columns = 0;
  for (const TargetOffset& target : targets) target_columns += target.differentiated;
  const auto count = static_cast<Index>(components.size());
  Forecast result;
  result.mean.resize(static_cast<Index>(planned.readings.size()) * count);
  result.spread = MatrixXd::Zero(result.mean.size(), model.root.cols());
  result.forms = MatrixXd::Zero(result.mean.size(), forms);
  result.by_targets = MatrixXd::Zero(result.mean.size(), target_columns);
  for (std::size_t i = 0; i < planned.readings.size(); ++i)
    for (Index c = 0; c < count; ++c) {
      const Index row = static_cast<Index>(i) * count + c;
      const Index k = components[static_cast<std::size_t>(c)];
      const double sigma = planned.readings[i].sigma[k];
      result.mean[row] = predictions.displacement[i][k] / sigma;
      if (predictions.derivatives.empty() || predictions.derivatives[i].cols() == 0) continue;
      const Eigen::RowVectorXd change = predictions.derivatives[i].row(k) / sigma;
      if (model.root.cols() > 0) result.spread.row(row) = change.head(known) * model.root;
      result.forms.row(row) = change.segment(known, forms).cwiseProduct(widths.transpose());
      result.by_targets.row(row) = change.tail(target_columns);
    }
  return result;
}

PlanModel fitted_alone(PlanModel model) {
  constexpr double rough = 0.5;  // of the logarithm of a stiffness
  const Index n = model.values.size();
  model.root = MatrixXd::Zero(n, n);
  for (Index k = 0; k < n; ++k) {
    const Parameter& p = model.parameters[static_cast<std::size_t>(k)];
    if (p.lower < p.upper) model.root(k, k) = p.is_logarithm() ? rough : p.typical;
  }
  return model;
}

PlanModel under_known_weights(const vjm::Robot& robot, PlanModel model) {
  const std::size_t own = robot.effects.size();
  for (std::size_t e = own; e < model.effects.size(); ++e) {
    vjm::Effect& effect = model.effects[e];
    if (effect.kind->place != vjm::EffectPlace::load) continue;
    for (Index v = 0; v < effect.values.size(); ++v)
      effect.values[v] = effect.kind->parameters[static_cast<std::size_t>(v)].none;
    std::erase_if(model.own, [e](const Parameter& value) { return value.effect == e; });
    for (std::size_t p = 0; p < model.parameters.size(); ++p) {
      const Parameter& parameter = model.parameters[p];
      if (parameter.is_logarithm() || parameter.effect != e) continue;
      model.values[static_cast<Index>(p)] = effect.values[parameter.value];
      // What the readings so far leave unsure together with it is as sure as if it were known.
      const VectorXd way = model.root.row(static_cast<Index>(p)).transpose();
      if (way.norm() > 0) model.root -= (model.root * way) * way.transpose() / way.squaredNorm();
      model.root.row(static_cast<Index>(p)).setZero();
    }
  }
  return model;
}

MatrixXd session_unknowns(const Campaign& like, const Campaign& planned,
                          const std::vector<Index>& components, const Forecast& of_any) {
  const VectorXd& mean = of_any.mean;
  const Index target_columns = of_any.by_targets.cols();
  const auto count = static_cast<Index>(components.size());
  const bool zeros = like.zero == ZeroReading::estimated;
  // Who measured differences need not know where the robot stands in the instrument's frame.
  const bool absolute = planned.displacement == DisplacementKind::absolute;
  const bool frame = like.session_frame == SessionFrame::estimated ||
                     (absolute && like.displacement == DisplacementKind::difference);
  const Index frame_columns = !frame ? 0 : absolute ? 6 : 3;
  MatrixXd columns =
      MatrixXd::Zero(mean.size(), (zeros ? count : 0) + frame_columns + target_columns);
  columns.rightCols(target_columns) = of_any.by_targets;
  for (std::size_t i = 0; i < planned.readings.size(); ++i) {
    const VectorXd& sigma = planned.readings[i].sigma;
    std::vector<Vector6> displacements(planned.sensors.size(), Vector6::Zero());
    for (Index c = 0; c < count; ++c) {
      const Component& component = planned.component(components[static_cast<std::size_t>(c)]);
      displacements[component.sensor][component.axis] =
          mean[static_cast<Index>(i) * count + c] * sigma[components[static_cast<std::size_t>(c)]];
    }
    std::vector<spatial::Matrix6> by_frame(planned.sensors.size(), spatial::Matrix6::Zero());
    for (std::size_t s = 0; frame && s < planned.sensors.size(); ++s)
      if (planned.sensors[s].by_instrument)
        by_frame[s] =
            seen_from(Vector6::Zero(), displacements[s], planned.displacement, displacements[s])
                .by_frame;
    for (Index c = 0; c < count; ++c) {
      const Index row = static_cast<Index>(i) * count + c;
      const Index k = components[static_cast<std::size_t>(c)];
      if (zeros) columns(row, c) = unknown_width;
      // A frame that is off by a whole turn, or by metres, moves any reading beyond all noise.
      const Component& component = planned.component(k);
      columns.row(row).segment(columns.cols() - target_columns - frame_columns, frame_columns) =
          by_frame[component.sensor].row(component.axis).tail(frame_columns) / sigma[k];
    }
  }
  return columns;
}

}  // namespace kinetostat::calibration
