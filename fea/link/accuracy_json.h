// Error estimate of a link's compliance, for programs.
#pragma once

#include "kinetostat/fea/link/refinement.h"
#include "kinetostat/io/json.h"

namespace kinetostat::fea {

/// The key `error` of the link result file (docs/reference/link-file.md).
io::Json to_json(const Accuracy& accuracy);

}  // namespace kinetostat::fea
