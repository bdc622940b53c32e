// How far a long computation is, and whether it should stop.
#pragma once

#include <stdexcept>
#include <string_view>

namespace kinetostat::common {

/// Thrown out of a computation that its user has cancelled.
class Cancelled : public std::runtime_error {
 public:
  Cancelled() : std::runtime_error("cancelled") {}
};

/// Handed down through every computation that may take longer than a second. This class itself
/// shows nothing and never cancels: what a library user gets who does not ask for progress.
class Progress {
 public:
  Progress() = default;
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  virtual ~Progress() = default;

  /// `fraction` in [0, 1] of the named phase is done; a new name starts a new phase. Throws
  /// Cancelled when the user has asked to stop, so call it where unwinding is safe: not inside a
  /// parallel region. Cheap enough for every iteration of a solver.
  void report(std::string_view phase, double fraction) {
    show(phase, fraction);
    if (cancelled()) throw Cancelled();
  }
  /// For places that cannot throw, such as parallel loops. May be called from any thread.
  virtual bool cancelled() const { return false; }

 private:
  virtual void show(std::string_view /*phase*/, double /*fraction*/) {}
};

/// A part of a computation that reports its progress as a whole: shows nothing, and stops when the
/// whole is to stop.
class SilentPart : public Progress {
 public:
  explicit SilentPart(const Progress& whole) : whole_(whole) {}
  bool cancelled() const override { return whole_.cancelled(); }

 private:
  const Progress& whole_;
};

}  // namespace kinetostat::common
