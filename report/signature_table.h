// Residual and signatures of a diagnosis as a table, for methods other than ours.
#pragma once

#include <string>

#include "kinetostat/calibration/search/signature_table.h"

namespace kinetostat::report {

/// CSV: reading, component, residual; then "fit: NAME" for what is fitted anyway, and a column for
/// each of a candidate's directions, "EFFECT at PLACE" and "EFFECT at PLACE (2)". In units of the
/// noise.
std::string signature_csv(const calibration::Campaign& campaign,
                          const calibration::SignatureTable& table);

}  // namespace kinetostat::report
