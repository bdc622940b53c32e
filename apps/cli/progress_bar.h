// Progress on standard error: a bar on a terminal, in a log each phase once and how far it is every
// ten seconds.
#pragma once

#include <chrono>
#include <cstdio>
#include <deque>
#include <mutex>
#include <optional>
#include <set>
#include <string>

#include "kinetostat/common/progress.h"

namespace kinetostat::apps {

/// "1:05" for 65 s, "2:00:00" for two hours.
std::string clock_text(double seconds);

/// How fast a computation goes: by the later half of the time that it has had, so that what was
/// found in a cache at the start makes nobody hope that the rest is as quick.
class Pace {
 public:
  /// `fraction` is done after so many seconds; times ascend.
  void add(double seconds, double fraction);
  /// Seconds that are left; nothing in the first second, or where nothing moves.
  std::optional<double> left() const;

 private:
  struct Moment {
    double seconds = 0, fraction = 0;
  };
  std::deque<Moment> past_;  // from half of the time on, or just before
  Moment now_;
};

class ProgressBar : public common::Progress {
 public:
  enum class Style { none, lines, bar };

  /// A bar when `stream` is a terminal that can redraw a line, otherwise lines.
  static Style style_for(std::FILE* stream);

  ProgressBar(std::FILE* stream, Style style);
  ~ProgressBar() override { wipe(); }

  /// Takes the bar off the screen, before something else is printed.
  void wipe();
  bool cancelled() const override;

 private:
  using Clock = std::chrono::steady_clock;

  void show(std::string_view phase, double fraction) override;
  void draw_bar(double fraction);
  void print_line(double fraction);
  void put(const std::string& text);
  std::string time_left() const;

  std::FILE* stream_;
  Style style_;
  std::mutex mutex_;
  std::string phase_;
  Clock::time_point phase_began_;
  Pace pace_;
  Clock::time_point last_shown_;
  bool drawn_ = false;
  std::set<std::string, std::less<>> named_;  // phases that a log has the names of
};

}  // namespace kinetostat::apps
