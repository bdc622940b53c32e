#include "kinetostat/calibration/kinematics/kinematic_calibration.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include <fmt/format.h>

#include "kinetostat/calibration/campaign/noise_estimate.h"
#include "kinetostat/calibration/comparison/column_error.h"
#include "kinetostat/calibration/kinematics/generic_poses.h"
#include "kinetostat/calibration/kinematics/pose_error.h"
#include "kinetostat/calibration/regression/held_out.h"
#include "kinetostat/calibration/regression/undetermined.h"
#include "kinetostat/calibration/regression/wrench_noise.h"
#include "kinetostat/common/error.h"

namespace kinetostat::calibration {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr std::size_t fewest_poses = 4;   // to leave one out
constexpr double usual_tolerance = 1e-3;  // of the reach, and [rad]

// How far the platform is from where the chains start, over the postures of the readings [m].
double reach_of(const Predictor& predictor, const vjm::Manipulator& bare,
                const Campaign& campaign) {
  double reach = 0;
  for (std::size_t i = 0; i < campaign.readings.size(); ++i) {
    if (campaign.readings[i].masked) continue;
    const spatial::Vector3 platform = predictor.posture_of(i).platform.position();
    for (const vjm::Chain& chain : bare.chains())
      reach = std::max(reach, (platform - chain.base().position()).norm());
  }
  return reach > 0 ? reach : 1;
}

Tolerance tolerance_of(const KinematicOptions& options, double reach) {
  Tolerance tolerance = options.tolerance;
  if (!(tolerance.length > 0)) tolerance.length = usual_tolerance * reach;
  if (!(tolerance.angle > 0)) tolerance.angle = usual_tolerance;
  return tolerance;
}

Noise scaled(Noise noise, double factor) {
  for (VectorXd& sigma : noise.sigma) sigma *= factor;
  for (Datum& datum : noise.datums) datum.sigma *= factor;
  return noise;
}

// What a fit leaves, in units of the noise by which it was made.
double ratio_of(const BaseFit& fit) {
  if (fit.loss == Loss::squares)
    return std::sqrt(fit.squared_error /
                     std::max<double>(1, static_cast<double>(fit.degrees_of_freedom())));
  constexpr double normal = 1.4826;  // standard deviations in a median absolute deviation
  VectorXd sizes = fit.at.residual.cwiseAbs();
  std::nth_element(sizes.begin(), sizes.begin() + sizes.size() / 2, sizes.end());
  return normal * sizes[sizes.size() / 2];
}

std::vector<std::size_t> poses_in_use(const Campaign& campaign) {
  std::set<std::size_t> poses;
  for (const Value& value : values_in_use(campaign))
    poses.insert(campaign.readings[value.reading].configuration);
  return {poses.begin(), poses.end()};
}

void require_within_range(const ParameterEstimate& estimate, const GeometricParameter& what) {
  if (estimate.hit == BoundHit::none) return;
  throw common::NotIdentifiable(fmt::format(
      "{} would have to be {} than {:.3g} {}: that is no error of a geometry. Correct the robot "
      "file first (tool, home positions, units and signs of joints), or where the target is "
      "('target_point' in the campaign file).",
      what.phrase(), estimate.hit == BoundHit::upper ? "more" : "less", estimate.value,
      what.unit()));
}

class Calibration {
 public:
  Calibration(const vjm::Robot& robot, const Campaign& whole, const KinematicOptions& options,
              int threads, common::Progress& progress)
      : robot_(robot),
        whole_(whole),
        campaign_(only(whole, {Role::fit})),
        options_(options),
        threads_(threads),
        progress_(progress),
        nominal_predictor_(robot.without_effects(), robot.effects, whole, threads, progress),
        reach_(reach_of(nominal_predictor_, robot.without_effects(), campaign_)),
        tolerance_(tolerance_of(options, reach_)),
        model_(geometric_model(robot, tolerance_)),
        predictor_(nominal_predictor_.with_effects(model_.effects)),
        noise_(with_wrench_noise(noise_of(whole, replicate_groups(whole)), whole, predictor_, {},
                                 {}, progress)) {
    result_.reach = reach_;
    result_.tolerance = tolerance_;
    // Whitened by what they share, one gross error would be in many readings.
    if (options.loss != Loss::squares) noise_.datums.clear();
    collect_parameters();
  }

  KinematicCalibration run() {
    nominal_ = fit({}, noise_, {});
    require_columns();
    values_ = values_in_use(campaign_);
    choose();
    settle();
    make_stages();
    take(result_.taken);
    return std::move(result_);
  }

 private:
  // A stage: which of all parameters are fitted, and the fit.
  struct Stage {
    std::vector<Index> chosen;
    BaseFit fit;
    std::optional<PoseErrors> held_out = {};
  };

  Index geometric() const { return static_cast<Index>(model_.parameters.size()); }
  const GeometricParameter& geometry(Index k) const {
    return model_.parameters[static_cast<std::size_t>(k)];
  }
  std::string phrase_of(Index k) const {
    return k < geometric() ? geometry(k).phrase() : all_[static_cast<std::size_t>(k)].phrase();
  }

  void collect_parameters();
  BaseFit fit(const std::vector<Index>& chosen, const Noise& noise, const VectorXd& starts) const {
    return fit(chosen, noise, starts, campaign_, nullptr, true);
  }
  BaseFit fit(const std::vector<Index>& chosen, const Noise& noise, const VectorXd& starts,
              const Campaign& campaign, const Predictions* near, bool may_still_move) const;
  /// Changes of the readings in units of the noise: by frames and zero offsets, and by one
  /// tolerance.
  void columns_at(const std::vector<Index>& chosen, const VectorXd& values, const BaseFit& at,
                  MatrixXd& nuisance, MatrixXd& columns) const;
  void choose();
  void settle();
  void leave_out(const LeftOutColumn& column, const std::vector<Index>& of, LeftOut why);
  void require_columns() const;
  void require_geometry() const;
  void require_errors(const BaseFit& fit, const MatrixXd& nuisance, const MatrixXd& columns) const;
  /// Prior precision over the tolerance, and how many of these are geometry: the first.
  VectorXd information_of(const std::vector<Index>& chosen) const;
  Index geometric_count(const std::vector<Index>& chosen) const;
  void make_stages();
  void add_stage(const std::string& name, const std::vector<Index>& chosen);
  std::optional<PoseErrors> held_out(const Stage& stage);
  std::vector<std::vector<std::size_t>> folds() const;
  void take(std::size_t taken);
  void add_geometry(const Stage& stage);
  bool is_judged() const { return options_.folds > 1; }
  [[noreturn]] void fail_to_judge() const;
  /// Errors of readings that a fit has not used.
  void add_predicted(const Campaign& others, const BaseFit& fit, PoseErrors& errors) const;
  void judge_confirmed(const Stage& before, const Stage& after);

  const vjm::Robot& robot_;
  const Campaign& whole_;
  Campaign campaign_;  // readings of other roles masked
  KinematicOptions options_;
  int threads_;
  common::Progress& progress_;
  Predictor nominal_predictor_;
  double reach_;
  Tolerance tolerance_;
  GeometricModel model_;
  Predictor predictor_;
  Noise noise_;
  std::vector<Parameter> all_;  // geometry, then others
  BaseFit nominal_;
  std::vector<Value> values_;
  std::vector<Index> chosen_;  // of all
  VectorXd found_;             // their values
  double ratio_ = 1;
  std::vector<Stage> stages_;
  bool too_few_poses_ = false;  // to leave any out of the stage made last
  KinematicCalibration result_;
};

// What the file declares uncertain stands behind the geometry, without what is geometry itself.
void Calibration::collect_parameters() {
  all_ = fit_parameters(model_, robot_.without_effects());
  for (std::size_t k = 0; options_.prior && k < all_.size(); ++k)
    all_[k].prior =
        Parameter::Prior{.mean = all_[k].start, .deviation = model_.parameters[k].tolerance};
  std::vector<Parameter> others;
  for (Parameter& other : uncertain_parameters(robot_)) {
    const bool is_geometry =
        !other.is_logarithm() &&
        std::any_of(model_.parameters.begin(), model_.parameters.end(), [&](const auto& p) {
          return p.effect == other.effect && p.component == other.value;
        });
    if (!is_geometry) others.push_back(std::move(other));
  }
  believe_design(others);
  all_.insert(all_.end(), others.begin(), others.end());
}

BaseFit Calibration::fit(const std::vector<Index>& chosen, const Noise& noise,
                         const VectorXd& starts, const Campaign& campaign, const Predictions* near,
                         bool may_still_move) const {
  std::vector<Parameter> parameters;
  for (std::size_t k = 0; k < chosen.size(); ++k) {
    parameters.push_back(all_[static_cast<std::size_t>(chosen[k])]);
    if (starts.size() > 0)
      parameters.back().start = std::clamp(starts[static_cast<Index>(k)], parameters.back().lower,
                                           parameters.back().upper);
  }
  BaseFit result = fit_base(
      predictor_, campaign, noise, parameters, progress_,
      {.tolerance = 1e-9, .loss = options_.loss, .near = near, .accept_unsettled = may_still_move});
  for (std::size_t k = 0; k < chosen.size(); ++k)
    result.parameters[k].parameter.start = all_[static_cast<std::size_t>(chosen[k])].start;
  return result;
}

void Calibration::columns_at(const std::vector<Index>& chosen, const VectorXd& values,
                             const BaseFit& at, MatrixXd& nuisance, MatrixXd& columns) const {
  std::vector<Parameter> parameters;
  parameters.reserve(chosen.size());
  for (const Index k : chosen) parameters.push_back(all_[static_cast<std::size_t>(k)]);
  const auto count = static_cast<Index>(chosen.size());
  const auto linear =
      linearised_at(predictor_, campaign_, noise_, parameters, values, at, count, progress_);
  if (!linear)
    throw common::NoConvergence(
        fmt::format("{}: the model has no equilibrium with geometric errors of its best fit",
                    robot_.file.string()));
  columns = linear->jacobian.leftCols(count);
  nuisance = linear->jacobian.rightCols(linear->jacobian.cols() - count);
  for (Index k = 0; k < count; ++k)
    columns.col(k) *= parameters[static_cast<std::size_t>(k)].typical;
}

void Calibration::leave_out(const LeftOutColumn& column, const std::vector<Index>& of,
                            LeftOut why) {
  const Index k = of[static_cast<std::size_t>(column.column)];
  const bool is_unseen = column.like.empty() && !column.like_nuisance;
  if (k >= geometric()) {
    result_.others_kept.push_back(
        fmt::format("{} stays at its nominal value: {}.", phrase_of(k),
                    is_unseen ? "no reading depends on it" : "it is confounded with the geometry"));
    return;
  }
  LeftOutGeometry out{.what = geometry(k), .why = is_unseen ? LeftOut::unseen : why, .like = {}};
  for (const Index other : column.like)
    out.like.push_back(phrase_of(of[static_cast<std::size_t>(other)]));
  if (column.like_nuisance) out.like.push_back("the frame of the readings");
  result_.left_out.push_back(std::move(out));
}

// What kinematics and readings determine at the nominal geometry.
void Calibration::choose() {
  constexpr double alike = 1e-3;
  const bool is_known = noise_.source != NoiseSource::unknown;
  progress_.report("which parameters the poses show", 0);
  std::vector<Index> candidates;
  for (Index k = 0; k < geometric(); ++k) candidates.push_back(k);
  const IndependentColumns generic =
      generically_independent(robot_, model_, campaign_, reach_, threads_, progress_);
  for (const LeftOutColumn& column : generic.left_out)
    leave_out(column, candidates, LeftOut::redundant);
  candidates = generic.kept;
  for (auto k = geometric(); k < std::ssize(all_); ++k) candidates.push_back(k);
  VectorXd at = VectorXd::Zero(static_cast<Index>(candidates.size()));
  for (std::size_t k = 0; k < candidates.size(); ++k)
    if (candidates[k] >= geometric())
      at[static_cast<Index>(k)] = all_[static_cast<std::size_t>(candidates[k])].start;
  MatrixXd nuisance, columns;
  columns_at(candidates, at, nominal_, nuisance, columns);
  const IndependentColumns seen = independent_columns(nuisance, columns, is_known ? 1 : 0, alike);
  for (const LeftOutColumn& column : seen.left_out)
    leave_out(column, candidates, LeftOut::confounded);
  // Two equations for each unknown at least.
  const auto most =
      static_cast<std::size_t>(std::max<Index>(0, (std::ssize(values_) - nuisance.cols()) / 2));
  for (const Index k : seen.kept) {
    const Index parameter = candidates[static_cast<std::size_t>(k)];
    if (chosen_.size() < most)
      chosen_.push_back(parameter);
    else if (parameter < geometric())
      result_.left_out.push_back({geometry(parameter), LeftOut::too_many, {}});
    else
      result_.others_kept.push_back(fmt::format(
          "{} stays at its nominal value: there are too few readings.", phrase_of(parameter)));
  }
  require_geometry();
}

void Calibration::require_geometry() const {
  if (!chosen_.empty() && chosen_.front() < geometric()) return;
  const std::string wanted = fmt::format(
      "Calibration needs absolute poses ('displacement: absolute'), unloaded or under known loads, "
      "at {} postures or more that move every joint",
      std::max<Index>(10, geometric()));
  throw common::NotIdentifiable(fmt::format(
      "{}: {}. {}.", whole_.file.string(),
      campaign_.displacement == DisplacementKind::difference
          ? "these readings are differences between the robot under load and without, in which its "
            "geometry cancels"
          : fmt::format("these {} values determine no geometric parameter to its tolerance",
                        values_.size()),
      wanted));
}

// Errors of the geometry would take the place of a sign.
void Calibration::require_columns() const {
  const std::string slip = column_error(robot_, campaign_, nominal_.predicted, threads_, progress_);
  if (!slip.empty())
    throw common::NotIdentifiable(fmt::format("{}: {}", whole_.file.string(), slip));
}

// A bound that readings press against, whatever else they leave, is no matter of noise.
void Calibration::require_errors(const BaseFit& fit, const MatrixXd& nuisance,
                                 const MatrixXd& columns) const {
  constexpr double little = 1e-3;
  const double ratio = noise_.source == NoiseSource::unknown ? little * ratio_ : 1;
  const IndependentColumns known = determined_columns(nuisance, columns, information_of(chosen_),
                                                      ratio, geometric_count(chosen_));
  for (const Index k : known.kept)
    if (const Index parameter = chosen_[static_cast<std::size_t>(k)]; parameter < geometric())
      require_within_range(fit.parameters[static_cast<std::size_t>(k)], geometry(parameter));
}

// Fits; what the fit leaves counts as noise, beside which some may not be determined.
void Calibration::settle() {
  constexpr int most_rounds = 10;
  const bool is_known = noise_.source != NoiseSource::unknown;
  for (int round = 0; round < most_rounds; ++round) {
    progress_.report("fit of the geometry", static_cast<double>(round) / most_rounds);
    const BaseFit all = fit(chosen_, noise_, found_);
    found_ = values_of(all);
    ratio_ = is_known ? std::max(1.0, ratio_of(all)) : ratio_of(all);
    MatrixXd nuisance, columns;
    columns_at(chosen_, found_, all, nuisance, columns);
    require_errors(all, nuisance, columns);
    const IndependentColumns seen = determined_columns(nuisance, columns, information_of(chosen_),
                                                       ratio_, geometric_count(chosen_));
    if (seen.left_out.empty()) return;
    for (const LeftOutColumn& column : seen.left_out)
      leave_out(column, chosen_, LeftOut::confounded);
    found_ = VectorXd(found_(seen.kept));
    std::vector<Index> kept;
    for (const Index k : seen.kept) kept.push_back(chosen_[static_cast<std::size_t>(k)]);
    chosen_ = std::move(kept);
    require_geometry();
  }
}

VectorXd Calibration::information_of(const std::vector<Index>& chosen) const {
  VectorXd information = VectorXd::Zero(static_cast<Index>(chosen.size()));
  for (std::size_t k = 0; k < chosen.size(); ++k)
    if (const Parameter& p = all_[static_cast<std::size_t>(chosen[k])]; p.prior)
      information[static_cast<Index>(k)] = std::pow(p.typical / p.prior->deviation, 2);
  return information;
}

Index Calibration::geometric_count(const std::vector<Index>& chosen) const {
  return std::count_if(chosen.begin(), chosen.end(), [&](Index k) { return k < geometric(); });
}

void Calibration::make_stages() {
  std::vector<Index> chosen;
  add_stage("nominal", chosen);
  const auto add_if = [&](const std::string& name, const auto& belongs) {
    const std::size_t before = chosen.size();
    for (const Index k : chosen_)
      if (belongs(k)) chosen.push_back(k);
    if (chosen.size() == before || too_few_poses_) return;
    std::sort(chosen.begin(), chosen.end());
    add_stage(name, chosen);
  };
  const auto is_of = [&](std::initializer_list<GeometryGroup> groups) {
    return [this, groups = std::vector(groups)](Index k) {
      return k < geometric() &&
             std::find(groups.begin(), groups.end(), geometry(k).group) != groups.end();
    };
  };
  add_if("uncertain values", [&](Index k) { return k >= geometric(); });
  add_if("base and tool", is_of({GeometryGroup::base, GeometryGroup::tool}));
  add_if("joint offsets", is_of({GeometryGroup::joint_offset}));
  add_if("links", is_of({GeometryGroup::link}));
  add_if("drives", is_of({GeometryGroup::drive}));
  if (too_few_poses_ && stages_.size() == 1) fail_to_judge();
  result_.taken = is_judged() ? 0 : stages_.size() - 1;
  if (!is_judged()) return;
  for (std::size_t s = 1; s < stages_.size(); ++s)
    if (is_lower(*stages_[s].held_out, *stages_[result_.taken].held_out)) result_.taken = s;
}

void Calibration::add_stage(const std::string& name, const std::vector<Index>& chosen) {
  progress_.report(name, 0);
  VectorXd starts(static_cast<Index>(chosen.size()));
  for (std::size_t k = 0; k < chosen.size(); ++k)
    starts[static_cast<Index>(k)] =
        found_[std::find(chosen_.begin(), chosen_.end(), chosen[k]) - chosen_.begin()];
  Stage stage{chosen, fit(chosen, scaled(noise_, ratio_), starts)};
  stage.held_out = held_out(stage);
  too_few_poses_ = is_judged() && !stage.held_out;
  if (too_few_poses_ && !stages_.empty()) return;
  PoseErrors errors;
  errors.add(campaign_, stage.fit.predicted, ratio_ * stage.fit.at.residual);
  result_.stages.push_back({.name = name,
                            .fitted = static_cast<Index>(chosen.size()),
                            .at_fitted = errors.total(),
                            .held_out = {}});
  if (stage.held_out) result_.stages.back().held_out = stage.held_out->total();
  stages_.push_back(std::move(stage));
}

// Parts of the readings, by pose: the first, the last but nine, ... in the first of ten.
std::vector<std::vector<std::size_t>> Calibration::folds() const {
  const HeldOutGroups groups = held_out_groups(campaign_, values_);
  const auto count =
      std::min<std::size_t>(static_cast<std::size_t>(options_.folds), groups.members.size());
  std::vector<std::vector<std::size_t>> parts(count);
  for (std::size_t g = 0; g < groups.members.size() && count > 0; ++g)
    for (const Index v : groups.members[g])
      parts[g % count].push_back(values_[static_cast<std::size_t>(v)].reading);
  return parts;
}

// A fit predicts all readings of sessions whose frame and zero offsets it knows; those of others
// have to be estimated from what is predicted.
void Calibration::add_predicted(const Campaign& others, const BaseFit& fit,
                                PoseErrors& errors) const {
  const bool is_estimated = campaign_.session_frame == SessionFrame::estimated ||
                            campaign_.zero == ZeroReading::estimated;
  if ((is_estimated && campaign_.sessions.size() > 1) || !noise_.datums.empty()) {
    const BaseFit seen = predict_others(predictor_, others, scaled(noise_, ratio_), fit, progress_);
    errors.add(others, seen.predicted, ratio_ * seen.at.residual);
    return;
  }
  VectorXd residual(std::ssize(values_in_use(others)));
  Index row = 0;
  for (std::size_t i = 0; i < others.readings.size(); ++i) {
    const std::vector<Index> used = components_in_use(others.readings[i]);
    if (used.empty()) continue;
    MatrixXd block = (fit.predicted[i] - others.readings[i].displacement)(used);
    noise_.whiten(i, used, block);
    residual.segment(row, block.rows()) = block;
    row += block.rows();
  }
  errors.add(others, fit.predicted, residual);
}

void Calibration::fail_to_judge() const {
  throw common::NotIdentifiable(fmt::format(
      "{}: {} poses are too few to leave any out and judge a calibration by them. Measure {} or "
      "more that move every joint; '--hold-out 0' fits them all the same.",
      whole_.file.string(), poses_in_use(campaign_).size(), std::max<Index>(10, geometric())));
}

std::optional<PoseErrors> Calibration::held_out(const Stage& stage) {
  if (!is_judged() || poses_in_use(campaign_).size() < fewest_poses) return std::nullopt;
  PoseErrors errors;
  const Noise noise = scaled(noise_, ratio_);
  for (const std::vector<std::size_t>& part : folds()) {
    Campaign rest = campaign_, others = campaign_;
    for (Reading& reading : others.readings) reading.masked = true;
    for (const std::size_t reading : part) {
      rest.readings[reading].masked = true;
      others.readings[reading].masked = campaign_.readings[reading].masked;
    }
    try {
      add_predicted(others,
                    fit(stage.chosen, noise, values_of(stage.fit), rest, &stage.fit.model, true),
                    errors);
    } catch (const common::NotIdentifiable&) {
      return std::nullopt;  // too few are left
    }
  }
  return errors;
}

void Calibration::take(std::size_t taken) {
  Stage& stage = stages_[taken];
  // What goes into a file has come to rest; the other stages need not.
  stage.fit = fit(stage.chosen, scaled(noise_, ratio_), values_of(stage.fit), campaign_,
                  &stage.fit.model, false);
  for (const Index k : chosen_)
    if (std::find(stage.chosen.begin(), stage.chosen.end(), k) == stage.chosen.end()) {
      if (k < geometric())
        result_.left_out.push_back(
            {geometry(k), too_few_poses_ ? LeftOut::too_many : LeftOut::unneeded, {}});
      else
        result_.others_kept.push_back(
            fmt::format("{} stays at its nominal value: poses that were held out are predicted no "
                        "better with it fitted.",
                        phrase_of(k)));
    }
  result_.values = stage.fit.values;
  result_.poses = std::ssize(poses_in_use(campaign_));
  result_.readings = std::count_if(campaign_.readings.begin(), campaign_.readings.end(),
                                   [](const Reading& r) { return !components_in_use(r).empty(); });
  result_.is_judged = is_judged();
  result_.noise_source = noise_.source;
  result_.residual_ratio = ratio_ * ratio_of(stage.fit);
  result_.weak = stage.fit.weak;
  add_geometry(stage);
  if (!stage.chosen.empty()) {
    MatrixXd nuisance, columns;
    columns_at(stage.chosen, values_of(stage.fit), stage.fit, nuisance, columns);
    result_.observability = observability_of(nuisance, columns);
  }
  judge_confirmed(stages_[result_.before_stage()], stage);
}

void Calibration::add_geometry(const Stage& stage) {
  result_.effects = model_.effects;
  result_.own_effects = robot_.effects.size();
  const auto count = static_cast<Index>(stage.chosen.size());
  const MatrixXd covariance = stage.fit.covariance.topLeftCorner(count, count);
  const VectorXd inverse =
      covariance.diagonal().cwiseSqrt().unaryExpr([](double d) { return d > 0 ? 1 / d : 0; });
  result_.correlation = inverse.asDiagonal() * covariance * inverse.asDiagonal();
  for (std::size_t k = 0; k < stage.chosen.size(); ++k) {
    const ParameterEstimate& estimate = stage.fit.parameters[k];
    if (stage.chosen[k] >= geometric()) {
      result_.others.push_back(estimate);
      continue;
    }
    const GeometricParameter& what = geometry(stage.chosen[k]);
    require_within_range(estimate, what);
    result_.geometry.push_back({.what = what,
                                .before = estimate.parameter.start,
                                .value = estimate.value,
                                .deviation = estimate.standard_error});
    vjm::Effect& effect = result_.effects[what.effect];
    if (effect.deviations.size() == 0)
      effect.deviations = VectorXd::Constant(6, std::numeric_limits<double>::quiet_NaN());
    effect.values[what.component] = estimate.value;
    effect.deviations[what.component] = estimate.standard_error;
  }
}

void Calibration::judge_confirmed(const Stage& before, const Stage& after) {
  if (!has_role(whole_, Role::confirm)) return;
  const Campaign others = only(whole_, {Role::confirm});
  const auto error_of = [&](const Stage& stage) {
    PoseErrors errors;
    add_predicted(others, stage.fit, errors);
    return errors.total();
  };
  result_.confirmed_before = error_of(before);
  result_.confirmed = error_of(after);
}

}  // namespace

std::size_t KinematicCalibration::before_stage() const {
  std::size_t before = 0;
  for (std::size_t s = 0; s < taken; ++s)
    if (stages[s].name == "base and tool" || stages[s].name == "uncertain values") before = s;
  return before;
}

Index KinematicCalibration::count(LeftOut why) const {
  return std::count_if(left_out.begin(), left_out.end(),
                       [&](const LeftOutGeometry& out) { return out.why == why; });
}

KinematicCalibration calibrate_kinematics(const vjm::Robot& robot, const Campaign& campaign,
                                          const KinematicOptions& options, int threads,
                                          common::Progress& progress) {
  return Calibration(robot, campaign, options, threads, progress).run();
}

}  // namespace kinetostat::calibration
