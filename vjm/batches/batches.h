// Many postures of a manipulator at a time, in the vector registers of the processor.
//
// What each gets is to rounding what it gets alone, and none knows of the others: results do not
// depend on what is asked together.
#pragma once

#include <optional>
#include <vector>

#include "kinetostat/spatial/stiffness.h"
#include "kinetostat/vjm/manipulator/posture.h"
#include "kinetostat/vjm/statics/equilibrium_result.h"
#include "kinetostat/vjm/statics/load.h"

namespace kinetostat::vjm {

/// posture_at() of many poses: four at a time where the chains allow it.
std::vector<PostureResult> postures_at(const Manipulator& manipulator,
                                       const std::vector<spatial::Pose>& targets,
                                       const PostureOptions& options = {});

/// unloaded_stiffness_matrix() of many postures: four at a time where the chains allow it and no
/// joint has a law.
std::vector<std::optional<spatial::Stiffness6>> unloaded_stiffness_matrices(
    const Manipulator& manipulator, const std::vector<Posture>& postures);

/// Of equilibrium_under_load(): where the platform stands, and the tangent stiffness there.
struct StableEquilibrium {
  spatial::Pose platform;
  spatial::Stiffness6 stiffness;
};

/// Of many postures, each under its load, those that Newton's method reaches in whole steps and
/// that are clearly stable, of robots whose chains all run from base to platform, with six springs
/// at least and no laws beside them. Nothing for the others, of which equilibrium_under_load() has
/// more to say.
std::vector<std::optional<StableEquilibrium>> stable_equilibria(
    const Manipulator& manipulator, const std::vector<Posture>& postures,
    const std::vector<Load>& loads, const EquilibriumOptions& options = {});

}  // namespace kinetostat::vjm
