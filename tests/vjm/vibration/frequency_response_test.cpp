#include "kinetostat/vjm/vibration/frequency_response.h"

#include <cmath>

#include <gtest/gtest.h>

#include "kinetostat/io/text_file.h"
#include "kinetostat/vjm/chain/chain_builder.h"
#include "kinetostat/vjm/io/robot_file.h"
#include "kinetostat/vjm/manipulator/posture.h"
#include "kinetostat/vjm/statics/stiffness.h"
#include "kinetostat/vjm/vibration/natural_modes.h"

namespace kinetostat::vjm::frequency_response_test {
namespace {

using spatial::Pose;
using spatial::Vector3;
using Complex = std::complex<double>;

constexpr Damping modal{Damping::Kind::modal, 0.03}, structural{Damping::Kind::structural, 0.08};
const std::vector<double> somewhere = {0, 0.7, 4, 12.5, 31, 90, 700};  // [Hz]

FrequencyResponse response_of(const Manipulator& manipulator, const Damping& damping,
                              const std::map<std::string, double>& joints = {}) {
  return frequency_response(
      small_motions(manipulator, posture_from_joints(manipulator, joints).posture), damping,
      somewhere);
}

double distance(const Receptance& a, const Receptance& b) { return (a - b).norm() / b.norm(); }

// One mass on one spring: 1 / (k - m omega^2 + 2 i zeta omega sqrt(k m)), 1 / (k (1 + i eta) - m
// omega^2).
TEST(FrequencyResponse, OfOneMassIsItsClosedForm) {
  const double k = 8e4, m = 5;
  const Manipulator slide("slide", {ChainBuilder("slide", Pose())
                                        .actuator("rho", Motion::tz, k)
                                        .mass("load", m, Vector3::Zero())
                                        .build()});
  for (const Damping& damping : {modal, structural}) {
    const FrequencyResponse found = response_of(slide, damping);
    for (std::size_t i = 0; i < somewhere.size(); ++i) {
      const double w = 2 * M_PI * somewhere[i];
      const bool is_modal = damping.kind == Damping::Kind::modal;
      const Complex exact =
          1.0 / Complex(k - m * w * w,
                        is_modal ? 2 * damping.value * w * std::sqrt(k * m) : damping.value * k);
      EXPECT_NEAR(std::abs(found.receptance[i](2, 2) / exact - 1.0), 0, 1e-8) << somewhere[i];
      EXPECT_NEAR(found.receptance[i].cwiseAbs().sum(), std::abs(exact), 1e-7 * std::abs(exact));
    }
  }
}

// A motion that nothing resists: -1 / (m omega^2), and what a spring without mass adds at rest.
TEST(FrequencyResponse, OfAFreeMassIsItsInertia) {
  const double m = 5, k = 3e6;
  const Manipulator slide("slide", {ChainBuilder("slide", Pose())
                                        .passive("rho", Motion::tz)
                                        .mass("load", m, Vector3::Zero())
                                        .actuator("tip", Motion::tz, k)
                                        .build()});
  const FrequencyResponse found = response_of(slide, modal);
  for (std::size_t i = 1; i < somewhere.size(); ++i) {
    const double exact = -1 / (m * std::pow(2 * M_PI * somewhere[i], 2)) + 1 / k;
    EXPECT_NEAR(std::abs(found.receptance[i](2, 2) / exact - 1.0), 0, 1e-6) << somewhere[i];
  }
}

// Of a six-axis arm with elastic links of its own mass.
const Robot& arm() {
  static const Robot robot =
      read_robot(std::string(KINETOSTAT_SOURCE_DIR) + "/data/robots/heavy_arm.yaml");
  return robot;
}

TEST(FrequencyResponse, AtRestIsTheStaticCompliance) {
  const Posture posture = posture_from_joints(arm().manipulator, {}).posture;
  const spatial::Matrix6 compliance =
      unloaded_stiffness(arm().manipulator, posture).compliance->matrix();
  const FrequencyResponse found =
      frequency_response(small_motions(arm().manipulator, posture), {Damping::Kind::modal, 0}, {0});
  EXPECT_LT(distance(found.receptance[0], compliance.cast<Complex>()), 1e-6);
}

// K (1 + i eta) - omega^2 M inverted as a whole, and the modes added one by one.
TEST(FrequencyResponse, IsThatOfTheWholeEquationsAndOfTheSummedModes) {
  const Posture posture = posture_from_joints(arm().manipulator, {}).posture;
  const SmallMotions small = small_motions(arm().manipulator, posture);
  const NaturalModes modes = natural_modes(arm().manipulator, posture, 1000);
  const FrequencyResponse found =
      frequency_response(small_motions(arm().manipulator, posture), structural, somewhere);
  const auto rest = frequency_response(small_motions(arm().manipulator, posture), structural, {0});
  for (std::size_t i = 0; i < somewhere.size(); ++i) {
    const double w2 = std::pow(2 * M_PI * somewhere[i], 2);
    const Complex spring(1, structural.value);
    const Eigen::MatrixXcd whole = spring * small.stiffness - Complex(w2) * small.mass;
    const Eigen::MatrixXcd direct =
        small.platform * whole.fullPivLu().solve(small.platform.transpose().cast<Complex>());
    EXPECT_LT(distance(found.receptance[i], Receptance(direct)), 1e-6) << somewhere[i];
    // From rest on, what has no mass does the same at every frequency.
    Receptance summed = rest.receptance[0];
    for (const ManipulatorMode& mode : modes.modes) {
      const double own = std::pow(2 * M_PI * mode.frequency, 2);
      summed += mode.platform * mode.platform.transpose() *
                (1.0 / (spring * own - w2) - 1.0 / (spring * own));
    }
    EXPECT_LT(distance(found.receptance[i], summed), 1e-6) << somewhere[i];
  }
}

TEST(FrequencyResponse, IsSymmetric) {
  for (const Receptance& receptance : response_of(arm().manipulator, modal).receptance)
    EXPECT_LT(distance(receptance, receptance.transpose()), 1e-12);
}

TEST(ResponseFrequencies, HoldEndsAndPeaks) {
  const std::vector<double> found = response_frequencies(1, 100, 3, {0.5, 55, 200});
  ASSERT_EQ(found.size(), 4u);
  EXPECT_EQ(found.front(), 1);
  EXPECT_NEAR(found[1], 10, 1e-12);
  EXPECT_EQ(found[2], 55);
  EXPECT_EQ(found.back(), 100);
}

}  // namespace
}  // namespace kinetostat::vjm::frequency_response_test
