// Error estimate of a link's compliance, for programs.
#pragma once

#include "kinetostat/fea/refinement.h"
#include "kinetostat/files/json.h"

namespace kinetostat::fea {

/// The key `error` of the link result file (docs/reference/link-file.md).
files::Json to_json(const Accuracy& accuracy);

}  // namespace kinetostat::fea
