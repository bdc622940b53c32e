// Maps of indices, and matrices of stiffness, over poses.
#include <limits>
#include <pybind11/eigen.h>
#include <pybind11/numpy.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <fmt/format.h>

#include "kinetostat/apps/cli/map_request.h"
#include "kinetostat/common/parallel.h"
#include "kinetostat/io/text_file.h"
#include "kinetostat/python/bindings.h"
#include "kinetostat/python/long_call.h"
#include "kinetostat/python/robot_questions.h"
#include "kinetostat/report/manipulators/map.h"
#include "kinetostat/report/manipulators/pose.h"
#include "kinetostat/spatial/rotation.h"
#include "kinetostat/vjm/batches/batches.h"
#include "kinetostat/vjm/statics/equilibrium.h"

namespace kinetostat::python {
namespace {

namespace py = pybind11;

struct MapValue {
  RobotValue robot;
  vjm::PoseList list;
  std::vector<report::NamedIndex> indices;
  std::vector<vjm::MapPoint> points;

  report::Map map() const { return {robot.robot, list, indices, points}; }
  std::string json() const { return io::to_text(report::to_json(map())); }
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
                const GivenNumbers& wrench, const std::string& up_to, int threads,
                const py::object& progress) {
  apps::MapRequest request;
  request.grid = grid;
  request.path = path;
  request.indices = indices;
  request.load.wrench = wrench_words(wrench);
  request.up_to = up_to;
  MapValue value{robot, request.read_poses(robot.robot), {}, {}};
  value.indices = request.read_indices(robot.robot, value.list);
  std::vector<vjm::MapIndex> plain;
  for (const report::NamedIndex& named : value.indices) plain.push_back(named.index);
  run_long(progress, [&](common::Progress& shown) {
    value.points = workspace_map(robot.robot.manipulator, value.list.poses, plain,
                                 thread_count(threads), shown, nullptr, finer_models(robot));
  });
  warn_of(value.list.notes);
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

using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// A plain list of numbers, which arrives as a column, is one row.
Rows rows_of(const Rows& given) { return given.cols() == 1 ? Rows(given.transpose()) : given; }

// Three or six numbers a row, six of each; those of a single row are the same for all.
std::vector<spatial::Vector6> sixes(const Rows& rows, std::size_t count, const char* expected) {
  const auto given = static_cast<std::size_t>(rows.rows());
  if ((rows.cols() != 3 && rows.cols() != 6) || (given != count && given != 1))
    throw py::value_error(expected);
  for (Eigen::Index i = 0; i < rows.rows(); ++i)
    if (!rows.row(i).allFinite())
      throw py::value_error(fmt::format("row {} has an entry that is no number: {}", i, expected));
  std::vector<spatial::Vector6> all(count, spatial::Vector6::Zero());
  for (std::size_t i = 0; i < count; ++i)
    all[i].head(rows.cols()) = rows.row(given == 1 ? 0 : static_cast<Eigen::Index>(i));
  return all;
}

// Of postures under loads; nothing where no equilibrium is found that lasts and has a stiffness.
std::vector<std::optional<spatial::Stiffness6>> loaded_stiffnesses(
    const vjm::Manipulator& manipulator, const std::vector<vjm::Posture>& postures,
    const std::vector<vjm::Load>& loads) {
  std::vector<std::optional<spatial::Stiffness6>> all;
  const auto together = stable_equilibria(manipulator, postures, loads);
  for (std::size_t i = 0; i < postures.size(); ++i) {
    if (together[i]) {
      all.emplace_back(together[i]->stiffness);
      continue;
    }
    const vjm::Equilibrium alone = equilibrium_under_load(manipulator, postures[i], loads[i]);
    const bool lasts = alone.status == vjm::EquilibriumStatus::converged && alone.free.stable();
    all.push_back(lasts ? alone.stiffness : std::nullopt);
  }
  return all;
}

// Poses and, unless there are none, a wrench for each: the matrices row by row, 36 numbers each,
// not a number where there is none.
void fill_matrices(const vjm::Manipulator& manipulator, const std::vector<spatial::Vector6>& poses,
                   const std::vector<spatial::Vector6>& wrenches, std::size_t first,
                   std::size_t count, double* numbers) {
  std::vector<spatial::Pose> targets;
  for (std::size_t i = first; i < first + count; ++i)
    targets.emplace_back(spatial::exp_rotation(poses[i].tail<3>()), poses[i].head<3>());
  const std::vector<vjm::PostureResult> found = postures_at(manipulator, targets);
  std::vector<vjm::Posture> reached;
  std::vector<vjm::Load> loads;
  std::vector<std::size_t> places;
  for (std::size_t k = 0; k < count; ++k) {
    if (!found[k].reached) continue;
    reached.push_back(found[k].posture);
    places.push_back(first + k);
    if (wrenches.empty()) continue;
    loads.push_back(
        {.force = wrenches[first + k].head<3>(), .moment = wrenches[first + k].tail<3>()});
  }
  const auto matrices = wrenches.empty() ? unloaded_stiffness_matrices(manipulator, reached)
                                         : loaded_stiffnesses(manipulator, reached, loads);
  std::fill_n(numbers + 36 * first, 36 * count, std::numeric_limits<double>::quiet_NaN());
  for (std::size_t k = 0; k < places.size(); ++k)
    if (matrices[k])
      Eigen::Map<Eigen::Matrix<double, 6, 6, Eigen::RowMajor>>(numbers + 36 * places[k]) =
          matrices[k]->matrix();
}

py::array_t<double> stiffness_matrices(const RobotValue& robot, const Rows& given,
                                       const std::optional<Rows>& wrench, int threads,
                                       const py::object& progress) {
  const Rows poses = rows_of(given);
  const auto count = static_cast<std::size_t>(poses.rows());
  const auto at =
      sixes(poses, count, "poses are rows x, y, z, or x, y, z and a rotation vector [m, rad]");
  std::vector<spatial::Vector6> loads;
  if (wrench)
    loads = sixes(rows_of(*wrench), count,
                  "a wrench is Fx, Fy, Fz, or Fx, Fy, Fz, Mx, My, Mz [N, N m]: one for all poses, "
                  "or a row for each");
  py::array_t<double> result({poses.rows(), Eigen::Index{6}, Eigen::Index{6}});
  double* const numbers = result.mutable_data();
  constexpr std::size_t together = 64;
  run_long(progress, [&](common::Progress& shown) {
    common::parallel_for((count + together - 1) / together, thread_count(threads), "poses", shown,
                         [&](std::size_t group) {
                           const std::size_t first = group * together;
                           fill_matrices(robot.robot.manipulator, at, loads, first,
                                         std::min(together, count - first), numbers);
                         });
  });
  return result;
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
      .def_property_readonly("result", [](const MapValue& v) { return values_of(v.json()); })
      .def("columns", &columns_of_map)
      .def("to_json", &MapValue::json)
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
  module.def("stiffness_matrices", &stiffness_matrices, py::arg("robot"), py::arg("poses"),
             py::arg("wrench") = py::none(), py::kw_only(), py::arg("threads") = 0,
             py::arg("progress") = py::none());
}

}  // namespace kinetostat::python
