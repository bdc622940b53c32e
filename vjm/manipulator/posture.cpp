#include "kinetostat/vjm/manipulator/posture.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "kinetostat/spatial/decomposition.h"
#include "kinetostat/vjm/chain/kinematics.h"
#include "kinetostat/vjm/manipulator/joint_place.h"
#include "kinetostat/vjm/manipulator/posture_search.h"

namespace kinetostat::vjm {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using spatial::Pose;
using spatial::Vector6;

// A system of equations error(z) = 0 with its Jacobian, z in comparable units.
struct Residual {
  VectorXd error;
  MatrixXd jacobian;
};

// Levenberg-Marquardt; evaluate(z, residual) fills both members. Returns the last accepted z.
template <class Evaluate>
VectorXd solve_least_squares(VectorXd z, const Evaluate& evaluate, double tolerance,
                             int max_iterations) {
  Residual now, next;
  evaluate(z, now);
  double damping = 1e-6;
  for (int i = 0; i < max_iterations && now.error.lpNorm<Eigen::Infinity>() > tolerance; ++i) {
    const VectorXd gradient = now.jacobian.transpose() * now.error;
    MatrixXd normal = now.jacobian.transpose() * now.jacobian;
    normal.diagonal().array() += damping * std::max(1e-12, normal.diagonal().maxCoeff());
    const VectorXd step = -spatial::solve_symmetric(normal, gradient);
    const VectorXd candidate = z + step;
    evaluate(candidate, next);
    if (next.error.squaredNorm() < now.error.squaredNorm()) {
      z = candidate;
      std::swap(now, next);
      damping = std::max(damping * 0.1, 1e-15);
    } else {
      if (step.norm() <= 1e-13 * z.norm()) break;  // rounding
      damping = std::max(damping * 10, 1e-12);
      if (damping > 1e8) break;
    }
  }
  return z;
}

// Error of a pose with rotation turned into a length.
Vector6 scaled_difference(const Pose& from, const Pose& to, double length) {
  Vector6 e = spatial::pose_difference(from, to);
  e.tail<3>() *= length;
  return e;
}

// A coordinate that keeps its value.
struct HeldCoordinate {
  Index coordinate;
  double value;
};
using HeldCoordinates = std::vector<HeldCoordinate>;  // of one chain

bool is_held(const HeldCoordinates& held, Index coordinate) {
  return std::any_of(held.begin(), held.end(), [coordinate](const HeldCoordinate& one) {
    return one.coordinate == coordinate;
  });
}

// Held coordinates on their way from where they stand in a posture to their values. Steps are so
// small that the posture can follow on its branch.
class WayToHeld {
 public:
  WayToHeld(const Chain& chain, const VectorXd& x, HeldCoordinates held, double length)
      : held_(std::move(held)) {
    constexpr double largest_step = 0.1;  // [rad], and of the length
    for (const HeldCoordinate& one : held_) {
      const bool turns =
          is_rotation(chain.coordinates()[static_cast<std::size_t>(one.coordinate)].motion);
      const double way = one.value - x[one.coordinate];
      constexpr double turn = 2 * std::numbers::pi;
      way_.push_back(turns ? std::remainder(way, turn) : way);
      steps_ = std::max(steps_, std::abs(way_.back()) / (largest_step * (turns ? 1 : length)));
    }
    steps_ = std::clamp(std::ceil(steps_), 1.0, most_steps);
  }

  int steps() const { return static_cast<int>(steps_); }
  // The last step is the value itself, to the bit.
  void set(int step, int steps, VectorXd& x) const {
    for (std::size_t i = 0; i < held_.size(); ++i)
      x[held_[i].coordinate] = held_[i].value - way_[i] * (steps - step) / steps;
  }

 private:
  static constexpr double most_steps = 200;
  HeldCoordinates held_;
  std::vector<double> way_;
  double steps_ = 1;
};

// Inverse kinematics of one chain.
class ChainPostureSolver {
 public:
  ChainPostureSolver(const Chain& chain, const Pose& target, HeldCoordinates held,
                     const PostureOptions& options)
      : chain_(chain), target_(target), held_(std::move(held)), options_(options) {
    length_ = search_length(chain, chain.home(), kinematics_);
    for (const Index k : chain.posture_coordinates())
      if (!is_held(held_, k)) free_.push_back(k);
  }

  VectorXd solve() {
    if (held_.empty()) return solve_from_starts();
    ChainPostureSolver unheld(chain_, target_, {}, options_);
    VectorXd x = unheld.solve();
    if (!unheld.is_reached(x)) return x;  // nor is it with joints held
    const VectorXd followed = follow(x);
    return is_reached(followed) ? followed : solve_from_starts();
  }

  Vector6 error(const VectorXd& x) {
    evaluate(chain_, x, kinematics_);
    return scaled_difference(kinematics_.end, target_, length_);
  }
  bool is_reached(const VectorXd& x) {
    return error(x).lpNorm<Eigen::Infinity>() <= accepted() &&
           std::all_of(held_.begin(), held_.end(),
                       [&x](const HeldCoordinate& one) { return x[one.coordinate] == one.value; });
  }
  double length() const { return length_; }

 private:
  double accepted() const { return posture_accuracy(length_, target_, options_).accepted; }
  double sought() const { return posture_accuracy(length_, target_, options_).sought; }

  VectorXd follow(VectorXd x) {
    const WayToHeld way(chain_, x, held_, length_);
    for (int step = 1; step <= way.steps(); ++step) {
      way.set(step, way.steps(), x);
      x = solve_from(x);
      if (error(x).lpNorm<Eigen::Infinity>() > accepted()) break;
    }
    return x;
  }

  // The first start that reaches the target, else the one that comes nearest.
  VectorXd solve_from_starts() {
    VectorXd best = chain_.home();
    double best_error = std::numeric_limits<double>::infinity();
    for (int start = 0; start <= options_.restarts; ++start) {
      VectorXd from = starting_point(chain_, start, length_);
      for (const HeldCoordinate& one : held_) from[one.coordinate] = one.value;
      const VectorXd x = solve_from(from);
      const double e = error(x).lpNorm<Eigen::Infinity>();
      if (e < best_error) {
        best = x;
        best_error = e;
      }
      if (best_error <= accepted()) break;
    }
    return best;
  }

  VectorXd solve_from(const VectorXd& start) {
    const auto n = static_cast<Index>(free_.size());
    if (n == 0) return start;
    VectorXd x = start, unit = VectorXd::Ones(n), z(n);
    for (Index k = 0; k < n; ++k) {
      const Index c = free_[static_cast<std::size_t>(k)];
      if (is_rotation(chain_.coordinates()[static_cast<std::size_t>(c)].motion)) unit[k] = length_;
      z[k] = x[c] * unit[k];
    }
    const auto set = [&](const VectorXd& values) {
      for (Index k = 0; k < n; ++k) x[free_[static_cast<std::size_t>(k)]] = values[k] / unit[k];
    };
    z = solve_least_squares(
        z,
        [&](const VectorXd& values, Residual& residual) {
          set(values);
          residual.error = error(x);
          residual.jacobian.resize(6, n);
          for (Index k = 0; k < n; ++k)
            residual.jacobian.col(k) =
                -kinematics_.jacobian.col(free_[static_cast<std::size_t>(k)]) / unit[k];
          residual.jacobian.bottomRows<3>() *= length_;
        },
        0.1 * sought(), options_.max_iterations);
    set(z);
    return x;
  }

  const Chain& chain_;
  Pose target_;
  HeldCoordinates held_;
  PostureOptions options_;
  std::vector<Index> free_;
  ChainKinematics kinematics_;
  double length_ = 1;
};

// Closes all loops at once: unknown are the poses of the bodies (the platform's too, unless it is
// given) and the joints that are free to choose: not those held, of each chain.
class LoopCloser {
 public:
  LoopCloser(const Manipulator& manipulator, std::vector<VectorXd> start,
             const std::optional<Pose>& platform, const std::vector<HeldCoordinates>& held,
             const PostureOptions& options)
      : manipulator_(manipulator), options_(options), platform_given_(platform), held_(held) {
    posture_.coordinates = std::move(start);
    kinematics_.resize(manipulator.size());
    for (std::size_t c = 0; c < manipulator.size(); ++c)
      length_ = std::max(
          length_, search_length(manipulator.chains()[c], posture_.coordinates[c], kinematics_[c]));
    place_bodies();
    choose_joints();
  }

  PostureResult solve() {
    const auto n = static_cast<Index>(joints_.size());
    const std::vector<Pose> origin = bodies_;
    VectorXd z = VectorXd::Zero(6 * moving_bodies() + n);
    for (Index k = 0; k < n; ++k) z[6 * moving_bodies() + k] = value(k);
    // In a singular posture the last digits come slowly.
    const double accepted = std::max(options_.tolerance, closed_loop_error * length_);
    const auto evaluate_loops = [&](const VectorXd& values, Residual& residual) {
      set(values, origin);
      fill(residual);
    };
    z = solve_least_squares(z, evaluate_loops, 1e-4 * accepted, options_.max_iterations);
    Residual residual;
    evaluate_loops(z, residual);
    return result(residual, accepted);
  }

 private:
  struct Joint {
    std::size_t chain;
    Index coordinate;
    double unit;
  };

  Index moving_bodies() const {
    return static_cast<Index>(bodies_.size()) - (platform_given_ ? 1 : 0);
  }
  Index column_of(int body) const { return Index{6} * (body - (platform_given_ ? 1 : 0)); }
  Pose origin_of(std::size_t c) const {
    const int from = manipulator_.span(c).from;
    return from == Span::base ? Pose() : bodies_[static_cast<std::size_t>(from)];
  }

  // Each body where the first chain that leads to it from a known one puts it.
  void place_bodies() {
    bodies_.resize(manipulator_.body_count());
    std::vector<bool> known(bodies_.size(), false);
    if (platform_given_) bodies_[0] = *platform_given_;
    if (platform_given_) known[0] = true;
    for (std::size_t pass = 0; pass < bodies_.size(); ++pass)
      for (std::size_t c = 0; c < manipulator_.size(); ++c) {
        const Span& span = manipulator_.span(c);
        const auto to = static_cast<std::size_t>(span.to);
        if (known[to] || (span.from != Span::base && !known[static_cast<std::size_t>(span.from)]))
          continue;
        evaluate(manipulator_.chains()[c], posture_.coordinates[c], kinematics_[c], origin_of(c));
        bodies_[to] = kinematics_[c].end;
        known[to] = true;
      }
  }

  void choose_joints() {
    for (std::size_t c = 0; c < manipulator_.size(); ++c) {
      const Chain& chain = manipulator_.chains()[c];
      for (const Index k : chain.posture_coordinates()) {
        const Coordinate& coordinate = chain.coordinates()[static_cast<std::size_t>(k)];
        if (is_held(held_[c], k)) continue;
        if (coordinate.role == Role::passive || platform_given_)
          joints_.push_back({c, k, is_rotation(coordinate.motion) ? length_ : 1.0});
      }
    }
  }

  double value(Index k) const {
    const Joint& joint = joints_[static_cast<std::size_t>(k)];
    return posture_.coordinates[joint.chain][joint.coordinate] * joint.unit;
  }

  void set(const VectorXd& z, const std::vector<Pose>& origin) {
    for (std::size_t b = platform_given_ ? 1 : 0; b < bodies_.size(); ++b) {
      Vector6 displacement = z.segment<6>(column_of(static_cast<int>(b)));
      displacement.tail<3>() /= length_;
      bodies_[b] = spatial::displaced(origin[b], displacement);
    }
    for (std::size_t k = 0; k < joints_.size(); ++k)
      posture_.coordinates[joints_[k].chain][joints_[k].coordinate] =
          z[6 * moving_bodies() + static_cast<Index>(k)] / joints_[k].unit;
  }

  void fill(Residual& residual) {
    const Index bodies = 6 * moving_bodies();
    residual.error.resize(static_cast<Index>(6 * manipulator_.size()));
    residual.jacobian.setZero(residual.error.size(), bodies + static_cast<Index>(joints_.size()));
    for (std::size_t c = 0; c < manipulator_.size(); ++c) {
      const Span& span = manipulator_.span(c);
      evaluate(manipulator_.chains()[c], posture_.coordinates[c], kinematics_[c], origin_of(c));
      const auto row = static_cast<Index>(6 * c);
      const Pose& end = kinematics_[c].end;
      residual.error.segment<6>(row) =
          scaled_difference(end, bodies_[static_cast<std::size_t>(span.to)], length_);
      if (column_of(span.to) >= 0)
        residual.jacobian.block<6, 6>(row, column_of(span.to)).setIdentity();
      if (span.from != Span::base && column_of(span.from) >= 0) {
        residual.jacobian.block<6, 6>(row, column_of(span.from)) = -spatial::Matrix6::Identity();
        residual.jacobian.block<3, 3>(row, column_of(span.from) + 3) =
            spatial::skew(end.position() - origin_of(c).position()) / length_;
      }
    }
    for (std::size_t k = 0; k < joints_.size(); ++k) {
      const auto row = static_cast<Index>(6 * joints_[k].chain);
      const Index column = bodies + static_cast<Index>(k);
      residual.jacobian.block<6, 1>(row, column) =
          -kinematics_[joints_[k].chain].jacobian.col(joints_[k].coordinate) / joints_[k].unit;
      residual.jacobian.block<3, 1>(row + 3, column) *= length_;
    }
  }

  PostureResult result(const Residual& residual, double accepted) const {
    PostureResult result;
    result.posture = posture_;
    result.posture.platform = bodies_[0];
    result.posture.inner_bodies.assign(bodies_.begin() + 1, bodies_.end());
    result.reached = residual.error.lpNorm<Eigen::Infinity>() <= accepted;
    Index worst = 0;
    residual.error.cwiseAbs().maxCoeff(&worst);
    result.error = residual.error.segment<6>(worst - worst % 6);
    result.error.tail<3>() /= length_;
    if (!result.reached)
      result.reason =
          (platform_given_ ? "" : "the loops cannot be closed with these joint values: ") +
          miss_text(manipulator_.chains()[static_cast<std::size_t>(worst / 6)].name(),
                    result.error);
    return result;
  }

  const Manipulator& manipulator_;
  PostureOptions options_;
  std::optional<Pose> platform_given_;
  std::vector<HeldCoordinates> held_;
  Posture posture_;
  std::vector<Pose> bodies_;
  std::vector<Joint> joints_;
  std::vector<ChainKinematics> kinematics_;
  double length_ = 0;
};

std::vector<VectorXd> home_of(const Manipulator& manipulator) {
  std::vector<VectorXd> home;
  for (const Chain& chain : manipulator.chains()) home.push_back(chain.home());
  return home;
}

std::vector<HeldCoordinates> nothing_held(const Manipulator& manipulator) {
  return std::vector<HeldCoordinates>(manipulator.size());
}

// Mechanisms with inner bodies: from home, then from scattered starts like single chains.
PostureResult mechanism_from_starts(const Manipulator& manipulator, const Pose& target,
                                    const std::vector<HeldCoordinates>& held,
                                    const PostureOptions& options) {
  PostureResult best;
  for (int start = 0; start <= options.restarts; ++start) {
    std::vector<VectorXd> coordinates;
    ChainKinematics kinematics;
    for (std::size_t c = 0; c < manipulator.size(); ++c) {
      const Chain& chain = manipulator.chains()[c];
      coordinates.push_back(
          starting_point(chain, start, search_length(chain, chain.home(), kinematics)));
      for (const HeldCoordinate& one : held[c]) coordinates[c][one.coordinate] = one.value;
    }
    PostureResult result =
        LoopCloser(manipulator, std::move(coordinates), target, held, options).solve();
    if (start == 0 || result.reached || result.error.norm() < best.error.norm())
      best = std::move(result);
    if (best.reached) break;
  }
  return best;
}

// The same with the held joints led from where they stand in a posture to their values.
PostureResult mechanism_followed(const Manipulator& manipulator, PostureResult from,
                                 const std::vector<HeldCoordinates>& held,
                                 const PostureOptions& options) {
  const Pose target = from.posture.platform;
  std::vector<WayToHeld> ways;
  int steps = 1;
  ChainKinematics kinematics;
  for (std::size_t c = 0; c < manipulator.size(); ++c) {
    const Chain& chain = manipulator.chains()[c];
    ways.emplace_back(chain, from.posture.coordinates[c], held[c],
                      search_length(chain, chain.home(), kinematics));
    steps = std::max(steps, ways.back().steps());
  }
  for (int step = 1; step <= steps && from.reached; ++step) {
    std::vector<VectorXd> coordinates = from.posture.coordinates;
    for (std::size_t c = 0; c < manipulator.size(); ++c) ways[c].set(step, steps, coordinates[c]);
    from = LoopCloser(manipulator, std::move(coordinates), target, held, options).solve();
  }
  return from;
}

bool is_any_held(const std::vector<HeldCoordinates>& held) {
  return std::any_of(held.begin(), held.end(),
                     [](const HeldCoordinates& of_chain) { return !of_chain.empty(); });
}

PostureResult mechanism_posture(const Manipulator& manipulator, const Pose& target,
                                const std::vector<HeldCoordinates>& held,
                                const PostureOptions& options) {
  if (is_any_held(held)) {
    PostureResult unheld =
        mechanism_from_starts(manipulator, target, nothing_held(manipulator), options);
    if (!unheld.reached) return unheld;
    PostureResult followed = mechanism_followed(manipulator, std::move(unheld), held, options);
    if (followed.reached) return followed;
  }
  return mechanism_from_starts(manipulator, target, held, options);
}

PostureResult posture_of_chains(const Manipulator& manipulator, const Pose& target,
                                const std::vector<HeldCoordinates>& held,
                                const PostureOptions& options) {
  PostureResult result;
  result.reached = true;
  result.posture.platform = target;
  for (std::size_t c = 0; c < manipulator.size(); ++c) {
    const Chain& chain = manipulator.chains()[c];
    ChainPostureSolver solver(chain, target, held[c], options);
    result.posture.coordinates.push_back(solver.solve());
    if (solver.is_reached(result.posture.coordinates.back())) continue;
    Vector6 error = solver.error(result.posture.coordinates.back());
    error.tail<3>() /= solver.length();
    note_miss(chain, error, result);
  }
  return result;
}

// Loops that are closed at home and whose drives go from there to their values in steps, so that
// the assembly is the one of home. `to`: all coordinates, those of the drives as they shall be.
PostureResult loops_followed(const Manipulator& manipulator, const std::vector<VectorXd>& to,
                             const PostureOptions& options) {
  const auto closed = [&](std::vector<VectorXd> start) {
    return LoopCloser(manipulator, std::move(start), std::nullopt, nothing_held(manipulator),
                      options)
        .solve();
  };
  PostureResult at = closed(home_of(manipulator));
  std::vector<WayToHeld> ways;
  int steps = 1;
  ChainKinematics kinematics;
  for (std::size_t c = 0; c < manipulator.size(); ++c) {
    const Chain& chain = manipulator.chains()[c];
    HeldCoordinates drives;
    for (const Index k : chain.posture_coordinates())
      if (chain.coordinates()[static_cast<std::size_t>(k)].role == Role::actuated)
        drives.push_back({k, to[c][k]});
    ways.emplace_back(chain, at.posture.coordinates[c], std::move(drives),
                      search_length(chain, chain.home(), kinematics));
    steps = std::max(steps, ways.back().steps());
  }
  for (int step = 1; step <= steps && at.reached; ++step) {
    std::vector<VectorXd> coordinates = at.posture.coordinates;
    for (std::size_t c = 0; c < manipulator.size(); ++c) ways[c].set(step, steps, coordinates[c]);
    at = closed(std::move(coordinates));
  }
  return at;
}

// Whether some joint stands a quarter of a turn and more from where a search for it started.
bool turns_far(const Manipulator& manipulator, const std::vector<VectorXd>& start,
               const Posture& posture) {
  for (std::size_t c = 0; c < manipulator.size(); ++c)
    for (const Index k : manipulator.chains()[c].posture_coordinates())
      if (is_rotation(manipulator.chains()[c].coordinates()[static_cast<std::size_t>(k)].motion) &&
          std::abs(posture.coordinates[c][k] - start[c][k]) > std::numbers::pi / 2)
        return true;
  return false;
}

// At once where that stays near the start; else on the way from home, if there is one.
PostureResult loops_closed(const Manipulator& manipulator, const std::vector<VectorXd>& start,
                           const PostureOptions& options) {
  PostureResult at_once =
      LoopCloser(manipulator, start, std::nullopt, nothing_held(manipulator), options).solve();
  if (at_once.reached && !turns_far(manipulator, start, at_once.posture)) return at_once;
  PostureResult followed = loops_followed(manipulator, start, options);
  return followed.reached ? followed : at_once;
}

}  // namespace

PostureResult posture_at(const Manipulator& manipulator, const Pose& target,
                         const PostureOptions& options) {
  return posture_holding(manipulator, target, {}, options);
}

PostureResult posture_holding(const Manipulator& manipulator, const Pose& target,
                              const std::map<std::string, double>& held,
                              const PostureOptions& options) {
  if (manipulator.has_errors())
    return posture_holding(manipulator.without_errors(), target, held, options);
  std::vector<HeldCoordinates> of_chains = nothing_held(manipulator);
  for (const auto& [name, value] : held) {
    const JointPlace joint = find_joint(manipulator, name);
    of_chains[joint.chain].push_back({joint.coordinate, value});
  }
  return manipulator.is_parallel() ? posture_of_chains(manipulator, target, of_chains, options)
                                   : mechanism_posture(manipulator, target, of_chains, options);
}

PostureResult posture_from_joints(const Manipulator& manipulator,
                                  const std::map<std::string, double>& coordinates,
                                  const PostureOptions& options) {
  if (manipulator.has_errors())
    return posture_from_joints(manipulator.without_errors(), coordinates, options);
  std::vector<VectorXd> start = home_of(manipulator);
  for (const auto& [name, value] : coordinates) {
    const JointPlace joint = find_joint(manipulator, name);
    start[joint.chain][joint.coordinate] = value;
  }
  if (manipulator.size() > 1) return loops_closed(manipulator, start, options);
  PostureResult result;
  ChainKinematics kinematics;
  evaluate(manipulator.chains()[0], start[0], kinematics);
  result.posture.platform = kinematics.end;
  result.posture.coordinates = std::move(start);
  result.reached = true;
  return result;
}

}  // namespace kinetostat::vjm
