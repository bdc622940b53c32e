#include <algorithm>
#include <iterator>

#include <fmt/format.h>

#include "kinetostat/vjm/exchange/tree_export.h"

namespace kinetostat::vjm::sdf_export {
namespace {

using spatial::Pose;
using spatial::Vector3;

class Writer {
 public:
  explicit Writer(const BodyTree& tree) : tree_(tree) {}

  std::string run() && {
    // Joints that follow others are known from 1.11 on.
    const bool has_couplings =
        std::any_of(tree_.bodies.begin(), tree_.bodies.end(),
                    [](const TreeBody& body) { return body.coupling.has_value(); });
    add("<?xml version=\"1.0\"?>\n<sdf version=\"{}\">\n", has_couplings ? "1.11" : "1.9");
    text_ += lost_comment(lost_in_sdf(tree_), "  <!-- ", " -->");
    add("  <world name=\"world_of_robot\">\n    <gravity>{}</gravity>\n", xml_words(tree_.gravity));
    std::string parent = free_name("base", tree_);
    add("    <model name=\"{}\">\n      <link name=\"{}\"/>\n", xml_escaped(tree_.name), parent);
    add("      <joint name=\"{}\" type=\"fixed\">\n        <parent>world</parent>\n"
        "        <child>{}</child>\n      </joint>\n",
        free_name("base_joint", tree_), parent);
    for (const TreeBody& body : tree_.bodies) {
      const std::string link = xml_escaped(body.name) + "_link";
      add_link(body, link);
      add_joint(body, parent, link);
      parent = link;
    }
    add("      <frame name=\"{}\" attached_to=\"{}\">\n{}      </frame>\n",
        free_name("tool", tree_), parent, pose(tree_.tool, parent));
    add("    </model>\n  </world>\n</sdf>\n");
    return std::move(text_);
  }

 private:
  template <class... Arguments>
  void add(fmt::format_string<Arguments...> format, Arguments&&... arguments) {
    fmt::format_to(std::back_inserter(text_), format, std::forward<Arguments>(arguments)...);
  }

  static std::string pose(const Pose& pose, const std::string& in) {
    return fmt::format("        <pose relative_to=\"{}\">{} {}</pose>\n", in,
                       xml_words(pose.position()), xml_words(roll_pitch_yaw(pose.rotation())));
  }

  // A link that says nothing of its mass has 1 kg and 1 kg m^2 there.
  void add_link(const TreeBody& as_it_is, const std::string& link) {
    const TreeBody body = with_least_inertia(as_it_is);
    add("      <link name=\"{}\">\n        <pose relative_to=\"{}\"/>\n", link,
        xml_escaped(body.name));
    const auto& i = body.inertia;
    add("        <inertial>\n          <pose>{} 0 0 0</pose>\n          <mass>{}</mass>\n",
        xml_words(body.center), body.mass);
    add("          <inertia><ixx>{}</ixx><ixy>{}</ixy><ixz>{}</ixz><iyy>{}</iyy><iyz>{}</iyz>"
        "<izz>{}</izz></inertia>\n        </inertial>\n      </link>\n",
        i(0, 0), i(0, 1), i(0, 2), i(1, 1), i(1, 2), i(2, 2));
  }

  void add_joint(const TreeBody& body, const std::string& parent, const std::string& link) {
    add("      <joint name=\"{}\" type=\"{}\">\n{}", xml_escaped(body.name),
        !body.turns  ? "prismatic"
        : body.range ? "revolute"
                     : "continuous",
        pose(body.origin, parent));
    add("        <parent>{}</parent>\n        <child>{}</child>\n        <axis>\n"
        "          <xyz>{}</xyz>\n",
        parent, link, xml_words(Vector3::Unit(body.axis)));
    if (body.range)
      add("          <limit><lower>{}</lower><upper>{}</upper></limit>\n", body.range->front(),
          body.range->back());
    if (body.stiffness) {
      add("          <dynamics>\n            <spring_reference>{}</spring_reference>\n"
          "            <spring_stiffness>{}</spring_stiffness>\n",
          body.rest, *body.stiffness);
      if (body.damping > 0) add("            <damping>{}</damping>\n", body.damping);
      add("          </dynamics>\n");
    }
    if (body.coupling)
      add("          <mimic joint=\"{}\"><multiplier>{}</multiplier><offset>0</offset>"
          "<reference>0</reference></mimic>\n",
          xml_escaped(tree_.bodies[body.coupling->leader].name), body.coupling->factor);
    add("        </axis>\n      </joint>\n");
  }

  const BodyTree& tree_;
  std::string text_;
};

}  // namespace
}  // namespace kinetostat::vjm::sdf_export

namespace kinetostat::vjm {

std::vector<std::string> lost_in_sdf(const BodyTree& tree) {
  return lost_in_file({"the posture, but as spring_reference"}, tree, true);
}

std::string sdf(const BodyTree& tree) { return sdf_export::Writer(tree).run(); }

}  // namespace kinetostat::vjm
