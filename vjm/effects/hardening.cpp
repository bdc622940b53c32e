// A transmission that grows stiffer with its deflection.
#include "kinetostat/vjm/effects/kinds.h"

namespace kinetostat::vjm::effects {
namespace {

class Hardening : public CoordinateLaw {
 public:
  explicit Hardening(double k3) : k3_(k3) {}
  Value at(const JointState& joint) const override {
    const double d = joint.deflection;
    return {
        .energy = k3_ * d * d * d * d / 4, .force = k3_ * d * d * d, .tangent = 3 * k3_ * d * d};
  }

 private:
  double k3_;
};

Chain applied(const Chain& chain, const std::string& joint, const Eigen::VectorXd& values) {
  spring_of_joint(chain, joint);
  return Chain(chain).law(joint, std::make_shared<Hardening>(values[0]));
}

Eigen::MatrixXd force_derivatives(const EffectState& state, const std::string& joint,
                                  const Eigen::VectorXd&) {
  Eigen::MatrixXd derivatives = Eigen::MatrixXd::Zero(state.chain.size(), 1);
  const Eigen::Index k = state.chain.index_of(joint);
  const double d = state.deflection[k];
  derivatives(k, 0) = -d * d * d;
  return derivatives;
}

}  // namespace

EffectKind hardening() {
  return {.name = "hardening",
          .summary = "a joint's spring grows stiffer with its deflection",
          .law = "F = k d + k3 d^3, d = deflection from rest",
          .source = "cubic (Duffing) spring; Nayfeh and Mook, Nonlinear Oscillations, 1979, ch. 2",
          .signature = "displacement grows less than in proportion to the load, odd in the load",
          .confuser = "clearance: both are odd, but a gap acts at small loads",
          .place = EffectPlace::joint,
          .parameters = {{.name = "k3",
                          .linear = {.length = -2, .mass = 1, .time = -2},
                          .angular = {.length = 2, .mass = 1, .time = -2, .angle = -3},
                          .lower = 0,
                          .upper = 1e30,
                          .prior_sd = 0}},
          .applied = applied,
          .force_derivatives = force_derivatives};
}

}  // namespace kinetostat::vjm::effects
