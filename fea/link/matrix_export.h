// The reduced matrix of a link as text for other programs.
#pragma once

#include <string>

#include "kinetostat/fea/link/identify.h"
#include "kinetostat/fea/link/modal_study.h"

namespace kinetostat::fea {

/// The flexibility between the loaded interfaces, made symmetric, SI units. One column a load
/// ("tip.Fx"), one row a motion, named in the first cell ("tip.tx").
std::string flexibility_csv(const LinkResult& result);

/// The same as a MATLAB (or GNU Octave) script that defines `flexibility`, `stiffness`, `motions`,
/// `loads` and `points`.
std::string flexibility_matlab(const LinkResult& result);

/// `model` of the link as such a script, SI units: `name`, `freedoms` ("fixed.tx" .. "mode 1" ..),
/// `origins` of the interfaces, `K`, `M`.
std::string reduced_matlab(const ModalResult& result, const ReducedModel& model);

}  // namespace kinetostat::fea
