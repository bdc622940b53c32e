#include "kinetostat/vjm/workspace/path_choice.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "kinetostat/spatial/rotation.h"

namespace kinetostat::vjm {
namespace {

using spatial::Pose;
using spatial::Vector3;

// The score of what is not reached.
constexpr double lost = -std::numeric_limits<double>::infinity();

// The values of a turn that are tried; one, of no turn, where none is free.
std::vector<double> values_of(const std::optional<FreeTurn>& turn) {
  if (!turn) return {0};
  std::vector<double> values;
  values.reserve(static_cast<std::size_t>(turn->steps));
  for (int k = 0; k < turn->steps; ++k)
    values.push_back(turn->steps == 1
                         ? turn->from
                         : turn->from + (turn->to - turn->from) * k / (turn->steps - 1));
  return values;
}

// The logarithm of an index, or of one over it; nothing is worse than what has none.
double score(double value, bool more_is_better) {
  if (!(value > 0)) return lost;
  return more_is_better ? std::log(value) : -std::log(value);
}

// Scores of poses (rows) by turns (columns).
using Scores = Eigen::MatrixXd;

// Which turns may follow each other.
struct Neighbours {
  std::vector<double> values;
  double largest_change = -lost;

  bool may_follow(std::size_t before, std::size_t after) const {
    return std::abs(values[after] - values[before]) <= largest_change * (1 + 1e-12);
  }
};

// Along the path the best of all ways, by what joins the worth of the way so far and of a pose.
template <class Join>
struct Ways {
  Eigen::MatrixXd worth;
  std::vector<std::vector<std::size_t>> from;

  Ways(const Scores& scores, const Neighbours& turns, const Join& join) : worth(scores) {
    const auto count = static_cast<std::size_t>(scores.cols());
    from.assign(static_cast<std::size_t>(scores.rows()), std::vector<std::size_t>(count, 0));
    for (Eigen::Index i = 1; i < scores.rows(); ++i)
      for (std::size_t k = 0; k < count; ++k) {
        double best = lost;
        std::size_t& before = from[static_cast<std::size_t>(i)][k];
        for (std::size_t j = 0; j < count; ++j)
          if (turns.may_follow(j, k) && worth(i - 1, static_cast<Eigen::Index>(j)) > best)
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

// The turns of the best way with the best worst pose, and how good that is.
std::pair<std::vector<std::size_t>, std::array<double, 2>> best_way(Scores scores,
                                                                    const Neighbours& turns) {
  const Ways by_worst(scores, turns, worst_of_both);
  const double worst = by_worst.best();
  if (worst == lost) {  // some pose is: as few as can be, the others as good as can be
    constexpr double as_bad = -1e6;
    const Ways by_sum(scores.cwiseMax(as_bad), turns, sum_of_both);
    return {by_sum.way(), {worst, by_sum.best()}};
  }
  const double enough = worst - 1e-12 * std::abs(worst);
  scores = (scores.array() < enough).select(lost, scores);
  const Ways by_sum(scores, turns, sum_of_both);
  return {by_sum.way(), {worst, by_sum.best()}};
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

PathChoice best_path(const Manipulator& manipulator, const std::vector<TargetPose>& targets,
                     const MapIndex& index, const std::optional<FreeTurn>& turn,
                     const std::vector<Pose>& placements, int threads, common::Progress& progress) {
  if (placements.empty() || targets.empty())
    throw std::invalid_argument("a path needs a pose and a place for the robot");
  const Neighbours turns{values_of(turn), turn ? turn->largest_change : -lost};
  const bool more = is_more_better(index.kind);
  const auto pose_of = [&](std::size_t placement, std::size_t i, std::size_t k) {
    const TargetPose there = seen_from(targets[i], placements[placement]);
    return turn ? turned(there, turn->axis, turns.values[k]) : there;
  };
  PathChoice best;
  std::array<double, 2> worth{lost, lost};
  for (std::size_t p = 0; p < placements.size(); ++p) {
    std::vector<TargetPose> all;
    for (std::size_t i = 0; i < targets.size(); ++i)
      for (std::size_t k = 0; k < turns.values.size(); ++k) all.push_back(pose_of(p, i, k));
    MapIndex seen = index;  // a direction is one of the path, not of the robot
    seen.direction = placements[p].rotation().transpose() * index.direction;
    const std::vector<MapPoint> points = workspace_map(manipulator, all, {seen}, threads, progress);
    Scores scores(targets.size(), turns.values.size());
    for (std::size_t n = 0; n < points.size(); ++n)
      scores(static_cast<Eigen::Index>(n / turns.values.size()),
             static_cast<Eigen::Index>(n % turns.values.size())) =
          score(points[n].values.front(), more);
    const auto [way, worth_of_it] = best_way(std::move(scores), turns);
    if (p > 0 && !(worth_of_it > worth)) continue;
    worth = worth_of_it;
    best = {};
    best.placement = p;
    for (std::size_t i = 0; i < targets.size(); ++i) {
      best.poses.push_back(pose_of(p, i, way[i]));
      if (turn) best.turns.push_back(turns.values[way[i]]);
    }
  }
  best.worst = worth[0] == lost ? std::numeric_limits<double>::quiet_NaN()
                                : std::exp(more ? worth[0] : -worth[0]);
  return best;
}

}  // namespace kinetostat::vjm
