// Which joint or link yields: the share of every spring in a compliance.
#pragma once

#include <string>
#include <vector>

#include "kinetostat/vjm/manipulator/manipulator.h"
#include "kinetostat/vjm/manipulator/posture.h"

namespace kinetostat::vjm {

struct SpringShare {
  std::size_t chain = 0;  // of an elastic body the first
  std::string spring;     // a joint, a link, or an elastic body
  double share = 0;
};

/// "x.leg" of a spring in chain x, "frame" of an elastic body.
std::string name_of(const Manipulator& manipulator, const SpringShare& share);

/// Let the platform yield by c f under a small force f along a unit vector n at its reference point
/// (base axes), and the deflections of spring k change by d_k with it. Then by Castigliano
///
///     c = sum over k of d_k' K_k d_k / f^2,   share_k = d_k' K_k d_k / (c f^2) = -d ln c / d ln
///     K_k,
///
/// which add up to 1. The largest first; springs that take nothing are left out. Weight and
/// preloads act in both states. Empty where the platform stands in no equilibrium, or nothing
/// resists the force.
std::vector<SpringShare> spring_shares(const Manipulator& manipulator, const Posture& posture,
                                       const spatial::Vector3& direction);

}  // namespace kinetostat::vjm
