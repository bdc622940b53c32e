// Robots: reading, postures, stiffness, deflection.
#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <pybind11/eigen.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>
#include <stdexcept>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "kinetostat/apps/cli/robot_request.h"
#include "kinetostat/common/error.h"
#include "kinetostat/io/text_file.h"
#include "kinetostat/python/bindings.h"
#include "kinetostat/python/robot_questions.h"
#include "kinetostat/report/screen/manipulator.h"
#include "kinetostat/spatial/rotation.h"
#include "kinetostat/vjm/manipulator/joint_place.h"
#include "kinetostat/vjm/manipulator/posture.h"
#include "kinetostat/vjm/statics/equilibrium.h"
#include "kinetostat/vjm/statics/stiffness.h"

namespace kinetostat::python {
namespace {

namespace py = pybind11;
using Joints = std::map<std::string, double>;
using Path = std::filesystem::path;
using Kinds = std::vector<std::shared_ptr<vjm::EffectKind>>;  // pybind11 knows no const

vjm::EffectKinds all(const Kinds& kinds) {
  std::map<std::string, std::shared_ptr<const vjm::EffectKind>> by_name;
  vjm::EffectKinds result;
  for (const auto& kind : kinds) {
    if (!kind) throw py::type_error("kinds: None is no kind of effect");
    const auto [known, is_new] = by_name.emplace(kind->name, kind);
    if (is_new) result.push_back(kind);
    if (known->second != kind)
      throw py::value_error(fmt::format(
          "kinds: two are called '{}', give each a name of its own (name=...)", kind->name));
  }
  return result;
}

// The drives, as the robot's chains name them: "q1", or "x.rho" where there are several chains.
template <class Visit>
void for_each_drive(const vjm::Manipulator& manipulator, const Visit& visit) {
  const auto& chains = manipulator.chains();
  for (std::size_t c = 0; c < chains.size(); ++c)
    for (std::size_t i = 0; i < chains[c].coordinates().size(); ++i) {
      const vjm::Coordinate& drive = chains[c].coordinates()[i];
      if (drive.role != vjm::Role::actuated) continue;
      visit(chains.size() == 1 ? drive.name : chains[c].name() + "." + drive.name, c, i);
    }
}

Eigen::Matrix4d transform(const spatial::Pose& pose) {
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  matrix.topLeftCorner<3, 3>() = pose.rotation();
  matrix.topRightCorner<3, 1>() = pose.position();
  return matrix;
}

RobotValue parsed(const std::string& text, const Path& file, const vjm::EffectKinds& kinds) {
  return {vjm::parse_robot(text, file, {.kinds = kinds}), text, kinds};
}

RobotValue written(const RobotValue& value, const Path& file) {
  return write_robot(file, value.text, value.kinds);
}

// The bytes of the file and where it stands: of what is in Python alone there are none.
py::tuple pickled(const RobotValue& value) {
  if (!value.kinds.empty())
    throw py::type_error("a robot with effects of your own cannot be pickled");
  return py::make_tuple(value.robot.file.string(), value.text);
}

RobotValue unpickled(const py::tuple& state) {
  return parsed(state[1].cast<std::string>(), state[0].cast<std::string>(), {});
}

// Copies, for a list of them holds what cannot be changed.
py::list kinds_of(const RobotValue& value) {
  py::list kinds;
  for (const auto& kind : value.kinds)
    kinds.append(py::cast(std::const_pointer_cast<vjm::EffectKind>(kind)));
  return kinds;
}

std::vector<std::string> joint_names(const RobotValue& value) {
  std::vector<std::string> names;
  for_each_drive(value.robot.manipulator,
                 [&](const std::string& name, std::size_t, std::size_t) { names.push_back(name); });
  return names;
}

// x, y, z; with a rotation vector; or 4x4, as Posture::pose has it.
spatial::Pose pose_of(const Eigen::MatrixXd& at) {
  if (!at.allFinite()) throw py::value_error("'at' has an entry that is no number");
  if (at.rows() == 4 && at.cols() == 4 && at.row(3) == Eigen::RowVector4d(0, 0, 0, 1))
    return {at.topLeftCorner<3, 3>(), at.topRightCorner<3, 1>()};
  if ((at.size() != 3 && at.size() != 6) || (at.rows() != 1 && at.cols() != 1))
    throw py::value_error(
        fmt::format("'at' has {} x {} numbers: give x, y, z, or x, y, z and a rotation vector [m, "
                    "rad], or a pose 4x4 with the last row 0, 0, 0, 1",
                    at.rows(), at.cols()));
  spatial::Vector6 pose = spatial::Vector6::Zero();
  pose.head(at.size()) = at.reshaped();
  return {spatial::exp_rotation(pose.tail<3>()), pose.head<3>()};
}

// As --at has it: x, y, z and a rotation vector.
std::string words_of_pose(const Eigen::MatrixXd& at) {
  Eigen::VectorXd numbers = at.reshaped();
  if (at.rows() == 4) {
    const spatial::Pose pose = pose_of(at);
    numbers.resize(6);
    numbers << pose.position(), spatial::log_rotation(pose.rotation());
  }
  std::vector<std::string> parts;
  for (Eigen::Index i = 0; i < numbers.size(); ++i)
    parts.push_back(fmt::format("{} {}", numbers[i], i < 3 ? "m" : "rad"));
  return fmt::format("{}", fmt::join(parts, ","));
}

// As --joints has them.
std::string words_of_joints(const vjm::Manipulator& manipulator, const Joints& joints) {
  std::vector<std::string> parts;
  for (const auto& [name, value] : joints) {
    const vjm::Coordinate& joint = coordinate_at(manipulator, find_joint(manipulator, name));
    parts.push_back(fmt::format("{}={} {}", name, value, is_rotation(joint.motion) ? "rad" : "m"));
  }
  return fmt::format("{}", fmt::join(parts, ","));
}

PostureValue posture(const RobotValue& value, const std::optional<Eigen::MatrixXd>& at,
                     const std::optional<Joints>& joints) {
  const vjm::Manipulator& manipulator = value.robot.manipulator;
  if (at && joints) throw py::value_error("give either a pose ('at') or joint values");
  constexpr double far = 1e6;  // turns lose their digits before
  for (const auto& [name, coordinate] : joints.value_or(Joints()))
    if (!(std::abs(coordinate) < far))
      throw py::value_error(
          fmt::format("{} = {} is no place of a joint [m or rad]", name, coordinate));
  vjm::PostureResult found = at ? posture_at(manipulator, pose_of(*at))
                                : posture_from_joints(manipulator, joints.value_or(Joints()));
  if (!found.reached) throw common::NoConvergence(found.reason);
  PostureValue result{std::move(found.posture), {}};
  if (at) result.at = words_of_pose(*at);
  if (joints) result.joint_values = words_of_joints(manipulator, *joints);
  for_each_drive(manipulator, [&](const std::string& name, std::size_t chain, std::size_t i) {
    result.joints[name] = result.posture.coordinates[chain][static_cast<Eigen::Index>(i)];
  });
  return result;
}

// The same for a caller in Python, which is warned of joints outside of their ranges.
PostureValue asked_posture(const RobotValue& value, const std::optional<Eigen::MatrixXd>& at,
                           const std::optional<Joints>& joints) {
  PostureValue result = posture(value, at, joints);
  warn_of(apps::beyond_ranges(value.robot, result.posture));
  return result;
}

// Home where none is given.
vjm::Posture chosen(const RobotValue& value, const PostureValue* given) {
  if (given == nullptr) return posture(value, {}, {}).posture;
  require_own(value, *given);
  return given->posture;
}

std::optional<spatial::Stiffness6> stiffness(const RobotValue& value, const PostureValue* given) {
  return unloaded_stiffness_matrix(value.robot.manipulator, chosen(value, given));
}

std::optional<spatial::Compliance6> compliance(const RobotValue& value, const PostureValue* given) {
  return unloaded_stiffness(value.robot.manipulator, chosen(value, given)).compliance;
}

struct Deflection {
  vjm::Equilibrium equilibrium;
  bool is_stable;
  std::string headline;
};

Deflection deflect(const RobotValue& value, const Eigen::VectorXd& wrench,
                   const PostureValue* given, const spatial::Vector3& point) {
  if (wrench.size() != 3 && wrench.size() != 6)
    throw py::value_error("a wrench is Fx, Fy, Fz, or Fx, Fy, Fz, Mx, My, Mz [N, N m]");
  if (!wrench.allFinite() || !point.allFinite())
    throw py::value_error("the wrench or its point has an entry that is no number");
  vjm::Load load;
  load.force = wrench.head<3>();
  if (wrench.size() == 6) load.moment = wrench.tail<3>();
  load.point_on_platform = point;
  vjm::Equilibrium found =
      equilibrium_under_load(value.robot.manipulator, chosen(value, given), load);
  if (found.status != vjm::EquilibriumStatus::converged) throw common::NoConvergence(found.reason);
  const bool stable = found.free.stable();
  std::string headline = report::headline(value.robot, found);
  return {std::move(found), stable, std::move(headline)};
}

py::tuple pickled_posture(const PostureValue& value) {
  std::vector<Eigen::Matrix4d> inner;
  for (const spatial::Pose& body : value.posture.inner_bodies) inner.push_back(transform(body));
  return py::make_tuple(transform(value.posture.platform), value.posture.coordinates, inner,
                        value.joints, value.at, value.joint_values);
}

PostureValue unpickled_posture(const py::tuple& state) {
  PostureValue value{{.platform = pose_of(state[0].cast<Eigen::MatrixXd>()),
                      .coordinates = state[1].cast<std::vector<Eigen::VectorXd>>()},
                     state[3].cast<Joints>(),
                     state[4].cast<std::string>(),
                     state[5].cast<std::string>()};
  for (const auto& body : state[2].cast<std::vector<Eigen::MatrixXd>>())
    value.posture.inner_bodies.push_back(pose_of(body));
  return value;
}

void add_postures(py::module_& module) {
  py::class_<PostureValue>(module, "Posture", "Where a robot stands with all springs relaxed.")
      .def_property_readonly("pose",
                             [](const PostureValue& p) { return transform(p.posture.platform); })
      .def_property_readonly(
          "position",
          [](const PostureValue& p) { return spatial::Vector3(p.posture.platform.position()); })
      .def_readonly("joints", &PostureValue::joints)
      .def(py::pickle(&pickled_posture, &unpickled_posture))
      .def("__repr__", [](const PostureValue& p) {
        const spatial::Vector3& at = p.posture.platform.position();
        std::vector<std::string> values;
        for (const auto& [name, value] : p.joints)
          values.push_back(fmt::format("{}={:.6g}", name, value));
        return fmt::format("Posture at ({:.6g}, {:.6g}, {:.6g}) m, {}", at.x(), at.y(), at.z(),
                           fmt::join(values, ", "));
      });
}

void add_deflections(py::module_& module) {
  py::class_<Deflection>(module, "Deflection", "The equilibrium of a robot under a load.")
      .def_property_readonly("displacement",
                             [](const Deflection& d) {
                               return spatial::Vector6(d.equilibrium.displacement.coordinates());
                             })
      .def_property_readonly("pose",
                             [](const Deflection& d) { return transform(d.equilibrium.platform); })
      .def_property_readonly("stiffness",
                             [](const Deflection& d) { return d.equilibrium.stiffness; })
      .def_property_readonly("energy", [](const Deflection& d) { return d.equilibrium.energy; })
      .def_readonly("stable", &Deflection::is_stable)
      .def_readonly("headline", &Deflection::headline)
      .def("__repr__", [](const Deflection& d) { return "Deflection: " + d.headline; });
}

}  // namespace

RobotValue robot_from(const std::filesystem::path& file, const vjm::EffectKinds& kinds) {
  return {vjm::read_robot(file, {.kinds = kinds}), io::read_text(file), kinds};
}

bool is_in_its_file(const RobotValue& robot) {
  const Path& file = robot.robot.file;
  return std::filesystem::exists(file) && io::read_text(file) == robot.text;
}

void require_own(const RobotValue& robot, const PostureValue& posture) {
  const auto& chains = robot.robot.manipulator.chains();
  const auto& coordinates = posture.posture.coordinates;
  bool is_own = chains.size() == coordinates.size();
  for (std::size_t c = 0; is_own && c < chains.size(); ++c)
    is_own = chains[c].size() == coordinates[c].size();
  for (const std::string& name : joint_names(robot))
    is_own = is_own && posture.joints.contains(name);
  if (!is_own)
    throw py::value_error("the posture is one of another robot: ask this robot for its posture()");
}

RobotValue write_robot(const std::filesystem::path& file, const std::string& text,
                       const vjm::EffectKinds& kinds) {
  RobotValue robot = {vjm::parse_robot(text, file, {.kinds = kinds}), text, kinds};
  io::write_atomically(file, text);
  return robot;
}

void add_robots(py::module_& module) {
  add_postures(module);
  add_deflections(module);
  py::class_<RobotValue> robot(module, "Robot", "A robot as its file has it.");
  add_import(robot);
  robot
      .def_static(
          "read", [](const Path& file, const Kinds& kinds) { return robot_from(file, all(kinds)); },
          py::arg("file"), py::arg("kinds") = Kinds())
      .def_static(
          "parse",
          [](const std::string& text, const Path& file, const Kinds& kinds) {
            return parsed(text, file, all(kinds));
          },
          py::arg("text"), py::arg("file"), py::arg("kinds") = Kinds())
      .def(py::pickle(&pickled, &unpickled))
      .def("write", &written, py::arg("file"))
      .def_property_readonly("name", [](const RobotValue& v) { return v.robot.name; })
      .def_property_readonly("file", [](const RobotValue& v) { return v.robot.file.string(); })
      .def_readonly("text", &RobotValue::text)
      .def_property_readonly("kinds", &kinds_of)
      .def_property_readonly("joints", &joint_names)
      .def("posture", &asked_posture, py::arg("at") = py::none(), py::arg("joints") = py::none())
      .def("stiffness", &stiffness, py::arg("posture") = py::none())
      .def("compliance", &compliance, py::arg("posture") = py::none())
      .def("deflect", &deflect, py::arg("wrench"), py::arg("posture") = py::none(),
           py::arg("point") = spatial::Vector3(spatial::Vector3::Zero()),
           py::call_guard<py::gil_scoped_release>())
      .def("__repr__", [](const RobotValue& v) {
        return fmt::format("Robot '{}' ({}): {}", v.robot.name, v.robot.file.string(),
                           fmt::join(joint_names(v), ", "));
      });
}

}  // namespace kinetostat::python
