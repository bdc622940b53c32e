#include "kinetostat/vjm/exchange/mjcf_import.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <set>
#include <string_view>
#include <tinyxml2.h>

#include <Eigen/Geometry>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "kinetostat/common/error.h"
#include "kinetostat/spatial/rotation.h"
#include "kinetostat/vjm/exchange/solid_inertia.h"
#include "kinetostat/vjm/exchange/xml_file.h"

namespace kinetostat::vjm::mjcf_import {
namespace {

// Of geoms; the viewer hides others, as collision meshes are.
constexpr double last_shown_group = 2;
constexpr double usual_density = 1000;  // [kg/m^3] of geoms

using spatial::Matrix3;
using spatial::Pose;
using spatial::Vector3;
using Element = XmlFile::Element;

// What a class of defaults says of elements, and the class that it is in.
struct DefaultClass {
  std::vector<const Element*> elements;
  std::string parent;
};

class Reader {
 public:
  explicit Reader(const std::filesystem::path& file)
      : xml_(file), top_(xml_.root("mujoco", "MJCF")) {}

  RobotDescription read() {
    description_.file = xml_.file();
    description_.format = "MJCF";
    description_.name = xml_.text_or(top_, "model", xml_.file().stem().string());
    read_includes(top_);
    read_settings();
    for (const Element* e : parts(top_, "default")) add_class(*e, "");
    for (const Element* asset : parts(top_, "asset"))
      for (const Element* e : parts(*asset, "mesh")) add_mesh(*e);
    description_.links.push_back({.name = "world"});
    for (const Element* world : parts(top_, "worldbody"))
      add_content(*world, {"world", Pose(), "main"});
    read_couplings();
    read_efforts();
    check_names(description_);
    take_masses_of_geoms();
    say_what_lacks();
    say_what_is_left_out();
    separate_collision_shapes();
    return std::move(description_);
  }

 private:
  // Where the content of an element goes.
  struct Place {
    std::string link;
    Pose pose;           // of the element's frame in the link
    std::string active;  // class of defaults
  };

  void read_includes(const Element& parent) {
    for (const Element* e = parent.FirstChildElement(); e != nullptr; e = e->NextSiblingElement()) {
      const bool is_include = e->Name() == std::string("include");
      if (is_include) included_[e] = &xml_.include(*e, "file");
      read_includes(is_include ? *included_[e] : *e);
    }
  }

  // What is in an element, and in files that are included there.
  std::vector<const Element*> parts(const Element& parent) const {
    std::vector<const Element*> all;
    for (const Element* e = parent.FirstChildElement(); e != nullptr; e = e->NextSiblingElement()) {
      const auto included = included_.find(e);
      if (included == included_.end()) {
        all.push_back(e);
      } else {
        const std::vector<const Element*> inner = parts(*included->second);
        all.insert(all.end(), inner.begin(), inner.end());
      }
    }
    return all;
  }
  std::vector<const Element*> parts(const Element& parent, const std::string& name) const {
    std::vector<const Element*> all = parts(parent);
    std::erase_if(all, [&name](const Element* e) { return e->Name() != name; });
    return all;
  }

  void read_settings() {
    for (const Element* compiler : parts(top_, "compiler")) {
      degrees_ = xml_.choice_or(*compiler, "angle", {"degree", "radian"},
                                degrees_ ? "degree" : "radian") == "degree";
      sequence_ = xml_.text_or(*compiler, "eulerseq", sequence_);
      mesh_folder_ =
          xml_.text_or(*compiler, "meshdir", xml_.text_or(*compiler, "assetdir", mesh_folder_));
      auto_limits_ = xml_.text_or(*compiler, "autolimits", "true") != "false";
      read_sources_of_masses(*compiler);
    }
    description_.gravity = {0, 0, -9.81};  // MuJoCo's default
    for (const Element* option : parts(top_, "option"))
      description_.gravity = xml_.vector_or(option, "gravity", description_.gravity);
  }

  void read_sources_of_masses(const Element& compiler) {
    inertia_from_geom_ =
        xml_.choice_or(compiler, "inertiafromgeom", {"auto", "true", "false"}, inertia_from_geom_);
    if (xml_.has(compiler, "inertiagrouprange"))
      groups_of_masses_ = xml_.numbers(compiler, "inertiagrouprange", 2);
    if (xml_.number_or(compiler, "settotalmass", -1) > 0)
      description_.remarks.emplace_back(
          "settotalmass is left out: masses are those of the bodies before it scales them");
  }

  double angle(double value) const { return degrees_ ? value * std::numbers::pi / 180 : value; }

  void add_class(const Element& element, const std::string& parent) {
    const std::string name = xml_.text_or(element, "class", "main");
    classes_[name] = {parts(element), parent};
    for (const Element* e : parts(element, "default")) add_class(*e, name);
  }

  // The class that an attribute names, which must be there unless it is that of all.
  std::string known_class(const Element& element, const char* attribute,
                          const std::string& otherwise) const {
    std::string name = xml_.text_or(element, attribute, otherwise);
    if (name.empty() || name == "main" || classes_.contains(name)) return name;
    std::vector<std::string> known;
    for (const auto& [other, _] : classes_) known.push_back(other);
    xml_.fail_unknown(element, "the class of defaults", name, known);
  }

  // The element itself, or that of its kind in the nearest class that has the attribute.
  const Element* holder(const Element& element, const char* attribute,
                        const std::string& active) const {
    if (xml_.has(element, attribute)) return &element;
    std::string name = known_class(element, "class", active);
    for (int depth = 0; !name.empty() && depth < 100; ++depth) {
      const auto found = classes_.find(name);
      if (found == classes_.end()) return nullptr;
      for (const Element* e : found->second.elements)
        if (std::string_view(e->Name()) == element.Name() && xml_.has(*e, attribute)) return e;
      name = found->second.parent;
    }
    return nullptr;
  }
  std::string word(const Element& element, const char* attribute, const std::string& active,
                   const std::string& otherwise) const {
    const Element* e = holder(element, attribute, active);
    return e == nullptr ? otherwise : xml_.text(*e, attribute);
  }
  Vector3 vector(const Element& element, const char* attribute, const std::string& active,
                 const Vector3& otherwise) const {
    const Element* e = holder(element, attribute, active);
    return e == nullptr ? otherwise : xml_.vector(*e, attribute);
  }
  double number(const Element& element, const char* attribute, const std::string& active,
                double otherwise) const {
    const Element* e = holder(element, attribute, active);
    return e == nullptr ? otherwise : xml_.number(*e, attribute);
  }

  Matrix3 euler(const Element& element, const Vector3& angles) const {
    Matrix3 rotation = Matrix3::Identity();
    if (sequence_.size() != 3 || sequence_.find_first_not_of("xyzXYZ") != std::string::npos)
      xml_.fail(element, fmt::format("eulerseq '{}' is not three of x, y, z", sequence_));
    for (int k = 0; k < 3; ++k) {
      const char letter = sequence_[static_cast<std::size_t>(k)];
      const bool fixed = letter < 'a';
      const Matrix3 turn =
          spatial::exp_rotation(angle(angles[k]) * Vector3::Unit(letter - (fixed ? 'X' : 'x')));
      rotation = fixed ? Matrix3(turn * rotation) : Matrix3(rotation * turn);
    }
    return rotation;
  }

  Matrix3 rotation(const Element& e, const std::string& active) const {
    if (const Element* h = holder(e, "quat", active)) {
      const std::vector<double> q = xml_.numbers(*h, "quat", 4);
      const Eigen::Quaterniond quaternion(q[0], q[1], q[2], q[3]);
      if (!(quaternion.norm() > 1e-9)) xml_.fail(*h, "the quaternion has no length");
      return quaternion.normalized().toRotationMatrix();
    }
    if (const Element* h = holder(e, "axisangle", active)) {
      const std::vector<double> a = xml_.numbers(*h, "axisangle", 4);
      const Vector3 axis(a[0], a[1], a[2]);
      if (!(axis.norm() > 1e-9)) xml_.fail(*h, "the axis has no length");
      return spatial::exp_rotation(angle(a[3]) * axis.normalized());
    }
    if (const Element* h = holder(e, "euler", active)) return euler(*h, xml_.vector(*h, "euler"));
    if (const Element* h = holder(e, "xyaxes", active)) {
      const std::vector<double> a = xml_.numbers(*h, "xyaxes", 6);
      const Vector3 x(a[0], a[1], a[2]), y(a[3], a[4], a[5]);
      if (!(x.cross(y).norm() > 1e-9)) xml_.fail(*h, "the axes are parallel or have no length");
      return spatial::rotation_from_axes(x, y);
    }
    if (const Element* h = holder(e, "zaxis", active))
      return Eigen::Quaterniond::FromTwoVectors(Vector3::UnitZ(), xml_.direction(*h, "zaxis"))
          .toRotationMatrix();
    return Matrix3::Identity();
  }
  Pose pose_of(const Element& e, const std::string& active) const {
    return {rotation(e, active), vector(e, "pos", active, Vector3::Zero())};
  }

  void add_mesh(const Element& element) {
    const std::string file = word(element, "file", "main", "");
    if (file.empty()) return;  // vertices in the XML itself
    const std::string name =
        xml_.text_or(element, "name", std::filesystem::path(file).stem().string());
    meshes_[name] = {.file = (std::filesystem::path(mesh_folder_) / file).string(),
                     .scale = vector(element, "scale", "main", Vector3::Ones())};
  }

  DescribedLink& link(const std::string& name) {
    return *std::find_if(description_.links.begin(), description_.links.end(),
                         [&name](const DescribedLink& other) { return other.name == name; });
  }

  // Children of a body, of <worldbody> or of a <frame>.
  void add_content(const Element& parent, const Place& place) {
    for (const Element* e : parts(parent)) {
      const std::string kind = e->Name();
      const Place inner{place.link, place.pose * Pose(),
                        known_class(*e, "childclass", place.active)};
      if (kind == "body") add_body(*e, inner);
      if (kind == "frame")
        add_content(*e, {place.link, place.pose * pose_of(*e, ""), inner.active});
      if (kind == "inertial") link(place.link).inertia = read_inertia(*e, place.pose);
      if (kind == "geom") add_geom(*e, place);
      if (kind == "site") add_site(*e, place);
      if (kind == "freejoint" || kind == "composite" || kind == "flexcomp" || kind == "attach" ||
          kind == "replicate")
        xml_.fail(*e, fmt::format("<{}> cannot be part of a stiffness model", kind),
                  "Cut it out, or give the model as MuJoCo saves it");
    }
  }

  // A joint of a body, and the frame in it in which it is written.
  struct PlacedJoint {
    const Element* element = nullptr;
    Pose frame;
    std::string active;
  };
  void find_joints(const Element& parent, const Pose& frame, const std::string& active,
                   std::vector<PlacedJoint>& joints) const {
    for (const Element* e : parts(parent)) {
      const std::string kind = e->Name();
      if (kind == "joint") joints.push_back({e, frame, active});
      if (kind == "frame")
        find_joints(*e, frame * pose_of(*e, ""), known_class(*e, "childclass", active), joints);
    }
  }

  void add_body(const Element& element, const Place& parent) {
    const std::string name =
        xml_.text_or(element, "name", fmt::format("body_{}", description_.links.size()));
    Pose origin = parent.pose * pose_of(element, "");
    std::string at = parent.link;
    // Joints turn about their places one after the other.
    std::vector<PlacedJoint> joints;
    find_joints(element, Pose(), parent.active, joints);
    for (const auto& [e, frame, active] : joints) {
      DescribedJoint joint = read_joint(*e, active);
      joint.axis = frame.rotation() * joint.axis;
      const Pose place = Pose::translation(frame * vector(*e, "pos", active, Vector3::Zero()));
      joint.parent = at;
      joint.origin = origin * place * at_reference(*e, joint, active);
      at = joint.child = fmt::format("{}@{}", name, joint.name);
      description_.links.push_back({.name = at, .line = xml_.line(element)});
      description_.joints.push_back(std::move(joint));
      origin = place.inverse();
    }
    add_fixed(name, at, origin, element, !joints.empty());
    add_content(element, {name, Pose(), parent.active});
  }

  // The body behind its joints: the last link between where that has the same frame.
  void add_fixed(const std::string& name, const std::string& at, const Pose& origin,
                 const Element& element, bool has_joints) {
    const bool same =
        has_joints && origin.position().norm() == 0 && origin.rotation().isIdentity(0);
    if (same) {
      description_.links.back().name = name;
      description_.joints.back().child = name;
      return;
    }
    description_.links.push_back({.name = name, .line = xml_.line(element)});
    description_.joints.push_back({.name = name + "@fixed",
                                   .line = xml_.line(element),
                                   .parent = at,
                                   .child = name,
                                   .origin = origin});
  }

  DescribedJoint read_joint(const Element& e, const std::string& active) {
    const std::string type = word(e, "type", active, "hinge");
    if (type == "ball" || type == "free")
      xml_.fail(e, fmt::format("a {} joint cannot be part of a stiffness model", type),
                "Cut it out, or replace it by joints with one axis each");
    if (type != "hinge" && type != "slide")
      xml_.fail_unknown(e, "the joint type", type, {"hinge", "slide"});
    DescribedJoint joint{
        .name = xml_.text_or(e, "name", fmt::format("joint_{}", description_.joints.size() + 1)),
        .line = xml_.line(e),
        .type = type == "slide" ? JointType::prismatic : JointType::continuous};
    const Element* axis = holder(e, "axis", active);
    joint.axis = axis == nullptr ? Vector3::UnitZ() : xml_.direction(*axis, "axis");
    read_range(e, active, joint);
    read_spring(e, active, joint);
    if (number(e, "armature", active, 0) != 0) with_armature_.push_back(joint.name);
    if (const Element* h = holder(e, "actuatorfrcrange", active))
      joint.effort = xml_.numbers(*h, "actuatorfrcrange", 2)[1];
    return joint;
  }

  void read_spring(const Element& e, const std::string& active, DescribedJoint& joint) const {
    const Element* h = holder(e, "stiffness", active);
    const double stiffness = h == nullptr ? 0 : xml_.not_negative(*h, "stiffness", "a stiffness"),
                 rest = number(e, "springref", active, 0);
    if (!(stiffness > 0)) return;
    joint.stiffness = stiffness;
    joint.rest = turns(joint) ? angle(rest) : rest;
  }

  void read_range(const Element& e, const std::string& active, DescribedJoint& joint) const {
    const Element* range = holder(e, "range", active);
    const std::string limited = word(e, "limited", active, auto_limits_ ? "auto" : "false");
    if (range == nullptr || limited == "false") return;
    std::vector<double> ends = xml_.numbers(*range, "range", 2);
    if (ends[0] > ends[1]) xml_.fail(*range, "the range has its upper end first");
    if (ends[0] == ends[1]) return;
    if (joint.type == JointType::prismatic) {
      joint.limits = {ends[0], ends[1]};
    } else {
      joint.type = JointType::revolute;
      joint.limits = {angle(ends[0]), angle(ends[1])};
    }
  }

  // Where a joint stands at a coordinate, in where it stands at zero.
  static Pose moved(const DescribedJoint& joint, double coordinate) {
    const Vector3 along = coordinate * joint.axis;
    return turns(joint) ? Pose::rotation(spatial::exp_rotation(along)) : Pose::translation(along);
  }

  // The frame of the joint where it stands at zero, in that where it stands at `ref`.
  Pose at_reference(const Element& e, const DescribedJoint& joint, const std::string& active) {
    const double ref = number(e, "ref", active, 0);
    references_[joint.name] = turns(joint) ? angle(ref) : ref;
    return moved(joint, -references_[joint.name]);
  }

  DescribedInertia read_inertia(const Element& e, const Pose& place) const {
    const Pose pose = place * pose_of(e, "");
    DescribedInertia inertia{.mass = xml_.not_negative(e, "mass", "a mass"),
                             .center = pose.position()};
    Matrix3 tensor = Matrix3::Zero();
    if (xml_.has(e, "fullinertia")) {
      const std::vector<double> i = xml_.numbers(e, "fullinertia", 6);
      tensor << i[0], i[3], i[4], i[3], i[1], i[5], i[4], i[5], i[2];
    } else if (xml_.has(e, "diaginertia")) {
      tensor = xml_.vector(e, "diaginertia").asDiagonal();
    }
    inertia.tensor = pose.rotation() * tensor * pose.rotation().transpose();
    return inertia;
  }

  void add_geom(const Element& e, const Place& place) {
    solids_[place.link] = true;
    std::optional<DescribedShape> shape = shape_of(e, place.active);
    if (shape) shape->pose = place.pose * shape->pose;
    add_mass(e, place, shape);
    if (!shape) return;
    const bool collides = number(e, "contype", place.active, 1) != 0 ||
                          number(e, "conaffinity", place.active, 1) != 0;
    const bool is_shown = number(e, "group", place.active, 0) <= last_shown_group;
    shape->is_collision = !is_shown;
    DescribedLink& carrier = link(place.link);
    if (is_shown && collides) both_[place.link].push_back(carrier.shapes.size());
    carrier.shapes.push_back(std::move(*shape));
  }

  // Where a link has shapes to look at alone, those that collide are not to look at.
  void separate_collision_shapes() {
    for (const auto& [name, numbers] : both_) {
      std::vector<DescribedShape>& shapes = link(name).shapes;
      const auto shown = std::count_if(shapes.begin(), shapes.end(),
                                       [](const DescribedShape& s) { return !s.is_collision; });
      if (static_cast<std::size_t>(shown) == numbers.size()) continue;
      for (const std::size_t n : numbers) shapes[n].is_collision = true;
    }
  }

  // Of a geom, from its mass or its density: those outside of the range of groups do not count,
  // planes and height fields have none.
  void add_mass(const Element& e, const Place& place, const std::optional<DescribedShape>& shape) {
    const double group = number(e, "group", place.active, 0);
    const std::string type = word(e, "type", place.active, "sphere");
    if (group < groups_of_masses_[0] || group > groups_of_masses_[1]) return;
    if (type == "plane" || type == "hfield") return;
    const Element* stated = holder(e, "mass", place.active);
    const double of_mass = stated == nullptr ? number(e, "density", place.active, usual_density)
                                             : xml_.number(*stated, "mass");
    if (of_mass < 0) xml_.fail(e, "a mass or a density cannot be negative");
    if (of_mass == 0) return;
    if (!shape || !word(e, "mesh", place.active, "").empty() ||
        word(e, "shellinertia", place.active, "false") == "true") {
      without_mass_.insert(place.link);
      return;
    }
    const double mass = stated == nullptr ? of_mass * volume(*shape) : of_mass;
    of_geoms_[place.link] = together(of_geoms_[place.link], uniform_inertia(*shape, mass));
  }

  bool is_from_geoms(const DescribedLink& link) const {
    return inertia_from_geom_ == "true" || (inertia_from_geom_ == "auto" && !link.inertia);
  }

  // As MuJoCo does: where no inertia is stated, or everywhere.
  void take_masses_of_geoms() {
    std::vector<std::string> names;
    for (const auto& [name, inertia] : of_geoms_) {
      DescribedLink& carrier = link(name);
      if (name == "world" || without_mass_.contains(name) || !is_from_geoms(carrier)) continue;
      carrier.inertia = inertia;
      names.push_back(name);
    }
    if (!names.empty())
      description_.remarks.push_back(
          fmt::format("masses of bodies that follow from their geoms, of {} kg/m^3 where these do "
                      "not say otherwise: {}",
                      usual_density, fmt::join(names, ", ")));
  }

  // None of a plane, a height field, or what has no size of its own.
  std::optional<DescribedShape> shape_of(const Element& e, const std::string& active) const {
    using Kind = PrimitiveSolid::Kind;
    if (const auto found = meshes_.find(word(e, "mesh", active, "")); found != meshes_.end()) {
      DescribedShape shape = found->second;
      shape.pose = pose_of(e, active);
      return shape;
    }
    const std::string type = word(e, "type", active, "sphere");
    if (!word(e, "mesh", active, "").empty() || type == "mesh" || type == "plane" ||
        type == "hfield" || type == "sdf")
      return std::nullopt;
    std::vector<double> half = sizes(e, type, active);
    DescribedShape shape{.pose = pose_of(e, active)};
    if (const Element* ends = holder(e, "fromto", active)) {
      const std::vector<double> p = xml_.numbers(*ends, "fromto", 6);
      const Vector3 from(p[0], p[1], p[2]), to(p[3], p[4], p[5]);
      const double length = (to - from).norm();
      if (!(length > 0)) xml_.fail(*ends, "both ends of 'fromto' are in one place");
      shape.pose = {
          Eigen::Quaterniond::FromTwoVectors(Vector3::UnitZ(), to - from).toRotationMatrix(),
          (from + to) / 2};
      half = type == "box" || type == "ellipsoid"
                 ? std::vector<double>{half[0], half[0], length / 2}
                 : std::vector<double>{half[0], length / 2, 0};
    }
    if (type == "box")
      shape.solid.edges = 2 * Vector3(half[0], half[1], half[2]);
    else if (type == "cylinder" || type == "capsule")
      shape.solid = {.kind = type == "capsule" ? Kind::capsule : Kind::cylinder,
                     .radius = half[0],
                     .length = 2 * half[1]};
    else if (type == "sphere")
      shape.solid = {.kind = Kind::capsule, .radius = half[0]};
    else if (type == "ellipsoid") {
      shape.solid = {.kind = Kind::capsule, .radius = 1};
      shape.scale = {half[0], half[1], half[2]};
    }
    return shape;
  }

  // Half edges, radius and half length, or half axes, as many as the type of a geom has; with
  // `fromto` the ends give the last one.
  std::vector<double> sizes(const Element& e, const std::string& type,
                            const std::string& active) const {
    static const std::map<std::string, std::size_t> counts = {
        {"sphere", 1}, {"capsule", 2}, {"cylinder", 2}, {"ellipsoid", 3}, {"box", 3}};
    const auto known = counts.find(type);
    if (known == counts.end())
      xml_.fail_unknown(
          e, "the type of geom", type,
          {"sphere", "capsule", "cylinder", "ellipsoid", "box", "mesh", "plane", "hfield", "sdf"});
    const std::size_t count = holder(e, "fromto", active) != nullptr ? 1 : known->second;
    const Element* sized = holder(e, "size", active);
    std::vector<double> half;
    if (sized != nullptr) half = xml_.numbers(*sized, "size");
    if (half.size() < count || std::any_of(half.begin(), half.begin() + std::ptrdiff_t(count),
                                           [](double size) { return !(size > 0); }))
      xml_.fail(e, fmt::format("a {} needs {} of 'size' above zero", type,
                               count == 1 ? "a number" : fmt::format("{} numbers", count)));
    half.resize(3);
    return half;
  }

  void add_site(const Element& e, const Place& place) {
    const std::string name = xml_.text_or(e, "name", "");
    if (name.empty()) return;
    const bool taken = std::any_of(description_.links.begin(), description_.links.end(),
                                   [&](const DescribedLink& l) { return l.name == name; });
    const std::string unique = taken ? name + "@site" : name;
    description_.links.push_back({.name = unique, .line = xml_.line(e), .is_mark = true});
    description_.joints.push_back({.name = unique + "@fixed",
                                   .line = xml_.line(e),
                                   .parent = place.link,
                                   .child = unique,
                                   .origin = place.pose * pose_of(e, place.active)});
  }

  DescribedJoint* joint(const std::string& name) {
    const auto found = std::find_if(description_.joints.begin(), description_.joints.end(),
                                    [&](const DescribedJoint& j) { return j.name == name; });
    return found == description_.joints.end() ? nullptr : &*found;
  }

  // What is in all elements of a name at the top: "actuator".
  std::vector<const Element*> parts_of(const char* section) const {
    std::vector<const Element*> all;
    for (const Element* element : parts(top_, section))
      for (const Element* e : parts(*element)) all.push_back(e);
    return all;
  }

  // joint1 - ref1 = polynomial of (joint2 - ref2); of a constant where there is no joint2.
  void read_couplings() {
    for (const Element* e : parts_of("equality")) {
      if (xml_.text_or(*e, "active", "true") == "false") continue;
      const std::string kind = e->Name();
      if (kind == "joint") {
        read_coupling(*e);
      } else if (kind == "connect" || kind == "weld") {
        xml_.fail(*e, fmt::format("<{}> closes a loop of bodies, and loops are not read", kind),
                  "Cut it out, or write the robot file by hand: it may have several chains");
      } else {
        description_.remarks.push_back(fmt::format("<{}> of <equality> is left out", kind));
      }
    }
  }

  void read_coupling(const Element& e) {
    DescribedJoint* follower = joint(xml_.text(e, "joint1"));
    const std::string leader = xml_.text_or(e, "joint2", "");
    if (follower == nullptr || (!leader.empty() && joint(leader) == nullptr)) return;
    std::vector<double> c{0, 1, 0, 0, 0};
    if (xml_.has(e, "polycoef")) c = xml_.numbers(e, "polycoef");
    c.resize(5);
    const double reference = references_[follower->name];
    if (leader.empty()) {
      follower->origin = follower->origin * moved(*follower, reference + c[0]);
      follower->type = JointType::fixed;
      return;
    }
    if (c[2] != 0 || c[3] != 0 || c[4] != 0)
      description_.remarks.push_back(fmt::format(
          "{} follows {} by a curve: its linear part is taken", follower->name, leader));
    follower->mimics = leader;
    follower->mimic_offset = c[0] + reference - c[1] * references_[leader];
    follower->mimic_factor = c[1];
  }

  // The largest force of the actuator of a joint.
  void read_efforts() {
    for (const Element* e : parts_of("actuator")) {
      DescribedJoint* driven = joint(xml_.text_or(*e, "joint", ""));
      const Element* range = holder(*e, "forcerange", "main");
      if (driven == nullptr || driven->effort || range == nullptr) continue;
      driven->effort = std::abs(ratio_of(*e) * xml_.numbers(*range, "forcerange", 2)[1]);
    }
  }

  double ratio_of(const Element& actuator) const {
    const Element* gear = holder(actuator, "gear", "main");
    if (gear == nullptr) return 1;
    const std::vector<double> ratios = xml_.numbers(*gear, "gear");
    if (ratios.empty()) xml_.fail(*gear, "gear holds no number");
    return ratios.front();
  }

  // Of an actuator that drives a joint to a position: what its force falls by with the way, as the
  // actuator sees it. 0 of another one.
  double gain(const Element& e) const {
    if (const Element* h = holder(e, "kp", "main")) return xml_.number(*h, "kp");
    if (word(e, "biastype", "main", "none") != "affine") return 0;
    const Element* h = holder(e, "biasprm", "main");
    const std::vector<double> bias =
        h == nullptr ? std::vector<double>() : xml_.numbers(*h, "biasprm");
    return bias.size() > 1 ? -bias[1] : 0;
  }

  void say_what_drives() {
    std::vector<std::string> gains;
    for (const Element* e : parts_of("actuator")) {
      const DescribedJoint* driven = joint(xml_.text_or(*e, "joint", ""));
      const double stiffness = gain(*e) * ratio_of(*e) * ratio_of(*e);
      if (driven != nullptr && stiffness > 0)
        gains.push_back(fmt::format("{}={:.6g} {}", driven->name, stiffness,
                                    turns(*driven) ? "N m/rad" : "N/m"));
    }
    if (!gains.empty())
      description_.remarks.push_back(
          fmt::format("Left out: gains of controllers, which are no springs. Where they are the "
                      "stiffness of the drives, give --joint-stiffness '{}'",
                      fmt::join(gains, ",")));
  }

  void say_what_is_left_out() {
    if (!with_armature_.empty())
      description_.remarks.push_back(
          fmt::format("Left out: the inertia of rotors (armature) of {}, which frequencies lack",
                      fmt::join(with_armature_, ", ")));
    std::vector<std::string> tendons;
    for (const Element* e : parts_of("tendon"))
      tendons.push_back(xml_.text_or(*e, "name", fmt::format("line {}", e->GetLineNum())));
    if (!tendons.empty())
      description_.remarks.push_back(
          fmt::format("Left out: tendons and their springs ({})", fmt::join(tendons, ", ")));
    say_what_drives();
  }

  void say_what_lacks() {
    std::vector<std::string> of_meshes, without;
    for (const auto& [name, is_solid] : solids_) {
      if (name == "world") continue;
      if (without_mass_.contains(name) && is_from_geoms(link(name)))
        of_meshes.push_back(name);
      else if (inertia_from_geom_ == "false" && !link(name).inertia)
        without.push_back(name);
    }
    if (!of_meshes.empty())
      description_.remarks.push_back(fmt::format(
          "bodies whose masses MuJoCo computes from meshes or shells, which is not done "
          "here: {}",
          fmt::join(of_meshes, ", ")));
    if (!without.empty())
      description_.remarks.push_back(
          fmt::format("bodies without <inertial> have no mass, as inertiafromgeom is false: {}",
                      fmt::join(without, ", ")));
  }

  XmlFile xml_;
  const Element& top_;
  RobotDescription description_;
  bool degrees_ = true, auto_limits_ = true;
  std::string sequence_ = "xyz", mesh_folder_, inertia_from_geom_ = "auto";
  std::vector<double> groups_of_masses_{0, 5};
  std::map<std::string, DescribedInertia> of_geoms_;   // of links, from what their geoms weigh
  std::set<std::string> without_mass_;                 // links with geoms whose mass is not known
  std::map<const Element*, const Element*> included_;  // by <include>: what is outermost there
  std::map<std::string, DefaultClass> classes_;
  std::vector<std::string> with_armature_;  // joints
  std::map<std::string, DescribedShape> meshes_;
  std::map<std::string, double> references_;              // of joints: `ref` [m or rad]
  std::map<std::string, bool> solids_;                    // links with geoms
  std::map<std::string, std::vector<std::size_t>> both_;  // shapes that collide and are shown
};

}  // namespace
}  // namespace kinetostat::vjm::mjcf_import

namespace kinetostat::vjm {

RobotDescription read_mjcf(const std::filesystem::path& file) {
  return mjcf_import::Reader(file).read();
}

}  // namespace kinetostat::vjm
