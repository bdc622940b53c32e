// How large a number in a file may be.
#pragma once

namespace kinetostat::io {

/// Beyond it squares and products overflow, and a matrix of NaN would be the answer.
inline constexpr double largest_number = 1e100;

}  // namespace kinetostat::io
