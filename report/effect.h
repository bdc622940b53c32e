// Kinds of effects as people and programs read them.
#pragma once

#include <string>

#include "kinetostat/io/json.h"
#include "kinetostat/vjm/io/robot_file.h"

namespace kinetostat::report {

/// Unit in SI of a parameter ("N m/rad"); empty where it has none. `angular`: it acts on a turn.
std::string unit_of(const vjm::EffectParameter& parameter, bool angular);
/// What the width of its prior is counted in: "times the stiffness of the joint's spring", "SI".
std::string prior_unit(const vjm::EffectParameter& parameter);
/// Where it can act in a robot; a sentence.
std::string places_text(const std::shared_ptr<const vjm::EffectKind>& kind,
                        const vjm::Robot& robot);

io::Json to_json(const vjm::EffectKind& kind);

}  // namespace kinetostat::report
