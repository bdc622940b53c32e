// Error estimate of a link's compliance, for people.
#pragma once

#include <string>

#include "kinetostat/fea/link/identify.h"

namespace kinetostat::apps {

/// The error bars of every printed 6x6 as a matrix, the meshes that led to them, and sentences on
/// convergence. Ends with a line end.
std::string accuracy_text(const fea::LinkResult& result);

}  // namespace kinetostat::apps
