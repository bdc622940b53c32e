// What several chains have in common: the foundation that they stand on, and what the platform
// holds its tool with.
#pragma once

#include <cstddef>
#include <limits>
#include <string>

#include "kinetostat/vjm/manipulator/manipulator.h"

namespace kinetostat::vjm {

/// Chains from the base start on a foundation instead; the platform of the chains becomes an inner
/// body, which holds the platform, with the tool, behind all of them. Both stand on rigid chains,
/// the last ones of the manipulator, which have no coordinates until effects let them yield: the
/// first at the base frame, the other where the chains end, on average.
struct SharedMounts {
  /// Stand for the numbers of the two chains, which depend on the manipulator.
  static constexpr std::size_t foundation = std::numeric_limits<std::size_t>::max() - 1;
  static constexpr std::size_t tool = std::numeric_limits<std::size_t>::max();

  bool has_foundation = false, has_tool = false;

  bool any() const { return has_foundation || has_tool; }
  /// Of one of those numbers, in the manipulator with mounts; every other number as it is.
  std::size_t chain(std::size_t number, const Manipulator& without) const;
  Manipulator on(const Manipulator& without) const;
  /// The posture of that, from one of the manipulator without.
  Posture on(const Posture& without, const Manipulator& with) const;
};

/// Whether several chains, but no elastic body, stand on the base; whether they carry the platform.
/// A single chain has places of its own for either.
bool may_have_foundation(const Manipulator& manipulator);
bool may_have_tool(const Manipulator& manipulator);

}  // namespace kinetostat::vjm
