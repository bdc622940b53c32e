#include "kinetostat/fea/linear_algebra/blas.h"

#include <cstddef>
#include <dlfcn.h>
#include <new>
#include <sys/mman.h>
#include <vector>

namespace kinetostat::fea {
namespace {

// OpenBLAS is linked through CHOLMOD and may be replaced by another BLAS when the program runs.
template <class Function>
Function* find_function(const char* name) {
  return reinterpret_cast<Function*>(dlsym(RTLD_DEFAULT, name));
}

void set_blas_threads(int threads) {
  if (auto* set = find_function<void(int)>("openblas_set_num_threads")) set(threads);
}

using MatrixProduct = void(const char*, const char*, const int*, const int*, const int*,
                           const double*, const double*, const int*, const double*, const int*,
                           const double*, double*, const int*);

// OpenBLAS takes 128 MiB of address space at its first product of matrices, keeps them, and asks
// for them for ever where they are not to be had. So it is made to take them where they are.
// Throws std::bad_alloc where they are not.
bool reserve_memory_of_blas() {
  constexpr std::size_t wanted = std::size_t{160} << 20;
  auto* multiply = find_function<MatrixProduct>("dgemm_");
  if (multiply == nullptr || find_function<char*()>("openblas_get_config") == nullptr) return true;
  void* room = mmap(nullptr, wanted, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (room == MAP_FAILED) throw std::bad_alloc();
  munmap(room, wanted);
  constexpr int n = 160;  // small ones are multiplied without that memory
  const std::vector<double> a(std::size_t{n} * n, 1);
  std::vector<double> product(a.size());
  const double one = 1, zero = 0;
  multiply("N", "N", &n, &n, &n, &one, a.data(), &n, a.data(), &n, &zero, product.data(), &n);
  return true;
}

}  // namespace

std::string BlasInfo::warning() const {
  if (threading == Threading::openmp)
    return "this OpenBLAS is the OpenMP flavour, several times slower here with more than one "
           "thread; install libopenblas0-pthread";
  if (threading == Threading::unknown)
    return "the BLAS in use is not OpenBLAS; install libopenblas0-pthread for speed";
  return {};
}

BlasInfo blas_info() {
  BlasInfo info;
  if (auto* config = find_function<char*()>("openblas_get_config")) info.name = config();
  if (auto* parallel = find_function<int()>("openblas_get_parallel")) {
    const int kind = parallel();
    info.threading = kind == 0   ? BlasInfo::Threading::none
                     : kind == 1 ? BlasInfo::Threading::pthread
                                 : BlasInfo::Threading::openmp;
  }
  if (auto* count = find_function<int()>("openblas_get_num_threads")) info.threads = count();
  return info;
}

OneBlasThread::OneBlasThread() : before_(blas_info().threads) {
  set_blas_threads(1);
  static const bool reserved = reserve_memory_of_blas();
  static_cast<void>(reserved);
}

OneBlasThread::~OneBlasThread() {
  if (before_ > 0) set_blas_threads(before_);
}

}  // namespace kinetostat::fea
