// Units read and written: "15 um", "210 GPa", "1.0e5 N/mm". Everything inside is SI.
#pragma once

#include <array>
#include <string>
#include <string_view>

namespace kinetostat::spatial {

/// Exponents of metre, kilogram, second, kelvin and radian.
struct Dimension {
  int length = 0, mass = 0, time = 0, temperature = 0, angle = 0;

  bool operator==(const Dimension&) const = default;
};

Dimension operator*(const Dimension& a, const Dimension& b);
Dimension operator/(const Dimension& a, const Dimension& b);
/// For example "kg m^2 s^-2", or "1" for a plain number.
std::string to_string(const Dimension& dimension);

namespace dimension {
inline constexpr Dimension none{};
inline constexpr Dimension length{.length = 1};
inline constexpr Dimension area{.length = 2};
inline constexpr Dimension second_moment{.length = 4};
inline constexpr Dimension mass{.mass = 1};
inline constexpr Dimension time{.time = 1};
inline constexpr Dimension temperature{.temperature = 1};
inline constexpr Dimension angle{.angle = 1};
inline constexpr Dimension force{.length = 1, .mass = 1, .time = -2};
inline constexpr Dimension moment{.length = 2, .mass = 1, .time = -2};
inline constexpr Dimension pressure{.length = -1, .mass = 1, .time = -2};
inline constexpr Dimension density{.length = -3, .mass = 1};
inline constexpr Dimension inertia{.length = 2, .mass = 1};
inline constexpr Dimension linear_stiffness{.mass = 1, .time = -2};
inline constexpr Dimension torsional_stiffness{.length = 2, .mass = 1, .time = -2, .angle = -1};
}  // namespace dimension

/// A unit: how many SI units it is worth. Temperatures are differences (1 degC = 1 K).
struct Unit {
  double factor = 1.0;
  Dimension dimension;
};

/// Reads a unit expression of SI symbols with prefixes (mm, um or µm, kN, GPa, mrad), and min, h,
/// deg, turn, rev, inch, in, lbf, lb, psi, ksi, percent (%), K, degC; with '*' or a blank or '.',
/// '/', '^' or
/// '**' and parentheses. A '/' divides by all that follows up to the next '*', '/' or ')':
/// "N/mm", "kg/m^3", "N*m/rad", "1/(N m)". Throws std::invalid_argument naming the piece that is
/// not understood and the nearest unit that would be.
Unit parse_unit(std::string_view text);

/// Reads "<number> <unit>" and returns the value in SI. A plain number is taken in `default_unit`;
/// when `default_unit` is empty, a unit is required unless a plain number is expected. Either unit
/// must have the dimension `expected`; angles count as plain numbers inside compound units
/// ("N m/rad" and "N m" are both torsional stiffness), but not alone. "inf" is read as infinity.
/// Throws std::invalid_argument saying what was expected and what would work.
double parse_quantity(std::string_view text, const Dimension& expected,
                      std::string_view default_unit = {});

/// Writes an SI value in a unit, with the fewest digits that read back to the same number (or,
/// where the unit's factor allows none, to its neighbour): format_quantity(1.5e-5, "um") == "15
/// um".
std::string format_quantity(double value_in_si, std::string_view unit);

/// The unit-of-measure choices of a file (`units: {length: mm, force: N, angle: deg}`). Bare
/// numbers of compound dimension are taken in the compound of these units, torsional stiffness per
/// radian.
struct UnitSystem {
  std::string length = "m", force = "N", angle = "rad", time = "s", temperature = "K", mass = "kg";

  /// The unit for a bare number, for example "N/mm" for a linear stiffness.
  /// Throws std::invalid_argument for a dimension that no file key has.
  std::string unit_for(const Dimension& dimension) const;
};

}  // namespace kinetostat::spatial
