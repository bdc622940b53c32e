// The reduced matrix of a link as text for other programs.
#pragma once

#include <string>

#include "kinetostat/fea/link/identify.h"

namespace kinetostat::fea {

/// The flexibility between the loaded interfaces, made symmetric, SI units. One column a load
/// ("tip.Fx"), one row a motion, named in the first cell ("tip.tx").
std::string flexibility_csv(const LinkResult& result);

/// The same as a MATLAB (or GNU Octave) script that defines `flexibility`, `stiffness`, `motions`,
/// `loads` and `points`.
std::string flexibility_matlab(const LinkResult& result);

}  // namespace kinetostat::fea
