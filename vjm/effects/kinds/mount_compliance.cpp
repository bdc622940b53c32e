// What a chain stands on, and what it carries, yield: foundation and pedestal; flange and tool.
#include <utility>
#include <vector>

#include "kinetostat/vjm/chain/chain_modifier.h"
#include "kinetostat/vjm/effects/kinds/kinds.h"

namespace kinetostat::vjm::effects {
namespace mount_compliance_kind {
namespace {

// A motion in which the mount yields, and the value that says how far.
struct Yield {
  Motion motion = Motion::tx;
  Eigen::Index value = 0;
};

class MountCompliance : public EffectKind {
 public:
  // `label`: of its coordinates, whose names are those of no other effect there.
  MountCompliance(std::string label, std::vector<Yield> yields)
      : label_(std::move(label)), yields_(std::move(yields)) {}

  void act(ChainModifier& modifier, const std::string& element,
           const EffectInput& input) const override {
    for (const auto& [motion, value] : yields_)
      modifier.add_compliance_behind(element, coordinate_name(element, motion), motion,
                                     input.values[value]);
  }

  void differentiate(ChainColumns& columns, const std::string& element,
                     const EffectInput&) const override {
    for (const auto& [motion, value] : yields_)
      columns.add_compliance_behind(value, element, coordinate_name(element, motion), motion, 1);
  }

 private:
  std::string coordinate_name(const std::string& element, Motion motion) const {
    return label_ + " at " + element + "." + to_string(motion);
  }

  std::string label_;
  std::vector<Yield> yields_;
};

// The same in all directions.
std::shared_ptr<MountCompliance> isotropic() {
  std::vector<Yield> yields;
  for (const Motion motion : all_motions) yields.push_back({motion, is_rotation(motion) ? 1 : 0});
  auto kind = std::make_shared<MountCompliance>("mount", std::move(yields));
  kind->parameters = {added_compliance("translation", compliance::linear),
                      added_compliance("rotation", compliance::angular)};
  return kind;
}

}  // namespace
}  // namespace mount_compliance_kind

Kind base_compliance() {
  auto kind = mount_compliance_kind::isotropic();
  kind->name = "base_compliance";
  kind->effect_class = EffectClass::compliance;
  kind->summary = "what a chain stands on yields, the same in all directions";
  kind->law = "u = translation F, turn = rotation M, at the base frame of the chain";
  kind->source = "a six-dimensional spring at the start of the chain: MMT11 section 2";
  kind->signature =
      "the whole robot moves; rotations grow with the moment about the base, so with reach";
  kind->confuser = "joint_compliance of the first joint";
  kind->place = EffectPlace::base;
  return kind;
}

Kind base_tilt() {
  using namespace mount_compliance_kind;
  auto kind = std::make_shared<MountCompliance>(
      "tilt", std::vector<Yield>{{Motion::rx, 0}, {Motion::ry, 1}, {Motion::rz, 2}});
  for (const char* axis : {"x", "y", "z"})
    kind->parameters.push_back(added_compliance(axis, compliance::angular));
  kind->name = "base_tilt";
  kind->effect_class = EffectClass::compliance;
  kind->summary = "what a chain stands on tilts, about each axis by a compliance of its own";
  kind->law = "turn = [x Mx, y My, z Mz] about the axes of the base frame of the chain";
  kind->source = "foundation of a machine on bolts or feet: Rivin, Stiffness and Damping, 1999";
  kind->signature = "the whole robot turns with the moment about the base, more about one axis";
  kind->confuser =
      "base_compliance, which tilts alike about all axes; bearing_compliance of the "
      "first joint";
  kind->place = EffectPlace::base;
  return kind;
}

Kind platform_compliance() {
  auto kind = mount_compliance_kind::isotropic();
  kind->name = "platform_compliance";
  kind->effect_class = EffectClass::compliance;
  kind->summary = "flange, platform or tool yields where a chain ends, the same in all directions";
  kind->law =
      "u = translation F, turn = rotation M, behind the last joint or elastic link of the chain";
  kind->source = "a six-dimensional spring at the end of the chain: MMT11 section 2";
  kind->signature = "the same compliance in platform axes at every posture";
  kind->confuser = "link_compliance of the last link";
  kind->place = EffectPlace::end;
  return kind;
}

}  // namespace kinetostat::vjm::effects
