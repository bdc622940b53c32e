// Dates and times of day as loggers write them.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace kinetostat::calibration {

struct ClockTime {
  std::optional<long> day;  // since 1970-01-01; nullopt for a time of day alone
  double seconds = 0;       // of the day [s]; a zone that is given is taken off
};

/// ISO 8601 ("2026-05-03T14:22:05.100Z", with a blank for the T, with a comma in the seconds, the
/// date alone), "2026/05/03 ...", "03.05.2026 ...", and times of day "14:22:05.1", "14:22",
/// "2:22:05 PM". nullopt for anything else, so for "5/3/2026", which is May or March.
std::optional<ClockTime> read_clock_time(std::string_view text);

/// The day of what read_clock_time() reads as a date, "2026-05-03"; empty for anything else.
std::string iso_date(std::string_view text);

/// "5/3/2026": two numbers, either of which may be the month.
bool is_ambiguous_date(std::string_view text);

}  // namespace kinetostat::calibration
