// Bearings and guides yield across the motion that they leave free.
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "kinetostat/vjm/chain/chain_modifier.h"
#include "kinetostat/vjm/effects/kinds/kinds.h"

namespace kinetostat::vjm::effects {
namespace bearing_compliance_kind {
namespace {

// Of a value for each motion but the joint's own, in series with it.
class AcrossJoint : public EffectKind {
 public:
  void act(ChainModifier& modifier, const std::string& joint,
           const EffectInput& input) const override {
    const Motion own = motion_of(modifier.chain(), joint);
    for (const Motion motion : all_motions)
      if (const auto value = value_of(motion, own))
        modifier.add_compliance_behind(joint, coordinate_name(joint, motion), motion,
                                       input.values[*value]);
  }

  void differentiate(ChainColumns& columns, const std::string& joint,
                     const EffectInput&) const override {
    const Motion own = motion_of(columns.state().chain, joint);
    for (const Motion motion : all_motions)
      if (const auto value = value_of(motion, own))
        columns.add_compliance_behind(*value, joint, coordinate_name(joint, motion), motion, 1);
  }

 protected:
  // Of its coordinates, whose names are those of no other effect there.
  explicit AcrossJoint(std::string label) : label_(std::move(label)) { place = EffectPlace::joint; }

  // Which value a motion yields by; none for the joint's own.
  virtual std::optional<Eigen::Index> value_of(Motion motion, Motion own) const = 0;

  static Motion motion_of(const Chain& chain, const std::string& joint) {
    return chain.coordinates()[static_cast<std::size_t>(chain.index_of(joint))].motion;
  }

 private:
  std::string coordinate_name(const std::string& joint, Motion motion) const {
    return label_ + " of " + joint + "." + to_string(motion);
  }

  std::string label_;
};

class BearingCompliance : public AcrossJoint {
 public:
  BearingCompliance() : AcrossJoint("bearing") {
    name = "bearing_compliance";
    effect_class = EffectClass::compliance;
    summary = "a joint yields across its motion: radially, along its axis, and in tilt";
    law =
        "u = c F for the two radial displacements (radial), that along the axis (axial, where the "
        "joint turns), and rotations other than its own (tilt); relative to the axes of the joint";
    source = "passive joints with elastic constraints: MMT11 section 2; JAMRIS09 eq. 1";
    signature = "displacement across the joint's axis, in proportion to the load, at all postures";
    confuser = "link_compliance of the link behind the joint";
    parameters = {added_compliance("radial", compliance::linear),
                  added_compliance("axial", compliance::linear),
                  added_compliance("tilt", compliance::angular)};
  }

  void act(ChainModifier& modifier, const std::string& joint,
           const EffectInput& input) const override {
    if (!is_rotation(motion_of(modifier.chain(), joint)) && input.values[axial] != 0)
      throw std::invalid_argument(
          fmt::format("joint '{}' slides: along its axis its drive yields, not a bearing", joint));
    AcrossJoint::act(modifier, joint, input);
  }

 private:
  enum Value { radial, axial, tilt };

  std::optional<Eigen::Index> value_of(Motion motion, Motion own) const override {
    if (motion == own) return std::nullopt;
    if (is_rotation(motion)) return tilt;
    return axis_index(motion) == axis_index(own) ? axial : radial;
  }
};

// Carriages pitch, yaw and roll by compliances of their own.
class BearingTilt : public AcrossJoint {
 public:
  BearingTilt() : AcrossJoint("tilt") {
    name = "bearing_tilt";
    effect_class = EffectClass::compliance;
    summary = "a joint tilts across its motion, about each axis by a compliance of its own";
    law = "turn = [x Mx, y My, z Mz] about the axes of the joint, but for its own where it turns";
    source = "pitch, yaw and roll of a carriage under moments: ISO 14728-1; ISO 230-1";
    signature = "what the joint carries turns with the moment on it, more about one axis";
    confuser = "bearing_compliance, which tilts alike about all axes; link_compliance behind it";
    parameters = {added_compliance("x", compliance::angular),
                  added_compliance("y", compliance::angular),
                  added_compliance("z", compliance::angular)};
  }

  void act(ChainModifier& modifier, const std::string& joint,
           const EffectInput& input) const override {
    const Motion own = motion_of(modifier.chain(), joint);
    if (is_rotation(own) && input.values[axis_index(own)] != 0)
      throw std::invalid_argument(
          fmt::format("joint '{}' turns about {}: about that axis its drive yields, not a bearing",
                      joint, parameters[static_cast<std::size_t>(axis_index(own))].name));
    AcrossJoint::act(modifier, joint, input);
  }

 private:
  std::optional<Eigen::Index> value_of(Motion motion, Motion own) const override {
    if (motion == own || !is_rotation(motion)) return std::nullopt;
    return axis_index(motion);
  }
};

}  // namespace
}  // namespace bearing_compliance_kind

Kind bearing_compliance() { return std::make_shared<bearing_compliance_kind::BearingCompliance>(); }
Kind bearing_tilt() { return std::make_shared<bearing_compliance_kind::BearingTilt>(); }

}  // namespace kinetostat::vjm::effects
