#include "kinetostat/vjm/vibration/natural_modes.h"

#include <array>
#include <cmath>
#include <vector>

#include <Eigen/Eigenvalues>
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "kinetostat/io/text_file.h"
#include "kinetostat/spatial/rotation.h"
#include "kinetostat/vjm/chain/chain_builder.h"
#include "kinetostat/vjm/io/robot_file.h"
#include "kinetostat/vjm/manipulator/posture.h"
#include "kinetostat/vjm/statics/stiffness.h"

#include "support/temporary_folder.h"
#include "vjm/elastic_sample.h"

namespace kinetostat::vjm::natural_modes_test {
namespace {

using spatial::Pose;
using spatial::Vector3;

Pose along_x(double by) { return Pose::translation({by, 0, 0}); }

NaturalModes modes_of(const Manipulator& manipulator, int count,
                      const std::map<std::string, double>& joints = {}) {
  return natural_modes(manipulator, posture_from_joints(manipulator, joints).posture, count);
}

double squared(const ManipulatorMode& mode) { return std::pow(2 * M_PI * mode.frequency, 2); }

// k exp(-rate v) of a slide at the command v: what a joint's law does without any load is in the
// frequency.
TEST(NaturalModes, HaveTheLawsOfJointsAtRest) {
  const double k = 1e6, rate = 2, mass = 10;
  const std::string text = fmt::format(
      "kinetostat: 1\nname: slide\nunits: {{length: m, force: N, angle: rad}}\nchain_types:\n"
      "  slide:\n    - actuator: {{name: q, axis: Tx, stiffness: {}}}\n"
      "    - mass: {{name: table, mass: {} kg}}\nmanipulator: {{chain: slide}}\n"
      "effects:\n  - {{effect: stiffness_along_joint, at: q, rate: {} 1/m}}\n",
      k, mass, rate);
  const Robot robot = parse_robot(text, "slide.yaml");
  for (const double at : {0.0, 0.3, -0.5}) {
    const NaturalModes found = modes_of(robot.manipulator, 1, {{"q", at}});
    ASSERT_EQ(found.modes.size(), 1u);
    EXPECT_NEAR(squared(found.modes[0]), k * std::exp(-rate * at) / mass, 1e-6 * k / mass) << at;
  }
}

// Two rods without mass, particles at their ends, a spring at each joint: the double pendulum, with
// its mass matrix written down by hand.
TEST(NaturalModes, OfTwoLinksWithParticlesAreThoseOfTheDoublePendulum) {
  const double l1 = 0.7, l2 = 0.5, m1 = 3, m2 = 2, k1 = 4e4, k2 = 1.5e4, bend = 0.8;
  const Manipulator arm(
      "arm", {ChainBuilder("arm", Pose(spatial::exp_rotation({0.3, -0.2, 0.5}), {1, 2, 3}))
                  .actuator("q1", Motion::rz, k1)
                  .offset(along_x(l1))
                  .mass("elbow", m1, Vector3::Zero())
                  .actuator("q2", Motion::rz, k2)
                  .offset(along_x(l2))
                  .mass("tip", m2, Vector3::Zero())
                  .build()});
  const double c = std::cos(bend);
  Eigen::Matrix2d mass, stiffness;
  mass << m1 * l1 * l1 + m2 * (l1 * l1 + l2 * l2 + 2 * l1 * l2 * c), m2 * (l2 * l2 + l1 * l2 * c),
      m2 * (l2 * l2 + l1 * l2 * c), m2 * l2 * l2;
  stiffness << k1, 0, 0, k2;
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::Matrix2d> exact(stiffness, mass);
  const NaturalModes found = modes_of(arm, 5, {{"q2", bend}});
  ASSERT_EQ(found.modes.size(), 2u);
  EXPECT_EQ(found.mass, m1 + m2);
  EXPECT_EQ(found.free_motions, 0);
  for (std::size_t i = 0; i < 2; ++i) {
    const double omega_squared = exact.eigenvalues()[static_cast<Eigen::Index>(i)];
    EXPECT_NEAR(squared(found.modes[i]), omega_squared, 1e-7 * omega_squared);
    // The energy is the springs', and of each what its joint turns by.
    double sum = 0;
    for (const SpringShare& share : found.modes[i].springs) sum += share.share;
    EXPECT_NEAR(sum, 1, 1e-7);
    const Eigen::Vector2d x = exact.eigenvectors().col(static_cast<Eigen::Index>(i));
    const double first = k1 * x[0] * x[0] / omega_squared;
    const SpringShare& largest = found.modes[i].springs.front();
    EXPECT_NEAR(largest.share, largest.spring == "q1" ? first : 1 - first, 1e-6);
  }
}

// In a robot file, as people give them.
NaturalModes of_file(const std::string& chain, int count, int segment_multiple = 1,
                     const std::string& links = "") {
  const test::TemporaryFolder folder;
  const auto file =
      folder.file("robot.yaml",
                  "kinetostat: 1\nname: robot\nunits: {length: m, force: N, angle: rad}\n"
                  "materials: {steel: {E: 210 GPa, nu: 0.3, density: 7850 kg/m^3}}\n"
                  "links:\n" +
                      links + "chain_types:\n  arm:\n" + chain + "manipulator: {chain: arm}\n");
  const Robot robot = read_robot(file, {.segment_multiple = segment_multiple});
  return modes_of(robot.manipulator, count);
}

// A uniform rod on a hinge with a spring has m L^2 / 3.
TEST(NaturalModes, OfARodOnAHingeHaveItsInertia) {
  const NaturalModes found =
      of_file("    - actuator: {name: q, axis: Rz, stiffness: 2e4 N m/rad}\n    - link: rod\n", 2,
              1, "  rod: {rigid: [0.8, 0, 0], mass: {mass: 5 kg, center: [0.4, 0, 0]}}\n");
  ASSERT_EQ(found.modes.size(), 1u);
  const double exact = 2e4 / (5 * 0.8 * 0.8 / 3);
  EXPECT_NEAR(squared(found.modes[0]), exact, 1e-7 * exact);
}

// Steiner: about the hinge a body has its own inertia about that axis and m r^2, however it is
// turned.
TEST(NaturalModes, OfABodyOnAHingeHaveTheInertiaThatItsFileGives) {
  const NaturalModes found = of_file(
      "    - actuator: {name: q, axis: Rz, stiffness: 2e4 N m/rad}\n"
      "    - offset: {rpy: [0.4, -0.7, 0.2]}\n    - link: body\n",
      2, 1,
      "  body: {rigid: [0.8, 0, 0.1], mass: {mass: 5 kg, center: [0.4, 0.1, 0.2], inertia: [0.3, "
      "0.02, -0.03, 0.4, 0.01, 0.5]}}\n");
  ASSERT_EQ(found.modes.size(), 1u);
  const spatial::Matrix3 turn = spatial::rotation_from_rpy({0.4, -0.7, 0.2});
  spatial::Matrix3 own;
  own << 0.3, 0.02, -0.03, 0.02, 0.4, 0.01, -0.03, 0.01, 0.5;
  const Vector3 center = turn * Vector3(0.4, 0.1, 0.2);
  const double about = (turn * own * turn.transpose())(2, 2) + 5 * center.head<2>().squaredNorm();
  EXPECT_NEAR(squared(found.modes[0]), 2e4 / about, 1e-7 * 2e4 / about);
}

// All of the tensor counts where the body hangs on springs of all six directions, and as much in a
// `mass` element.
TEST(NaturalModes, OfABodyOnSixSpringsAreThoseOfItsSixMotions) {
  const std::string springs =
      "    - link: soft\n    - offset: {point: [0.1, -0.2, 0.3], rpy: [1, 2, 3]}\n";
  const std::string soft =
      "  soft: {stiffness: [[2e6, 0, 0, 0, 0, 0], [0, 3e6, 0, 0, 0, 0], [0, 0, 4e6, 0, 0, 0], [0, "
      "0, 0, 5e4, 0, 0], [0, 0, 0, 0, 6e4, 0], [0, 0, 0, 0, 0, 7e4]]}\n";
  const std::string own = "inertia: [0.3, 0.02, -0.03, 0.4, 0.01, 0.5]";
  const NaturalModes as_link = of_file(
      springs + "    - link: body\n", 6, 1,
      soft + "  body: {rigid: [0.5, 0, 0], mass: {mass: 5, center: [0.3, 0.1, 0], " + own + "}}\n");
  const NaturalModes as_mass = of_file(
      springs + "    - mass: {name: m, mass: 5, at: [0.3, 0.1, 0], " + own + "}\n", 6, 1, soft);
  spatial::Matrix3 tensor;
  tensor << 0.3, 0.02, -0.03, 0.02, 0.4, 0.01, -0.03, 0.01, 0.5;
  const Pose frame(spatial::rotation_from_rpy({1, 2, 3}), {0.1, -0.2, 0.3});
  spatial::Matrix6 mass = spatial::Matrix6::Zero(), stiffness = spatial::Matrix6::Zero();
  Eigen::Matrix<double, 3, 6> center = spatial::rigid_motion(frame * Vector3(0.3, 0.1, 0));
  mass = 5 * center.transpose() * center;
  mass.bottomRightCorner<3, 3>() += frame.rotation() * tensor * frame.rotation().transpose();
  stiffness.diagonal() << 2e6, 3e6, 4e6, 5e4, 6e4, 7e4;
  const Eigen::GeneralizedSelfAdjointEigenSolver<spatial::Matrix6> exact(stiffness, mass);
  ASSERT_EQ(as_link.modes.size(), 6u);
  ASSERT_EQ(as_mass.modes.size(), 6u);
  for (std::size_t k = 0; k < 6; ++k) {
    const double value = exact.eigenvalues()[static_cast<Eigen::Index>(k)];
    EXPECT_NEAR(squared(as_link.modes[k]), value, 1e-7 * value);
    EXPECT_NEAR(squared(as_mass.modes[k]), value, 1e-7 * value);
  }
}

// The inertia of a uniform rod, stated, changes nothing, in a flexible link either.
TEST(NaturalModes, OfARodAreTheSameWhenItsInertiaIsStated) {
  const std::string compliance =
      "compliance: [[1e-7, 0, 0, 0, 0, 0], [0, 2e-6, 0, 0, 0, 0], [0, 0, 3e-6, 0, 0, 0], [0, 0, 0, "
      "4e-6, 0, 0], [0, 0, 0, 0, 5e-6, 0], [0, 0, 0, 0, 0, 6e-6]], end: [0.6, 0, 0]";
  const auto of_rod = [&](const std::string& inertia) {
    return of_file(
        "    - actuator: {name: q, axis: Rz, stiffness: 2e4 N m/rad}\n    - link: rod\n", 6, 1,
        "  rod: {" + compliance + ", mass: {mass: 4, center: [0.3, 0, 0]" + inertia + "}}\n");
  };
  const NaturalModes bare = of_rod(""), stated = of_rod(", inertia: [0, 0, 0, 0.12, 0, 0.12]");
  ASSERT_EQ(bare.modes.size(), stated.modes.size());
  for (std::size_t k = 0; k < bare.modes.size(); ++k)
    EXPECT_NEAR(squared(stated.modes[k]), squared(bare.modes[k]), 1e-7 * squared(bare.modes[k]));
}

const std::string beam =
    "  beam: {beam: {length: 1, section: {rectangle: {y: 0.03, z: 0.02}}, material: steel, "
    "segments: "
    "4}}\n";

// A slender cantilever of beams: Euler's and Bernoulli's frequencies, nearer with more segments, as
// the square of their length.
TEST(NaturalModes, OfACantileverOfBeamsAreEulersAndBernoullis) {
  const double c = std::sqrt(210e9 / 7850), thin = 0.02 / std::sqrt(12.0),
               thick = 0.03 / std::sqrt(12.0);
  const double exact[] = {1.8751 * 1.8751 * c * thin, 1.8751 * 1.8751 * c * thick,
                          4.6941 * 4.6941 * c * thin};
  double before = 1;
  for (const int multiple : {1, 2, 4}) {
    const NaturalModes found =
        of_file("    - actuator: {name: q, axis: Rz}\n    - link: beam\n", 3, multiple, beam);
    ASSERT_EQ(found.modes.size(), 3u);
    for (std::size_t k = 0; k < 3; ++k)
      EXPECT_NEAR(std::sqrt(squared(found.modes[k])), exact[k],
                  (k == 2 ? 0.04 : 0.01) * exact[k] / (multiple * multiple) + 0.004 * exact[k]);
    const double error = std::abs(std::sqrt(squared(found.modes[0])) / exact[0] - 1);
    EXPECT_LT(error, before);
    before = error + 1e-4;  // shear and the digits of the root
  }
}

// The equations of two beams of one section in a row, w = a cos bx + b sin bx + c cosh bx +
// d sinh bx in each, on a joint at the root and one between them: the determinant of what holds at
// both joints and at the free end, columns of unit length. Joints by their stiffness over EI [1/m].
double determinant_of_arm(double b, const std::array<double, 2>& length,
                          const std::array<double, 2>& joint) {
  // Derivative k of the four functions at x, over b^k.
  const auto at = [b](double x, int k) {
    const double c = std::cos(b * x), s = std::sin(b * x), ch = std::cosh(b * x),
                 sh = std::sinh(b * x);
    const Eigen::RowVector4d all[] = {
        {c, s, ch, sh}, {-s, c, sh, ch}, {-c, -s, ch, sh}, {s, -c, sh, ch}};
    return all[k];
  };
  const Eigen::RowVector4d none = Eigen::RowVector4d::Zero();
  Eigen::Matrix<double, 8, 8> m;
  const double first = length[0], last = length[1];
  m << at(0, 0), none, b * at(0, 2) - joint[0] * at(0, 1), none, at(first, 0), -at(0, 0),
      b * at(first, 2) + joint[1] * at(first, 1), -joint[1] * at(0, 1), at(first, 2), -at(0, 2),
      at(first, 3), -at(0, 3), none, at(last, 2), none, at(last, 3);
  return m.colwise().normalized().determinant();
}

// Wave numbers of the arm's modes, ascending [1/m].
std::vector<double> wave_numbers(const std::array<double, 2>& length,
                                 const std::array<double, 2>& joint, std::size_t count) {
  constexpr double step = 0.02;
  std::vector<double> roots;
  for (double low = step; roots.size() < count; low += step) {
    double a = low, b = low + step;
    const double before = determinant_of_arm(a, length, joint);
    if (before * determinant_of_arm(b, length, joint) > 0) continue;
    for (int i = 0; i < 50; ++i)
      (before * determinant_of_arm((a + b) / 2, length, joint) > 0 ? a : b) = (a + b) / 2;
    roots.push_back(a);
  }
  return roots;
}

// A slender arm of two links that swings about its two elastic joints and bends: Euler's and
// Bernoulli's frequencies, nearer with more segments.
TEST(NaturalModes, OfAnArmOfTwoLinksAreEulersAndBernoullis) {
  constexpr double young = 210e9, density = 7850, width = 0.02, height = 0.03;
  const double bends = young * width * std::pow(height, 3) / 12, line = density * width * height;
  const std::array<double, 2> length{1, 0.6}, stiffness{3e4, 1.2e4};
  const auto exact = wave_numbers(length, {stiffness[0] / bends, stiffness[1] / bends}, 3);
  const std::string links =
      "  upper: {beam: {length: 1, section: {rectangle: {y: 0.03, z: 0.02}}, material: steel, "
      "segments: 4}}\n"
      "  fore: {beam: {length: 0.6, section: {rectangle: {y: 0.03, z: 0.02}}, material: steel, "
      "segments: 3}}\n";
  const std::string arm =
      "    - actuator: {name: q1, axis: Rz, stiffness: 3e4 N m/rad}\n    - link: upper\n"
      "    - actuator: {name: q2, axis: Rz, stiffness: 1.2e4 N m/rad}\n    - link: fore\n";
  for (const int multiple : {2, 8}) {
    std::vector<double> in_plane;
    for (const ManipulatorMode& mode : of_file(arm, 8, multiple, links).modes)
      if (std::abs(mode.platform[1]) > std::abs(mode.platform[2]))
        in_plane.push_back(std::sqrt(squared(mode)));
    ASSERT_GE(in_plane.size(), exact.size());
    for (std::size_t k = 0; k < exact.size(); ++k) {
      const double expected = exact[k] * exact[k] * std::sqrt(bends / line);
      EXPECT_NEAR(in_plane[k], expected, (0.16 / (multiple * multiple) + 0.004) * expected) << k;
    }
  }
}

// Two springs side by side, and the mass on the platform that they share.
TEST(NaturalModes, OfChainsSideBySideAreThoseOfBothSprings) {
  const auto slide = [](const char* name, double stiffness, double mass) {
    ChainBuilder chain(name);
    chain.actuator(std::string("z") + name, Motion::tz, stiffness);
    if (mass > 0) chain.mass("load", mass, Vector3(0.1, 0, 0));
    return chain.build();
  };
  const Manipulator pair("pair", {slide("a", 3e5, 0), slide("b", 5e5, 4)});
  const NaturalModes found = modes_of(pair, 3);
  ASSERT_EQ(found.modes.size(), 1u);
  EXPECT_NEAR(squared(found.modes[0]), 8e5 / 4, 1e-7 * 2e5);
  EXPECT_NEAR(found.modes[0].platform[2], 1 / std::sqrt(4.0), 1e-9);
  EXPECT_NEAR(found.modes[0].springs[0].share, 5.0 / 8, 1e-7);
}

TEST(NaturalModes, CountMotionsThatNothingResists) {
  const Manipulator arm("arm", {ChainBuilder("arm")
                                    .passive("p", Motion::rz)
                                    .offset(along_x(0.5))
                                    .actuator("q", Motion::rz, 1e4)
                                    .offset(along_x(0.5))
                                    .mass("tip", 2, Vector3(0, 0.1, 0))
                                    .mass("elbow", 2, Vector3(-0.6, 0, 0))
                                    .build()});
  const NaturalModes found = modes_of(arm, 4);
  EXPECT_EQ(found.free_motions, 1);
  ASSERT_EQ(found.modes.size(), 1u);
  EXPECT_GT(found.modes[0].frequency, 1);
}

TEST(NaturalModes, OfARobotWithoutMassAreNone) {
  const Robot robot = read_robot(std::string(KINETOSTAT_SOURCE_DIR) + "/data/robots/six_axis.yaml");
  EXPECT_TRUE(modes_of(robot.manipulator, 4).modes.empty());
  EXPECT_EQ(modes_of(robot.manipulator, 4).mass, 0);
}

// A particle on the platform of a parallel robot, and nothing else with a mass: it moves by the
// compliance that statics finds, in three modes.
TEST(NaturalModes, OfAPayloadAreThoseOfThePlatformsCompliance) {
  const std::filesystem::path file =
      std::string(KINETOSTAT_SOURCE_DIR) + "/data/robots/orthoglide.yaml";
  const Robot robot = parse_robot(
      io::read_text(file) + "\neffects:\n  - {effect: payload, at: platform, mass: 12 kg}\n", file);
  const Posture posture =
      posture_at(robot.manipulator, {spatial::Matrix3::Identity(), {0.02, -0.01, 0.03}}).posture;
  const auto statics = unloaded_stiffness(robot.without_effects(), posture).compliance;
  ASSERT_TRUE(statics);
  const spatial::Matrix3 compliance = statics->matrix().topLeftCorner<3, 3>();
  const Eigen::SelfAdjointEigenSolver<spatial::Matrix3> exact(compliance);
  const NaturalModes found = natural_modes(robot.manipulator, posture, 6);
  EXPECT_NEAR(found.mass, 12, 1e-12);
  ASSERT_EQ(found.modes.size(), 3u);
  for (std::size_t k = 0; k < 3; ++k) {
    const double omega_squared = 1 / (12 * exact.eigenvalues()[2 - static_cast<Eigen::Index>(k)]);
    EXPECT_NEAR(squared(found.modes[k]), omega_squared, 1e-6 * omega_squared);
  }
}

// With a modal mass of 1, twice the energy of all springs is the squared frequency.
TEST(NaturalModes, OfAClosedLoopAgreeWithTheEnergyOfTheirSprings) {
  const Robot robot =
      read_robot(std::string(KINETOSTAT_SOURCE_DIR) + "/data/robots/heavy_arm.yaml");
  const NaturalModes found = modes_of(robot.manipulator, 6);
  ASSERT_EQ(found.modes.size(), 6u);
  for (const ManipulatorMode& mode : found.modes) {
    double energy = 0;
    for (std::size_t c = 0; c < robot.manipulator.size(); ++c)
      energy +=
          mode.coordinates[c].dot(robot.manipulator.chains()[c].stiffness() * mode.coordinates[c]);
    EXPECT_NEAR(energy, squared(mode), 1e-6 * energy);
  }
  for (std::size_t k = 1; k < 6; ++k)
    EXPECT_LE(found.modes[k - 1].frequency, found.modes[k].frequency);
}

// A body on one interface, with a rod that has no mass: the modes of its own two matrices.
TEST(NaturalModes, OfAnElasticBodyAreThoseOfItsStiffnessAndMass) {
  const samples::BodyBetweenPoints body({"foot", "left", "right"},
                                        {{0, 0, 0}, {0.2, 0.1, 0.3}, {-0.2, 0.05, 0.3}}, 21);
  const Robot robot = samples::robot_with_body(R"(kinetostat: 1
name: bracket
units: {length: m, force: N, angle: rad}
links:
  rod: {stiffness: [[9.0e5, 0, 0, 0, 0, 0], [0, 8.0e5, 0, 0, 0, 0], [0, 0, 7.0e5, 0, 0, 0],
    [0, 0, 0, 6.0e3, 0, 0], [0, 0, 0, 0, 5.0e3, 0], [0, 0, 0, 0, 0, 4.0e3]], end: [0, 0, 0.1]}
chain_types: {rod: [{link: rod}]}
manipulator:
  bodies: [{name: b, elastic: body.json, interfaces: {foot: base}, pose: {point: [1, 2, 3], rpy: [0.3, -0.5, 0.7]}}]
  chains: [{name: r, type: rod, from: b.left, base: [0.2, 0.1, 0.3]}]
)",
                                               body.json());
  const NaturalModes found = modes_of(robot.manipulator, 4);
  const Eigen::MatrixXd stiffness = body.stiffness.bottomRightCorner<12, 12>(),
                        mass = body.inertia.bottomRightCorner<12, 12>();
  // Motions without a mass make the problem one of 1/omega^2.
  const Eigen::LLT<Eigen::MatrixXd> factor(stiffness);
  const Eigen::MatrixXd half = factor.matrixL().solve(mass);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> exact(
      factor.matrixL().solve(half.transpose()));
  ASSERT_EQ(found.modes.size(), 4u);
  double total = 0;
  for (const auto& [m, place] : body.particles) total += m;
  EXPECT_NEAR(found.mass, total, 1e-10 * total);
  for (std::size_t i = 0; i < 4; ++i) {
    const double omega_squared = 1 / exact.eigenvalues()[11 - static_cast<Eigen::Index>(i)];
    EXPECT_NEAR(squared(found.modes[i]), omega_squared, 1e-6 * omega_squared);
    ASSERT_EQ(found.modes[i].springs.size(), 1u);
    EXPECT_EQ(name_of(robot.manipulator, found.modes[i].springs[0]), "b");
  }
}

}  // namespace
}  // namespace kinetostat::vjm::natural_modes_test
