// The falling error as bars of text.
#pragma once

#include <string>
#include <vector>

#include "kinetostat/calibration/comparison/waterfall.h"

namespace kinetostat::report {

/// One row a stage: its name (`names`, each for one stage, else in words), a bar, the error
/// in units of the noise and its 95 % interval; the noise last. The stage "as adopted", which
/// counts other readings, is left out. Empty without stages.
std::string falling_error(const std::vector<calibration::WaterfallStage>& stages,
                          std::vector<std::pair<std::string, std::string>> names);
/// "1.48 -> 1.17 -> 1.01".
std::string fall_in_words(const std::vector<calibration::WaterfallStage>& stages);

}  // namespace kinetostat::report
