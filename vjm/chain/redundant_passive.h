// Passive joints that repeat what others of their chain do. Internal to this module.
#pragma once

#include <vector>

#include "kinetostat/vjm/chain/kinematics.h"

namespace kinetostat::vjm {

/// Passive coordinates without a spring or a law.
std::vector<Eigen::Index> perfect_passive(const Chain& chain);

/// Perfect passive coordinates that may be held without changing what the chain can do: one for
/// every motion inside the chain that, in every configuration, moves neither of its ends and
/// deforms nothing, such as the spin of a leg between two spherical joints. `at` is the state where
/// the others must do as well without them.
std::vector<Eigen::Index> redundant_passive(const Chain& chain, const ChainKinematics& at);

}  // namespace kinetostat::vjm
