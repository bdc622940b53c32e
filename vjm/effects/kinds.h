// The kinds of effects, one file each. Internal to this room; effect.h lists them.
#pragma once

#include "kinetostat/vjm/effect.h"

namespace kinetostat::vjm::effects {

EffectKind joint_compliance();
EffectKind link_compliance();
EffectKind hardening();
EffectKind clearance();
EffectKind preload();
EffectKind payload();

/// The spring of a joint. Throws std::invalid_argument when the joint has none.
const Spring& spring_of_joint(const Chain& chain, const std::string& joint);

}  // namespace kinetostat::vjm::effects
