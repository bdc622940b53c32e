// Error estimate of a link's compliance, for people and for programs.
#pragma once

#include <string>

#include "kinetostat/fea/link/identify.h"
#include "kinetostat/io/json.h"

namespace kinetostat::report {

/// Error bars of the compliance, whether the accuracy was reached, and the meshes on the way.
std::string accuracy_text(const fea::LinkResult& result);
/// The key `error` of the link result file (docs/reference/link-file.md).
io::Json to_json(const fea::Accuracy& accuracy);

}  // namespace kinetostat::report
