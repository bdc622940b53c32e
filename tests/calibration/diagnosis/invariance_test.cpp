// A verdict does not depend on how large the machine is, nor on a weight that hangs on all
// readings.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calibration/laboratory.h"

namespace kinetostat::calibration::invariance_test {
namespace {

using test::Laboratory;

constexpr double stiffness = 1e5;    // N m/rad
constexpr double largest = 150;      // N m
constexpr double exactness = 20e-6;  // rad

// One joint, with torques and angles so many times as large.
std::string joint(double torque, double angle) {
  return fmt::format(
      "kinetostat: 1\nname: joint\nunits: {{length: m, force: N, angle: rad}}\nchain_types:\n"
      "  arm:\n    - actuator: {{name: q, axis: Rz, stiffness: {} N m/rad}}\n"
      "manipulator: {{chain: arm}}\nuncertain:\n  - {{stiffness: q}}\n",
      stiffness * torque / angle);
}

// Up and down and reversed, three times; `weight`: a force along the axis, on every reading.
std::string loops(double torque, double weight) {
  std::string csv = "id,cycle,step,mz,fz\n";
  int n = 0;
  for (int cycle = 1; cycle <= 3; ++cycle)
    for (int step = 0; step <= 24; ++step) {
      const int way = step <= 12 ? step : 24 - step;
      const double level = (way <= 6 ? way : 12 - way) / 6.0;
      csv += fmt::format("a{},{},{},{},{}\n", ++n, cycle, step,
                         (step <= 12 ? 1 : -1) * level * largest * torque, weight);
    }
  return csv;
}

struct Hidden {
  const char* kind;
  std::string (*size)(double torque, double angle);
};

const Hidden friction{"friction", [](double torque, double angle) {
                        return fmt::format("force={} N m,presliding={} rad", 15 * torque,
                                           5e-5 * angle);
                      }};
const Hidden clearance{
    "clearance", [](double, double angle) { return fmt::format("gap={} rad", 4e-4 * angle); }};
const Hidden hardening{"hardening", [](double torque, double angle) {
                         return fmt::format("k3={} N m/rad^3",
                                            1.3e10 * torque / (angle * angle * angle));
                       }};

enum class Noise { stated, replicates };

Diagnosis diagnosed(const Hidden& hidden, double torque, double angle, double weight = 0,
                    Noise noise = Noise::stated) {
  Laboratory laboratory(joint(torque, angle));
  laboratory.options().components = {false, false, false, false, false, true};
  laboratory.options().rotation_noise = exactness * angle;
  laboratory.hide(hidden.kind, "q", hidden.size(torque, angle));
  Campaign campaign = laboratory.measure(loops(torque, weight));
  if (noise == Noise::replicates) campaign.noise_stated = false;
  return laboratory.diagnose(campaign, {});
}

void expect_same(const Diagnosis& a, const Diagnosis& b) {
  EXPECT_EQ(to_string(a.verdict), to_string(b.verdict));
  ASSERT_EQ(a.found.size(), b.found.size());
  for (std::size_t f = 0; f < a.found.size(); ++f) {
    EXPECT_NEAR(a.found[f].probability, b.found[f].probability, 0.01);
    ASSERT_FALSE(b.found[f].decision.answers.empty());
    EXPECT_EQ(a.found[f].decision.answers.at(0).effect_class,
              b.found[f].decision.answers.at(0).effect_class);
    EXPECT_NEAR(a.found[f].decision.nothing, b.found[f].decision.nothing, 0.01);
    EXPECT_NEAR(a.found[f].decision.unexplained, b.found[f].decision.unexplained, 0.01);
  }
}

struct Size {
  const char* name;
  const Hidden& hidden;
  double torque, angle;
};

class Scaled : public testing::TestWithParam<Size> {};

TEST_P(Scaled, TheVerdictIsTheSame) {
  const Hidden& hidden = GetParam().hidden;
  const Diagnosis usual = diagnosed(hidden, 1, 1);
  EXPECT_EQ(usual.verdict, Verdict::identified);
  expect_same(usual, diagnosed(hidden, GetParam().torque, GetParam().angle));
}

INSTANTIATE_TEST_SUITE_P(Machines, Scaled,
                         testing::Values(Size{"friction_in_a_watch", friction, 1e-6, 1},
                                         Size{"friction_in_an_excavator", friction, 1e4, 1},
                                         Size{"friction_in_a_stiff_joint", friction, 1, 0.01},
                                         Size{"friction_in_a_soft_joint", friction, 1, 100},
                                         Size{"play_in_a_watch", clearance, 1e-6, 1},
                                         Size{"play_in_an_excavator", clearance, 1e4, 1},
                                         Size{"play_in_a_stiff_joint", clearance, 1, 0.01},
                                         Size{"play_in_a_soft_joint", clearance, 1, 100},
                                         Size{"hardening_in_a_toy", hardening, 1e-3, 1},
                                         Size{"hardening_in_an_excavator", hardening, 1e4, 1},
                                         Size{"hardening_in_a_stiff_joint", hardening, 1, 0.1},
                                         Size{"hardening_in_a_soft_joint", hardening, 1, 100}),
                         [](const auto& size) { return size.param.name; });

// It took reversal, unloading and hysteresis out of sight: friction was taken for noise.
TEST(ConstantWeight, ChangesNoVerdict) {
  for (const Noise noise : {Noise::stated, Noise::replicates}) {
    const Diagnosis bare = diagnosed(friction, 1, 1, 0, noise);
    EXPECT_EQ(bare.verdict, Verdict::identified);
    expect_same(bare, diagnosed(friction, 1, 1, -424, noise));
  }
}

// A shaft that softens, turned by a force at a lever, or by the same force and its moment.
TEST(WrittenOtherwise, TheSameLoadsGiveTheSameVerdict) {
  const auto turned = [](bool by_lever) {
    Laboratory laboratory(joint(1, 1));
    laboratory.options().components = {false, false, false, false, false, true};
    laboratory.options().rotation_noise = exactness;
    laboratory.hide("piecewise_stiffness", "q", "ratio2=0.6,force1=60 N m,force2=1000 N m");
    std::string csv = by_lever ? "id,fy,px,py,pz\n" : "id,fy,mz,px,py,pz\n";
    int n = 0;
    for (int repeat = 0; repeat < 3; ++repeat)
      for (const int force : {0, 100, 200, 300, 400, 500})
        csv += by_lever ? fmt::format("a{},{},0.3,0,0\n", ++n, force)
                        : fmt::format("a{},{},{},0,0,0\n", ++n, force, 0.3 * force);
    const Campaign campaign = laboratory.measure(csv);
    return laboratory.diagnose(campaign, {});
  };
  expect_same(turned(true), turned(false));
}

// Play whose jump is not at zero load: a weight of 14 N m that nobody stated leans on one flank.
TEST(PlayWithABias, IsBacklashWithItsBias) {
  for (const unsigned seed : {1u, 2u, 3u, 4u}) {
    Laboratory laboratory(joint(1, 1));
    laboratory.options().components = {false, false, false, false, false, true};
    laboratory.options().rotation_noise = exactness;
    laboratory.options().seed = seed;
    laboratory.hide("preload", "q", "14 N m");
    laboratory.hide("clearance", "q", "1.5 mrad");
    const Diagnosis d = laboratory.diagnose(laboratory.measure(loops(1, 0)), {});
    EXPECT_EQ(to_string(d.verdict), "identified");
    ASSERT_EQ(d.found.size(), 1u);
    EXPECT_EQ(d.found[0].decision.answers.at(0).effect_class, "backlash");
    EXPECT_EQ(d.found[0].candidate.effect.kind->name, "biased_clearance");
    for (Eigen::Index k = 0; k < 2; ++k)
      EXPECT_NEAR(d.found[0].candidate.effect.values[k], k == 0 ? 1.5e-3 : 14.0,
                  4 * d.found[0].deviations[k]);
  }
}

}  // namespace
}  // namespace kinetostat::calibration::invariance_test
