// Random but reproducible chains for property tests.
#pragma once

#include <random>

#include "kinetostat/spatial/rotation.h"
#include "kinetostat/vjm/chain/chain_builder.h"

namespace kinetostat::vjm::samples {

class RandomChains {
 public:
  explicit RandomChains(unsigned seed) : engine_(seed) {}

  double uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(engine_);
  }
  spatial::Vector3 vector(double size) {
    return {uniform(-size, size), uniform(-size, size), uniform(-size, size)};
  }
  spatial::Vector6 vector6(double translation, double rotation) {
    spatial::Vector6 v;
    v << vector(translation), vector(rotation);
    return v;
  }
  spatial::Pose pose(double size) { return {spatial::exp_rotation(vector(2.0)), vector(size)}; }
  /// A well-conditioned symmetric positive definite compliance of a robot link of about 0.3 m.
  spatial::Compliance6 compliance() {
    spatial::Matrix6 a;
    for (double& entry : a.reshaped()) entry = uniform(-1, 1);
    spatial::Matrix6 c = a * a.transpose() + spatial::Matrix6::Identity();
    spatial::Vector6 scale;
    scale << 1e-4, 1e-4, 1e-4, 4e-4, 4e-4, 4e-4;
    return spatial::Compliance6(scale.asDiagonal() * c * scale.asDiagonal());
  }
  /// Actuated, passive, coupled and elastic coordinates in mixed order, with offsets between.
  Chain chain(int passive_joints, bool with_node = false) {
    ChainBuilder chain("random", pose(0.3));
    chain.actuator("a1", motion(), 1e6);
    chain.offset(pose(0.3));
    chain.link("l1", pose(0.3), compliance());
    for (int i = 0; i < passive_joints; ++i) {
      chain.passive("p" + std::to_string(i), motion());
      chain.offset(pose(0.2));
    }
    if (passive_joints > 0) chain.coupled("p0", chain.so_far().coordinates()[7].motion, -1);
    if (with_node) chain.node("elbow", vector(0.2));
    chain.link("l2", pose(0.3), compliance());
    chain.passive("sprung", motion(), 2e4, 0.0, 0.0);
    chain.offset(pose(0.1));
    return chain.build();
  }
  Motion motion() { return static_cast<Motion>(std::uniform_int_distribution<int>(0, 5)(engine_)); }
  Eigen::VectorXd state(const Chain& chain, double size) {
    Eigen::VectorXd x(chain.size());
    for (double& value : x) value = uniform(-size, size);
    return x;
  }

 private:
  std::mt19937 engine_;
};

}  // namespace kinetostat::vjm::samples
