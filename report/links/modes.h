// Natural frequencies of a link, for people and for programs.
#pragma once

#include <string>

#include "kinetostat/fea/link/modal_study.h"
#include "kinetostat/io/json.h"

namespace kinetostat::report {

/// Modes `first` to `end` - 1, a row each: frequency, error, shares of the motion along the axes.
std::string mode_table(const fea::ModalResult& result, std::size_t first, std::size_t end);
/// All modes, what takes part of the mass when the support shakes, and the meshes on the way.
std::string text(const fea::ModalResult& result);

/// docs/reference/modes.md, in SI units.
io::Json to_json(const fea::ModalResult& result);

}  // namespace kinetostat::report
