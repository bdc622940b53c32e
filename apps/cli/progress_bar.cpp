#include "kinetostat/apps/cli/progress_bar.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <unistd.h>

#include <fmt/format.h>

#include "kinetostat/apps/cli/cancellation.h"

namespace kinetostat::apps {
namespace {

constexpr std::chrono::milliseconds redraw_interval{100};
constexpr std::chrono::seconds line_interval{10};
constexpr int bar_width = 30;

}  // namespace

std::string clock_text(double seconds) {
  const long total = std::lround(std::min(std::max(seconds, 0.0), 3.6e6));
  const long h = total / 3600, m = total / 60 % 60, s = total % 60;
  return h > 0 ? fmt::format("{}:{:02}:{:02}", h, m, s) : fmt::format("{}:{:02}", m, s);
}

void Pace::add(double seconds, double fraction) {
  now_ = {seconds, fraction};
  // A hundredth of the time apart: never many.
  if (past_.empty() || seconds - past_.back().seconds > 0.01 * seconds) past_.push_back(now_);
  while (past_.size() > 1 && past_[1].seconds <= seconds / 2) past_.pop_front();
}

std::optional<double> Pace::left() const {
  if (now_.seconds < 1 || past_.empty() || now_.fraction >= 1) return std::nullopt;
  const double gained = now_.fraction - past_.front().fraction;
  if (!(gained > 0)) return std::nullopt;
  return (1 - now_.fraction) / gained * (now_.seconds - past_.front().seconds);
}

ProgressBar::Style ProgressBar::style_for(std::FILE* stream) {
  const char* terminal = std::getenv("TERM");
  const bool dumb = terminal == nullptr || std::string_view(terminal) == "dumb";
  return ::isatty(::fileno(stream)) && !dumb ? Style::bar : Style::lines;
}

ProgressBar::ProgressBar(std::FILE* stream, Style style) : stream_(stream), style_(style) {}

void ProgressBar::wipe() {
  if (drawn_) std::fputs("\r\x1b[K", stream_);
  drawn_ = false;
}

bool ProgressBar::cancelled() const { return cancelling_signal() != 0; }

void ProgressBar::show(std::string_view phase, double fraction) {
  if (style_ == Style::none) return;
  const std::scoped_lock lock(mutex_);
  const Clock::time_point now = Clock::now();
  const bool new_phase = phase != phase_;
  if (new_phase) {
    phase_ = phase;
    phase_began_ = now;
    pace_ = {};
  }
  pace_.add(std::chrono::duration<double>(now - phase_began_).count(), fraction);
  if (style_ == Style::bar && (new_phase || now - last_shown_ >= redraw_interval)) {
    draw_bar(fraction);
    last_shown_ = now;
  }
  const bool unnamed = new_phase && named_.emplace(phase).second;
  if (style_ == Style::lines && (unnamed || now - last_shown_ >= line_interval)) {
    print_line(fraction);
    last_shown_ = now;
  }
}

void ProgressBar::draw_bar(double fraction) {
  const int filled = static_cast<int>(std::lround(std::clamp(fraction, 0.0, 1.0) * bar_width));
  put(fmt::format("\r\x1b[K{:<28.28} [{:#<{}}{:.<{}}] {:3.0f} %{}", phase_, "", filled, "",
                  bar_width - filled, 100 * fraction, time_left()));
  drawn_ = true;
}

void ProgressBar::print_line(double fraction) {
  put(fraction > 0 ? fmt::format("{}: {:.0f} %{}\n", phase_, 100 * fraction, time_left())
                   : fmt::format("{}\n", phase_));
}

// A computation goes on whether anybody can see how far it is or not.
void ProgressBar::put(const std::string& text) {
  std::fputs(text.c_str(), stream_);
  std::fflush(stream_);
}

std::string ProgressBar::time_left() const {
  const std::optional<double> seconds = pace_.left();
  return seconds ? fmt::format(", {} left", clock_text(*seconds)) : "";
}

}  // namespace kinetostat::apps
