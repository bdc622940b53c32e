// Long computations for a caller in Python.
#pragma once

#include <functional>
#include <pybind11/pybind11.h>

#include "kinetostat/common/progress.h"

namespace kinetostat::python {

/// Does the work in a thread of its own, without Python's lock, while the calling thread waits and
/// hands on what is reported to `progress` (None, or a callable that takes the phase and the
/// fraction done). Ctrl-C and an exception of `progress` stop the work and are thrown from here.
/// Throws what the work throws.
void run_long(const pybind11::object& progress, const std::function<void(common::Progress&)>& work);

/// 0 stands for all processors.
int thread_count(int asked);

}  // namespace kinetostat::python
