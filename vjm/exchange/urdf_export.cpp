#include <iterator>

#include <fmt/format.h>

#include "kinetostat/vjm/exchange/tree_export.h"

namespace kinetostat::vjm::urdf_export {
namespace {

using spatial::Pose;
using spatial::Vector3;

class Writer {
 public:
  explicit Writer(const BodyTree& tree) : tree_(tree) {}

  std::string run() && {
    add("<?xml version=\"1.0\"?>\n<robot name=\"{}\">\n", xml_escaped(tree_.name));
    text_ += lost_comment(lost_in_urdf(tree_), "  <!-- ", " -->");
    std::string parent = "world";  // Gazebo fixes a link of this name
    add("  <link name=\"{}\"/>\n", parent);
    for (const TreeBody& body : tree_.bodies) {
      const std::string link = xml_escaped(body.name) + "_link";
      add_link(body, link);
      add_joint(body, parent, link);
      parent = link;
    }
    const std::string tool = free_name("tool", tree_);
    add("  <link name=\"{}\"/>\n  <joint name=\"{}\" type=\"fixed\">\n{}", tool,
        free_name("tool_joint", tree_), origin(tree_.tool));
    add("    <parent link=\"{}\"/>\n    <child link=\"{}\"/>\n  </joint>\n</robot>\n", parent,
        tool);
    return std::move(text_);
  }

 private:
  template <class... Arguments>
  void add(fmt::format_string<Arguments...> format, Arguments&&... arguments) {
    fmt::format_to(std::back_inserter(text_), format, std::forward<Arguments>(arguments)...);
  }

  static std::string origin(const Pose& pose) {
    return fmt::format("    <origin xyz=\"{}\" rpy=\"{}\"/>\n", xml_words(pose.position()),
                       xml_words(roll_pitch_yaw(pose.rotation())));
  }

  // Gazebo drops links without mass, and all behind them.
  void add_link(const TreeBody& as_it_is, const std::string& link) {
    const TreeBody body = with_least_inertia(as_it_is);
    const auto& i = body.inertia;
    add("  <link name=\"{}\">\n    <inertial>\n      <origin xyz=\"{}\"/>\n", link,
        xml_words(body.center));
    add("      <mass value=\"{}\"/>\n      <inertia ixx=\"{}\" ixy=\"{}\" ixz=\"{}\" iyy=\"{}\" "
        "iyz=\"{}\" izz=\"{}\"/>\n    </inertial>\n  </link>\n",
        body.mass, i(0, 0), i(0, 1), i(0, 2), i(1, 1), i(1, 2), i(2, 2));
  }

  // A joint with limits must have those of effort and speed, a prismatic one limits: none that
  // matter where the robot states none.
  void add_joint(const TreeBody& body, const std::string& parent, const std::string& link) {
    const std::string name = xml_escaped(body.name);
    add("  <joint name=\"{}\" type=\"{}\">\n{}    <parent link=\"{}\"/>\n    <child "
        "link=\"{}\"/>\n",
        name,
        !body.turns  ? "prismatic"
        : body.range ? "revolute"
                     : "continuous",
        origin(body.origin), parent, link);
    add("    <axis xyz=\"{}\"/>\n", xml_words(Vector3::Unit(body.axis)));
    if (body.coupling)
      add("    <mimic joint=\"{}\" multiplier=\"{}\"/>\n",
          xml_escaped(tree_.bodies[body.coupling->leader].name), body.coupling->factor);
    if (!body.turns || body.range) {
      const auto [lower, upper] = body.range.value_or(std::array{-1000.0, 1000.0});
      add("    <limit lower=\"{}\" upper=\"{}\" effort=\"1e9\" velocity=\"1e9\"/>\n", lower, upper);
    }
    if (body.damping > 0) add("    <dynamics damping=\"{}\" friction=\"0\"/>\n", body.damping);
    add("  </joint>\n");
    if (body.stiffness)
      add("  <gazebo reference=\"{}\">\n    <springStiffness>{}</springStiffness>\n"
          "    <springReference>{}</springReference>\n  </gazebo>\n",
          name, *body.stiffness, body.rest);
  }

  const BodyTree& tree_;
  std::string text_;
};

}  // namespace
}  // namespace kinetostat::vjm::urdf_export

namespace kinetostat::vjm {

std::vector<std::string> lost_in_urdf(const BodyTree& tree) {
  return lost_in_file(
      {"the springs of joints, but for readers that know Gazebo's extension",
       "gravity, and the posture that the springs are relaxed in, but as springReference"},
      tree, true);
}

std::string urdf(const BodyTree& tree) { return urdf_export::Writer(tree).run(); }

}  // namespace kinetostat::vjm
