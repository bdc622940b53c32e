// Robots given by Denavit and Hartenberg's parameters.
#pragma once

#include "kinetostat/vjm/exchange/robot_description.h"

namespace kinetostat::vjm {

/// `standard`: Rz(theta) Tz(d) Tx(a) Rx(alpha) behind the axis of each joint (Denavit and
/// Hartenberg 1955); `modified`: Rx(alpha) Tx(a) before it and Rz(theta) Tz(d) behind it (Craig
/// 1986). The joint turns on from theta, or slides on from d.
enum class DhConvention { standard, modified };

/// A table of these (docs/reference/import.md): YAML with `dh: standard` or `modified`, or CSV with
/// a column `convention`. Throws common::InputError with file and line.
RobotDescription read_dh_table(const std::filesystem::path& file);

}  // namespace kinetostat::vjm
