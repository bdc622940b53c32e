// Words and numbers of first screens: at most 100 columns, as many digits as a value deserves,
// places as people call them.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "kinetostat/vjm/manipulator/manipulator.h"

namespace kinetostat::report {

inline constexpr std::size_t screen_columns = 100, screen_lines = 25;

/// Text in lines of at most screen_columns (a longer word stands alone); the first is indented by
/// `first` blanks, the others by `rest`. Ends with a line end. Empty for an empty text.
std::string wrapped(const std::string& text, std::size_t first = 0, std::size_t rest = 0);
/// Lines that fit as they are, longer ones wrapped.
std::string wrapped_lines(const std::string& text);
/// A row of a list: `label` padded to `width`, then the text, wrapped beside it.
std::string labelled(const std::string& label, std::size_t width, const std::string& text);
/// "a", "a and b", "a, b and c".
std::string listed(const std::vector<std::string>& words, const std::string& last = "and");
std::string capitalised(std::string text);

/// An error in units of the noise: "1.48", "23.1", "312".
std::string times(double error);
/// Value and standard deviation with the digits that the latter deserves: "0.57 +- 0.04",
/// "1230 +- 70". Four digits without one (NaN, infinite, or 0).
std::string with_error(double value, double deviation);
/// The same of a change in percent: "+16 % +- 7".
std::string change(double factor, double deviation);
/// `digits` significant digits without an exponent where people would write none: "1060",
/// "0.0282", "107,000"; as number() below 0.001 and from ten million on.
std::string figure(double value, int digits = 3);
/// "96 %", "over 99.9 %", "0.0001 %".
std::string short_percent(double share);
/// Odds of something improbable against the rest: "1 : 1,200,000", "below 1 : 10^12".
std::string odds(double probability);
/// "p = 0.02" as people say it: "2 %", "below 1e-8".
std::string chance(double p_value);
std::string minutes(double minutes);

/// "joint q2", "link upper", "platform"; with its chain where several have one of the name ("joint
/// x.rho"); "joint rho of every chain".
std::string place_in_words(const vjm::Manipulator& manipulator, const std::string& at);
/// The name alone: "q2", or "x.rho" where several chains have it.
std::string short_name(const vjm::Manipulator& manipulator, const std::string& name);
/// "clearance at joint x.rho". Effects of the load and of the instrument have no place of their
/// own.
std::string effect_in_words(const vjm::Manipulator& manipulator, const std::string& kind,
                            const std::string& at);

/// The unit in which people read a length of that size [m]: micrometres where it is below a tenth
/// of a millimetre and `own` is metric, else `own`.
std::string length_unit_for(double length, const std::string& own);
/// A length [m] in that unit: "8.17 um", "0.244 mm".
std::string length_in_words(double length, const std::string& own);
/// "N m^-1" as people write it: "N/m"; "K^-1": "1/K"; "N m rad^-1": "N m/rad".
std::string unit_in_words(const std::string& unit);

/// A bar of `length` at most, `share` of it, at least one sign long.
std::string bar(double share, std::size_t length);

/// "Next: kinetostat ..." and what for, on one line if it fits, else on several, as a shell takes
/// them.
std::string next_step(const std::string& command, const std::string& why);
/// An argument as a shell takes it.
std::string quoted(const std::filesystem::path& file);

}  // namespace kinetostat::report
