#include "kinetostat/fea/blas.h"

#include <dlfcn.h>

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

OneBlasThread::OneBlasThread() : before_(blas_info().threads) { set_blas_threads(1); }

OneBlasThread::~OneBlasThread() {
  if (before_ > 0) set_blas_threads(before_);
}

}  // namespace kinetostat::fea
