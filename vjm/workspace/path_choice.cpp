#include "kinetostat/vjm/workspace/path_choice.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "kinetostat/common/parallel.h"
#include "kinetostat/spatial/rotation.h"
#include "kinetostat/vjm/manipulator/joint_place.h"
#include "kinetostat/vjm/manipulator/posture.h"

namespace kinetostat::vjm {
namespace {

using spatial::Pose;
using spatial::Vector3;

// The score of what is not reached.
constexpr double lost = -std::numeric_limits<double>::infinity();

// Values from first to last.
std::vector<double> grid(double from, double to, int steps) {
  std::vector<double> values;
  values.reserve(static_cast<std::size_t>(steps));
  for (int k = 0; k < steps; ++k)
    values.push_back(steps == 1 ? from : from + (to - from) * k / (steps - 1));
  return values;
}

// The logarithm of an index, or of one over it; nothing is worse than what has none.
double score(double value, bool more_is_better) {
  if (!(value > 0)) return lost;
  return more_is_better ? std::log(value) : -std::log(value);
}

// Scores of poses (rows) by candidates (columns).
using Scores = Eigen::MatrixXd;

// What is tried at the poses of a path: values of the turn, then of the joints (rows), by
// candidates (columns), and the pose of each, pose by pose.
struct Candidates {
  std::vector<Eigen::MatrixXd> values;
  std::vector<TargetPose> poses;
  Eigen::VectorXd largest_change;

  std::size_t count() const { return static_cast<std::size_t>(values.front().cols()); }
  const TargetPose& pose(std::size_t i, std::size_t k) const { return poses[i * count() + k]; }
  // Whether candidate `after` of a pose may follow `before` of the one before it.
  bool may_follow(std::size_t pose, std::size_t before, std::size_t after) const {
    const auto j = static_cast<Eigen::Index>(before), k = static_cast<Eigen::Index>(after);
    for (Eigen::Index a = 0; a < largest_change.size(); ++a)
      if (!(std::abs(values[pose](a, k) - values[pose - 1](a, j)) <=
            largest_change[a] * (1 + 1e-12)))
        return false;
    return true;
  }
};

// Tries what is free at one pose.
class PoseCandidates {
 public:
  PoseCandidates(const Manipulator& manipulator, const PathFreedom& freedom)
      : manipulator_(manipulator), freedom_(freedom) {
    turns_ = freedom.turn ? grid(freedom.turn->from, freedom.turn->to, freedom.turn->steps)
                          : std::vector<double>{0};
    joints_.emplace_back(0);
    for (const FreeJoint& joint : freedom.joints) {
      std::vector<Eigen::VectorXd> longer;
      for (const Eigen::VectorXd& values : joints_)
        for (const double value : grid(joint.from, joint.to, joint.steps)) {
          longer.emplace_back(values.size() + 1);
          longer.back() << values, value;
        }
      joints_ = std::move(longer);
    }
  }

  std::size_t count() const {
    return turns_.size() * (joints_.size() + (freedom_.joints.empty() ? 0 : 1));
  }

  // All candidates of a pose from number `first` on.
  Eigen::MatrixXd fill(const TargetPose& target, TargetPose* first) const {
    Eigen::MatrixXd values(1 + static_cast<Eigen::Index>(freedom_.joints.size()),
                           static_cast<Eigen::Index>(count()));
    Eigen::Index column = 0;
    for (const double turn : turns_) {
      const TargetPose there = freedom_.turn ? turned(target, freedom_.turn->axis, turn) : target;
      const auto add = [&](const Eigen::VectorXd& joints) {
        values.col(column++) << turn, joints;
        *first++ = holding(there, joints);
      };
      // Where nothing is held they may stand beyond what is tried: another value twice, then.
      if (!freedom_.joints.empty()) add(standing(there).value_or(joints_.front()));
      for (const Eigen::VectorXd& joints : joints_) add(joints);
    }
    return values;
  }

 private:
  TargetPose holding(TargetPose pose, const Eigen::VectorXd& values) const {
    for (std::size_t j = 0; j < freedom_.joints.size(); ++j)
      pose.held[freedom_.joints[j].name] = values[static_cast<Eigen::Index>(j)];
    return pose;
  }

  // Where the free joints stand when nothing holds them, if that is within what is tried.
  std::optional<Eigen::VectorXd> standing(const TargetPose& pose) const {
    const PostureResult found = posture_holding(manipulator_, pose.platform, pose.held);
    if (!found.reached) return std::nullopt;
    Eigen::VectorXd values(static_cast<Eigen::Index>(freedom_.joints.size()));
    for (std::size_t j = 0; j < freedom_.joints.size(); ++j) {
      const FreeJoint& joint = freedom_.joints[j];
      const JointPlace place = find_joint(manipulator_, joint.name);
      double value = found.posture.coordinates[place.chain][place.coordinate];
      constexpr double turn = 2 * std::numbers::pi;
      if (is_rotation(coordinate_at(manipulator_, place).motion))
        value -= turn * std::round((value - 0.5 * (joint.from + joint.to)) / turn);
      if (!(value >= joint.from && value <= joint.to)) return std::nullopt;
      values[static_cast<Eigen::Index>(j)] = value;
    }
    return values;
  }

  const Manipulator& manipulator_;
  const PathFreedom& freedom_;
  std::vector<double> turns_;
  std::vector<Eigen::VectorXd> joints_;  // combinations of their values
};

Candidates candidates_of(const Manipulator& manipulator, const std::vector<TargetPose>& targets,
                         const PathFreedom& freedom, const Pose& placement, int threads,
                         common::Progress& progress) {
  const PoseCandidates at_pose(manipulator, freedom);
  Candidates result;
  result.values.resize(targets.size());
  result.poses.resize(targets.size() * at_pose.count());
  common::parallel_for(targets.size(), threads, "postures", progress, [&](std::size_t i) {
    result.values[i] =
        at_pose.fill(seen_from(targets[i], placement), result.poses.data() + i * at_pose.count());
  });
  result.largest_change.setConstant(1 + static_cast<Eigen::Index>(freedom.joints.size()), -lost);
  if (freedom.turn) result.largest_change[0] = freedom.turn->largest_change;
  for (std::size_t j = 0; j < freedom.joints.size(); ++j)
    result.largest_change[static_cast<Eigen::Index>(j + 1)] = freedom.joints[j].largest_change;
  return result;
}

// Along the path the best of all ways, by what joins the worth of the way so far and of a pose.
template <class Join>
struct Ways {
  Eigen::MatrixXd worth;
  std::vector<std::vector<std::size_t>> from;

  Ways(const Scores& scores, const Candidates& candidates, const Join& join) : worth(scores) {
    const auto count = static_cast<std::size_t>(scores.cols());
    from.assign(static_cast<std::size_t>(scores.rows()), std::vector<std::size_t>(count, 0));
    for (Eigen::Index i = 1; i < scores.rows(); ++i)
      for (std::size_t k = 0; k < count; ++k) {
        double best = lost;
        std::size_t& before = from[static_cast<std::size_t>(i)][k];
        for (std::size_t j = 0; j < count; ++j)
          if (worth(i - 1, static_cast<Eigen::Index>(j)) > best &&
              candidates.may_follow(static_cast<std::size_t>(i), j, k))
            best = worth(i - 1, static_cast<Eigen::Index>(j)), before = j;
        worth(i, static_cast<Eigen::Index>(k)) =
            join(best, scores(i, static_cast<Eigen::Index>(k)));
      }
  }

  double best() const { return worth.bottomRows<1>().maxCoeff(); }
  std::vector<std::size_t> way() const {
    Eigen::Index last = 0;
    worth.bottomRows<1>().maxCoeff(&last);
    std::vector<std::size_t> result(from.size());
    auto at = static_cast<std::size_t>(last);
    for (std::size_t i = from.size(); i-- > 0;) {
      result[i] = at;
      at = from[i][at];
    }
    return result;
  }
};

double worst_of_both(double so_far, double pose) { return std::min(so_far, pose); }
double sum_of_both(double so_far, double pose) { return so_far + pose; }

// The candidates of the best way with the best worst pose, and how good that is.
std::pair<std::vector<std::size_t>, std::array<double, 2>> best_way(Scores scores,
                                                                    const Candidates& candidates) {
  const Ways by_worst(scores, candidates, worst_of_both);
  const double worst = by_worst.best();
  if (worst == lost) {  // some pose is: as few as can be, the others as good as can be
    constexpr double as_bad = -1e6;
    const Ways by_sum(scores.cwiseMax(as_bad), candidates, sum_of_both);
    return {by_sum.way(), {worst, by_sum.best()}};
  }
  const double enough = worst - 1e-12 * std::abs(worst);
  scores = (scores.array() < enough).select(lost, scores);
  const Ways by_sum(scores, candidates, sum_of_both);
  return {by_sum.way(), {worst, by_sum.best()}};
}

// A direction is one of the path, not of the robot.
MapIndex index_seen_from(const MapIndex& index, const Pose& base) {
  MapIndex seen = index;
  seen.direction = base.rotation().transpose() * index.direction;
  return seen;
}

Scores scores_of(const Manipulator& manipulator, const Candidates& candidates,
                 const MapIndex& index, int threads, common::Progress& progress) {
  const std::vector<MapPoint> points =
      workspace_map(manipulator, candidates.poses, {index}, threads, progress);
  const std::size_t count = candidates.count();
  Scores scores(candidates.values.size(), count);
  for (std::size_t n = 0; n < points.size(); ++n)
    scores(static_cast<Eigen::Index>(n / count), static_cast<Eigen::Index>(n % count)) =
        score(points[n].values.front(), is_more_better(index.kind));
  return scores;
}

PathChoice choice_of(const Candidates& candidates, const std::vector<std::size_t>& way,
                     const PathFreedom& freedom) {
  PathChoice choice;
  choice.joints.resize(freedom.joints.size());
  for (std::size_t i = 0; i < way.size(); ++i) {
    choice.poses.push_back(candidates.pose(i, way[i]));
    const Eigen::VectorXd values = candidates.values[i].col(static_cast<Eigen::Index>(way[i]));
    if (freedom.turn) choice.turns.push_back(values[0]);
    for (std::size_t j = 0; j < choice.joints.size(); ++j)
      choice.joints[j].push_back(values[static_cast<Eigen::Index>(j + 1)]);
  }
  return choice;
}

}  // namespace

bool is_more_better(MapIndex::Kind kind) {
  return kind != MapIndex::Kind::deflection && kind != MapIndex::Kind::rotation &&
         kind != MapIndex::Kind::condition;
}

TargetPose turned(const TargetPose& pose, const Vector3& axis, double angle) {
  const spatial::Matrix3 turn = spatial::exp_rotation(angle * axis);
  TargetPose result = pose;
  result.platform = Pose(pose.platform.rotation() * turn, pose.platform.position());
  result.load.point_on_platform = turn.transpose() * pose.load.point_on_platform;
  return result;
}

TargetPose seen_from(const TargetPose& pose, const Pose& base) {
  const spatial::Matrix3 back = base.rotation().transpose();
  TargetPose result = pose;
  result.platform = base.inverse() * pose.platform;
  result.load.force = back * pose.load.force;
  result.load.moment = back * pose.load.moment;
  return result;
}

double candidates_per_pose(const PathFreedom& freedom) {
  double joints = 1;
  for (const FreeJoint& joint : freedom.joints) joints *= joint.steps;
  if (!freedom.joints.empty()) joints += 1;
  return (freedom.turn ? freedom.turn->steps : 1) * joints;
}

PathChoice best_path(const Manipulator& manipulator, const std::vector<TargetPose>& targets,
                     const MapIndex& index, const PathFreedom& freedom, int threads,
                     common::Progress& progress) {
  if (freedom.placements.empty() || targets.empty())
    throw std::invalid_argument("a path needs a pose and a place for the robot");
  const bool more = is_more_better(index.kind);
  PathChoice best;
  std::array<double, 2> worth{lost, lost};
  for (std::size_t p = 0; p < freedom.placements.size(); ++p) {
    const Pose& placement = freedom.placements[p];
    const Candidates candidates =
        candidates_of(manipulator, targets, freedom, placement, threads, progress);
    const auto [way, worth_of_it] = best_way(
        scores_of(manipulator, candidates, index_seen_from(index, placement), threads, progress),
        candidates);
    if (p > 0 && !(worth_of_it > worth)) continue;
    worth = worth_of_it;
    best = choice_of(candidates, way, freedom);
    best.placement = p;
  }
  best.worst = worth[0] == lost ? std::numeric_limits<double>::quiet_NaN()
                                : std::exp(more ? worth[0] : -worth[0]);
  return best;
}

JointStep largest_turn(const Manipulator& manipulator, const std::vector<TargetPose>& path) {
  JointStep largest;
  std::optional<Posture> before;
  for (std::size_t i = 0; i < path.size(); ++i) {
    const PostureResult now = posture_holding(manipulator, path[i].platform, path[i].held);
    for (const JointPlace& place : actuated_joints(manipulator)) {
      if (!before || !now.reached || !is_rotation(coordinate_at(manipulator, place).motion))
        continue;
      const double change = std::remainder(now.posture.coordinates[place.chain][place.coordinate] -
                                               before->coordinates[place.chain][place.coordinate],
                                           2 * std::numbers::pi);
      if (std::abs(change) >= std::abs(largest.change))
        largest = {full_name(manipulator, place), change, i};
    }
    before = now.reached ? std::optional(now.posture) : std::nullopt;
  }
  return largest;
}

}  // namespace kinetostat::vjm
