#include <algorithm>
#include <iterator>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "kinetostat/common/printable.h"
#include "kinetostat/vjm/exchange/tree_export.h"

namespace kinetostat::vjm::mjcf_export {
namespace {

using spatial::Matrix3;
using spatial::Pose;
using spatial::Vector3;

class Writer {
 public:
  explicit Writer(const BodyTree& tree) : tree_(tree) {}

  std::string run() && {
    add("<mujoco model=\"{}\">\n", xml_escaped(tree_.name));
    text_ += lost_comment(lost_in_mjcf(tree_), "  <!-- ", " -->");
    add("  <compiler angle=\"radian\" autolimits=\"true\"/>\n");
    add("  <option gravity=\"{}\"/>\n  <worldbody>\n", xml_words(tree_.gravity));
    for (std::size_t b = 0; b < tree_.bodies.size(); ++b) open_body(b);
    add("{}<site name=\"{}\" {}/>\n", indent(tree_.bodies.size()), free_name("tool", tree_),
        place(tree_.tool));
    for (std::size_t b = tree_.bodies.size(); b-- > 0;) add("{}</body>\n", indent(b));
    add("  </worldbody>\n");
    add_couplings();
    add("  <keyframe>\n    <key name=\"posture\" qpos=\"");
    for (std::size_t b = 0; b < tree_.bodies.size(); ++b)
      add("{}{}", b == 0 ? "" : " ", tree_.bodies[b].value);
    add("\"/>\n  </keyframe>\n</mujoco>\n");
    return std::move(text_);
  }

 private:
  template <class... Arguments>
  void add(fmt::format_string<Arguments...> format, Arguments&&... arguments) {
    fmt::format_to(std::back_inserter(text_), format, std::forward<Arguments>(arguments)...);
  }
  static std::string indent(std::size_t depth) { return std::string(2 * depth + 4, ' '); }

  static std::string place(const Pose& pose) {
    const Eigen::Quaterniond q(pose.rotation());
    return fmt::format("pos=\"{}\" quat=\"{} {} {} {}\"", xml_words(pose.position()), q.w() + 0.0,
                       q.x() + 0.0, q.y() + 0.0, q.z() + 0.0);
  }

  void open_body(std::size_t b) {
    const TreeBody body = with_least_inertia(tree_.bodies[b]);
    const Matrix3& inertia = body.inertia;
    const std::string name = xml_escaped(body.name);
    add("{}<body name=\"{}\" {}>\n", indent(b), name, place(body.origin));
    add("{}  <inertial pos=\"{}\" mass=\"{}\" fullinertia=\"{} {} {} {} {} {}\"/>\n", indent(b),
        xml_words(body.center), body.mass, inertia(0, 0), inertia(1, 1), inertia(2, 2),
        inertia(0, 1), inertia(0, 2), inertia(1, 2));
    add("{}  <joint name=\"{}\" type=\"{}\" axis=\"{}\"{}{}/>\n", indent(b), name,
        body.turns ? "hinge" : "slide", xml_words(Vector3::Unit(body.axis)), range(body),
        spring(body));
  }

  // As hard as MuJoCo has them: `solimp` at its limit, no slower than two of its usual time steps.
  void add_couplings() {
    std::string laws;
    for (const TreeBody& body : tree_.bodies)
      if (body.coupling)
        laws += fmt::format(
            "    <joint joint1=\"{}\" joint2=\"{}\" polycoef=\"0 {} 0 0 0\" solref=\"0.004 1\" "
            "solimp=\"0.9999 0.9999 0.001\"/>\n",
            xml_escaped(body.name), xml_escaped(tree_.bodies[body.coupling->leader].name),
            body.coupling->factor);
    if (!laws.empty()) add("  <equality>\n{}  </equality>\n", laws);
  }

  static std::string range(const TreeBody& body) {
    if (!body.range) return {};
    return fmt::format(" range=\"{} {}\"", body.range->front(), body.range->back());
  }

  static std::string spring(const TreeBody& body) {
    if (!body.stiffness) return {};
    std::string text =
        fmt::format(" stiffness=\"{}\" springref=\"{}\"", *body.stiffness, body.rest);
    if (body.damping > 0) text += fmt::format(" damping=\"{}\"", body.damping);
    return text;
  }

  const BodyTree& tree_;
  std::string text_;
};

}  // namespace
}  // namespace kinetostat::vjm::mjcf_export

namespace kinetostat::vjm {

std::vector<std::string> lost_in_mjcf(const BodyTree& tree) {
  std::vector<std::string> own;
  for (const TreeBody& body : tree.bodies)
    if (body.coupling)
      own.push_back(fmt::format("that {} follows {} exactly: constraints of MuJoCo yield a little",
                                common::printable(body.name),
                                common::printable(tree.bodies[body.coupling->leader].name)));
  return lost_in_file(std::move(own), tree, true);
}

std::string mjcf(const BodyTree& tree) { return mjcf_export::Writer(tree).run(); }

}  // namespace kinetostat::vjm
