#include "kinetostat/calibration/comparison/joint_curve.h"

#include <algorithm>
#include <cmath>

#include "kinetostat/calibration/campaign/load_history.h"
#include "kinetostat/calibration/statistics/median.h"

namespace kinetostat::calibration {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr double hardly = 3;  // times the median deviation

// The joint's coordinate and the spring over it alone.
struct JointSpring {
  std::size_t chain = 0;
  Index coordinate = 0;
  std::string spring;
};

std::optional<JointSpring> spring_of(const vjm::Robot& robot, const vjm::EffectSite& joint) {
  const vjm::Manipulator& bare = robot.without_effects();
  if (joint.chain >= bare.size()) return std::nullopt;
  const vjm::Chain& chain = bare.chains()[joint.chain];
  if (!chain.has_coordinate(joint.element)) return std::nullopt;
  for (const vjm::Effect& effect : robot.effects)
    for (const vjm::EffectSite& site : effect.sites)
      if (site.chain == joint.chain && site.element == joint.element) return std::nullopt;
  const Index coordinate = chain.index_of(joint.element);
  for (const vjm::Spring& spring : chain.springs())
    if (spring.first == coordinate && spring.stiffness.rows() == 1)
      return JointSpring{joint.chain, coordinate, spring.name};
  return std::nullopt;
}

// A model with the spring as one parameter more.
struct Model {
  std::vector<Parameter> parameters;
  Eigen::VectorXd values;
};

Model model_of(const BaseFit& fit, const JointSpring& spring) {
  Model model;
  model.parameters = held_parameters(fit);
  model.values = Eigen::VectorXd::Zero(static_cast<Index>(model.parameters.size()) + 1);
  model.values.head(static_cast<Index>(model.parameters.size())) = starts_of(model.parameters);
  model.parameters.push_back(
      {.name = spring.spring, .springs = {{spring.chain, spring.spring}}, .stiffness = {}});
  return model;
}

// Of the joint, one a reading; NaN where there is no equilibrium.
std::vector<double> deflections(const Predictor& predictor, const Campaign& campaign,
                                const Predictions& predictions, const vjm::Manipulator& bare,
                                const JointSpring& spring) {
  std::vector<double> result;
  for (std::size_t i = 0; i < campaign.readings.size(); ++i) {
    double& d = result.emplace_back(std::nan(""));
    if (!is_used(campaign.readings[i]) || predictions.loaded[i].coordinates.empty()) continue;
    const double x = predictions.loaded[i].coordinates[spring.chain][spring.coordinate];
    // A state without load that nobody had to find is that of the command.
    const bool is_from_command = campaign.displacement == DisplacementKind::absolute ||
                                 i >= predictions.unloaded.size() ||
                                 predictions.unloaded[i].coordinates.empty();
    const double from = is_from_command
                            ? predictor.posture_of(i).coordinates_of(
                                  bare.chains()[spring.chain], spring.chain)[spring.coordinate]
                            : predictions.unloaded[i].coordinates[spring.chain][spring.coordinate];
    d = x - from;
  }
  return result;
}

// du/dd of every configuration; zero where the joint does not deflect.
std::vector<VectorXd> followings(const Campaign& campaign, const Predictions& predictions,
                                 const std::vector<double>& deflection) {
  std::vector<VectorXd> result(campaign.configurations.size(), VectorXd::Zero(campaign.size()));
  std::vector<double> largest(campaign.configurations.size(), 0);
  for (std::size_t i = 0; i < campaign.readings.size(); ++i) {
    const std::size_t c = campaign.readings[i].configuration;
    const double size = std::abs(deflection[i]);
    if (std::isnan(size) || size <= largest[c]) continue;
    largest[c] = size;
    result[c] = -predictions.derivatives[i].rightCols<1>() / deflection[i];
  }
  return result;
}

// What moves the joint by one unit of information: J' W J, and J' W r.
struct Projection {
  double information = 0, residual = 0;
};

Projection projection_of(const Reading& reading, const VectorXd& sigma, const VectorXd& following,
                         const VectorXd& residual) {
  Projection p;
  for (const Index k : components_in_use(reading)) {
    const double weight = following[k] / (sigma[k] * sigma[k]);
    p.information += weight * following[k];
    p.residual += weight * residual[k];
  }
  return p;
}

double stiffness_of(const vjm::Robot& robot, const Model& model, const JointSpring& spring) {
  return with_values(robot.without_effects(), robot.effects, model.parameters, model.values)
      .bare()
      .chains()[spring.chain]
      .stiffness()(spring.coordinate, spring.coordinate);
}

// One model: how its joint deflects, and how stiff the spring is.
struct JointView {
  Predictions predictions;
  std::vector<double> deflection;  // one a reading
  double stiffness = 0;
};

// `by`: what the predictions are differentiated with respect to.
std::optional<JointView> view_of(const vjm::Robot& robot, const Campaign& campaign,
                                 const Model& model, const std::vector<Parameter>& by,
                                 const JointSpring& spring, int threads,
                                 common::Progress& progress) {
  const vjm::Manipulator& bare = robot.without_effects();
  const Predictor predictor(bare, robot.effects, campaign, threads, progress);
  JointView view{.predictions = predictor.predict(model.parameters, model.values, by, progress),
                 .deflection = {},
                 .stiffness = stiffness_of(robot, model, spring)};
  if (view.predictions.failure) return std::nullopt;
  view.deflection = deflections(predictor, campaign, view.predictions, bare, spring);
  return view;
}

void leave_out_what_is_hardly_seen(std::vector<JointCurvePoint>& points) {
  if (points.empty()) return;
  std::vector<double> deviations;
  deviations.reserve(points.size());
  for (const JointCurvePoint& p : points) deviations.push_back(p.deviation);
  std::erase_if(points, [limit = hardly * upper_median(std::move(deviations))](
                            const JointCurvePoint& p) { return p.deviation > limit; });
}

}  // namespace

std::optional<std::vector<JointCurvePoint>> joint_curve(
    const vjm::Robot& first, const vjm::Robot& second, const Campaign& campaign, const Noise& noise,
    const Assessment& without, const Assessment& with, const vjm::EffectSite& joint, int threads,
    common::Progress& progress) {
  const std::optional<JointSpring> spring = spring_of(first, joint);
  if (!spring) return std::nullopt;
  const Model model = model_of(without.fit, *spring);
  const auto before =
      view_of(first, campaign, model, {model.parameters.back()}, *spring, threads, progress);
  const auto after =
      view_of(second, campaign, model_of(with.fit, *spring), {}, *spring, threads, progress);
  if (!before || !after) return std::nullopt;
  const std::vector<VectorXd> following_of =
      followings(campaign, before->predictions, before->deflection);
  std::vector<JointCurvePoint> points;
  for (std::size_t i = 0; i < campaign.readings.size(); ++i) {
    const Reading& reading = campaign.readings[i];
    const VectorXd& following = following_of[reading.configuration];
    const double d = before->deflection[i], e = after->deflection[i];
    if (std::isnan(d) || std::isnan(e) || following.isZero(0)) continue;
    const Projection p = projection_of(reading, noise.sigma[i], following, with.residual[i]);
    if (!(p.information > 0)) continue;
    points.push_back({.reading = i,
                      .load = before->stiffness * d,
                      .measured = e + p.residual / p.information,
                      .without = d,
                      .with = e,
                      .spring = before->stiffness * d / after->stiffness,
                      .deviation = 1 / std::sqrt(p.information)});
  }
  leave_out_what_is_hardly_seen(points);
  if (points.empty()) return std::nullopt;
  return points;
}

}  // namespace kinetostat::calibration
