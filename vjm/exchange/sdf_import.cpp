#include "kinetostat/vjm/exchange/sdf_import.h"

#include <algorithm>
#include <map>
#include <numbers>
#include <tinyxml2.h>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "kinetostat/common/error.h"
#include "kinetostat/spatial/rotation.h"
#include "kinetostat/vjm/exchange/solid_inertia.h"
#include "kinetostat/vjm/exchange/xml_file.h"

namespace kinetostat::vjm::sdf_import {
namespace {

using spatial::Matrix3;
using spatial::Pose;
using spatial::Vector3;
using Element = XmlFile::Element;

constexpr double no_limit = 1e15;  // the format's own way to say so: 1e16

class Reader {
 public:
  explicit Reader(const std::filesystem::path& file) : xml_(file), sdf_(xml_.root("sdf", "SDF")) {}

  RobotDescription read() {
    const Element& model = find_model();
    description_.file = xml_.file();
    description_.format = "SDF";
    description_.name = xml_.text(model, "name");
    refuse_nested(model);
    model_in_world_ = raw_pose(model);
    axes_of_model_ = is_older_than_1_5();
    for (const char* kind : {"link", "frame", "joint"})
      for (const Element* e : XmlFile::children(model, kind)) frames_[xml_.text(*e, "name")] = e;
    for (const Element* e : XmlFile::children(model, "link")) add_link(*e);
    for (const Element* e : XmlFile::children(model, "joint")) add_joint(*e);
    for (const Element* e : XmlFile::children(model, "frame")) add_mark(*e);
    check_names(description_);
    turn_gravity();
    return std::move(description_);
  }

 private:
  // Axes of joints are then in the frame of the model.
  bool is_older_than_1_5() const {
    const std::string version = xml_.text_or(sdf_, "version", "1.11");
    return version.starts_with("1.") && version.size() == 3 && version[2] < '5';
  }

  // From the world into the root: the first link that no joint carries.
  void turn_gravity() {
    for (const DescribedLink& link : description_.links) {
      if (carrier_of(description_, link.name) != nullptr) continue;
      const auto found = frames_.find(link.name);
      if (found == frames_.end()) return;  // the world
      const Pose in_world = model_in_world_ * pose_of(*found->second);
      description_.gravity = in_world.rotation().transpose() * description_.gravity;
      return;
    }
  }

  const Element& find_model() {
    const Element* world = XmlFile::child(sdf_, "world");
    const Element& parent = world == nullptr ? sdf_ : *world;
    const std::vector<const Element*> models = XmlFile::children(parent, "model");
    if (models.empty()) xml_.fail(parent, "there is no <model>");
    if (models.size() > 1)
      description_.remarks.push_back(
          fmt::format("the file has {} models: the first is taken", models.size()));
    description_.gravity = {0, 0, -9.8};  // the default of the specification
    if (world != nullptr)
      if (const Element* g = XmlFile::child(*world, "gravity"))
        description_.gravity = xml_.vector(*g, nullptr);
    return *models.front();
  }

  void refuse_nested(const Element& model) const {
    for (const char* kind : {"model", "include"})
      if (const Element* nested = XmlFile::child(model, kind))
        xml_.fail(*nested, "nested models are not read",
                  "Flatten the file first: gz sdf -p model.sdf > flat.sdf");
  }

  std::string inside(const Element& parent, const char* name) const {
    const Element* e = XmlFile::child(parent, name);
    const char* words = e == nullptr ? nullptr : e->GetText();
    if (words == nullptr) xml_.fail(parent, fmt::format("there is no <{}>", name));
    const std::string text = words;
    const std::size_t first = text.find_first_not_of(" \t\r\n");
    const std::size_t last = text.find_last_not_of(" \t\r\n");
    return first == std::string::npos ? "" : text.substr(first, last + 1 - first);
  }
  double number_in(const Element* parent, const char* name, double otherwise) const {
    const Element* e = parent == nullptr ? nullptr : XmlFile::child(*parent, name);
    return e == nullptr ? otherwise : xml_.number(*e, nullptr);
  }
  double not_negative_in(const Element* parent, const char* name, double otherwise,
                         const char* what) const {
    const Element* e = parent == nullptr ? nullptr : XmlFile::child(*parent, name);
    return e == nullptr ? otherwise : xml_.not_negative(*e, nullptr, what);
  }

  Pose raw_pose(const Element& parent) const {
    const Element* pose = XmlFile::child(parent, "pose");
    if (pose == nullptr || pose->GetText() == nullptr) return {};
    if (xml_.text_or(*pose, "rotation_format", "euler_rpy") == "quat_xyzw") {
      const std::vector<double> v = xml_.numbers(*pose, nullptr, 7);
      return {Eigen::Quaterniond(v[6], v[3], v[4], v[5]).normalized().toRotationMatrix(),
              {v[0], v[1], v[2]}};
    }
    const std::vector<double> v = xml_.numbers(*pose, nullptr, 6);
    const double unit =
        xml_.text_or(*pose, "degrees", "false") == "true" ? std::numbers::pi / 180 : 1;
    return {spatial::rotation_from_rpy(unit * Vector3(v[3], v[4], v[5])), {v[0], v[1], v[2]}};
  }

  // What the pose of an element is given in, unless it says.
  std::string home_of(const Element& element) const {
    const std::string kind = element.Name();
    if (kind == "joint") return inside(element, "child");
    return kind == "frame" ? xml_.text_or(element, "attached_to", "__model__") : "__model__";
  }

  // In the frame of the model.
  Pose pose_of(const Element& element, int depth = 0) const {
    const Element* pose = XmlFile::child(element, "pose");
    std::string in = pose == nullptr ? "" : xml_.text_or(*pose, "relative_to", "");
    if (in.empty()) in = home_of(element);
    return frame(in, element, depth) * raw_pose(element);
  }
  Pose frame(const std::string& name, const Element& asking, int depth = 0) const {
    if (name == "__model__") return {};
    if (name == "world") return model_in_world_.inverse();
    const auto found = frames_.find(name);
    if (found == frames_.end()) xml_.fail(asking, fmt::format("there is no frame '{}'", name));
    if (depth > 100) xml_.fail(asking, fmt::format("the pose of '{}' refers to itself", name));
    return pose_of(*found->second, depth + 1);
  }

  void add_link(const Element& element) {
    DescribedLink link{.name = xml_.text(element, "name"), .line = element.GetLineNum()};
    const Element* inertial = XmlFile::child(element, "inertial");
    const bool is_computed = inertial != nullptr && is_true(xml_.text_or(*inertial, "auto", ""));
    link.inertia = is_computed           ? inertia_of_collisions(element, *inertial)
                   : inertial == nullptr ? unit_inertia()
                                         : read_inertia(*inertial, link.name);
    for (const char* kind : {"visual", "collision"})
      for (const Element* e : XmlFile::children(element, kind)) {
        const Element* geometry = XmlFile::child(*e, "geometry");
        if (geometry == nullptr) continue;
        DescribedShape shape = read_shape(*geometry);
        if (shape.is_empty()) continue;
        shape.pose = raw_pose(*e);
        shape.is_collision = std::string_view(kind) == "collision";
        link.shapes.push_back(std::move(shape));
      }
    description_.links.push_back(std::move(link));
  }

  Vector3 vector_in(const Element& parent, const char* name, const Vector3& otherwise) const {
    const Element* e = XmlFile::child(parent, name);
    return e == nullptr ? otherwise : xml_.vector(*e, nullptr);
  }

  // What lacks has the default of the specification.
  DescribedShape read_shape(const Element& geometry) const {
    using Kind = PrimitiveSolid::Kind;
    if (const Element* mesh = XmlFile::child(geometry, "mesh"))
      return {.file = inside(*mesh, "uri"), .scale = vector_in(*mesh, "scale", Vector3::Ones())};
    if (const Element* box = XmlFile::child(geometry, "box"))
      return {.solid = {.kind = Kind::box, .edges = vector_in(*box, "size", Vector3::Ones())}};
    if (const Element* ball = XmlFile::child(geometry, "sphere"))
      return {.solid = {.kind = Kind::capsule,
                        .radius = not_negative_in(ball, "radius", 1, "a radius")}};
    if (const Element* ball = XmlFile::child(geometry, "ellipsoid"))
      return {.solid = {.kind = Kind::capsule, .radius = 1},
              .scale = vector_in(*ball, "radii", Vector3::Ones())};
    for (const auto& [name, kind] :
         {std::pair("cylinder", Kind::cylinder), std::pair("capsule", Kind::capsule)})
      if (const Element* e = XmlFile::child(geometry, name))
        return {.solid = {.kind = kind,
                          .radius = not_negative_in(e, "radius", 0.5, "a radius"),
                          .length = not_negative_in(e, "length", 1, "a length")}};
    return {};
  }

  // What the specification gives a link that says nothing.
  static DescribedInertia unit_inertia() {
    return {.mass = 1, .tensor = Matrix3::Identity(), .is_assumed = true};
  }

  static bool is_true(const std::string& word) { return word == "true" || word == "1"; }

  // As the attribute `auto` has it: that of the collision shapes by their densities, scaled to the
  // mass where one is stated. None where a mesh is among them, with a remark.
  std::optional<DescribedInertia> inertia_of_collisions(const Element& link,
                                                        const Element& inertial) {
    constexpr double usual_density = 1000;  // [kg/m^3]
    const double of_link = not_negative_in(&inertial, "density", usual_density, "a density");
    DescribedInertia sum;
    for (const Element* e : XmlFile::children(link, "collision")) {
      const Element* geometry = XmlFile::child(*e, "geometry");
      DescribedShape shape = geometry == nullptr ? DescribedShape() : read_shape(*geometry);
      if (!shape.file.empty()) {
        description_.remarks.push_back(fmt::format(
            "{} has no mass here: Gazebo computes it from a mesh", xml_.text(link, "name")));
        return std::nullopt;
      }
      if (shape.is_empty()) continue;
      const double density = not_negative_in(e, "density", of_link, "a density");
      shape.pose = raw_pose(*e);
      sum = together(sum, uniform_inertia(shape, density * volume(shape)));
    }
    if (!(sum.mass > 0))
      xml_.fail(inertial, "auto: the link has no collision that weighs anything");
    const double mass = not_negative_in(&inertial, "mass", sum.mass, "a mass");
    sum.tensor *= mass / sum.mass;
    sum.mass = mass;
    return sum;
  }

  DescribedInertia read_inertia(const Element& element, const std::string& link) {
    const Pose pose = raw_pose(element);
    DescribedInertia inertia{.mass = not_negative_in(&element, "mass", 1, "a mass"),
                             .center = pose.position()};
    const Element* moments = XmlFile::child(element, "inertia");
    if (moments == nullptr)
      description_.remarks.push_back(fmt::format(
          "'{}' has a mass and no <inertia>: of that SDF takes 1 kg m^2 about every axis", link));
    const auto about = [&](const char* name) {
      return not_negative_in(moments, name, 1, "a moment of inertia");
    };
    const auto of = [&](const char* name) { return number_in(moments, name, 0); };
    Matrix3 tensor;
    tensor << about("ixx"), of("ixy"), of("ixz"), of("ixy"), about("iyy"), of("iyz"), of("ixz"),
        of("iyz"), about("izz");
    inertia.tensor = pose.rotation() * tensor * pose.rotation().transpose();
    return inertia;
  }

  void add_joint(const Element& element) {
    DescribedJoint joint{.name = xml_.text(element, "name"),
                         .line = element.GetLineNum(),
                         .type = read_type(element),
                         .parent = inside(element, "parent"),
                         .child = inside(element, "child")};
    if (joint.parent == "world") add_world();
    const Pose child = frame(joint.child, element), at = pose_of(element);
    joint.origin = frame(joint.parent, element).inverse() * at;
    if (joint.type != JointType::fixed) read_axis(element, at, joint);
    const Pose rest = at.inverse() * child;
    if (rest.position().norm() > 1e-14 || !rest.rotation().isIdentity(1e-14)) {
      const std::string between = joint.child + "@" + joint.name;
      description_.links.push_back({.name = between, .line = joint.line});
      description_.joints.push_back({.name = between,
                                     .line = joint.line,
                                     .parent = between,
                                     .child = joint.child,
                                     .origin = rest});
      joint.child = between;
    }
    description_.joints.push_back(std::move(joint));
  }

  // A frame is a place on the link that it is attached to, by way of others perhaps.
  void add_mark(const Element& element) {
    std::string link = home_of(element);
    for (int depth = 0; depth < 100 && frames_.contains(link); ++depth) {
      const Element& holder = *frames_.at(link);
      if (std::string_view(holder.Name()) == "link") break;
      link = home_of(holder);
    }
    if (link == "__model__" || link == "world") return;
    const auto found = frames_.find(link);
    if (found == frames_.end())
      xml_.fail(element, fmt::format("it is attached to '{}', and there is no such frame", link));
    const std::string name = xml_.text(element, "name");
    description_.links.push_back({.name = name, .line = element.GetLineNum(), .is_mark = true});
    description_.joints.push_back({.name = name + "@fixed",
                                   .line = element.GetLineNum(),
                                   .parent = link,
                                   .child = name,
                                   .origin = pose_of(*found->second).inverse() * pose_of(element)});
  }

  void add_world() {
    const bool there = std::any_of(description_.links.begin(), description_.links.end(),
                                   [](const DescribedLink& link) { return link.name == "world"; });
    if (!there) description_.links.push_back({.name = "world"});
  }

  JointType read_type(const Element& element) const {
    const std::string type = xml_.text(element, "type");
    if (type == "fixed") return JointType::fixed;
    if (type == "revolute") return JointType::revolute;
    if (type == "continuous") return JointType::continuous;
    if (type == "prismatic") return JointType::prismatic;
    for (const char* several : {"ball", "universal", "revolute2", "screw", "gearbox"})
      if (type == several)
        xml_.fail(element, fmt::format("a {} joint is not read", type),
                  "Replace it by revolute and prismatic joints with one axis each");
    xml_.fail_unknown(element, fmt::format("of '{}' the joint type", xml_.text(element, "name")),
                      type, {"fixed", "revolute", "continuous", "prismatic"});
  }

  void read_axis(const Element& element, const Pose& at, DescribedJoint& joint) const {
    const Element* axis = XmlFile::child(element, "axis");
    if (axis == nullptr) xml_.fail(element, "there is no <axis>");
    joint.axis = axis_of(*axis, at);
    const Element* limit = XmlFile::child(*axis, "limit");
    const double lower = number_in(limit, "lower", -no_limit),
                 upper = number_in(limit, "upper", no_limit),
                 effort = number_in(limit, "effort", -1);
    if (lower > upper) xml_.fail(*limit, "lower is above upper");
    if (lower > -no_limit && upper < no_limit) joint.limits = {lower, upper};
    if (effort >= 0 && effort < no_limit) joint.effort = effort;
    read_spring(XmlFile::child(*axis, "dynamics"), joint);
    if (const Element* mimic = XmlFile::child(*axis, "mimic")) {
      joint.mimics = xml_.text(*mimic, "joint");
      joint.mimic_factor = number_in(mimic, "multiplier", 1);
      joint.mimic_offset =
          number_in(mimic, "offset", 0) - joint.mimic_factor * number_in(mimic, "reference", 0);
    }
  }

  void read_spring(const Element* dynamics, DescribedJoint& joint) const {
    const double stiffness = not_negative_in(dynamics, "spring_stiffness", 0, "a stiffness");
    if (!(stiffness > 0)) return;
    joint.stiffness = stiffness;
    joint.rest = number_in(dynamics, "spring_reference", 0);
  }

  // In the frame of the joint, which is `at` in the model.
  Vector3 axis_of(const Element& axis, const Pose& at) const {
    const Element* xyz = XmlFile::child(axis, "xyz");
    if (xyz == nullptr) return Vector3::UnitZ();
    Vector3 given = xml_.direction(*xyz, nullptr);
    std::string in = xml_.text_or(*xyz, "expressed_in", "");
    const Element* old = XmlFile::child(axis, "use_parent_model_frame");
    if (old != nullptr && inside(axis, "use_parent_model_frame") != "0" &&
        inside(axis, "use_parent_model_frame") != "false")
      in = "__model__";
    if (in.empty() && axes_of_model_) in = "__model__";
    if (in.empty()) return given;
    return at.rotation().transpose() * frame(in, axis).rotation() * given;
  }

  XmlFile xml_;
  const Element& sdf_;
  RobotDescription description_;
  std::map<std::string, const Element*> frames_;
  Pose model_in_world_;
  bool axes_of_model_ = false;
};

}  // namespace
}  // namespace kinetostat::vjm::sdf_import

namespace kinetostat::vjm {

RobotDescription read_sdf(const std::filesystem::path& file) {
  return sdf_import::Reader(file).read();
}

}  // namespace kinetostat::vjm
