// Kinds of effects as people and programs read them.
#pragma once

#include <string>

#include "kinetostat/io/json.h"
#include "kinetostat/vjm/io/robot_file.h"

namespace kinetostat::report {

/// One line: name, what it acts on, what it is.
std::string line(const vjm::EffectKind& kind);
/// All that is known of it: law, source, signature, nearest confounder, and its parameters with
/// units, physical ranges and prior widths. docs/theory/effects.md shows the same text.
std::string text(const vjm::EffectKind& kind);
/// Unit in SI of a parameter ("N m/rad"); empty where it has none. `angular`: it acts on a turn.
std::string unit_of(const vjm::EffectParameter& parameter, bool angular);
/// Where it can act in a robot; a sentence.
std::string places_text(const vjm::EffectKind& kind, const vjm::Robot& robot);

io::Json to_json(const vjm::EffectKind& kind);

}  // namespace kinetostat::report
