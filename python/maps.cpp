// Maps of indices over poses.
#include <pybind11/eigen.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <fmt/format.h>

#include "kinetostat/apps/cli/map_request.h"
#include "kinetostat/io/text_file.h"
#include "kinetostat/python/bindings.h"
#include "kinetostat/python/long_call.h"
#include "kinetostat/report/manipulators/map.h"
#include "kinetostat/report/manipulators/pose.h"

namespace kinetostat::python {
namespace {

namespace py = pybind11;

struct MapValue {
  RobotValue robot;
  vjm::PoseList list;
  std::vector<report::NamedIndex> indices;
  std::vector<vjm::MapPoint> points;

  report::Map map() const { return {robot.robot, list, indices, points}; }
};

// With the beams in two and in four times the segments.
std::vector<vjm::Manipulator> finer_models(const RobotValue& value) {
  std::vector<vjm::Manipulator> finer;
  if (!value.robot.has_beams) return finer;
  for (const int multiple : {2, 4})
    finer.push_back(vjm::parse_robot(value.text, value.robot.file,
                                     {.segment_multiple = multiple, .kinds = value.kinds})
                        .manipulator);
  return finer;
}

MapValue map_of(const RobotValue& robot, const std::string& grid,
                const std::vector<std::string>& indices, const std::string& path,
                const std::string& wrench, const std::string& up_to, int threads,
                const py::object& progress) {
  apps::MapRequest request;
  request.grid = grid;
  request.path = path;
  request.indices = indices;
  request.load.wrench = wrench;
  request.up_to = up_to;
  MapValue value{robot, request.read_poses(robot.robot), {}, {}};
  value.indices = request.read_indices(robot.robot, value.list);
  std::vector<vjm::MapIndex> plain;
  for (const report::NamedIndex& named : value.indices) plain.push_back(named.index);
  run_long(progress, [&](common::Progress& shown) {
    value.points = workspace_map(robot.robot.manipulator, value.list.poses, plain,
                                 thread_count(threads), shown, nullptr, finer_models(robot));
  });
  return value;
}

// Columns by name: poses and indices in SI, what pandas.DataFrame() takes.
py::dict columns_of_map(const MapValue& value) {
  const auto count = static_cast<Eigen::Index>(value.points.size());
  Eigen::MatrixXd poses(count, 6), values(count, static_cast<Eigen::Index>(value.indices.size()));
  std::vector<std::string> states;
  for (Eigen::Index i = 0; i < count; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const auto coordinates = report::coordinates_of(value.list.poses[k].platform);
    for (Eigen::Index c = 0; c < 6; ++c) poses(i, c) = coordinates[static_cast<std::size_t>(c)];
    for (Eigen::Index c = 0; c < values.cols(); ++c)
      values(i, c) = value.points[k].values[static_cast<std::size_t>(c)];
    states.push_back(to_string(value.points[k].state));
  }
  py::dict table;
  for (Eigen::Index c = 0; c < 6; ++c)
    table[vjm::pose_columns[static_cast<std::size_t>(c)]] = Eigen::VectorXd(poses.col(c));
  table["state"] = states;
  for (Eigen::Index c = 0; c < values.cols(); ++c)
    table[value.indices[static_cast<std::size_t>(c)].name.c_str()] = Eigen::VectorXd(values.col(c));
  return table;
}

}  // namespace

void add_maps(py::module_& module) {
  py::class_<MapValue>(module, "Map", "Indices of stiffness over poses.")
      .def_property_readonly("headline", [](const MapValue& v) { return headline(v.map()); })
      .def_property_readonly("text", [](const MapValue& v) { return text(v.map()); })
      .def_property_readonly("indices",
                             [](const MapValue& v) {
                               std::vector<std::string> names;
                               for (const auto& named : v.indices) names.push_back(named.name);
                               return names;
                             })
      .def_property_readonly("shape", [](const MapValue& v) { return py::cast(v.list.shape); })
      .def("columns", &columns_of_map)
      .def("to_csv", [](const MapValue& v) { return csv(v.map()); })
      .def(
          "write",
          [](const MapValue& v, const std::filesystem::path& file) {
            io::write_atomically(file, csv(v.map()));
          },
          py::arg("file"))
      .def("__len__", [](const MapValue& v) { return v.points.size(); })
      .def("__repr__", [](const MapValue& v) { return "Map: " + headline(v.map()); });
  module.def("map_poses", &map_of, py::arg("robot"), py::arg("grid") = "",
             py::arg("indices") = std::vector<std::string>{"weakest-translation"}, py::kw_only(),
             py::arg("path") = "", py::arg("wrench") = "", py::arg("up_to") = "",
             py::arg("threads") = 0, py::arg("progress") = py::none());
}

}  // namespace kinetostat::python
