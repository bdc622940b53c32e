#include "kinetostat/calibration/regression/base_fit.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <set>
#include <stdexcept>
#include <tuple>

#include <fmt/format.h>

#include "kinetostat/calibration/campaign/datum.h"
#include "kinetostat/calibration/regression/session_frame.h"
#include "kinetostat/calibration/statistics/identifiability.h"
#include "kinetostat/common/error.h"
#include "kinetostat/spatial/rotation.h"

namespace kinetostat::calibration {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using spatial::Vector6;

// Sessions that have a value in use.
std::set<std::size_t> sessions_in_use(const std::vector<Value>& values, const Campaign& campaign) {
  std::set<std::size_t> sessions;
  for (const Value& value : values) sessions.insert(campaign.readings[value.reading].session);
  return sessions;
}

std::optional<double> known_zero(const BaseFit& fit, std::size_t session, Index component) {
  for (const Zero& zero : fit.zeros)
    if (zero.session == session && zero.component == component) return zero.value;
  return std::nullopt;
}

// A target that is unknown, and how many of its coordinates.
struct UnknownTarget {
  std::size_t sensor = 0;
  Index coordinates = 0;
};

// Those that the readings in use may show: rotations only in absolute poses.
std::vector<UnknownTarget> unknown_targets(const std::vector<Value>& values,
                                           const Campaign& campaign) {
  std::vector<UnknownTarget> result;
  for (std::size_t sensor = 0; sensor < campaign.sensors.size(); ++sensor) {
    if (!campaign.estimates_target(sensor)) continue;
    UnknownTarget target{sensor};
    for (const Value& value : values) {
      const Component& component = campaign.component(value.component);
      if (component.sensor != sensor) continue;
      const bool turns =
          is_rotation(component.axis) && campaign.displacement == DisplacementKind::absolute;
      target.coordinates = std::max<Index>(target.coordinates, turns ? 6 : 3);
    }
    if (target.coordinates > 0) result.push_back(target);
  }
  return result;
}

// The unknowns of a fit and where each stands in their vector: parameters, zero offsets, frames,
// target.
class Unknowns {
 public:
  Unknowns(const Campaign& campaign, const std::vector<Parameter>& parameters,
           const std::vector<Value>& values, const BaseFit* known)
      : campaign_(campaign), parameters_(parameters) {
    std::set<std::pair<std::size_t, Index>> zeros;
    if (campaign.zero == ZeroReading::estimated)
      for (const Value& value : values)
        zeros.emplace(campaign.readings[value.reading].session, value.component);
    for (const auto& [session, component] : zeros)
      if (known == nullptr || !known_zero(*known, session, component))
        zeros_.push_back({session, component});
    if (campaign.session_frame == SessionFrame::estimated)
      for (const std::size_t session : sessions_in_use(values, campaign))
        if (known == nullptr || !known_frame(*known, session)) frames_.push_back(session);
    // In differences the position of the frame cancels.
    first_frame_component_ = campaign.displacement == DisplacementKind::difference ? 3 : 0;
    if (known == nullptr) targets_ = unknown_targets(values, campaign);
  }

  const std::vector<Parameter>& parameters() const { return parameters_; }
  const std::vector<Zero>& zeros() const { return zeros_; }
  const std::vector<std::size_t>& frames() const { return frames_; }  // sessions
  Index parameter_count() const { return static_cast<Index>(parameters_.size()); }
  Index frame_components() const { return 6 - first_frame_component_; }
  Index zero_at(std::size_t zero) const { return parameter_count() + static_cast<Index>(zero); }
  Index frame_at(std::size_t frame) const {
    return zero_at(zeros_.size()) + static_cast<Index>(frame) * frame_components();
  }
  const std::vector<UnknownTarget>& targets() const { return targets_; }
  Index target_at(std::size_t target) const {
    Index at = frame_at(frames_.size());
    for (std::size_t t = 0; t < target; ++t) at += targets_[t].coordinates;
    return at;
  }
  Index target_components() const { return size() - target_at(0); }
  Index size() const { return target_at(targets_.size()); }
  bool has_poses() const { return size() > frame_at(0); }  // frames, or targets

  std::optional<std::size_t> frame_of(std::size_t session) const {
    const auto found = std::lower_bound(frames_.begin(), frames_.end(), session);
    if (found == frames_.end() || *found != session) return std::nullopt;
    return static_cast<std::size_t>(found - frames_.begin());
  }
  Vector6 frame(const VectorXd& q, std::size_t frame) const {
    Vector6 result = Vector6::Zero();
    result.tail(frame_components()) = q.segment(frame_at(frame), frame_components());
    return result;
  }

  std::vector<UnknownName> names() const {
    std::vector<UnknownName> result;
    for (const Parameter& p : parameters_)
      result.push_back({p.phrase(), true, p.is_logarithm(), p.unit, p.typical});
    for (const Zero& zero : zeros_)
      result.push_back(
          {fmt::format("the zero offset of {}{}", campaign_.component(zero.component).name,
                       in_session(zero.session)),
           false, false, spatial::to_string(campaign_.component(zero.component).dimension)});
    for (const std::size_t session : frames_)
      for (Index k = first_frame_component_; k < 6; ++k)
        result.push_back(
            {fmt::format("the {} of the frame{}", coordinate_words(k), in_session(session)), false,
             false, is_rotation(k) ? "rad" : "m"});
    for (const auto& [sensor, coordinates] : targets_)
      for (Index k = 0; k < coordinates; ++k)
        result.push_back({fmt::format("the {} of the target{}", coordinate_words(k), of(sensor)),
                          false, false, is_rotation(k) ? "rad" : "m"});
    return result;
  }

 private:
  static const char* coordinate_words(Index k) {
    return std::array{
        "x", "y", "z", "turn about x", "turn about y", "turn about z"}[static_cast<std::size_t>(k)];
  }
  std::string of(std::size_t sensor) const {
    const std::string& name = campaign_.sensors[sensor].name;
    return name.empty() ? "" : fmt::format(" of '{}'", name);
  }
  std::string in_session(std::size_t session) const {
    const std::string& name = campaign_.sessions[session];
    return name.empty() ? "" : fmt::format(" in session '{}'", name);
  }

  const Campaign& campaign_;
  const std::vector<Parameter>& parameters_;
  std::vector<Zero> zeros_;
  std::vector<std::size_t> frames_;
  Index first_frame_component_ = 0;
  std::vector<UnknownTarget> targets_;
};

// The weighted least-squares problem.
class Problem {
 public:
  Problem(const Predictor& predictor, const Campaign& campaign, const Noise& noise,
          const std::vector<Parameter>& parameters, const BaseFit* known,
          common::Progress& progress)
      : predictor_(predictor),
        campaign_(campaign),
        noise_(noise),
        known_(known),
        values_(values_in_use(campaign)),
        first_row_(first_values(values_, campaign.readings.size())),
        shared_(noise, values_),
        unknowns_(campaign, parameters, values_, known),
        progress_(progress),
        framed_(framed_components(campaign)) {}

  const Unknowns& unknowns() const { return unknowns_; }
  Index values() const { return static_cast<Index>(values_.size()); }
  Index priors() const {
    return std::count_if(unknowns_.parameters().begin(), unknowns_.parameters().end(),
                         [](const Parameter& p) { return p.prior.has_value(); });
  }
  /// Takes out the displacements, and the wrenches that work on them.
  std::pair<std::vector<VectorXd>, std::vector<Vector6>> take_predicted(const VectorXd& q) {
    if (predicted_.empty() || predicted_at_ != q) (void)at(q);
    return {std::move(predicted_), std::move(work_)};
  }
  const std::optional<PredictionFailure>& failure() const { return failure_; }
  /// Of a similar model, which outlives this; or of this one without its last effect, condensed.
  void begin_near(const Predictions& predictions, const CondensedModel* without = nullptr) {
    similar_ = &predictions;
    without_ = without;
  }
  /// Keeps one state a configuration, where there are many readings.
  void keep_few_states() {
    constexpr std::size_t long_table = 10000;
    few_states_ = campaign_.readings.size() >= long_table;
  }
  Predictions take_nearest() { return std::move(nearest_); }
  /// Zero offsets, frames and targets as a fit has them.
  void place_as(const BaseFit& fit, VectorXd& q) const {
    for (std::size_t z = 0; z < fit.zeros.size(); ++z) q[unknowns_.zero_at(z)] = fit.zeros[z].value;
    for (std::size_t f = 0; f < fit.frames.size(); ++f)
      q.segment(unknowns_.frame_at(f), unknowns_.frame_components()) =
          fit.frames[f].value.tail(unknowns_.frame_components());
    for (std::size_t t = 0; t < fit.targets.size(); ++t) {
      const Index coordinates = unknowns_.targets()[t].coordinates;
      q.segment(unknowns_.target_at(t), coordinates) = fit.targets[t].value.head(coordinates);
    }
  }

  std::optional<Linearisation> at(const VectorXd& q) { return at(q, unknowns_.parameter_count()); }

  // With derivatives by the last so many parameters.
  std::optional<Linearisation> at(const VectorXd& q, Index differentiated) {
    const std::vector<Parameter>& parameters = unknowns_.parameters();
    predicted_.clear();
    work_.clear();
    predicted_at_.resize(0);
    const Index rows = values() + priors();
    Linearisation result{VectorXd(rows), MatrixXd::Zero(rows, unknowns_.size())};
    place_frames(q);
    Predictions predictions;
    try {
      predictions = predicted_with(
          q.head(unknowns_.parameter_count()),
          {parameters.end() - differentiated, parameters.end()}, targets(q),
          [&](std::size_t i, VectorXd& predicted, Vector6& work, const MatrixXd& derivatives) {
            add_reading(q, i, predicted, work, derivatives, result);
          });
    } catch (const std::invalid_argument& error) {  // values that exclude each other
      predictions.failure = {0, error.what()};
    }
    failure_ = predictions.failure;
    beyond_.reset();
    if (failure_) return std::nullopt;
    predicted_ = std::move(predictions.displacement);
    work_ = std::move(predictions.work);
    predicted_at_ = q;
    add_priors(q, result);
    beyond_ = first_beyond(result);
    if (beyond_) return std::nullopt;
    shared_.whiten(result.residual.head(values()));
    if (differentiated > 0 || unknowns_.size() > unknowns_.parameter_count())
      shared_.whiten(result.jacobian.topRows(values()));
    if (without_ != nullptr) return result;  // condensed ones have no states to be near to
    predictions.displacement.clear();
    predictions.work.clear();
    nearest_ = std::move(predictions);
    similar_ = nullptr;
    return result;
  }

  VectorXd start() const {
    VectorXd q = VectorXd::Zero(unknowns_.size());
    for (std::size_t k = 0; k < unknowns_.parameters().size(); ++k)
      q[static_cast<Index>(k)] = unknowns_.parameters()[k].start;
    return q;
  }

  // A frame may be anywhere: its start is where the positions fit best.
  void start_frames(VectorXd& q) {
    if (unknowns_.frames().empty() || unknowns_.frame_components() < 6) {
      start_target_alone(q);
      return;
    }
    const Predictions predictions =
        predictor_.predict(unknowns_.parameters(), q.head(unknowns_.parameter_count()), {},
                           progress_, {.targets = targets(q), .few_states = few_states_});
    if (predictions.failure) return;
    if (is_target_of_platform(0)) {
      start_frames_and_target(predictions, q);
      return;
    }
    for (std::size_t f = 0; f < unknowns_.frames().size(); ++f) {
      std::vector<spatial::Vector3> predicted, measured;
      for (std::size_t i = 0; i < campaign_.readings.size(); ++i) {
        const Reading& r = campaign_.readings[i];
        if (r.session != unknowns_.frames()[f]) continue;
        for (const auto& [axes, rows] : framed_) {
          const bool is_position = rows.size() >= 3 && axes[2] == 2 && r.uses(rows[0]) &&
                                   r.uses(rows[1]) && r.uses(rows[2]);
          if (!is_position) continue;
          predicted.push_back(predictions.displacement[i].segment<3>(rows[0]));
          measured.push_back(r.displacement.segment<3>(rows[0]));
        }
      }
      q.segment<6>(unknowns_.frame_at(f)) = frame_between(predicted, measured);
    }
    start_target_rotations(predictions, q);
  }

  bool is_target_of_platform(std::size_t target) const {
    return target < unknowns_.targets().size() && campaign_.reads_platform() &&
           unknowns_.targets()[target].sensor == 0;
  }

  // Differences show a target by rotations alone, and absolute poses linearly: from where it
  // stands.
  void start_target_alone(VectorXd& q) {
    const auto& targets = unknowns_.targets();
    if (std::none_of(targets.begin(), targets.end(),
                     [](const UnknownTarget& t) { return t.coordinates == 6; }))
      return;
    const Predictions predictions = predictor_.predict(
        unknowns_.parameters(), q.head(unknowns_.parameter_count()), false, progress_);
    if (!predictions.failure) start_target_rotations(predictions, q);
  }

  // The target and every session's frame by turns, as positions fit best.
  void start_frames_and_target(const Predictions& predictions, VectorXd& q) {
    std::vector<PlacedPosition> positions;
    for (std::size_t i = 0; i < campaign_.readings.size(); ++i) {
      const Reading& r = campaign_.readings[i];
      const auto f = unknowns_.frame_of(r.session);
      if (!f || !r.uses(0) || !r.uses(1) || !r.uses(2)) continue;
      positions.push_back({.frame = *f,
                           .predicted = predictions.displacement[i].head<3>(),
                           .axes = spatial::exp_rotation(predictions.displacement[i].tail<3>()),
                           .measured = r.displacement.head<3>()});
    }
    const FramesAndTarget start = frames_and_target(positions, unknowns_.frames().size());
    for (std::size_t f = 0; f < unknowns_.frames().size(); ++f)
      q.segment<6>(unknowns_.frame_at(f)) = start.frames[f];
    q.segment<3>(unknowns_.target_at(0)) = start.target;
    start_target_rotations(predictions, q);
  }

  // The first of three components, where a sensor has them all.
  std::optional<Index> rotations_of(std::size_t sensor) const {
    for (Index k = 0; k + 2 < campaign_.size(); ++k)
      if (campaign_.component(k).sensor == sensor && campaign_.component(k).axis == 3 &&
          campaign_.component(k + 2).sensor == sensor)
        return k;
    return std::nullopt;
  }

  void start_target_rotations(const Predictions& predictions, VectorXd& q) const {
    for (std::size_t t = 0; t < unknowns_.targets().size(); ++t)
      if (unknowns_.targets()[t].coordinates == 6) start_target_rotation(t, predictions, q);
  }

  // As the first reading with all three rotations has it.
  void start_target_rotation(std::size_t target, const Predictions& predictions,
                             VectorXd& q) const {
    const std::size_t sensor = unknowns_.targets()[target].sensor;
    const std::optional<Index> rotations = rotations_of(sensor);
    if (!rotations) return;
    const Index first = *rotations;
    for (std::size_t i = 0; i < campaign_.readings.size(); ++i) {
      const Reading& r = campaign_.readings[i];
      if (!r.uses(first) || !r.uses(first + 1) || !r.uses(first + 2)) continue;
      std::optional<std::size_t> f;
      if (campaign_.sensors[sensor].by_instrument) f = unknowns_.frame_of(r.session);
      const spatial::Matrix3 frame = f ? spatial::exp_rotation(unknowns_.frame(q, *f).tail<3>())
                                       : spatial::Matrix3::Identity();
      const spatial::Matrix3 seen =
          frame * spatial::exp_rotation(predictions.displacement[i].segment<3>(first));
      q.segment<3>(unknowns_.target_at(target) + 3) = spatial::log_rotation(
          seen.transpose() * spatial::exp_rotation(r.displacement.segment<3>(first)));
      return;
    }
  }

  double scale() const { return norm_over_noise(values_, campaign_, noise_); }

  [[noreturn]] void fail_prediction() const {
    if (!failure_) fail_beyond();
    const Reading& reading = campaign_.readings[failure_->reading];
    throw common::NoConvergence(
        fmt::format("{}:{}: the model has no equilibrium for reading '{}': {}. Check the load and "
                    "its unit, or mask the reading.",
                    campaign_.readings_file.string(), reading.line, reading.id, failure_->reason));
  }

 private:
  // Near those that were made last.
  Predictions predicted_with(const VectorXd& values, const std::vector<Parameter>& by,
                             const std::vector<TargetOffset>& targets, const ReadingTaker& take) {
    return predictor_.predict(unknowns_.parameters(), values, by, progress_,
                              {.near = similar_ != nullptr ? similar_ : &nearest_,
                               .targets = targets,
                               .without = without_,
                               .take = take,
                               .few_states = few_states_});
  }

  std::vector<TargetOffset> targets(const VectorXd& q) const {
    if (known_ != nullptr) return targets_of(*known_);
    std::vector<TargetOffset> result;
    for (std::size_t t = 0; t < unknowns_.targets().size(); ++t) {
      const auto& [sensor, coordinates] = unknowns_.targets()[t];
      result.push_back({.sensor = sensor, .differentiated = coordinates});
      result.back().pose.head(coordinates) = q.segment(unknowns_.target_at(t), coordinates);
    }
    return result;
  }

  // The first value whose error over its noise, or its derivative, is no number to compute with:
  // evidences and tests take fourth powers.
  std::optional<std::size_t> first_beyond(const Linearisation& at) const {
    constexpr double most = 1e75;
    for (Index row = 0; row < values(); ++row)
      if (!(std::abs(at.residual[row]) < most && at.jacobian.row(row).allFinite()))
        return static_cast<std::size_t>(row);
    return std::nullopt;
  }

  [[noreturn]] void fail_beyond() const {
    const auto& [reading, component] = values_[beyond_.value()];
    const Reading& r = campaign_.readings[reading];
    throw common::InputError(
        {.file = campaign_.readings_file,
         .line = r.line,
         .key = campaign_.component(component).name,
         .what = fmt::format("the error of reading '{}', {:.3g} less what the model says, is too "
                             "large to compute with over a noise of {:.3g} (SI)",
                             r.id, r.displacement[component], noise_.sigma[reading][component]),
         .cure = "Check the value, its unit and its noise, or mask the reading"});
  }

  // The last rows.
  void add_priors(const VectorXd& q, Linearisation& result) const {
    Index row = values();
    for (std::size_t k = 0; k < unknowns_.parameters().size(); ++k) {
      const auto i = static_cast<Index>(k);
      const auto& prior = unknowns_.parameters()[k].prior;
      if (!prior) continue;
      result.residual[row] = (q[i] - prior->mean) / prior->deviation;
      result.jacobian(row++, i) = 1 / prior->deviation;
    }
  }

  // Memory that one thread uses for reading after reading.
  struct Scratch {
    MatrixXd all, block;
    vjm::Matrix6X before, after;
    std::vector<Index> used;
  };

  // Fills the rows of one reading.
  void add_reading(const VectorXd& q, std::size_t i, VectorXd& predicted, Vector6& work,
                   const MatrixXd& by_parameters, Linearisation& result) const {
    thread_local Scratch scratch;
    auto& [all, block, before, after, used] = scratch;
    const Reading& reading = campaign_.readings[i];
    all.setZero(campaign_.size(), unknowns_.size());
    Index differentiated = 0;
    if (by_parameters.cols() > 0) {
      differentiated = by_parameters.cols() - unknowns_.target_components();
      all.leftCols(unknowns_.parameter_count()).rightCols(differentiated) =
          by_parameters.leftCols(differentiated);
      all.rightCols(unknowns_.target_components()) =
          by_parameters.rightCols(unknowns_.target_components());
    }
    add_frame(reading, predicted, work, scratch);
    add_zeros(q, reading, predicted, all);
    find_components_in_use(reading, used);
    const auto count = static_cast<Index>(used.size());
    if (count == 0) return;
    const Index columns = unknowns_.size() - unknowns_.parameter_count() + differentiated;
    block.resize(count, columns + 1);
    for (Index k = 0; k < count; ++k) {  // indices in Eigen's brackets would be copied
      const Index from = used[static_cast<std::size_t>(k)];
      block(k, 0) = predicted[from] - reading.displacement[from];
      block.row(k).tail(columns) = all.row(from).tail(columns);
    }
    noise_.whiten(i, used, block);
    const auto row = static_cast<Index>(first_row_[i]);
    result.residual.segment(row, count) = block.col(0);
    result.jacobian.middleRows(row, count).rightCols(columns) = block.rightCols(columns);
  }

  // Of all sessions that have one.
  void place_frames(const VectorXd& q) {
    frames_.assign(campaign_.sessions.size(), std::nullopt);
    for (std::size_t session = 0; session < frames_.size(); ++session) {
      const auto f = unknowns_.frame_of(session);
      const std::optional<Vector6> frame = f        ? unknowns_.frame(q, *f)
                                           : known_ ? known_frame(*known_, session)
                                                    : std::nullopt;
      if (frame) frames_[session].emplace(*frame);
    }
  }

  void add_frame(const Reading& reading, VectorXd& predicted, Vector6& work,
                 Scratch& scratch) const {
    auto& [all, block, before, after, used] = scratch;
    const auto f = unknowns_.frame_of(reading.session);
    const std::optional<MeasuringFrame>& frame = frames_[reading.session];
    if (!frame) return;
    work << frame->turn() * work.head<3>(), frame->turn() * work.tail<3>();
    for (const FramedComponents& of_sensor : framed_) {
      const auto& [axes, rows] = of_sensor;
      Vector6 displacement = Vector6::Zero(), measured = Vector6::Zero();
      displacement(axes) = predicted(rows);
      measured(axes) = reading.displacement(rows);
      const SeenFromFrame seen = frame->seen(displacement, campaign_.displacement, measured);
      predicted(rows) = seen.displacement(axes);
      if (!f) continue;
      for (const auto& [first, count] :
           {std::pair(Index{0}, unknowns_.parameter_count()),
            std::pair(unknowns_.target_at(0), unknowns_.target_components())}) {
        const auto columns = Eigen::seqN(first, count);
        before.setZero(6, count);
        before(axes, Eigen::all) = all(rows, columns);
        after.resize(6, count);
        after.noalias() = seen.by_displacement.lazyProduct(before);
        all(rows, columns) = after(axes, Eigen::all);
      }
      const Index n = unknowns_.frame_components();
      all(rows, Eigen::seqN(unknowns_.frame_at(*f), n)) =
          seen.by_frame(axes, Eigen::seqN(6 - n, n));
    }
  }

  void add_zeros(const VectorXd& q, const Reading& reading, VectorXd& predicted,
                 MatrixXd& all) const {
    for (Index k = 0; k < campaign_.size() && known_ != nullptr; ++k)
      predicted[k] += known_zero(*known_, reading.session, k).value_or(0);
    for (std::size_t z = 0; z < unknowns_.zeros().size(); ++z) {
      const Zero& zero = unknowns_.zeros()[z];
      if (reading.session != zero.session) continue;
      predicted[zero.component] += q[unknowns_.zero_at(z)];
      all(zero.component, unknowns_.zero_at(z)) = 1;
    }
  }

  const Predictor& predictor_;
  const Campaign& campaign_;
  const Noise& noise_;
  const BaseFit* known_;  // of the sessions that it knows, or nullptr
  std::vector<Value> values_;
  std::vector<std::size_t> first_row_;  // of each reading
  SharedNoise shared_;
  Unknowns unknowns_;
  common::Progress& progress_;
  std::vector<FramedComponents> framed_;
  std::vector<VectorXd> predicted_;       // of the last residual
  std::vector<Vector6> work_;             // the same
  Predictions nearest_;                   // that were made last
  const Predictions* similar_ = nullptr;  // of a similar model, as long as none were made
  const CondensedModel* without_ = nullptr;
  bool few_states_ = false;
  std::vector<std::optional<MeasuringFrame>> frames_;  // one a session
  VectorXd predicted_at_;
  std::optional<PredictionFailure> failure_;
  std::optional<std::size_t> beyond_;  // of values_
};

void require_enough_values(const Problem& problem) {
  // What is held, as design fixes it, needs no reading.
  const auto& parameters = problem.unknowns().parameters();
  const Index unknowns =
      problem.unknowns().size() - std::count_if(parameters.begin(), parameters.end(),
                                                [](const Parameter& p) { return p.is_held(); });
  if (problem.values() > unknowns || unknowns == 0) return;
  throw common::NotIdentifiable(
      fmt::format("{} measured values for {} unknowns (parameters, zero offsets and frames) leave "
                  "nothing to judge the fit by. Measure more, or declare less uncertain.",
                  problem.values(), unknowns));
}

void require_bounded(const Problem& problem, const LeastSquaresResult& result) {
  for (std::size_t k = 0; k < problem.unknowns().parameters().size(); ++k) {
    const Parameter& parameter = problem.unknowns().parameters()[k];
    if (result.hit[k] == BoundHit::none || parameter.bounds_stated) continue;
    const bool up = result.hit[k] == BoundHit::upper;
    throw common::NotIdentifiable(
        fmt::format("{} cannot be determined, its best value is {}: these readings {}. Check units "
                    "and signs of load and displacement, seek the missing effect with 'diagnose', "
                    "or take it out of 'uncertain' in the robot file.",
                    parameter.phrase(), up ? "infinite" : "0",
                    up ? "show no such compliance" : "are larger than any spring explains"));
  }
}

LeastSquaresOptions options_for(const Problem& problem, const BaseFitOptions& options) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  const Index n = problem.unknowns().size();
  LeastSquaresOptions result{.max_iterations = options.max_iterations,
                             .tolerance = options.tolerance,
                             .least_gain = options.least_gain,
                             .scale = problem.scale(),
                             .lower = VectorXd::Constant(n, -infinity),
                             .upper = VectorXd::Constant(n, infinity),
                             .longest_step = VectorXd::Constant(n, infinity),
                             .loss = options.loss,
                             .first_damping = 0};
  for (std::size_t k = 0; k < problem.unknowns().parameters().size(); ++k) {
    const Parameter& parameter = problem.unknowns().parameters()[k];
    const auto i = static_cast<Index>(k);
    result.lower[i] = parameter.lower;
    result.upper[i] = parameter.upper;
    result.longest_step[i] = parameter.longest_step;
  }
  return result;
}

// Coordinates of frames and of the target stay as stated that no reading tells from those before
// them: what is measured in a plane does not depend on turns about axes in it, and a target that
// never turns may as well be another place of the frame.
void hold_undetermined_frames(Problem& problem, const VectorXd& start,
                              LeastSquaresOptions& options) {
  constexpr double alike = 1e-6;
  const Unknowns& unknowns = problem.unknowns();
  if (!unknowns.has_poses()) return;
  std::optional<Linearisation> there = problem.at(start, 0);
  if (!there) return;  // which the fit says better
  const Index first = unknowns.frame_at(0);
  const MatrixXd signatures = condensed(there->jacobian.rightCols(unknowns.size() - first));
  there.reset();
  const VectorXd least =
      (alike * signatures.colwise().norm()).cwiseMax(sensitivity_rounding * problem.scale());
  for (const Index k : made_up_by_those_before(signatures, least))
    options.lower[first + k] = options.upper[first + k] = start[first + k];
}

LeastSquaresResult solve(Problem& problem, const BaseFitOptions& options) {
  const auto residuals = [&problem](const VectorXd& q) { return problem.at(q); };
  VectorXd start = problem.start();
  try {
    problem.start_frames(start);
  } catch (const std::invalid_argument&) {  // values that exclude each other: the fit says so
  }
  LeastSquaresOptions within = options_for(problem, options);
  hold_undetermined_frames(problem, start, within);
  LeastSquaresResult result = minimise(residuals, start, within);
  if (result.status == LeastSquaresStatus::no_start) problem.fail_prediction();
  require_bounded(problem, result);
  require_identifiable(problem.unknowns().names(), result.at.jacobian, result.free(),
                       problem.scale());
  if (result.status != LeastSquaresStatus::converged && !options.accept_unsettled)
    throw common::NoConvergence(fmt::format(
        "the fit of the uncertain parameters did not converge: {} after {} "
        "evaluations of the model",
        result.status == LeastSquaresStatus::stalled ? "no step makes it better" : "it still moves",
        result.iterations));
  return result;
}

// By which the inverse of J'J is multiplied to be a covariance: 1 with a known noise. For a robust
// loss, Huber's (1973) correction for the information that the loss gives up.
double variance_of(const LeastSquaresResult& result, Loss loss, bool noise_known, Index freedom) {
  const double n = static_cast<double>(result.at.residual.size());
  if (loss == Loss::squares)
    return noise_known ? 1 : result.at.residual.squaredNorm() / static_cast<double>(freedom);
  double squares = 0, slopes = 0;
  for (Index i = 0; i < result.at.residual.size(); ++i) {
    const double r = result.at.residual[i];
    squares += std::pow(result.weights[i] * r, 2);
    slopes += influence_slope(loss, r);
  }
  return squares / static_cast<double>(freedom) / std::pow(slopes / n, 2);
}

void require_usable_noise(const Campaign& campaign, const Noise& noise, bool has_parameters,
                          Loss loss) {
  if (!noise.comparable && has_parameters)
    throw common::InputError(
        {.file = campaign.file,
         .key = "noise",
         .what = "translations and rotations cannot be fitted together, because nothing says how "
                 "exact either is",
         .cure = "State 'noise: {translation: ..., rotation: ...}', or repeat readings"});
  if (loss != Loss::squares && noise.source == NoiseSource::unknown)
    throw common::InputError(
        {.file = campaign.file,
         .key = "noise",
         .what = "a robust fit must know how large the noise is, to distinguish an outlier from it",
         .cure = "State 'noise: {translation: ...}', or repeat readings"});
}

// Estimates with their standard errors from the solution.
class Estimates {
 public:
  Estimates(const Unknowns& unknowns, const LeastSquaresResult& result, const MatrixXd& covariance)
      : unknowns_(unknowns), result_(result), errors_(covariance.diagonal().cwiseSqrt()) {}

  void add_to(BaseFit& fit) const {
    for (std::size_t k = 0; k < unknowns_.parameters().size(); ++k) {
      const auto i = static_cast<Index>(k);
      fit.parameters.push_back(
          {unknowns_.parameters()[k], result_.x[i], errors_[i], result_.hit[k]});
    }
    fit.zeros = unknowns_.zeros();
    for (std::size_t z = 0; z < fit.zeros.size(); ++z) {
      fit.zeros[z].value = result_.x[unknowns_.zero_at(z)];
      fit.zeros[z].standard_error = errors_[unknowns_.zero_at(z)];
    }
    for (std::size_t f = 0; f < unknowns_.frames().size(); ++f) add_frame(f, fit);
    for (std::size_t t = 0; t < unknowns_.targets().size(); ++t) add_target(t, fit);
  }

 private:
  void add_frame(std::size_t f, BaseFit& fit) const {
    const Index n = unknowns_.frame_components();
    const Vector6 unknown = Vector6::Constant(std::numeric_limits<double>::quiet_NaN());
    FrameEstimate frame{unknowns_.frames()[f], unknown, unknown};
    frame.value.tail(n) = result_.x.segment(unknowns_.frame_at(f), n);
    frame.standard_error.tail(n) = errors_.segment(unknowns_.frame_at(f), n);
    for (Index k = 0; k < n; ++k)
      if (result_.hit[static_cast<std::size_t>(unknowns_.frame_at(f) + k)] != BoundHit::none)
        frame.standard_error[6 - n + k] = std::numeric_limits<double>::quiet_NaN();
    fit.frames.push_back(frame);
  }

  void add_target(std::size_t t, BaseFit& fit) const {
    const Vector6 unknown = Vector6::Constant(std::numeric_limits<double>::quiet_NaN());
    TargetEstimate target{unknowns_.targets()[t].sensor, unknown, unknown};
    for (Index k = 0; k < unknowns_.targets()[t].coordinates; ++k) {
      const Index i = unknowns_.target_at(t) + k;
      target.value[k] = result_.x[i];
      if (result_.hit[static_cast<std::size_t>(i)] == BoundHit::none)
        target.standard_error[k] = errors_[i];
    }
    fit.targets.push_back(target);
  }

  const Unknowns& unknowns_;
  const LeastSquaresResult& result_;
  VectorXd errors_;
};

// Solves the problem and says what is known of it.
BaseFit fitted(Problem& problem, const Noise& noise, const BaseFitOptions& options) {
  LeastSquaresResult result = solve(problem, options);
  const std::vector<Index> free = result.free();
  BaseFit fit;
  fit.estimated = static_cast<Index>(free.size());
  fit.values = problem.values();
  fit.squared_error = result.at.residual.head(fit.values).squaredNorm();
  fit.iterations = result.iterations;
  fit.is_settled = result.status == LeastSquaresStatus::converged;
  fit.loss = options.loss;
  fit.weights.assign(result.weights.begin(), result.weights.begin() + fit.values);
  const double variance = variance_of(result, options.loss, noise.source != NoiseSource::unknown,
                                      fit.degrees_of_freedom());
  fit.covariance = variance * inverse_normal_matrix(result.at.jacobian, free);
  fit.error_source = noise.source;
  fit.weak = weak_sentences(problem.unknowns().names(), weak_combinations(result.at.jacobian, free),
                            std::sqrt(variance));
  Estimates(problem.unknowns(), result, fit.covariance).add_to(fit);
  std::tie(fit.predicted, fit.work) = problem.take_predicted(result.x);
  fit.model = problem.take_nearest();
  fit.at = std::move(result.at);
  if (problem.priors() > 0) {
    fit.at.residual.conservativeResize(fit.values);
    fit.at.jacobian.conservativeResize(fit.values, Eigen::NoChange);
  }
  for (Index k = problem.unknowns().frame_at(0); k < problem.unknowns().size(); ++k)
    if (result.hit[static_cast<std::size_t>(k)] != BoundHit::none) fit.at.jacobian.col(k).setZero();
  return fit;
}

}  // namespace

std::optional<Vector6> known_frame(const BaseFit& fit, std::size_t session) {
  for (const FrameEstimate& frame : fit.frames)
    if (frame.session == session)
      return frame.value.unaryExpr([](double x) { return std::isnan(x) ? 0 : x; });
  return std::nullopt;
}

std::vector<TargetOffset> targets_of(const BaseFit& fit) {
  std::vector<TargetOffset> result;
  for (const TargetEstimate& target : fit.targets)
    result.push_back({.sensor = target.sensor, .pose = target.value.unaryExpr([](double x) {
                        return std::isnan(x) ? 0 : x;
                      })});
  return result;
}

double norm_over_noise(const std::vector<Value>& values, const Campaign& campaign,
                       const Noise& noise) {
  double sum = 0;
  for (const auto& [reading, component] : values)
    sum += std::pow(
        campaign.readings[reading].displacement[component] / noise.sigma[reading][component], 2);
  return std::sqrt(sum);
}

VectorXd values_of(const BaseFit& fit) {
  VectorXd values(static_cast<Index>(fit.parameters.size()));
  for (std::size_t k = 0; k < fit.parameters.size(); ++k)
    values[static_cast<Index>(k)] = fit.parameters[k].value;
  return values;
}

std::vector<Parameter> held_parameters(const BaseFit& fit) {
  std::vector<Parameter> parameters;
  for (const ParameterEstimate& e : fit.parameters) {
    parameters.push_back(e.parameter);
    parameters.back().start = parameters.back().lower = parameters.back().upper = e.value;
    parameters.back().bounds_stated = true;
    parameters.back().prior.reset();
  }
  return parameters;
}

BaseFit fit_base(const Predictor& predictor, const Campaign& campaign, const Noise& noise,
                 const std::vector<Parameter>& parameters, common::Progress& progress,
                 const BaseFitOptions& options) {
  require_usable_noise(campaign, noise, !parameters.empty(), options.loss);
  Problem problem(predictor, campaign, noise, parameters, nullptr, progress);
  if (options.near != nullptr) problem.begin_near(*options.near);
  if (options.few_states) problem.keep_few_states();
  require_enough_values(problem);
  return fitted(problem, noise, options);
}

namespace {

// The problem of fit_condensed(): the exact parameters are the last, and `order` says of which
// parameter each is.
class RoughProblem {
 public:
  RoughProblem(Problem& problem, const BaseFit& fit, const std::vector<std::size_t>& order,
               Index exact)
      : problem_(problem),
        parameters_(problem.unknowns().parameters()),
        rough_(std::ssize(parameters_) - exact),
        start_(problem.start()),
        by_rough_(problem.values(), rough_) {
    problem.place_as(fit, start_);
    for (Index k = 0; k < rough_; ++k)
      by_rough_.col(k) =
          fit.at.jacobian.col(static_cast<Index>(order[static_cast<std::size_t>(k)]));
  }

  const VectorXd& start() const { return start_; }

  std::optional<Linearisation> at(const VectorXd& q) const {
    const Index n = problem_.values(), all = std::ssize(parameters_);
    VectorXd there = start_;
    there.segment(rough_, all - rough_) = q.segment(rough_, all - rough_);
    auto result = problem_.at(there, all - rough_);
    if (!result) return std::nullopt;
    const VectorXd change = q - there;
    result->residual += result->jacobian * change;  // priors, zero offsets, frames, targets
    for (Index k = 0; k < rough_; ++k) {
      const bool is_stiffness = parameters_[static_cast<std::size_t>(k)].is_logarithm();
      const double moved = is_stiffness ? -std::expm1(-change[k]) : change[k];
      const double slope = is_stiffness ? std::exp(-change[k]) : 1;
      result->residual.head(n) += moved * by_rough_.col(k);
      result->jacobian.col(k).head(n) = slope * by_rough_.col(k);
    }
    return result;
  }

 private:
  Problem& problem_;
  const std::vector<Parameter>& parameters_;
  Index rough_;  // so many are not exact
  VectorXd start_;
  MatrixXd by_rough_;
};

// Of parameters of which the first `fitted` are those of a fit; what is exact comes last.
std::vector<std::size_t> rough_before_exact(std::size_t count, std::size_t fitted,
                                            std::optional<std::size_t> own) {
  std::vector<std::size_t> order;
  for (std::size_t k = 0; k < fitted; ++k)
    if (k != own) order.push_back(k);
  if (own) order.push_back(*own);
  for (std::size_t k = fitted; k < count; ++k) order.push_back(k);
  return order;
}

}  // namespace

std::optional<CondensedFit> fit_condensed(const Predictor& predictor, const Campaign& campaign,
                                          const Noise& noise,
                                          const std::vector<Parameter>& parameters,
                                          std::optional<std::size_t> own, const BaseFit& fitted,
                                          const CondensedModel& condensed,
                                          common::Progress& progress) {
  constexpr double visible = 0.3;  // of all readings together, in units of the noise
  const std::vector<std::size_t> order =
      rough_before_exact(parameters.size(), fitted.parameters.size(), own);
  std::vector<Parameter> ordered;
  ordered.reserve(order.size());
  for (const std::size_t k : order) ordered.push_back(parameters[k]);
  Problem problem(predictor, campaign, noise, ordered, nullptr, progress);
  problem.begin_near(fitted.model, &condensed);
  const auto exact =
      std::ssize(parameters) - std::ssize(fitted.parameters) + static_cast<Index>(own.has_value());
  const RoughProblem rough(problem, fitted, order, exact);
  const LeastSquaresOptions options =
      options_for(problem, {.max_iterations = 60, .tolerance = visible / problem.scale()});
  const LeastSquaresResult found =
      minimise([&](const VectorXd& q) { return rough.at(q); }, rough.start(), options);
  if (found.status == LeastSquaresStatus::no_start) return std::nullopt;
  CondensedFit result{VectorXd(std::ssize(parameters)), found.cost};
  for (std::size_t k = 0; k < order.size(); ++k)
    result.values[static_cast<Index>(order[k])] = found.x[static_cast<Index>(k)];
  return result;
}

BaseFit predict_others(const Predictor& predictor, const Campaign& others, const Noise& noise,
                       const BaseFit& fit, common::Progress& progress) {
  const std::vector<Parameter> parameters = held_parameters(fit);
  Problem problem(predictor, others, noise, parameters, &fit, progress);
  return fitted(problem, noise, {});
}

std::optional<Linearisation> linearised_at(const Predictor& predictor, const Campaign& campaign,
                                           const Noise& noise,
                                           const std::vector<Parameter>& parameters,
                                           const VectorXd& values, const BaseFit& fit,
                                           Index differentiated, common::Progress& progress,
                                           const CondensedModel* without) {
  Problem problem(predictor, campaign, noise, parameters, nullptr, progress);
  problem.begin_near(fit.model, without);
  const Unknowns& unknowns = problem.unknowns();
  VectorXd q(unknowns.size());
  q.head(values.size()) = values;
  problem.place_as(fit, q);
  std::optional<Linearisation> result = problem.at(q, differentiated);
  if (!result) return std::nullopt;
  return Linearisation{result->residual.head(problem.values()),
                       result->jacobian.topRows(problem.values())};
}

}  // namespace kinetostat::calibration
