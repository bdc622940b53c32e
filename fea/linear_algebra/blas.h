// The BLAS that the factorisation runs on: which one, how many threads.
#pragma once

#include <string>

namespace kinetostat::fea {

struct BlasInfo {
  enum class Threading { unknown, none, pthread, openmp };
  std::string name = "unknown BLAS";  // OpenBLAS says version, options and processor
  Threading threading = Threading::unknown;
  int threads = 0;  // 0: unknown

  /// Empty, or what slows the factorisation down and its cure.
  std::string warning() const;
};

BlasInfo blas_info();

/// Keeps OpenBLAS at one thread while it lives (for the whole process; another BLAS is left alone).
/// With several threads the order of its sums, and so the last digits, depend on their number.
class OneBlasThread {
 public:
  /// Throws std::bad_alloc where OpenBLAS would wait for memory for ever.
  OneBlasThread();
  ~OneBlasThread();
  OneBlasThread(const OneBlasThread&) = delete;
  OneBlasThread& operator=(const OneBlasThread&) = delete;

 private:
  int before_;
};

}  // namespace kinetostat::fea
