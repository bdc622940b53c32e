// What a chain stands on, and what it carries, yield: foundation and pedestal; flange and tool.
#include <array>

#include "kinetostat/vjm/chain/chain_modifier.h"
#include "kinetostat/vjm/effects/kinds/kinds.h"

namespace kinetostat::vjm::effects {
namespace mount_compliance_kind {
namespace {

enum Value { translation, rotation };

class MountCompliance : public EffectKind {
 public:
  explicit MountCompliance(std::string element) : element_(std::move(element)) {
    parameters = {{.name = "translation",
                   .linear = compliance::linear,
                   .angular = compliance::linear,
                   .lower = 0,
                   .upper = 1,
                   .prior_sd = 0.1,
                   .prior_unit = PriorUnit::soft_compliance,
                   .required = false},
                  {.name = "rotation",
                   .linear = compliance::angular,
                   .angular = compliance::angular,
                   .lower = 0,
                   .upper = 1,
                   .prior_sd = 0.1,
                   .prior_unit = PriorUnit::soft_compliance,
                   .required = false}};
  }

  void act(ChainModifier& modifier, const std::string&, const EffectInput& input) const override {
    for (const Motion motion : all_motions)
      modifier.add_compliance_behind(element_, coordinate_name(motion), motion,
                                     input.values[value_of(motion)]);
  }

  void differentiate(ChainColumns& columns, const std::string&, const EffectInput&) const override {
    for (const Motion motion : all_motions)
      columns.add_compliance_behind(value_of(motion), element_, coordinate_name(motion), motion, 1);
  }

 private:
  static Value value_of(Motion motion) { return vjm::is_rotation(motion) ? rotation : translation; }
  std::string coordinate_name(Motion motion) const {
    return "mount at " + element_ + "." + to_string(motion);
  }

  std::string element_;
};

// Turns alone, about each axis by a compliance of its own.
class MountTilt : public EffectKind {
 public:
  MountTilt() {
    for (const char* axis : {"x", "y", "z"})
      parameters.push_back({.name = axis,
                            .linear = compliance::angular,
                            .angular = compliance::angular,
                            .lower = 0,
                            .upper = 1,
                            .prior_sd = 0.1,
                            .prior_unit = PriorUnit::soft_compliance,
                            .required = false});
  }

  void act(ChainModifier& modifier, const std::string&, const EffectInput& input) const override {
    for (std::size_t k = 0; k < turns.size(); ++k)
      modifier.add_compliance_behind("base", name_of(turns[k]), turns[k],
                                     input.values[static_cast<Eigen::Index>(k)]);
  }

  void differentiate(ChainColumns& columns, const std::string&, const EffectInput&) const override {
    for (std::size_t k = 0; k < turns.size(); ++k)
      columns.add_compliance_behind(static_cast<Eigen::Index>(k), "base", name_of(turns[k]),
                                    turns[k], 1);
  }

 private:
  static constexpr std::array turns = {Motion::rx, Motion::ry, Motion::rz};
  static std::string name_of(Motion motion) { return "tilt at base." + to_string(motion); }
};

}  // namespace
}  // namespace mount_compliance_kind

Kind base_compliance() {
  auto kind = std::make_shared<mount_compliance_kind::MountCompliance>("base");
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
  auto kind = std::make_shared<mount_compliance_kind::MountTilt>();
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
  auto kind = std::make_shared<mount_compliance_kind::MountCompliance>("end");
  kind->name = "platform_compliance";
  kind->effect_class = EffectClass::compliance;
  kind->summary = "flange, platform or tool yields where a chain ends, the same in all directions";
  kind->law = "u = translation F, turn = rotation M, behind the last joint or link of the chain";
  kind->source = "a six-dimensional spring at the end of the chain: MMT11 section 2";
  kind->signature = "the same compliance in platform axes at every posture";
  kind->confuser = "link_compliance of the last link";
  kind->place = EffectPlace::end;
  return kind;
}

}  // namespace kinetostat::vjm::effects
