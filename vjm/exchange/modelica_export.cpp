#include <algorithm>
#include <cctype>
#include <iterator>
#include <numbers>

#include <fmt/format.h>

#include "kinetostat/common/printable.h"
#include "kinetostat/spatial/rotation.h"
#include "kinetostat/vjm/exchange/tree_export.h"

namespace kinetostat::vjm::modelica_export {
namespace {

using spatial::Pose;
using spatial::Vector3;

// Letters, digits and underscores, a letter first.
std::string identifier(const std::string& name) {
  std::string out;
  for (const char c : name) out += std::isalnum(static_cast<unsigned char>(c)) != 0 ? c : '_';
  if (out.empty() || std::isalpha(static_cast<unsigned char>(out[0])) == 0) out = "m_" + out;
  return out;
}

std::string vector(const Vector3& v) {
  return fmt::format("{{{}, {}, {}}}", v.x() + 0.0, v.y() + 0.0, v.z() + 0.0);
}

class Writer {
 public:
  explicit Writer(const BodyTree& tree) : tree_(tree) {}

  std::string run() && {
    const std::string model = identifier(tree_.name);
    add("model {} \"{}, from kinetostat\"\n", model, quoted(tree_.name));
    text_ += lost_comment(lost_in_modelica(tree_), "  // ");
    add_world();
    std::string at = "world.frame_b";
    for (std::size_t b = 0; b < tree_.bodies.size(); ++b) at = add_body(b, at);
    add_frame("tool", tree_.tool);
    connect(at, "tool.frame_a");
    add("equation\n{}end {};\n", equations_, model);
    return std::move(text_);
  }

 private:
  template <class... Arguments>
  void add(fmt::format_string<Arguments...> format, Arguments&&... arguments) {
    fmt::format_to(std::back_inserter(text_), format, std::forward<Arguments>(arguments)...);
  }
  void connect(const std::string& a, const std::string& b) {
    equations_ += fmt::format("  connect({}, {});\n", a, b);
  }
  static std::string quoted(const std::string& text) {
    std::string out;
    for (const char c : common::printable(text)) {
      if (c == '"' || c == '\\') out += '\\';
      out += c;
    }
    return out;
  }

  void add_world() {
    const double g = tree_.gravity.norm();
    const Vector3 down = g > 0 ? Vector3(tree_.gravity / g) : Vector3(-Vector3::UnitZ());
    add("  inner Modelica.Mechanics.MultiBody.World world(g = {}, n = {});\n", g, vector(down));
  }

  // Turned about one axis: `angle` is in degrees.
  void add_frame(const std::string& name, const Pose& pose) {
    const Vector3 turn = spatial::log_rotation(pose.rotation());
    const double angle = turn.norm();
    const Vector3 axis = angle > 0 ? Vector3(turn / angle) : Vector3(Vector3::UnitX());
    add("  Modelica.Mechanics.MultiBody.Parts.FixedRotation {}(r = {}, n = {}, angle = {},\n"
        "    rotationType = Modelica.Mechanics.MultiBody.Types.RotationTypes.RotationAxis);\n",
        name, vector(pose.position()), vector(axis), angle * 180 / std::numbers::pi);
  }

  // Returns the connector behind it.
  std::string add_body(std::size_t number, const std::string& at) {
    const TreeBody& body = tree_.bodies[number];
    const std::string name = name_of(number);
    add_frame("to_" + name, body.origin);
    connect(at, fmt::format("to_{}.frame_a", name));
    const char* coordinate = body.turns ? "phi" : "s";
    add("  Modelica.Mechanics.MultiBody.Joints.{} {}(useAxisFlange = true, n = {},\n",
        body.turns ? "Revolute" : "Prismatic", name, vector(Vector3::Unit(body.axis)));
    add("    {0}(start = {1}, fixed = {3}), {2}(start = 0, fixed = {3}));\n", coordinate,
        body.value, body.turns ? "w" : "v", !body.coupling);
    connect(fmt::format("to_{}.frame_b", name), name + ".frame_a");
    add_spring(body, name);
    if (body.coupling) add_coupling(body, name);
    if (body.mass > 0) add_mass(body, name);
    return name + ".frame_b";
  }

  void add_spring(const TreeBody& body, const std::string& name) {
    if (!body.stiffness) return;
    add("  Modelica.Mechanics.{}.Components.SpringDamper spring_{}(c = {}, d = {}, {} = {});\n",
        body.turns ? "Rotational" : "Translational", name, *body.stiffness, body.damping,
        body.turns ? "phi_rel0" : "s_rel0", body.rest);
    connect(fmt::format("spring_{}.flange_a", name), name + ".support");
    connect(fmt::format("spring_{}.flange_b", name), name + ".axis");
  }

  // The transmissions are those of the library: flange_a.phi = ratio flange_b.phi, and
  // flange_R.phi = ratio flange_T.s. Two slides have a shaft between.
  void add_coupling(const TreeBody& body, const std::string& name) {
    const auto& [leader, factor] = *body.coupling;
    const std::string other = name_of(leader), gear = "gear_" + name;
    const bool leader_turns = tree_.bodies[leader].turns;
    if (leader_turns && body.turns) {
      add_gear("IdealGear", gear, 1 / factor);
      connect(other + ".axis", gear + ".flange_a");
      connect(gear + ".flange_b", name + ".axis");
      return;
    }
    add_gear("IdealGearR2T", gear, body.turns ? factor : 1 / factor);
    std::string turning = (body.turns ? name : other) + ".axis";
    if (!leader_turns && !body.turns) {
      add_gear("IdealGearR2T", "shaft_" + name, 1);
      connect(other + ".axis", fmt::format("shaft_{}.flangeT", name));
      turning = fmt::format("shaft_{}.flangeR", name);
    }
    connect(turning, gear + ".flangeR");
    connect(gear + ".flangeT", (body.turns ? other : name) + ".axis");
  }
  void add_gear(const char* kind, const std::string& name, double ratio) {
    add("  Modelica.Mechanics.Rotational.Components.{} {}(ratio = {});\n", kind, name, ratio);
  }
  std::string name_of(std::size_t body) const {
    return fmt::format("{}_{}", identifier(tree_.bodies[body].name), body + 1);
  }

  void add_mass(const TreeBody& body, const std::string& name) {
    const auto& i = body.inertia;
    add("  Modelica.Mechanics.MultiBody.Parts.Body body_{}(m = {}, r_CM = {}, I_11 = {}, I_22 = "
        "{},\n"
        "    I_33 = {}, I_21 = {}, I_31 = {}, I_32 = {});\n",
        name, body.mass, vector(body.center), i(0, 0), i(1, 1), i(2, 2), i(1, 0), i(2, 0), i(2, 1));
    connect(name + ".frame_b", fmt::format("body_{}.frame_a", name));
  }

  const BodyTree& tree_;
  std::string text_, equations_;
};

}  // namespace
}  // namespace kinetostat::vjm::modelica_export

namespace kinetostat::vjm {

std::vector<std::string> lost_in_modelica(const BodyTree& tree) {
  std::vector<std::string> own;
  if (std::any_of(tree.bodies.begin(), tree.bodies.end(),
                  [](const TreeBody& body) { return body.range.has_value(); }))
    own.emplace_back("ranges of joints");
  return lost_in_file(std::move(own), tree, false);
}

std::string modelica(const BodyTree& tree) { return modelica_export::Writer(tree).run(); }

}  // namespace kinetostat::vjm
