// Where a signed number is an index into a container of the standard library.
#pragma once

#include <concepts>
#include <cstddef>

namespace kinetostat::common {

/// The same number without a sign. Requires i >= 0.
constexpr std::size_t at(std::signed_integral auto i) { return static_cast<std::size_t>(i); }

}  // namespace kinetostat::common
