// The models between which a plan decides, as far as the readings so far know them.
#pragma once

#include <string>
#include <vector>

#include "kinetostat/calibration/design/discrimination.h"
#include "kinetostat/calibration/design/plan_question.h"

namespace kinetostat::calibration {

/// A model, the information about its parameters, and its weight among the candidates.
struct PlanModel {
  std::string name;  // of what it adds; "nothing more"
  std::string kind;  // of that effect
  vjm::EffectClass effect_class = vjm::EffectClass::other;
  /// Its family_of() and place: laws of one answer need not be distinguished.
  std::string family = {}, place = {};
  std::vector<vjm::Effect> effects;
  std::vector<Parameter> parameters;
  Eigen::VectorXd values;
  Eigen::MatrixXd root;  // of their covariance, by Laplace's approximation
  double weight = 1;     // beside that of others
  std::optional<double> log_evidence;
  /// The readings so far give no information about the added effect: it is forecast at its usual
  /// size, but may have any, and any form. `own` are its values, with the widths of their priors.
  bool any_size = false;
  std::vector<Parameter> own;
  /// No candidate, but it may act like one in new readings.
  bool is_look_alike = false;
  bool on_load = false, on_sensor = false;  // what it adds concerns the readings, not the robot
};

/// The candidates, fitted again where the diagnosis fitted them (of the others the uncertain values
/// have taken up what they can), and what else is unseen; at the end the model that adds nothing,
/// whether it is a candidate or not.
std::vector<PlanModel> plan_models(const vjm::Robot& robot, const Campaign& campaign,
                                   const Noise& noise, const PlanQuestion& question, int threads,
                                   common::Progress& progress);

/// For each kind that is no candidate, the place that new readings (their forecasts, and what a
/// session brings along) distinguish least from a candidate; at most eight kinds. The others are
/// left out.
std::vector<PlanModel> with_look_alikes(const std::vector<PlanModel>& models,
                                        std::vector<Forecast> forecasts, Eigen::MatrixXd common);

/// How many times its usual size something may be of which nothing is known.
inline constexpr double any_size = 3;

/// Two models; `b` of any size and form, where nothing is known of it. `nothing`: the model that
/// adds nothing.
Separation separation_of(const Forecast& a, const Forecast& b, bool b_has_any_size,
                         const Forecast& nothing, const Eigen::MatrixXd& common);

/// Forecast of planned readings by a model: values of `components` of each, in their order, divided
/// by `sigma`; NaN where it has no equilibrium.
Forecast forecast(const vjm::Robot& robot, const PlanModel& model, const Campaign& planned,
                  const std::vector<Eigen::Index>& components, int threads,
                  common::Progress& progress);

/// The same in a campaign of its own, where what is uncertain is fitted: nothing is known of it but
/// its size.
PlanModel fitted_alone(PlanModel model);

/// The same without what it adds to loads: as under known weights instead of the load cell.
PlanModel under_known_weights(const vjm::Robot& robot, PlanModel model);

/// Zero offsets, frames and targets that a planned session has to find as well, as columns in units
/// of the noise by a width that says that nothing is known of them. `of_any`: of any of the models.
Eigen::MatrixXd session_unknowns(const Campaign& like, const Campaign& planned,
                                 const std::vector<Eigen::Index>& components,
                                 const Forecast& of_any);

}  // namespace kinetostat::calibration
