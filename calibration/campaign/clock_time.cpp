#include "kinetostat/calibration/campaign/clock_time.h"

#include <charconv>
#include <chrono>
#include <string>

#include <fmt/format.h>

namespace kinetostat::calibration {
namespace {

bool is_digit(char c) { return c >= '0' && c <= '9'; }

// A text that is read from its front, piece by piece.
class Pieces {
 public:
  explicit Pieces(std::string_view text) : text_(text) {}

  bool at_end() const { return text_.empty(); }
  bool take(std::string_view start) {
    if (!text_.starts_with(start)) return false;
    text_.remove_prefix(start.size());
    return true;
  }
  void skip_blanks() {
    while (take(" ")) {
    }
  }
  // A whole number of `least` to `most` digits.
  std::optional<int> number(std::size_t least, std::size_t most) {
    std::size_t count = 0;
    while (count < text_.size() && is_digit(text_[count])) ++count;
    if (count < least || count > most) return std::nullopt;
    int value = 0;
    std::from_chars(text_.data(), text_.data() + count, value);
    text_.remove_prefix(count);
    return value;
  }
  // The digits after a decimal sign.
  double fraction() {
    if (!take(".") && !take(",")) return 0;
    std::string digits = "0.";
    while (!text_.empty() && is_digit(text_[0])) {
      digits += text_[0];
      text_.remove_prefix(1);
    }
    double value = 0;
    std::from_chars(digits.data(), digits.data() + digits.size(), value);
    return value;
  }

 private:
  std::string_view text_;
};

std::optional<long> day_of(int year, int month, int day) {
  const std::chrono::year_month_day date(std::chrono::year{year},
                                         std::chrono::month{static_cast<unsigned>(month)},
                                         std::chrono::day{static_cast<unsigned>(day)});
  if (!date.ok()) return std::nullopt;
  return std::chrono::sys_days(date).time_since_epoch().count();
}

// "2026-05-03", "2026/05/03" or "03.05.2026".
std::optional<long> read_date(Pieces& pieces) {
  const auto three = [](Pieces& p, std::string_view separator, bool year_first) {
    const auto a = year_first ? p.number(4, 4) : p.number(1, 2);
    if (!a || !p.take(separator)) return std::optional<long>();
    const auto b = p.number(1, 2);
    if (!b || !p.take(separator)) return std::optional<long>();
    const auto c = year_first ? p.number(1, 2) : p.number(4, 4);
    if (!c) return std::optional<long>();
    return year_first ? day_of(*a, *b, *c) : day_of(*c, *b, *a);
  };
  for (const auto& [separator, year_first] :
       {std::pair("-", true), std::pair("/", true), std::pair(".", false)}) {
    Pieces tried = pieces;
    if (const auto day = three(tried, separator, year_first)) {
      pieces = tried;
      return day;
    }
  }
  return std::nullopt;
}

// "14:22", "14:22:05.1", "2:22 PM".
std::optional<double> read_time_of_day(Pieces& pieces) {
  auto hour = pieces.number(1, 2);
  if (!hour || !pieces.take(":")) return std::nullopt;
  const auto minute = pieces.number(2, 2);
  if (!minute) return std::nullopt;
  double seconds = 0;
  if (pieces.take(":")) {
    const auto whole = pieces.number(2, 2);
    if (!whole || *whole > 60) return std::nullopt;
    seconds = *whole + pieces.fraction();
  }
  pieces.skip_blanks();
  const bool morning = pieces.take("AM") || pieces.take("am") || pieces.take("a.m.");
  const bool afternoon =
      !morning && (pieces.take("PM") || pieces.take("pm") || pieces.take("p.m."));
  if ((morning || afternoon) && (*hour < 1 || *hour > 12)) return std::nullopt;
  if (morning || afternoon) hour = *hour % 12 + (afternoon ? 12 : 0);
  if (*hour > 24 || *minute > 59) return std::nullopt;
  return *hour * 3600.0 + *minute * 60.0 + seconds;
}

// "Z", "+02:00", "-0500": how far local time is ahead [s].
std::optional<double> read_zone(Pieces& pieces) {
  if (pieces.at_end() || pieces.take("Z") || pieces.take("UTC")) return 0;
  const bool behind = pieces.take("-");
  if (!behind && !pieces.take("+")) return std::nullopt;
  std::optional<int> hours = pieces.number(2, 2), minutes = 0;
  if (hours && pieces.take(":")) minutes = pieces.number(2, 2);
  if (!hours && (hours = pieces.number(4, 4))) {
    minutes = *hours % 100;
    hours = *hours / 100;
  }
  if (!hours || !minutes) return std::nullopt;
  return (behind ? -1 : 1) * (*hours * 3600.0 + *minutes * 60.0);
}

}  // namespace

std::optional<ClockTime> read_clock_time(std::string_view text) {
  Pieces pieces(text);
  ClockTime time;
  time.day = read_date(pieces);
  if (time.day) {
    if (pieces.at_end()) return time;
    if (!pieces.take("T") && !pieces.take(" ")) return std::nullopt;
    pieces.skip_blanks();
  }
  const auto seconds = read_time_of_day(pieces);
  if (!seconds) return std::nullopt;
  const auto ahead = read_zone(pieces);
  if (!ahead || !pieces.at_end()) return std::nullopt;
  time.seconds = *seconds - *ahead;
  return time;
}

std::string iso_date(std::string_view text) {
  const auto time = read_clock_time(text);
  if (!time || !time->day) return {};
  const std::chrono::year_month_day date{std::chrono::sys_days(std::chrono::days(*time->day))};
  return fmt::format("{:04}-{:02}-{:02}", static_cast<int>(date.year()),
                     static_cast<unsigned>(date.month()), static_cast<unsigned>(date.day()));
}

bool is_ambiguous_date(std::string_view text) {
  Pieces pieces(text);
  return pieces.number(1, 2) && pieces.take("/") && pieces.number(1, 2) && pieces.take("/") &&
         pieces.number(2, 4);
}

}  // namespace kinetostat::calibration
