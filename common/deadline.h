// One limit of time for several attempts.
#pragma once

#include <algorithm>
#include <chrono>

namespace kinetostat::common {

class Deadline {
 public:
  explicit Deadline(double seconds) : seconds_(seconds) {}

  double elapsed() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  }
  /// [s], 0 when it is over.
  double left() const { return std::max(0.0, seconds_ - elapsed()); }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  double seconds_;
};

}  // namespace kinetostat::common
