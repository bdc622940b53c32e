// A chain whose built geometry differs from the nominal one.
#include "kinetostat/vjm/chain/chain_modifier.h"
#include "kinetostat/vjm/effects/kinds/kinds.h"

namespace kinetostat::vjm::effects {
namespace {

class GeometricError : public EffectKind {
 public:
  GeometricError() {
    name = "geometric_error";
    effect_class = EffectClass::geometry;
    is_exact = true;
    summary = "everything behind an element is displaced, as built";
    law =
        "the frame behind the element is moved by [x, y, z] and turned by the rotation vector "
        "[rx, ry, rz], in its axes; postures are those of the nominal robot";
    source = "assembly of imperfect chains: IROS11 eq. 12; NONPERF eq. 7-19";
    signature =
        "an offset that depends on the posture but not on the load; chains of a parallel robot "
        "strain each other, which changes its stiffness";
    confuser = "sensor_frame, whose offset is the same rigid motion at all postures";
    place = EffectPlace::element;
    for (const char* axis : {"x", "y", "z"})
      parameters.push_back(optional_parameter(axis, spatial::dimension::length, 0.1, 2e-4));
    for (const char* axis : {"rx", "ry", "rz"})
      parameters.push_back(optional_parameter(axis, spatial::dimension::angle, 0.1, 5e-4));
  }

  void act(ChainModifier& modifier, const std::string& element,
           const EffectInput& input) const override {
    modifier.add_displacement(element, false, input.values);
  }

  void differentiate(ChainColumns& columns, const std::string& element,
                     const EffectInput&) const override {
    for (Eigen::Index i = 0; i < 6; ++i)
      columns.add_displacement(i, element, false, spatial::Vector6::Unit(i));
  }
};

}  // namespace

Kind geometric_error() { return std::make_shared<GeometricError>(); }

}  // namespace kinetostat::vjm::effects
