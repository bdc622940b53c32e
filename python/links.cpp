// Links as `kinetostat identify` has written them.
#include <optional>
#include <pybind11/eigen.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <fmt/format.h>

#include "kinetostat/io/link_result_file.h"
#include "kinetostat/python/bindings.h"

namespace kinetostat::python {
namespace {

namespace py = pybind11;

struct LinkValue {
  std::string file;
  io::IdentifiedLink link;
};

std::optional<Eigen::MatrixXd> bar_of(const LinkValue& value) {
  if (!value.link.error) return std::nullopt;
  return value.link.error->bar;
}

}  // namespace

void add_links(py::module_& module) {
  py::class_<LinkValue>(module, "Link", "A link between two interfaces, the one held.")
      .def_static(
          "read",
          [](const std::filesystem::path& file) {
            return LinkValue{file.string(), io::read_identified_link(file)};
          },
          py::arg("file"))
      .def_property_readonly("file", [](const LinkValue& v) { return v.file; })
      .def_property_readonly("compliance", [](const LinkValue& v) { return v.link.compliance; })
      .def_property_readonly("bar", &bar_of)
      .def_property_readonly("mass", [](const LinkValue& v) { return v.link.mass; })
      .def("__repr__", [](const LinkValue& v) {
        const spatial::Vector3& p = v.link.compliance.frame().point;
        return fmt::format("Link ({}): its compliance at ({:.6g}, {:.6g}, {:.6g}) m", v.file, p.x(),
                           p.y(), p.z());
      });
}

}  // namespace kinetostat::python
