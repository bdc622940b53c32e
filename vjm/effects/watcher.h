// A manipulator as it is watched: its equilibria, and how what is seen of them changes.
#pragma once

#include <vector>

#include "kinetostat/vjm/effects/reading_errors.h"
#include "kinetostat/vjm/effects/sensitivity.h"
#include "kinetostat/vjm/effects/watch.h"
#include "kinetostat/vjm/manipulator/manipulator.h"

namespace kinetostat::vjm {

/// The manipulator with a node for each frame on a chain, so that effects move them with what they
/// change. Throws std::invalid_argument for an unknown place, with did-you-mean.
Manipulator with_watched(const Manipulator& manipulator, const Watch& watch);

/// Unit vector against gravity, base axes; z where there is none.
spatial::Vector3 vertical(const Manipulator& manipulator);

/// How many rows its derivatives have.
inline Eigen::Index watched_rows(const Watch& watch) {
  return 6 * std::ssize(watch.frames) + 2 * std::ssize(watch.joints);
}

/// In a posture whose springs are relaxed; derivatives by `parameters` parameters are zero.
Watched watched_at_rest(const Watch& watch, const Manipulator& manipulator, const Posture& posture,
                        Eigen::Index parameters);

/// An equilibrium as it is watched. All arguments must outlive it. `manipulator` is that of
/// with_watched(), with its effects.
class Watcher {
 public:
  Watcher(const Watch& watch, const EquilibriumResiduals& at, const ReadingErrors& errors);

  Watched values() const { return values_; }
  /// The chains whose coordinates change() needs.
  static std::vector<std::size_t> chains_of(const Watch& watch);
  /// Rows of Watched::derivatives for a change of the equations and of the state by it. `errors`:
  /// the change of the readings' errors (nullptr: none).
  Eigen::VectorXd change(const EquationChange& equations, const StateDerivative& state,
                         const ReadingErrors* errors) const;

 private:
  spatial::Vector6 motion_of(const CarriedFrame& frame, std::size_t index,
                             const EquationChange& equations, const StateDerivative& state) const;

  const Watch& watch_;
  const EquilibriumResiduals& at_;
  ReadingErrors errors_;
  std::vector<spatial::Pose> carried_;  // the frames without errors of the instrument
  std::vector<const Node*> nodes_;      // of frames on chains
  Watched values_;
};

}  // namespace kinetostat::vjm
