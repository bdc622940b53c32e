// 6x6 matrices that know their frame.
#include <optional>
#include <pybind11/eigen.h>
#include <pybind11/stl.h>

#include <fmt/format.h>

#include "kinetostat/python/bindings.h"
#include "kinetostat/spatial/pose.h"
#include "kinetostat/spatial/stiffness.h"

namespace kinetostat::python {
namespace {

namespace py = pybind11;
using spatial::Compliance6;
using spatial::Frame;
using spatial::Matrix3;
using spatial::Matrix6;
using spatial::Stiffness6;
using spatial::Vector3;

template <class Matrix>
std::string shown(const char* name, const Matrix& matrix) {
  const Vector3& p = matrix.frame().point;
  const std::string rows = py::str(py::cast(Matrix6(matrix.matrix())));
  const bool base = matrix.frame().axes == Matrix3::Identity();
  return fmt::format("{} at ({:.6g}, {:.6g}, {:.6g}) m, {} axes\n{}", name, p.x(), p.y(), p.z(),
                     base ? "base" : "own", rows);
}

// A copy: a frame and a changed matrix would no longer belong together.
template <class Matrix>
py::array array_of(const Matrix& matrix, const py::object& type) {
  const py::array array = py::cast(Matrix6(matrix.matrix()));
  return type.is_none() ? array : py::array(array.attr("astype")(type));
}

// Throws std::invalid_argument where the axes are no rotation, or something is no number.
Frame frame_of(const Vector3& point, const Matrix3& axes) {
  if (!point.allFinite()) throw py::value_error("the point is not three numbers [m]");
  const spatial::Pose pose(axes, point);
  return {pose.position(), pose.rotation()};
}

template <class Matrix>
Matrix at_frame(const Matrix& matrix, const Vector3& point, const std::optional<Matrix3>& axes) {
  return matrix.in(frame_of(point, axes.value_or(matrix.frame().axes)));
}

template <class Matrix>
py::class_<Matrix> add(py::module_& module, const char* name, const char* doc) {
  py::class_<Matrix> added(module, name, doc);
  added
      .def(py::init([](const Matrix6& array, const Vector3& point, const Matrix3& axes) {
             if (!array.allFinite())
               throw py::value_error("the matrix has an entry that is no number");
             return Matrix(array, frame_of(point, axes));
           }),
           py::arg("array"), py::arg("point") = Vector3(Vector3::Zero()),
           py::arg("axes") = Matrix3(Matrix3::Identity()))
      .def_property_readonly("array", [](const Matrix& m) { return Matrix6(m.matrix()); })
      .def_property_readonly("point", [](const Matrix& m) { return Vector3(m.frame().point); })
      .def_property_readonly("axes", [](const Matrix& m) { return Matrix3(m.frame().axes); })
      .def("at", &at_frame<Matrix>, py::arg("point"), py::arg("axes") = py::none())
      .def("inverse", &Matrix::inverse)
      .def(py::pickle(
          [](const Matrix& m) {
            return py::make_tuple(Matrix6(m.matrix()), Vector3(m.frame().point),
                                  Matrix3(m.frame().axes));
          },
          [](const py::tuple& state) {
            return Matrix(state[0].cast<Matrix6>(),
                          frame_of(state[1].cast<Vector3>(), state[2].cast<Matrix3>()));
          }))
      .def("__array__", &array_of<Matrix>, py::arg("dtype") = py::none())
      .def("__repr__", [name](const Matrix& m) { return shown(name, m); });
  return added;
}

}  // namespace

void add_matrices(py::module_& module) {
  add<Stiffness6>(module, "Stiffness",
                  "From a small displacement [translation m; rotation rad] to a wrench [force N; "
                  "moment N m].");
  add<Compliance6>(module, "Compliance",
                   "From a wrench [force N; moment N m] to a small displacement [translation m; "
                   "rotation rad].");
}

}  // namespace kinetostat::python
