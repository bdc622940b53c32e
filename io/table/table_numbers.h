// Numbers as tables hold them: with a decimal point or comma, and separators of thousands.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace kinetostat::io {

enum class DecimalSign { unknown, point, comma };

/// What one cell says of the sign in use: "0,5" and "1.234,5" are commas, "0.5" and "1,234,567"
/// points. Unknown for "12", for what is no number, and for "1,234" and "1.234", which may be
/// either.
DecimalSign decimal_sign_of(std::string_view cell);

/// "1,234" or "1.234": one sign before three digits, which may separate thousands.
bool is_ambiguous_number(std::string_view cell);

/// The number as C++ reads it: with a decimal point, without separators of thousands ('.' or ',',
/// the one that is not the decimal sign; an apostrophe or a blank; each before exactly three
/// digits), with a hyphen for a minus sign. nullopt for what is no number with this decimal sign.
std::optional<std::string> plain_number(std::string_view cell, DecimalSign decimal);

}  // namespace kinetostat::io
