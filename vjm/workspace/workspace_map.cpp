#include "kinetostat/vjm/workspace/workspace_map.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <stdexcept>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include "kinetostat/common/parallel.h"
#include "kinetostat/vjm/batches/batches.h"
#include "kinetostat/vjm/continuation/path.h"
#include "kinetostat/vjm/manipulator/joint_range.h"
#include "kinetostat/vjm/manipulator/posture.h"
#include "kinetostat/vjm/statics/equilibrium.h"
#include "kinetostat/vjm/statics/stiffness.h"
#include "kinetostat/vjm/vibration/natural_modes.h"
#include "kinetostat/vjm/workspace/map_checkpoint.h"

namespace kinetostat::vjm {
namespace {

using spatial::Matrix3;
using spatial::Matrix6;
using spatial::Vector3;
using spatial::Vector6;

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

// What yields and what does not: the compliance on the wrenches that are carried, and the projector
// on those that nothing carries (dimensionless, rotations times `length`).
struct Flexibility {
  Matrix6 compliance = Matrix6::Zero();
  Matrix6 uncarried = Matrix6::Zero();
  double length = 1;

  bool has_free_motion() const { return !uncarried.isZero(1e-6); }
  // Whether a wrench [N; N m] works on a free motion.
  bool is_uncarried(const Vector6& wrench) const {
    Vector6 scaled = wrench;
    scaled.tail<3>() /= length;
    return scaled.dot(uncarried * scaled) > 1e-9 * scaled.squaredNorm();
  }
};

Vector6 twist_scale(double length) {
  Vector6 scale = Vector6::Ones();
  scale.tail<3>().setConstant(length);
  return scale;
}

Matrix6 symmetric_part(const Matrix6& matrix) { return 0.5 * (matrix + matrix.transpose()); }

// Far from a free motion: none of its pivots is small beside the largest.
bool is_clearly_regular(const Eigen::LLT<Matrix6>& factor) {
  if (factor.info() != Eigen::Success) return false;
  const auto pivots = factor.matrixLLT().diagonal();
  return pivots.minCoeff() > 1e-3 * pivots.maxCoeff();
}

// The inverse on the motions that are resisted.
Flexibility flexibility_of(const Matrix6& stiffness, double length) {
  const Vector6 scale = twist_scale(length);
  const Matrix6 scaled = scale.cwiseInverse().asDiagonal() * symmetric_part(stiffness) *
                         scale.cwiseInverse().asDiagonal();
  Flexibility result{.length = length};
  if (const Eigen::LLT<Matrix6> factor(scaled); is_clearly_regular(factor)) {
    const Matrix6 inverse = factor.solve(Matrix6::Identity());
    result.compliance =
        scale.cwiseInverse().asDiagonal() * inverse * scale.cwiseInverse().asDiagonal();
    return result;
  }
  const Eigen::SelfAdjointEigenSolver<Matrix6> eigen(scaled);
  const double zero = 1e-9 * eigen.eigenvalues().cwiseAbs().maxCoeff();
  Matrix6 inverse = Matrix6::Zero();
  for (int i = 0; i < 6; ++i) {
    const Vector6 v = eigen.eigenvectors().col(i);
    if (std::abs(eigen.eigenvalues()[i]) <= zero) {
      result.uncarried += v * v.transpose();
    } else {
      inverse += v * v.transpose() / eigen.eigenvalues()[i];
    }
  }
  result.compliance =
      scale.cwiseInverse().asDiagonal() * inverse * scale.cwiseInverse().asDiagonal();
  return result;
}

// Of the largest compliances: less is rounding, and nothing yields there.
constexpr double rounding = 1e-12;

// Below this compliances [m/N] are rounding, rotations times the length of the flexibility.
double rounding_of(const Flexibility& flexibility) {
  const Vector6 scale = twist_scale(flexibility.length);
  return rounding * (scale.asDiagonal() * flexibility.compliance * scale.asDiagonal()).norm();
}

double along(const Flexibility& flexibility, const Vector6& unit_wrench) {
  if (flexibility.is_uncarried(unit_wrench)) return 0;
  const double compliance = unit_wrench.dot(flexibility.compliance * unit_wrench);
  const double size = unit_wrench.cwiseQuotient(twist_scale(flexibility.length)).squaredNorm();
  return std::abs(compliance) <= size * rounding_of(flexibility) ? infinity : 1 / compliance;
}

// Of compliances in increasing order: what is weakest, negative where it is unstable.
double weakest_of(const Eigen::Ref<const Eigen::VectorXd>& compliances, double nothing) {
  const double least = compliances[0], most = compliances[compliances.size() - 1];
  if (least < -nothing) return 1 / least;
  return most <= nothing ? infinity : 1 / most;
}

// Smallest stiffness under pure forces (first = 0) or pure moments (first = 3). A negative value
// means instability.
double weakest_of_block(const Flexibility& flexibility, int first) {
  const Matrix3 uncarried = flexibility.uncarried.block<3, 3>(first, first);
  if (!uncarried.isZero(1e-9)) return 0;
  const Eigen::SelfAdjointEigenSolver<Matrix3> eigen(
      flexibility.compliance.block<3, 3>(first, first), Eigen::EigenvaluesOnly);
  const double length = flexibility.length, unit = first == 0 ? 1 : length * length;
  return weakest_of(eigen.eigenvalues(), rounding_of(flexibility) / unit);
}

Vector6 scaled_compliances(const Flexibility& flexibility, double length) {
  const Vector6 scale = twist_scale(length);
  return Eigen::SelfAdjointEigenSolver<Matrix6>(
             scale.asDiagonal() * flexibility.compliance * scale.asDiagonal(),
             Eigen::EigenvaluesOnly)
      .eigenvalues();
}

double weakest(const Flexibility& flexibility, double length) {
  if (flexibility.has_free_motion()) return 0;
  const Vector6 values = scaled_compliances(flexibility, length);
  return weakest_of(values, rounding * values.norm());
}

double condition(const Flexibility& flexibility, double length) {
  if (flexibility.has_free_motion()) return infinity;
  const Vector6 values = scaled_compliances(flexibility, length).cwiseAbs();
  return values.minCoeff() <= rounding * values.norm() ? infinity
                                                       : values.maxCoeff() / values.minCoeff();
}

double value_of(const MapIndex& index, const Flexibility& flexibility, const Vector6& deflection) {
  Vector6 unit = Vector6::Zero();
  switch (index.kind) {
    case MapIndex::Kind::stiffness:
      unit.head<3>() = index.direction;
      return along(flexibility, unit);
    case MapIndex::Kind::rotational:
      unit.tail<3>() = index.direction;
      return along(flexibility, unit);
    case MapIndex::Kind::weakest_translation:
      return weakest_of_block(flexibility, 0);
    case MapIndex::Kind::weakest_rotation:
      return weakest_of_block(flexibility, 3);
    case MapIndex::Kind::weakest:
      return weakest(flexibility, index.length);
    case MapIndex::Kind::condition:
      return condition(flexibility, index.length);
    case MapIndex::Kind::deflection:
      return deflection.head<3>().norm();
    case MapIndex::Kind::rotation:
      return deflection.tail<3>().norm();
    case MapIndex::Kind::first_frequency:
    case MapIndex::Kind::critical_force:
      break;  // below
  }
  return not_a_number;
}

double lumped_critical_force(const Manipulator& manipulator, const Posture& posture,
                             const std::vector<NodeLoad>& constant, const MapIndex& index) {
  PathTask task;
  task.platform_held = false;
  task.growing.force = index.up_to * index.direction;
  task.constant = constant;
  common::Progress silent;
  const Path path = trace(manipulator, posture, task,
                          {.lowest = 0, .points = 20, .until_critical = true}, silent);
  if (path.status != EquilibriumStatus::converged) return not_a_number;
  for (const CriticalPoint& critical : path.critical)
    if (critical.unstable_after > critical.unstable_before)
      return std::max(0.0, critical.point.parameter) * index.up_to;
  const BranchEnd end = path.branches.at(0).end;
  const bool came_to_the_end =
      end == BranchEnd::target || end == BranchEnd::range || end == BranchEnd::locked;
  if (came_to_the_end) return infinity;
  return not_a_number;
}

// Of the distributed beams, which the first of `finer` has in twice the segments of the one before.
double critical_force(const Manipulator& manipulator, const TargetPose& target,
                      const Posture& posture, const MapIndex& index,
                      const std::vector<Manipulator>& finer) {
  double coarse = lumped_critical_force(manipulator, posture, target.load.nodes, index);
  for (const Manipulator& twice : finer) {
    const PostureResult same = posture_to(twice, target);
    if (!same.reached) return not_a_number;
    const double fine = lumped_critical_force(twice, same.posture, target.load.nodes, index);
    if (!std::isfinite(fine)) return fine;
    if (std::isfinite(coarse)) return fine + (fine - coarse) / 3;
    coarse = fine;
  }
  return coarse;
}

// Whether the equilibrium lasts when the beams have twice the segments.
bool lasts_with(const std::vector<Manipulator>& finer, const TargetPose& target) {
  if (finer.empty()) return true;
  const PostureResult posture = posture_to(finer[0], target);
  if (!posture.reached) return false;
  const Equilibrium loaded = equilibrium_under_load(finer[0], posture.posture, target.load);
  return loaded.status == EquilibriumStatus::converged && loaded.free.stable();
}

bool is_unloaded(const Load& load) {
  return load.force.isZero(0) && load.moment.isZero(0) && load.nodes.empty() && load.joints.empty();
}

// Nothing where a mass is free to move; infinite where none moves.
double first_frequency(const Manipulator& manipulator, const Posture& posture) {
  const NaturalModes found = natural_modes(manipulator, posture, 1);
  if (found.free_motions > 0) return 0;
  return found.modes.empty() ? std::numeric_limits<double>::infinity()
                             : found.modes.front().frequency;
}

void refuse_critical_force_beside_a_wrench(const Load& load, const std::vector<MapIndex>& indices) {
  if (load.force.isZero(0) && load.moment.isZero(0)) return;
  for (const MapIndex& index : indices)
    if (index.kind == MapIndex::Kind::critical_force)
      throw std::invalid_argument("a critical force grows from nothing, not from a wrench");
}

// A length of the size of the robot, to compare translations with rotations when ranks are decided.
double size_of(const Posture& posture) {
  double size = posture.platform.position().norm();
  for (const Eigen::VectorXd& x : posture.coordinates) size = std::max(size, x.norm());
  return size > 0 ? size : 1.0;
}

// What the quick ways, which treat many poses together, have found of one.
struct Known {
  std::optional<spatial::Stiffness6> relaxed;
  std::optional<StableEquilibrium> loaded;
  bool lasts = false;  // with finer beams as well
};

Flexibility relaxed_flexibility(const Manipulator& manipulator, const Posture& posture,
                                const std::optional<spatial::Stiffness6>& quick) {
  const double length = size_of(posture);
  if (quick) return flexibility_of(quick->matrix(), length);
  const UnloadedStiffness full = unloaded_stiffness(manipulator, posture);
  if (full.compliance)
    return {.compliance = symmetric_part(full.compliance->matrix()), .length = length};
  if (full.stiffness) return flexibility_of(full.stiffness->matrix(), length);
  return {.uncarried = Matrix6::Identity(), .length = length};
}

Flexibility loaded_flexibility(const StableEquilibrium& equilibrium, double length) {
  return {.compliance = symmetric_part(equilibrium.stiffness.inverse().matrix()), .length = length};
}

Flexibility loaded_flexibility(const Equilibrium& equilibrium, double length) {
  if (equilibrium.compliance)
    return {.compliance = symmetric_part(equilibrium.compliance->matrix()), .length = length};
  if (equilibrium.stiffness) return flexibility_of(equilibrium.stiffness->matrix(), length);
  return {.uncarried = Matrix6::Identity(), .length = length};
}

bool is_within_range(const Manipulator& manipulator, const PostureResult& posture) {
  return posture.reached && beyond_range(manipulator, posture.posture).empty();
}

// Whether the springs of a robot are relaxed at a pose.
bool is_relaxed_at(const Manipulator& manipulator, const TargetPose& target) {
  return is_unloaded(target.load) && manipulator.is_relaxed_when_unloaded();
}

// A pose in whose posture the robot stands.
MapPoint point_in(const Manipulator& manipulator, const TargetPose& target,
                  const PostureResult& posture, const Known& known,
                  const std::vector<MapIndex>& indices, const std::vector<Manipulator>& finer) {
  MapPoint point{.values = std::vector<double>(indices.size(), not_a_number)};
  if (!is_within_range(manipulator, posture)) return point;
  Flexibility flexibility;
  Vector6 deflection = Vector6::Zero();
  if (is_relaxed_at(manipulator, target)) {
    flexibility = relaxed_flexibility(manipulator, posture.posture, known.relaxed);
  } else if (known.loaded && (known.lasts || lasts_with(finer, target))) {
    flexibility = loaded_flexibility(*known.loaded, size_of(posture.posture));
    deflection = spatial::pose_difference(posture.posture.platform, known.loaded->platform);
  } else {
    const Equilibrium loaded = equilibrium_under_load(manipulator, posture.posture, target.load);
    point.state = MapState::no_equilibrium;
    if (loaded.status != EquilibriumStatus::converged) return point;
    point.state = MapState::unstable;
    if (!loaded.free.stable() || !lasts_with(finer, target)) return point;
    flexibility = loaded_flexibility(loaded, size_of(posture.posture));
    deflection = loaded.displacement.coordinates();
  }
  point.state = flexibility.has_free_motion() ? MapState::free_motion : MapState::reached;
  const auto value = [&](const MapIndex& index) {
    if (index.kind == MapIndex::Kind::critical_force)
      return critical_force(manipulator, target, posture.posture, index, finer);
    if (index.kind == MapIndex::Kind::first_frequency)
      return first_frequency(manipulator, posture.posture);
    return value_of(index, flexibility, deflection);
  };
  std::transform(indices.begin(), indices.end(), point.values.begin(), value);
  return point;
}

// The postures of some poses: together, but for those that hold joints.
std::vector<PostureResult> postures_of(const Manipulator& manipulator, const TargetPose* targets,
                                       std::size_t count) {
  std::vector<spatial::Pose> together;
  for (std::size_t i = 0; i < count; ++i)
    if (targets[i].held.empty()) together.push_back(targets[i].platform);
  std::vector<PostureResult> found = postures_at(manipulator, together), all;
  auto next = found.begin();
  for (std::size_t i = 0; i < count; ++i)
    all.push_back(targets[i].held.empty() ? std::move(*next++)
                                          : posture_to(manipulator, targets[i]));
  return all;
}

// Some poses of those that are treated together.
struct Chosen {
  std::vector<std::size_t> numbers;
  std::vector<Posture> postures;

  void add(std::size_t number, const PostureResult& found) {
    numbers.push_back(number);
    postures.push_back(found.posture);
  }
  std::vector<Load> loads(const TargetPose* targets) const {
    std::vector<Load> all;
    for (const std::size_t i : numbers) all.push_back(targets[i].load);
    return all;
  }
};

// Whether the equilibria that are known last when the beams have twice the segments.
void find_whether_they_last(const TargetPose* targets, const std::vector<Manipulator>& finer,
                            std::vector<Known>& known) {
  Chosen chosen;
  for (std::size_t i = 0; i < known.size(); ++i) {
    known[i].lasts = finer.empty();
    if (finer.empty() || !known[i].loaded) continue;
    if (const PostureResult posture = posture_to(finer[0], targets[i]); posture.reached)
      chosen.add(i, posture);
  }
  if (finer.empty()) return;
  const auto found = stable_equilibria(finer[0], chosen.postures, chosen.loads(targets));
  for (std::size_t k = 0; k < found.size(); ++k)
    known[chosen.numbers[k]].lasts = found[k].has_value();
}

// What is known of poses in whose postures a robot stands.
std::vector<Known> known_of(const Manipulator& manipulator, const TargetPose* targets,
                            const std::vector<PostureResult>& postures,
                            const std::vector<Manipulator>& finer) {
  std::vector<Known> known(postures.size());
  if (!manipulator.is_parallel()) return known;
  Chosen relaxed, loaded;
  for (std::size_t i = 0; i < postures.size(); ++i)
    if (is_within_range(manipulator, postures[i]))
      (is_relaxed_at(manipulator, targets[i]) ? relaxed : loaded).add(i, postures[i]);
  const auto stiffnesses = unloaded_stiffness_matrices(manipulator, relaxed.postures);
  for (std::size_t k = 0; k < stiffnesses.size(); ++k)
    known[relaxed.numbers[k]].relaxed = stiffnesses[k];
  const auto equilibria = stable_equilibria(manipulator, loaded.postures, loaded.loads(targets));
  for (std::size_t k = 0; k < equilibria.size(); ++k)
    known[loaded.numbers[k]].loaded = equilibria[k];
  find_whether_they_last(targets, finer, known);
  return known;
}

// Some poses, all by themselves: first the postures, then what is found of many together.
std::vector<MapPoint> points_of(const Manipulator& manipulator, const TargetPose* targets,
                                std::size_t count, const std::vector<MapIndex>& indices,
                                const std::vector<Manipulator>& finer) {
  const std::vector<PostureResult> postures = postures_of(manipulator, targets, count);
  const std::vector<Known> known = known_of(manipulator, targets, postures, finer);
  std::vector<MapPoint> points;
  for (std::size_t i = 0; i < count; ++i)
    points.push_back(point_in(manipulator, targets[i], postures[i], known[i], indices, finer));
  return points;
}

}  // namespace

spatial::Dimension dimension_of(MapIndex::Kind kind) {
  namespace dimension = spatial::dimension;
  switch (kind) {
    case MapIndex::Kind::rotational:
    case MapIndex::Kind::weakest_rotation:
      return dimension::torsional_stiffness;
    case MapIndex::Kind::condition:
      return dimension::none;
    case MapIndex::Kind::deflection:
      return dimension::length;
    case MapIndex::Kind::rotation:
      return dimension::angle;
    case MapIndex::Kind::first_frequency:
      return {.time = -1};
    case MapIndex::Kind::critical_force:
      return dimension::force;
    default:
      return dimension::linear_stiffness;
  }
}

std::string to_string(MapState state) {
  switch (state) {
    case MapState::reached:
      return "reached";
    case MapState::free_motion:
      return "free motion";
    case MapState::unstable:
      return "unstable";
    case MapState::no_equilibrium:
      return "no equilibrium";
    case MapState::unreachable:
      break;
  }
  return "unreachable";
}

MapPoint map_point(const Manipulator& manipulator, const TargetPose& target,
                   const std::vector<MapIndex>& indices, const std::vector<Manipulator>& finer) {
  refuse_critical_force_beside_a_wrench(target.load, indices);
  return points_of(manipulator, &target, 1, indices, finer).front();
}

std::vector<MapPoint> workspace_map(const Manipulator& manipulator,
                                    const std::vector<TargetPose>& targets,
                                    const std::vector<MapIndex>& indices, int threads,
                                    common::Progress& progress, MapCheckpoint* checkpoint,
                                    const std::vector<Manipulator>& finer) {
  using Clock = std::chrono::steady_clock;
  const auto seconds_since = [](Clock::time_point t) {
    return std::chrono::duration<double>(Clock::now() - t).count();
  };
  std::vector<MapPoint> points;
  if (checkpoint) points = read_map_checkpoint(*checkpoint, targets.size(), indices.size());
  if (checkpoint) checkpoint->found = points.size();
  common::Progress silent;
  Clock::time_point saved = Clock::now();
  for (const TargetPose& target : targets)
    refuse_critical_force_beside_a_wrench(target.load, indices);
  // Blocks of about half a second, so that progress, cancelling and saving come between them; their
  // size has no other effect.
  std::size_t block = 64;
  while (points.size() < targets.size()) {
    const std::size_t first = points.size(), count = std::min(block, targets.size() - first);
    const double done = static_cast<double>(first) / static_cast<double>(targets.size());
    try {
      progress.report("poses", done);
    } catch (const common::Cancelled&) {
      if (checkpoint) write_map_checkpoint(*checkpoint, points, targets.size());
      throw;
    }
    const Clock::time_point began = Clock::now();
    points.resize(first + count);
    // Poses that share what is found of the chains; enough groups for all threads.
    const std::size_t together =
        std::clamp<std::size_t>(count / (4 * static_cast<std::size_t>(threads)), 1, 64);
    const std::size_t groups = (count + together - 1) / together;
    common::parallel_for(groups, threads, "poses", silent, [&](std::size_t g) {
      const std::size_t from = first + g * together;
      const std::size_t size = std::min(together, first + count - from);
      std::vector<MapPoint> found =
          points_of(manipulator, targets.data() + from, size, indices, finer);
      std::move(found.begin(), found.end(), points.begin() + static_cast<std::ptrdiff_t>(from));
    });
    const double took = seconds_since(began);
    if (took < 0.25) block *= 2;
    if (took > 1 && block > 1) block /= 2;
    if (checkpoint && seconds_since(saved) > checkpoint->interval) {
      write_map_checkpoint(*checkpoint, points, targets.size());
      saved = Clock::now();
    }
  }
  if (checkpoint) std::filesystem::remove(checkpoint->file);
  return points;
}

MapRange range_of(const std::vector<MapPoint>& points, std::size_t index) {
  MapRange range;
  double sum = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double value = points[i].values[index];
    if (!std::isfinite(value)) continue;
    ++range.count;
    sum += value;
    if (value < range.smallest) {
      range.smallest = value;
      range.smallest_at = i;
    }
    if (value > range.largest) {
      range.largest = value;
      range.largest_at = i;
    }
  }
  range.mean = range.count > 0 ? sum / static_cast<double>(range.count) : not_a_number;
  return range;
}

}  // namespace kinetostat::vjm
