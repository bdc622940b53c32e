// Postures of many poses: four at a time.
#include <cmath>
#include <limits>
#include <numeric>

#include "kinetostat/spatial/rotation.h"
#include "kinetostat/vjm/batches/batches.h"
#include "kinetostat/vjm/batches/relaxed_chain.h"
#include "kinetostat/vjm/manipulator/posture_search.h"

namespace kinetostat::vjm {
namespace {

using Eigen::Index;
using spatial::Matrix3;
using spatial::Pose;
using Coordinates = RelaxedChain::Coordinates;

// Poses side by side.
struct Targets {
  Matrix3Lanes rotation;
  Vector3Lanes position;
};

// The rotation vector of the rotation from `from` to `to`: by the arc tangent of its skew part,
// which says little only near half a turn.
void rotation_between(const Matrix3Lanes& from, const Matrix3Lanes& to, Vector6Lanes& error) {
  Matrix3Lanes turn;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      turn(i, j) = to(i, 0) * from(j, 0) + to(i, 1) * from(j, 1) + to(i, 2) * from(j, 2);
  const Lanes cosine = (turn(0, 0) + turn(1, 1) + turn(2, 2) - 1.0) * 0.5;
  Lanes v[3] = {(turn(2, 1) - turn(1, 2)) * 0.5, (turn(0, 2) - turn(2, 0)) * 0.5,
                (turn(1, 0) - turn(0, 1)) * 0.5};
  const Lanes sine = sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
  constexpr double near_none = 1e-7, near_half_a_turn = -0.9;
  for (int lane = 0; lane < lane_count; ++lane) {
    if (cosine[lane] < near_half_a_turn) {
      Matrix3 alone;
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) alone(i, j) = turn(i, j)[lane];
      const spatial::Vector3 exact = spatial::log_rotation(alone);
      for (int i = 0; i < 3; ++i) error[3 + i].set(lane, exact[i]);
      continue;
    }
    const double s = sine[lane];
    const double factor = s < near_none ? 1 + s * s / 6 : std::atan2(s, cosine[lane]) / s;
    for (int i = 0; i < 3; ++i) error[3 + i].set(lane, factor * v[i][lane]);
  }
}

// Where a search stands: the poses' errors there, rotations times a length, and their derivatives.
struct Place {
  Coordinates z;  // rotations times the length
  Vector6Lanes error;
  RelaxedChain::Twists jacobian;
  Lanes squared, largest;
};

struct Search {
  const RelaxedChain& chain;
  const Targets& targets;
  double length;

  void evaluate_at(Place& at) const {
    Coordinates x = at.z;
    for (Index k = 0; k < x.size(); ++k)
      if (chain.chosen[static_cast<std::size_t>(k)].turns) x[k] = x[k] / length;
    RelaxedKinematics kinematics;
    evaluate(chain, x, kinematics);
    for (int i = 0; i < 3; ++i) at.error[i] = targets.position[i] - kinematics.position[i];
    rotation_between(kinematics.rotation, targets.rotation, at.error);
    at.squared = 0.0;
    at.largest = 0.0;
    for (int i = 0; i < 6; ++i) {
      if (i >= 3) at.error[i] *= length;
      at.squared += at.error[i] * at.error[i];
      at.largest = max(at.largest, abs(at.error[i]));
    }
    twists_of(chain, kinematics, at.jacobian);
    for (Index k = 0; k < x.size(); ++k) {
      const double unit = chain.chosen[static_cast<std::size_t>(k)].turns ? length : 1.0;
      for (int i = 0; i < 6; ++i) at.jacobian(i, k) *= (i < 3 ? -1.0 : -length) / unit;
    }
  }
};

// -(J'J + damping)^-1 J'e by Cholesky's factors.
Coordinates step_from(const Place& at, Lanes damping) {
  const Index n = at.z.size();
  LaneMatrix<RelaxedChain::most_coordinates, RelaxedChain::most_coordinates> normal;
  Coordinates step(n);
  Lanes largest(1e-12);
  for (Index a = 0; a < n; ++a) {
    for (Index b = 0; b <= a; ++b) {
      Lanes sum = at.jacobian(0, a) * at.jacobian(0, b);
      for (int i = 1; i < 6; ++i) sum += at.jacobian(i, a) * at.jacobian(i, b);
      normal(a, b) = sum;
    }
    Lanes gradient = at.jacobian(0, a) * at.error[0];
    for (int i = 1; i < 6; ++i) gradient += at.jacobian(i, a) * at.error[i];
    step[a] = -gradient;
    largest = max(largest, normal(a, a));
  }
  for (Index a = 0; a < n; ++a) normal(a, a) += damping * largest;
  for (Index a = 0; a < n; ++a) {
    for (Index b = 0; b < a; ++b) {
      Lanes sum = normal(a, b);
      for (Index k = 0; k < b; ++k) sum -= normal(a, k) * normal(b, k);
      normal(a, b) = sum * normal(b, b);
    }
    Lanes pivot = normal(a, a);
    for (Index k = 0; k < a; ++k) pivot -= normal(a, k) * normal(a, k);
    normal(a, a) = 1.0 / sqrt(pivot);
  }
  for (Index a = 0; a < n; ++a) {
    for (Index k = 0; k < a; ++k) step[a] -= normal(a, k) * step[k];
    step[a] *= normal(a, a);
  }
  for (Index a = n - 1; a >= 0; --a) {
    for (Index k = a + 1; k < n; ++k) step[a] -= normal(k, a) * step[k];
    step[a] *= normal(a, a);
  }
  return step;
}

// One search in every lane, each as solve_least_squares() goes on: a lane that has arrived, or does
// not come nearer, waits for the others. `z` is start and result; the errors that are left.
Lanes find(const Search& search, Coordinates& z, Lanes tolerance, int max_iterations) {
  Place now, next;
  now.z = z;
  search.evaluate_at(now);
  Lanes damping(1e-6);
  LaneMask going = now.largest > tolerance;
  for (int i = 0; i < max_iterations && going.any(); ++i) {
    const Coordinates step = step_from(now, damping);
    next.z = now.z;
    Lanes length(0.0), size(0.0);
    for (Index k = 0; k < step.size(); ++k) {
      next.z[k] += step[k];
      length += step[k] * step[k];
      size += now.z[k] * now.z[k];
    }
    search.evaluate_at(next);
    const LaneMask better = next.squared < now.squared, take = going & better;
    const LaneMask stays = (!better) & (length <= size * 1e-26);  // rounding
    damping = Lanes::chosen(better, max(damping * 0.1, 1e-15), max(damping * 10.0, 1e-12));
    const auto keep = [&](auto& of, const auto& from) {
      for (Index k = 0; k < of.size(); ++k)
        of.data()[k] = Lanes::chosen(take, from.data()[k], of.data()[k]);
    };
    keep(now.z, next.z);
    keep(now.error, next.error);
    keep(now.jacobian, next.jacobian);
    now.squared = Lanes::chosen(take, next.squared, now.squared);
    now.largest = Lanes::chosen(take, next.largest, now.largest);
    going = going & (now.largest > tolerance) & !stays & (better | (damping <= 1e8));
  }
  z = now.z;
  return now.largest;
}

// A chain that looks for the postures of many poses.
class ChainSearch {
 public:
  ChainSearch(const Chain& chain, RelaxedChain relaxed, const PostureOptions& options)
      : chain_(chain), relaxed_(std::move(relaxed)), options_(options) {
    length_ = search_length(chain, chain.home(), kinematics_);
  }

  // Adds what the first start leads to that reaches a pose, else what comes nearest.
  void place(const std::vector<Pose>& targets, std::vector<PostureResult>& results) {
    nearest_.assign(targets.size(), {});
    std::vector<std::size_t> missed(targets.size());
    std::iota(missed.begin(), missed.end(), std::size_t{0});
    for (int start = 0; start <= options_.restarts && !missed.empty(); ++start) {
      const Eigen::VectorXd from = starting_point(chain_, start, length_);
      for (std::size_t first = 0; first < missed.size(); first += lane_count)
        look(targets, missed, first, from);
      std::erase_if(missed, [&](std::size_t i) { return is_reached(i, targets[i]); });
    }
    for (std::size_t i = 0; i < targets.size(); ++i) {
      if (!is_reached(i, targets[i])) note(targets[i], nearest_[i].x, results[i]);
      results[i].posture.coordinates.push_back(std::move(nearest_[i].x));
    }
  }

 private:
  struct Nearest {
    Eigen::VectorXd x;
    double left = std::numeric_limits<double>::infinity();
  };

  bool is_reached(std::size_t i, const Pose& target) const {
    return nearest_[i].left <= posture_accuracy(length_, target, options_).accepted;
  }

  // Four of the missed poses from the same coordinates.
  void look(const std::vector<Pose>& targets, const std::vector<std::size_t>& missed,
            std::size_t first, const Eigen::VectorXd& from) {
    Targets poses;
    Lanes tolerance;
    for (int lane = 0; lane < lane_count; ++lane) {
      const Pose& pose = targets[missed[piece_of(first, lane, missed.size())]];
      for (int i = 0; i < 3; ++i) poses.position[i].set(lane, pose.position()[i]);
      for (int i = 0; i < 9; ++i)
        poses.rotation(i % 3, i / 3).set(lane, pose.rotation()(i % 3, i / 3));
      tolerance.set(lane, 0.1 * posture_accuracy(length_, pose, options_).sought);
    }
    Coordinates z(static_cast<Index>(relaxed_.chosen.size()));
    for (Index k = 0; k < z.size(); ++k) z[k] = from[chosen(k).coordinate] * unit(k);
    Lanes left;
    in_lanes([&] {
      left = find({relaxed_, poses, length_}, z, tolerance, options_.max_iterations);
    });
    for (std::size_t i = first; i < std::min(first + lane_count, missed.size()); ++i) {
      const auto lane = static_cast<int>(i - first);
      Nearest& nearest = nearest_[missed[i]];
      if (!(left[lane] < nearest.left)) continue;
      nearest.left = left[lane];
      nearest.x = chain_.home();
      for (Index k = 0; k < z.size(); ++k) nearest.x[chosen(k).coordinate] = z[k][lane] / unit(k);
    }
  }

  void note(const Pose& target, Eigen::VectorXd& x, PostureResult& result) {
    if (x.size() == 0) x = chain_.home();
    evaluate(chain_, x, kinematics_);
    note_miss(chain_, spatial::pose_difference(kinematics_.end, target), result);
  }

  const RelaxedChain::Chosen& chosen(Index k) const {
    return relaxed_.chosen[static_cast<std::size_t>(k)];
  }
  double unit(Index k) const { return chosen(k).turns ? length_ : 1.0; }

  const Chain& chain_;
  const RelaxedChain relaxed_;
  const PostureOptions& options_;
  ChainKinematics kinematics_;
  double length_ = 1;
  std::vector<Nearest> nearest_;  // of the poses
};

}  // namespace

std::vector<PostureResult> postures_at(const Manipulator& manipulator,
                                       const std::vector<Pose>& targets,
                                       const PostureOptions& options) {
  if (manipulator.has_errors()) return postures_at(manipulator.without_errors(), targets, options);
  std::vector<PostureResult> results(targets.size());
  std::vector<RelaxedChain> chains = manipulator.is_parallel()
                                         ? relaxed_chains(manipulator.chains())
                                         : std::vector<RelaxedChain>();
  for (std::size_t i = 0; i < targets.size(); ++i) {
    if (chains.empty()) {
      results[i] = posture_at(manipulator, targets[i], options);
      continue;
    }
    results[i].reached = true;
    results[i].posture.platform = targets[i];
    results[i].posture.coordinates.reserve(chains.size());
  }
  for (std::size_t c = 0; c < chains.size(); ++c)
    ChainSearch(manipulator.chains()[c], std::move(chains[c]), options).place(targets, results);
  return results;
}

}  // namespace kinetostat::vjm
