// The extension module kinetostat._core.
#include "kinetostat/apps/cli/version.h"
#include "kinetostat/python/bindings.h"

PYBIND11_MODULE(_core, module) {
  module.attr("__version__") = kinetostat::apps::version();
  kinetostat::python::add_errors(module);
  kinetostat::python::add_matrices(module);
  kinetostat::python::add_links(module);
  kinetostat::python::add_effects(module);
  kinetostat::python::add_robots(module);
  kinetostat::python::add_maps(module);
  kinetostat::python::add_readings(module);
  kinetostat::python::add_robot_results(module);
  kinetostat::python::add_calibration(module);
  kinetostat::python::add_simulation(module);
}
