#include "vjm/exchange/tree_reader.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <regex>
#include <sstream>
#include <tinyxml2.h>

#include <gtest/gtest.h>

namespace kinetostat::test {
namespace {

using Eigen::Index;
using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using tinyxml2::XMLElement;

std::vector<double> words(const char* text) {
  std::istringstream stream(text == nullptr ? "" : text);
  std::vector<double> values;
  for (double value = 0; stream >> value;) values.push_back(value);
  return values;
}
Vector3d vector(const std::vector<double>& v, std::size_t from = 0) {
  return {v.at(from), v.at(from + 1), v.at(from + 2)};
}
std::vector<double> inside(const XMLElement& parent, const char* name) {
  const XMLElement* e = parent.FirstChildElement(name);
  return words(e == nullptr ? nullptr : e->GetText());
}

// Position, then roll, pitch and yaw about fixed axes.
Isometry3d posed(const std::vector<double>& v) {
  using Eigen::AngleAxisd;
  return Eigen::Translation3d(vector(v)) * AngleAxisd(v.at(5), Vector3d::UnitZ()) *
         AngleAxisd(v.at(4), Vector3d::UnitY()) * AngleAxisd(v.at(3), Vector3d::UnitX());
}

Matrix3d symmetric(double xx, double xy, double xz, double yy, double yz, double zz) {
  Matrix3d m;
  m << xx, xy, xz, xy, yy, yz, xz, yz, zz;
  return m;
}

// Of the one of these joints that has the name.
ReadCoupling coupled(const std::vector<std::string>& names, const std::string& leader,
                     double factor) {
  const auto found = std::find(names.begin(), names.end(), leader);
  EXPECT_NE(found, names.end()) << leader;
  return {static_cast<int>(found - names.begin()), factor};
}

// --- MJCF

Isometry3d placed(const XMLElement& element) {
  const std::vector<double> q = words(element.Attribute("quat"));
  return Eigen::Translation3d(vector(words(element.Attribute("pos")))) *
         Eigen::Quaterniond(q.at(0), q.at(1), q.at(2), q.at(3));
}

RawBody mjcf_body(const XMLElement& element, double value) {
  const XMLElement& joint = *element.FirstChildElement("joint");
  const XMLElement& inertial = *element.FirstChildElement("inertial");
  const std::vector<double> i = words(inertial.Attribute("fullinertia"));
  return {.origin = placed(element),
          .axis = vector(words(joint.Attribute("axis"))),
          .turns = std::string(joint.Attribute("type")) == "hinge",
          .value = value,
          .stiffness = joint.DoubleAttribute("stiffness"),
          .rest = joint.DoubleAttribute("springref"),
          .damping = joint.DoubleAttribute("damping"),
          .mass = inertial.DoubleAttribute("mass"),
          .center = vector(words(inertial.Attribute("pos"))),
          .inertia = symmetric(i.at(0), i.at(3), i.at(4), i.at(1), i.at(5), i.at(2))};
}

// --- URDF

Isometry3d urdf_origin(const XMLElement& parent) {
  const XMLElement* origin = parent.FirstChildElement("origin");
  if (origin == nullptr) return Isometry3d::Identity();
  std::vector<double> v = words(origin->Attribute("xyz"));
  const std::vector<double> rpy = words(origin->Attribute("rpy"));
  v.insert(v.end(), rpy.begin(), rpy.end());
  v.resize(6, 0.0);
  return posed(v);
}

void add_inertial(const XMLElement* inertial, RawBody& body) {
  if (inertial == nullptr) return;
  const XMLElement& i = *inertial->FirstChildElement("inertia");
  const auto of = [&i](const char* name) { return i.DoubleAttribute(name); };
  body.mass = inertial->FirstChildElement("mass")->DoubleAttribute("value");
  body.center = urdf_origin(*inertial).translation();
  body.inertia = symmetric(of("ixx"), of("ixy"), of("ixz"), of("iyy"), of("iyz"), of("izz"));
}

const XMLElement* named(const XMLElement& top, const char* kind, const char* attribute,
                        const std::string& name) {
  const XMLElement* e = top.FirstChildElement(kind);
  while (e != nullptr && name != e->Attribute(attribute)) e = e->NextSiblingElement(kind);
  return e;
}

// --- SDF

RawBody sdf_body(const XMLElement& joint, const XMLElement& link) {
  const XMLElement& axis = *joint.FirstChildElement("axis");
  const XMLElement* dynamics = axis.FirstChildElement("dynamics");
  const auto of = [&](const char* name) {
    const auto v = dynamics == nullptr ? std::vector<double>{} : inside(*dynamics, name);
    return v.empty() ? 0.0 : v[0];
  };
  EXPECT_EQ(std::string(joint.FirstChildElement("pose")->Attribute("relative_to")),
            joint.FirstChildElement("parent")->GetText());
  EXPECT_EQ(std::string(link.FirstChildElement("pose")->Attribute("relative_to")),
            joint.Attribute("name"));
  RawBody body{.origin = posed(inside(joint, "pose")),
               .axis = vector(inside(axis, "xyz")),
               .turns = std::string(joint.Attribute("type")) != "prismatic",
               .value = of("spring_reference"),
               .stiffness = of("spring_stiffness"),
               .rest = of("spring_reference"),
               .damping = of("damping")};
  if (const XMLElement* inertial = link.FirstChildElement("inertial")) {
    const XMLElement& i = *inertial->FirstChildElement("inertia");
    const auto entry = [&i](const char* name) { return inside(i, name).at(0); };
    body.mass = inside(*inertial, "mass").at(0);
    body.center = vector(inside(*inertial, "pose"));
    body.inertia = symmetric(entry("ixx"), entry("ixy"), entry("ixz"), entry("iyy"), entry("iyz"),
                             entry("izz"));
  }
  return body;
}

// --- Modelica

// Components by name: the text in their parentheses; and what each connector is connected to.
struct ModelicaModel {
  std::map<std::string, std::pair<std::string, std::string>> components;  // class, modifiers
  std::multimap<std::string, std::string> connected;

  explicit ModelicaModel(std::string text) {
    text = std::regex_replace(text, std::regex("//[^\n]*\n"), "\n");
    const std::regex component(R"(\s(Modelica\.[\w.]+)\s+(\w+)\(([^;]*)\);)");
    for (std::sregex_iterator i(text.begin(), text.end(), component), end; i != end; ++i)
      components[(*i)[2]] = {(*i)[1], (*i)[3]};
    const std::regex connection(R"(connect\(([\w.]+), ([\w.]+)\);)");
    for (std::sregex_iterator i(text.begin(), text.end(), connection), end; i != end; ++i) {
      connected.emplace((*i)[1], (*i)[2]);
      connected.emplace((*i)[2], (*i)[1]);
    }
  }

  // Numbers of "name = {a, b}" or "name = a".
  std::vector<double> values(const std::string& of, const std::string& name) const {
    const std::string& text = components.at(of).second;
    std::smatch found;
    if (!std::regex_search(text, found,
                           std::regex("(^|[ ,(])" + name + R"( = (\{[^}]*\}|[-+.\deE]+))")))
      return {};
    return words(std::regex_replace(found[2].str(), std::regex("[{},]"), " ").c_str());
  }
  double value(const std::string& of, const std::string& name) const {
    const std::vector<double> v = values(of, name);
    return v.empty() ? 0.0 : v[0];
  }
  Isometry3d fixed(const std::string& of) const {
    EXPECT_NE(components.at(of).second.find("RotationTypes.RotationAxis"), std::string::npos);
    return Eigen::Translation3d(vector(values(of, "r"))) *
           Eigen::AngleAxisd(value(of, "angle") * M_PI / 180, vector(values(of, "n")));
  }
  // The component at the other side of `connector` whose class ends so.
  std::string behind(const std::string& connector, const std::string& kind) const {
    const auto [first, last] = connected.equal_range(connector);
    for (auto i = first; i != last; ++i) {
      std::string name = i->second.substr(0, i->second.find('.'));
      if (components.contains(name) && components.at(name).first.ends_with(kind)) return name;
    }
    return {};
  }
};

// Joints by their transmissions: flange_a.phi = ratio flange_b.phi, flange_R.phi = ratio
// flange_T.s.
ReadCoupling modelica_coupling(const ModelicaModel& model, const std::vector<std::string>& joints) {
  const auto joint_at = [&](const std::string& connector) {
    for (const char* kind : {".Revolute", ".Prismatic"})
      if (std::string name = model.behind(connector, kind); !name.empty()) return name;
    return std::string();
  };
  const std::string at = joints.back() + ".axis";
  if (const std::string gear = model.behind(at, ".IdealGear"); !gear.empty()) {
    const std::string leader = joint_at(gear + ".flange_a");
    if (leader != joints.back()) return coupled(joints, leader, 1 / model.value(gear, "ratio"));
  }
  const std::string gear = model.behind(at, ".IdealGearR2T");
  if (gear.empty()) return {};
  const double ratio = model.value(gear, "ratio");
  const std::string slide = joint_at(gear + ".flangeT"), turn = joint_at(gear + ".flangeR");
  if (turn == joints.back())
    return gear.starts_with("gear_" + turn) ? coupled(joints, slide, ratio) : ReadCoupling();
  if (!gear.starts_with("gear_" + slide)) return {};
  if (!turn.empty()) return coupled(joints, turn, 1 / ratio);
  const std::string shaft = model.behind(gear + ".flangeR", ".IdealGearR2T");
  return coupled(joints, joint_at(shaft + ".flangeT"), model.value(shaft, "ratio") / ratio);
}

RawBody modelica_body(const ModelicaModel& model, const std::string& frame) {
  std::string joint = model.behind(frame + ".frame_b", ".Revolute");
  const bool turns = !joint.empty();
  if (!turns) joint = model.behind(frame + ".frame_b", ".Prismatic");
  RawBody body{.origin = model.fixed(frame),
               .axis = vector(model.values(joint, "n")),
               .turns = turns,
               .value = model.value(joint, "start")};
  if (const std::string spring = model.behind(joint + ".axis", ".SpringDamper"); !spring.empty()) {
    EXPECT_EQ(model.behind(joint + ".support", ".SpringDamper"), spring);
    body.stiffness = model.value(spring, "c");
    body.damping = model.value(spring, "d");
    body.rest = model.value(spring, turns ? "phi_rel0" : "s_rel0");
  }
  if (const std::string mass = model.behind(joint + ".frame_b", ".Body"); !mass.empty()) {
    const auto i = [&](const char* name) { return model.value(mass, name); };
    body.mass = i("m");
    body.center = vector(model.values(mass, "r_CM"));
    body.inertia = symmetric(i("I_11"), i("I_21"), i("I_31"), i("I_22"), i("I_32"), i("I_33"));
  }
  return body;
}

}  // namespace

Eigen::Matrix<double, 6, Eigen::Dynamic> ReadTree::jacobian(std::size_t b,
                                                            const Vector3d& point) const {
  Eigen::Matrix<double, 6, Eigen::Dynamic> columns =
      Eigen::Matrix<double, 6, Eigen::Dynamic>::Zero(6, std::ssize(bodies));
  for (std::size_t j = 0; j <= b; ++j) {
    auto column = columns.col(static_cast<Index>(j));
    if (bodies[j].turns)
      column << bodies[j].axis.cross(point - bodies[j].frame.translation()), bodies[j].axis;
    else
      column.head<3>() = bodies[j].axis;
  }
  return columns * couplings();
}

MatrixXd ReadTree::couplings() const {
  MatrixXd all = MatrixXd::Identity(std::ssize(bodies), std::ssize(bodies));
  std::vector<Index> free;
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    const auto& [leader, factor] = bodies[b].coupling;
    if (leader < 0)
      free.push_back(static_cast<Index>(b));
    else
      all(static_cast<Index>(b), leader) = factor;
  }
  return all(Eigen::all, free);
}

MatrixXd ReadTree::mass() const {
  const Index free = couplings().cols();
  MatrixXd sum = MatrixXd::Zero(free, free);
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    const auto j = jacobian(b, bodies[b].center);
    sum += bodies[b].mass * j.topRows<3>().transpose() * j.topRows<3>() +
           j.bottomRows<3>().transpose() * bodies[b].inertia * j.bottomRows<3>();
  }
  return sum;
}

MatrixXd ReadTree::stiffness() const {
  Eigen::VectorXd diagonal(std::ssize(bodies));
  for (std::size_t b = 0; b < bodies.size(); ++b)
    diagonal[static_cast<Index>(b)] = bodies[b].stiffness;
  const MatrixXd t = couplings();
  return t.transpose() * diagonal.asDiagonal() * t;
}

Eigen::Matrix<double, 6, 6> ReadTree::compliance() const {
  const auto j = jacobian(bodies.size() - 1, tool.translation());
  return j * stiffness().inverse() * j.transpose();
}

ReadTree assembled(const std::vector<RawBody>& raw, const Isometry3d& tool) {
  ReadTree tree;
  Isometry3d frame = Isometry3d::Identity();
  for (const RawBody& body : raw) {
    frame = frame * body.origin;
    frame = body.turns ? frame * Eigen::AngleAxisd(body.value, body.axis)
                       : frame * Eigen::Translation3d(body.value * body.axis);
    const Matrix3d rotation = frame.rotation();
    tree.bodies.push_back({.frame = frame,
                           .axis = rotation * body.axis,
                           .turns = body.turns,
                           .stiffness = body.stiffness,
                           .rest = body.rest,
                           .damping = body.damping,
                           .mass = body.mass,
                           .center = frame * body.center,
                           .inertia = rotation * body.inertia * rotation.transpose(),
                           .coupling = body.coupling});
  }
  tree.tool = frame * tool;
  return tree;
}

ReadTree read_mjcf_text(const std::string& text) {
  tinyxml2::XMLDocument document;
  EXPECT_EQ(document.Parse(text.c_str()), tinyxml2::XML_SUCCESS);
  const XMLElement& top = *document.FirstChildElement("mujoco");
  EXPECT_STREQ(top.FirstChildElement("compiler")->Attribute("angle"), "radian");
  const XMLElement& key = *top.FirstChildElement("keyframe")->FirstChildElement("key");
  const std::vector<double> qpos = words(key.Attribute("qpos"));
  std::vector<RawBody> bodies;
  std::vector<std::string> names;
  const XMLElement* element = top.FirstChildElement("worldbody");
  while (const XMLElement* inner = element->FirstChildElement("body")) {
    element = inner;
    const XMLElement* equality = top.FirstChildElement("equality");
    bodies.push_back(mjcf_body(*element, qpos.at(bodies.size())));
    names.emplace_back(element->FirstChildElement("joint")->Attribute("name"));
    const XMLElement* law =
        equality == nullptr ? nullptr : named(*equality, "joint", "joint1", names.back());
    if (law != nullptr)
      bodies.back().coupling =
          coupled(names, law->Attribute("joint2"), words(law->Attribute("polycoef")).at(1));
  }
  EXPECT_EQ(bodies.size(), qpos.size());
  ReadTree tree = assembled(bodies, placed(*element->FirstChildElement("site")));
  tree.gravity = vector(words(top.FirstChildElement("option")->Attribute("gravity")));
  return tree;
}

ReadTree read_urdf_text(const std::string& text) {
  tinyxml2::XMLDocument document;
  EXPECT_EQ(document.Parse(text.c_str()), tinyxml2::XML_SUCCESS);
  const XMLElement& top = *document.FirstChildElement("robot");
  std::vector<RawBody> bodies;
  std::vector<std::string> names;
  std::string at = "world";
  Isometry3d tool = Isometry3d::Identity();
  for (const XMLElement* joint = top.FirstChildElement("joint"); joint != nullptr;
       joint = joint->NextSiblingElement("joint")) {
    EXPECT_EQ(at, joint->FirstChildElement("parent")->Attribute("link"));
    at = joint->FirstChildElement("child")->Attribute("link");
    const std::string type = joint->Attribute("type");
    if (type == "fixed") {
      tool = urdf_origin(*joint);
      continue;
    }
    RawBody body{.origin = urdf_origin(*joint),
                 .axis = vector(words(joint->FirstChildElement("axis")->Attribute("xyz"))),
                 .turns = type != "prismatic"};
    if (const XMLElement* dynamics = joint->FirstChildElement("dynamics"))
      body.damping = dynamics->DoubleAttribute("damping");
    if (const XMLElement* spring = named(top, "gazebo", "reference", joint->Attribute("name"))) {
      body.stiffness = inside(*spring, "springStiffness").at(0);
      body.value = body.rest = inside(*spring, "springReference").at(0);
    }
    add_inertial(named(top, "link", "name", at)->FirstChildElement("inertial"), body);
    names.emplace_back(joint->Attribute("name"));
    if (const XMLElement* law = joint->FirstChildElement("mimic")) {
      body.coupling = coupled(names, law->Attribute("joint"), law->DoubleAttribute("multiplier"));
      body.value = body.coupling.factor * bodies.at(std::size_t(body.coupling.leader)).value;
    }
    bodies.push_back(body);
  }
  return assembled(bodies, tool);
}

ReadTree read_sdf_text(const std::string& text) {
  tinyxml2::XMLDocument document;
  EXPECT_EQ(document.Parse(text.c_str()), tinyxml2::XML_SUCCESS);
  const XMLElement& world = *document.FirstChildElement("sdf")->FirstChildElement("world");
  const XMLElement& model = *world.FirstChildElement("model");
  std::vector<RawBody> bodies;
  std::vector<std::string> names;
  std::string at = "world";
  for (const XMLElement* joint = model.FirstChildElement("joint"); joint != nullptr;
       joint = joint->NextSiblingElement("joint")) {
    EXPECT_EQ(at, joint->FirstChildElement("parent")->GetText());
    at = joint->FirstChildElement("child")->GetText();
    if (std::string(joint->Attribute("type")) == "fixed") continue;
    bodies.push_back(sdf_body(*joint, *named(model, "link", "name", at)));
    names.emplace_back(joint->Attribute("name"));
    if (const XMLElement* law = joint->FirstChildElement("axis")->FirstChildElement("mimic")) {
      EXPECT_GE(document.FirstChildElement("sdf")->DoubleAttribute("version"), 1.11);
      RawBody& body = bodies.back();
      body.coupling = coupled(names, law->Attribute("joint"), inside(*law, "multiplier").at(0));
      body.value = body.coupling.factor * bodies.at(std::size_t(body.coupling.leader)).value;
    }
  }
  const XMLElement& tool = *named(model, "frame", "name", "tool");
  EXPECT_EQ(at, tool.Attribute("attached_to"));
  ReadTree tree = assembled(bodies, posed(inside(tool, "pose")));
  tree.gravity = vector(inside(world, "gravity"));
  return tree;
}

ReadTree read_modelica_text(const std::string& text) {
  const ModelicaModel model(text);
  std::vector<RawBody> bodies;
  std::vector<std::string> joints;
  std::string at = "world.frame_b";
  while (true) {
    const std::string frame = model.behind(at, ".FixedRotation");
    EXPECT_FALSE(frame.empty()) << at;
    if (frame.empty() || frame == "tool") break;
    std::string joint = model.behind(frame + ".frame_b", ".Revolute");
    if (joint.empty()) joint = model.behind(frame + ".frame_b", ".Prismatic");
    bodies.push_back(modelica_body(model, frame));
    joints.push_back(joint);
    bodies.back().coupling = modelica_coupling(model, joints);
    at = joint + ".frame_b";
  }
  ReadTree tree = assembled(bodies, model.fixed("tool"));
  tree.gravity = model.value("world", "g") * vector(model.values("world", "n"));
  return tree;
}

MatrixXd read_matrix(const std::string& script, const std::string& name) {
  const std::size_t at = script.find("\n" + name + " = [\n");
  EXPECT_NE(at, std::string::npos) << name;
  if (at == std::string::npos) return {};
  std::istringstream lines(script.substr(at + name.size() + 6));
  std::vector<std::vector<double>> rows;
  for (std::string line; std::getline(lines, line) && !line.starts_with("]");)
    rows.push_back(words(line.c_str()));
  MatrixXd matrix(std::ssize(rows), rows.empty() ? 0 : std::ssize(rows[0]));
  for (std::size_t i = 0; i < rows.size(); ++i)
    for (std::size_t j = 0; j < rows[i].size(); ++j)
      matrix(static_cast<Index>(i), static_cast<Index>(j)) = rows[i][j];
  return matrix;
}

}  // namespace kinetostat::test
