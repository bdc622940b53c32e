// First screens of `effect list` and `effect show`.
#pragma once

#include <string>

#include "kinetostat/vjm/effects/effect.h"

namespace kinetostat::report {

/// Names by the place where they act.
std::string first_screen(const vjm::EffectKinds& kinds);
/// One line: name, what it acts on, what it is.
std::string line(const vjm::EffectKind& kind);
/// All that is known of it: law, source, signature, nearest confounder, and its parameters with
/// units, physical ranges and prior widths. docs/theory/effects.md shows the same text.
std::string text(const vjm::EffectKind& kind);

}  // namespace kinetostat::report
