// A constant force in a joint: a spring, a brake, a bearing set with force.
#include <algorithm>
#include <stdexcept>

#include <fmt/format.h>

#include "kinetostat/vjm/effects/kinds.h"

namespace kinetostat::vjm::effects {
namespace {

class Preload : public CoordinateLaw {
 public:
  explicit Preload(double force) : force_(force) {}
  Value at(const JointState& joint) const override {
    return {.energy = -force_ * joint.deflection, .force = -force_, .tangent = 0};
  }

 private:
  double force_;
};

Chain applied(const Chain& chain, const std::string& joint, const Eigen::VectorXd& values) {
  const Eigen::Index k = chain.index_of(joint);
  const auto& free = chain.free_coordinates();
  if (std::find(free.begin(), free.end(), k) == free.end())
    throw std::invalid_argument(fmt::format(
        "joint '{}' of chain '{}' is rigid: a force in it moves nothing", joint, chain.name()));
  return Chain(chain).law(joint, std::make_shared<Preload>(values[0]));
}

Eigen::MatrixXd force_derivatives(const EffectState& state, const std::string& joint,
                                  const Eigen::VectorXd&) {
  Eigen::MatrixXd derivatives = Eigen::MatrixXd::Zero(state.chain.size(), 1);
  derivatives(state.chain.index_of(joint), 0) = 1;
  return derivatives;
}

}  // namespace

EffectKind preload() {
  return {
      .name = "preload",
      .summary = "a constant force that drives a joint in its positive direction",
      .law = "F = k d - force",
      .source = "MMT11 eq. 2: passive joints with preloaded springs",
      .signature = "an offset without load; internal loads change the stiffness of closed loops",
      .confuser = "payload, or the zero of the session",
      .place = EffectPlace::joint,
      .parameters = {{.name = "force",
                      .linear = spatial::dimension::force,
                      .angular = spatial::dimension::moment,
                      .lower = -1e6,
                      .upper = 1e6,
                      .prior_sd = 100}},
      .applied = applied,
      .force_derivatives = force_derivatives};
}

}  // namespace kinetostat::vjm::effects
