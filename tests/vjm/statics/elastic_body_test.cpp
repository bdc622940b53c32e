// Elastic bodies in robots: against chains of springs, finite differences, and rigid bodies.
#include "kinetostat/vjm/manipulator/elastic_body.h"

#include <cmath>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "kinetostat/spatial/rotation.h"
#include "kinetostat/vjm/manipulator/posture.h"
#include "kinetostat/vjm/statics/equilibrium.h"
#include "kinetostat/vjm/statics/spring_shares.h"
#include "kinetostat/vjm/statics/stiffness.h"

#include "vjm/elastic_sample.h"

namespace kinetostat::vjm::elastic_body_test {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using samples::BodyBetweenPoints;
using samples::robot_with_body;
using spatial::Matrix6;
using spatial::Pose;
using spatial::Vector3;
using spatial::Vector6;

const std::string head = R"(kinetostat: 1
name: robot with an elastic body
units: {length: m, force: N, angle: rad}
links:
  rod: {compliance: [[2.0e-7, 0, 0, 0, 1.0e-7, 0], [0, 3.0e-7, 0, -1.0e-7, 0, 0], [0, 0, 2.0e-9, 0, 0, 0],
    [0, -1.0e-7, 0, 4.0e-6, 0, 0], [1.0e-7, 0, 0, 0, 5.0e-6, 0], [0, 0, 0, 0, 0, 8.0e-6]], end: [0, 0, 0.3]}
chain_types:
  leg:
    - actuator: {name: s, axis: Tz, stiffness: 2.0e7}
    - link: rod
    - passive: {name: u, axes: [Rx, Ry]}
)";

// Where the three legs stand.
const std::vector<Vector3> corners = {{0.25, 0, 0}, {-0.1, 0.2, 0}, {-0.15, -0.22, 0}};

std::string legs(const std::string& from, const std::string& to) {
  std::string text;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::string place = fmt::format("[{}, {}, 0]", corners[i].x(), corners[i].y());
    const std::string name(1, "abc"[i]);
    text +=
        fmt::format("    - {{name: {0}, type: leg, base: {1}, platform_point: {1}", name, place);
    if (!from.empty()) text += fmt::format(", from: {}.{}", from, name);
    if (!to.empty()) text += fmt::format(", to: {}.{}", to, name);
    text += "}\n";
  }
  return text;
}

std::vector<Vector3> points_with(const Vector3& further) {
  std::vector<Vector3> points = corners;
  points.push_back(further);
  return points;
}

BodyBetweenPoints plate() { return {{"a", "b", "c", "tool"}, points_with({0.05, 0.02, 0.08}), 5}; }
BodyBetweenPoints frame() { return {{"a", "b", "c", "foot"}, points_with({0.02, 0.03, -0.2}), 9}; }

const std::string rigid_robot = head + "manipulator:\n  chains:\n" + legs("", "");
// Its platform is a plate that the legs carry.
const std::string plate_robot = head +
                                "manipulator:\n  bodies: [{name: plate, elastic: body.json, "
                                "interfaces: {tool: platform}}]\n  chains:\n" +
                                legs("", "plate");
const std::string weight = "gravity: {direction: [0.3, -0.2, -1], acceleration: 90 m/s^2}\n";
const std::string heavy_plate_robot = head + weight + plate_robot.substr(head.size());
// Its legs stand on a frame, which is heavy.
const std::string frame_robot = head + weight +
                                "manipulator:\n  bodies: [{name: frame, elastic: body.json, "
                                "interfaces: {foot: base}}]\n  chains:\n" +
                                legs("frame", "");

Posture posture_of(const Manipulator& manipulator) {
  const PostureResult result = posture_from_joints(manipulator, {});
  EXPECT_TRUE(result.reached) << result.reason;
  return result.posture;
}

Equilibrium loaded(const Manipulator& manipulator, const Load& load) {
  const Equilibrium e = equilibrium_under_load(manipulator, posture_of(manipulator), load);
  EXPECT_EQ(e.status, EquilibriumStatus::converged) << e.reason;
  return e;
}

const Load heavy{{3000, -2000, -4000}, {60, -80, 50}, {0.02, 0.01, 0.03}};

double apart(const MatrixXd& a, const MatrixXd& b) { return (a - b).norm() / b.norm(); }

// A body between two points is the link of a chain, whichever of its ends the base is behind.
TEST(ElasticBody, WithTwoInterfacesIsTheLinkBetweenThem) {
  const BodyBetweenPoints body({"near", "far"}, {{0, 0, 0}, {0.1, -0.05, 0.3}}, 3);
  // The compliance at the far end with the near one held, to all digits.
  const Matrix6 compliance = body.stiffness.bottomRightCorner<6, 6>().inverse();
  std::string matrix;
  for (int i = 0; i < 6; ++i) {
    matrix += i == 0 ? "[[" : "], [";
    for (int j = 0; j < 6; ++j)
      matrix += fmt::format("{}{:.17g}", j == 0 ? "" : ", ", compliance(i, j));
  }
  const std::string post =
      "{compliance: [[2.0e-7, 0, 0, 0, 1.0e-7, 0], [0, 3.0e-7, 0, -1.0e-7, 0, 0], [0, 0, 2.0e-9, "
      "0, "
      "0, 0], [0, -1.0e-7, 0, 4.0e-6, 0, 0], [1.0e-7, 0, 0, 0, 5.0e-6, 0], [0, 0, 0, 0, 0, "
      "8.0e-6]], end: [0, 0, 0.3]}\n";
  const std::string start =
      "kinetostat: 1\nname: arm\nunits: {length: m, force: N, angle: rad}\nlinks:\n  post: " +
      post + "  l: {compliance: " + matrix + "]], end: [0.1, -0.05, 0.3]}\nchain_types:\n";
  const std::string
      q1 = "{link: post}, {actuator: {name: q1, axis: Rz, stiffness: 3.0e4, home: 0.4}}",
      q2 = "{actuator: {name: q2, axis: Ry, stiffness: 2.0e4, home: 0.7}}, {link: post}";
  const std::string link =
      start + "  arm: [" + q1 + ", {link: l}, " + q2 + "]\nmanipulator: {chain: arm}\n";
  const std::string split = start + "  near: [" + q1 + "]\n  far: [" + q2 + R"(]
manipulator:
  bodies: [{name: l, elastic: body.json}]
  chains:
    - {name: near, type: near, to: l.near}
    - {name: far, type: far, from: l.far, base: [0.1, -0.05, 0.3]}
)";
  const Manipulator one = robot_with_body(link, body.json()).manipulator;
  const Manipulator two = robot_with_body(split, body.json()).manipulator;
  EXPECT_LT(apart(unloaded_stiffness(two, posture_of(two)).compliance.value().matrix(),
                  unloaded_stiffness(one, posture_of(one)).compliance.value().matrix()),
            1e-10);
  const Load load{{150, -250, 200}, {30, 20, -40}, {0.02, 0.01, 0.03}};
  const Equilibrium a = loaded(one, load), b = loaded(two, load);
  EXPECT_GT(a.displacement.translation.norm(), 1e-3);
  EXPECT_LT(spatial::pose_difference(a.platform, b.platform).norm(),
            1e-10 * a.displacement.coordinates().norm());
  const double stiffness = apart(b.stiffness->matrix(), a.stiffness->matrix());
  RecordProperty("loaded", fmt::format("{:.2g}", stiffness));
  EXPECT_LT(stiffness, 1e-10);
  EXPECT_NEAR(b.energy, a.energy, 1e-10 * a.energy);
}

// The stiffness of the free body by its own equations: interfaces and legs in one matrix.
TEST(ElasticBody, AddsToTheLegsAsOneLinearStructure) {
  const Manipulator rigid = robot_with_body(rigid_robot, plate().json()).manipulator;
  const Posture posture = posture_of(rigid);
  const BodyBetweenPoints body = plate();
  // Stiffness of each leg at its end on the plate, the plate's frame where the platform stands.
  MatrixXd whole = body.stiffness;
  ChainKinematics kinematics;
  for (std::size_t i = 0; i < 3; ++i) {
    evaluate(rigid.chains()[i], posture.coordinates[i], kinematics);
    const spatial::Stiffness6 leg = unloaded_stiffness(rigid.chains()[i], kinematics).value();
    const auto at = static_cast<Eigen::Index>(6 * i);
    whole.block<6, 6>(at, at) +=
        leg.in({posture.platform * body.points[i], Eigen::Matrix3d::Identity()}).matrix();
  }
  const Matrix6 compliance = whole.inverse().bottomRightCorner<6, 6>();
  const Manipulator elastic = robot_with_body(plate_robot, body.json()).manipulator;
  const UnloadedStiffness found = unloaded_stiffness(elastic, posture_of(elastic));
  const spatial::Compliance6 at_tool =
      found.compliance.value().in({posture.platform * body.points[3], Eigen::Matrix3d::Identity()});
  EXPECT_LT(apart(at_tool.matrix(), compliance), 1e-9);
}

class SlopeOfTheWrench : public testing::TestWithParam<std::string> {
 protected:
  Manipulator manipulator_ =
      robot_with_body(GetParam(), GetParam() == frame_robot ? frame().json() : plate().json())
          .manipulator;
};

TEST_P(SlopeOfTheWrench, IsTheTangent) {
  const Posture posture = posture_of(manipulator_);
  Vector6 displacement;
  displacement << 4e-4, -3e-4, 5e-4, 2e-3, -3e-3, 4e-3;
  const Pose pose = spatial::displaced(posture.platform, displacement);
  const auto held = [&](const Vector6& step) {
    const Equilibrium e =
        equilibrium_at_pose(manipulator_, posture, spatial::displaced(pose, step));
    EXPECT_EQ(e.status, EquilibriumStatus::converged) << e.reason;
    return e;
  };
  const Matrix6 tangent = held(Vector6::Zero()).stiffness.value().matrix();
  Matrix6 slope;
  for (int j = 0; j < 6; ++j) {
    const Vector6 step = 2e-5 * Vector6::Unit(j);
    const auto difference = [&](double factor) {
      return Vector6(
          (held(factor * step).wrench.coordinates() - held(-factor * step).wrench.coordinates()) /
          (factor * 4e-5));
    };
    slope.col(j) = (4 * difference(0.5) - difference(1)) / 3;
  }
  double worst = 0;
  for (int j = 0; j < 6; ++j) worst = std::max(worst, apart(slope.col(j), tangent.col(j)));
  RecordProperty("worst", fmt::format("{:.2g}", worst));
  EXPECT_LT(worst, 1e-6);
  // The loads have changed it by far more than that.
  const Matrix6 unloaded = unloaded_stiffness(manipulator_, posture).stiffness.value().matrix();
  EXPECT_GT(apart(tangent, unloaded), 1e-4);
}

// The work of the wrench round a closed loop, by the trapezoidal rule, which is exact for a smooth
// loop but for what falls with its points exponentially.
TEST_P(SlopeOfTheWrench, DoesNoWorkRoundAClosedLoop) {
  const Posture posture = posture_of(manipulator_);
  constexpr int points = 40;
  double work = 0, size = 0;
  for (int i = 0; i < points; ++i) {
    const double s = 2 * M_PI * i / points;
    Vector6 z, rate;
    z << 5e-4 * std::cos(s), 6e-4 * std::sin(s), 2e-4 * std::sin(2 * s), 3e-3 * std::sin(s),
        -2e-3 * std::cos(s), 4e-3 * std::cos(2 * s);
    rate << -5e-4 * std::sin(s), 6e-4 * std::cos(s), 4e-4 * std::cos(2 * s), 3e-3 * std::cos(s),
        2e-3 * std::sin(s), -8e-3 * std::sin(2 * s);
    const Equilibrium e =
        equilibrium_at_pose(manipulator_, posture, spatial::displaced(posture.platform, z));
    ASSERT_EQ(e.status, EquilibriumStatus::converged) << e.reason;
    rate.tail<3>() = (spatial::left_jacobian(z.tail<3>()) * rate.tail<3>()).eval();
    const double power = e.wrench.coordinates().dot(rate);
    work += power * 2 * M_PI / points;
    size += std::abs(power) * 2 * M_PI / points;
  }
  RecordProperty("work", fmt::format("{:.2g}", std::abs(work) / size));
  EXPECT_GT(size, 0.1);
  EXPECT_LT(std::abs(work), 1e-8 * size);
}

INSTANTIATE_TEST_SUITE_P(ElasticBody, SlopeOfTheWrench,
                         testing::Values(plate_robot, heavy_plate_robot, frame_robot),
                         [](const auto& robot) {
                           return robot.index == 0   ? "OfAPlatform"
                                  : robot.index == 1 ? "OfAHeavyPlatform"
                                                     : "OfAFrame";
                         });

// Stiffer and stiffer, the plate becomes the rigid platform: what is left falls as one over the
// factor, down to rounding.
TEST(ElasticBody, TendsToTheRigidOne) {
  const Manipulator rigid = robot_with_body(rigid_robot, plate().json()).manipulator;
  const Matrix6 unloaded = unloaded_stiffness(rigid, posture_of(rigid)).compliance.value().matrix();
  const Equilibrium under_load = loaded(rigid, heavy);
  double before = 1;
  for (const double factor : {1e6, 1e9}) {
    BodyBetweenPoints body = plate();
    body.stiffness *= factor;
    const Manipulator stiff = robot_with_body(plate_robot, body.json()).manipulator;
    const double left =
        apart(unloaded_stiffness(stiff, posture_of(stiff)).compliance.value().matrix(), unloaded);
    const Equilibrium e = loaded(stiff, heavy);
    const double moved = spatial::pose_difference(under_load.platform, e.platform).norm() /
                         under_load.displacement.coordinates().norm();
    const double tangent = apart(e.stiffness->matrix(), under_load.stiffness->matrix());
    RecordProperty(fmt::format("{:g}", factor),
                   fmt::format("{:.2g} {:.2g} {:.2g}", left, moved, tangent));
    const double limit = factor < 1e9 ? 1e-6 : 1e-9;
    EXPECT_LT(left, limit);
    EXPECT_LT(moved, limit);
    EXPECT_LT(tangent, limit);
    EXPECT_LT(left, before);
    before = left;
  }
}

// The same body with its interfaces in another order stands on another one. Where deflections are
// small that changes nothing.
TEST(ElasticBody, MayStandOnAnyInterface) {
  const BodyBetweenPoints first = plate();
  BodyBetweenPoints other = plate();
  const std::vector<std::size_t> order{2, 0, 3, 1};
  for (std::size_t i = 0; i < 4; ++i) {
    other.names[i] = first.names[order[i]];
    other.points[i] = first.points[order[i]];
    for (std::size_t j = 0; j < 4; ++j)
      other.stiffness.block<6, 6>(static_cast<Eigen::Index>(6 * i),
                                  static_cast<Eigen::Index>(6 * j)) =
          first.stiffness.block<6, 6>(static_cast<Eigen::Index>(6 * order[i]),
                                      static_cast<Eigen::Index>(6 * order[j]));
  }
  const Manipulator a = robot_with_body(plate_robot, first.json()).manipulator,
                    b = robot_with_body(plate_robot, other.json()).manipulator;
  EXPECT_NE(a.elastic_bodies()[0].interfaces[0].name, b.elastic_bodies()[0].interfaces[0].name);
  EXPECT_LT(apart(unloaded_stiffness(b, posture_of(b)).compliance.value().matrix(),
                  unloaded_stiffness(a, posture_of(a)).compliance.value().matrix()),
            1e-10);
  const auto difference = [&](double share) {
    const Load load = heavy.scaled(share);
    return (loaded(b, load).displacement.coordinates() - loaded(a, load).displacement.coordinates())
               .norm() /
           loaded(a, load).displacement.coordinates().norm();
  };
  const double whole = difference(1), tenth = difference(0.1);
  EXPECT_GT(whole, 1e-9);
  EXPECT_LT(whole, 1e-2);
  EXPECT_NEAR(tenth, 0.1 * whole, 0.03 * whole);
}

// Turned and moved as a whole, with its load, a robot does the same.
TEST(ElasticBody, IsObjective) {
  samples::RandomChains random(77);
  const Pose moved = random.pose(0.5);
  const BodyBetweenPoints body = frame();
  const auto turned = [&](const Vector3& v) { return Vector3(moved.rotation() * v); };
  const Eigen::Matrix3d r = moved.rotation();
  std::string text = frame_robot;
  const std::string pose = fmt::format(
      "{{point: [{:.17g}, {:.17g}, {:.17g}], x: [{:.17g}, {:.17g}, {:.17g}], y: [{:.17g}, {:.17g}, "
      "{:.17g}]}}",
      moved.position().x(), moved.position().y(), moved.position().z(), r(0, 0), r(1, 0), r(2, 0),
      r(0, 1), r(1, 1), r(2, 1));
  text.replace(text.find("{foot: base}"), 12, "{foot: base}, pose: " + pose);
  const Manipulator here = robot_with_body(frame_robot, body.json()).manipulator;
  Manipulator there = robot_with_body(text, body.json()).manipulator;
  there = there.with_gravity(turned(here.gravity()));
  // The robots' platforms have one frame: the chains end there in the same way.
  const PostureResult posture = posture_from_joints(there, {});
  ASSERT_TRUE(posture.reached) << posture.reason;
  const Equilibrium a = loaded(here, heavy);
  Load load = heavy;
  load.force = turned(heavy.force);
  load.moment = turned(heavy.moment);
  const Equilibrium b = equilibrium_under_load(there, posture.posture, load);
  ASSERT_EQ(b.status, EquilibriumStatus::converged) << b.reason;
  const Vector3 shift = b.platform.position() - posture.posture.platform.position();
  const double error = (shift - turned(a.displacement.translation)).norm();
  RecordProperty("apart", fmt::format("{:.2g} {:.2g}", error, std::abs(b.energy / a.energy - 1)));
  EXPECT_LT(error, 1e-12);
  EXPECT_NEAR(b.energy, a.energy, 1e-12 * a.energy);
}

// The derivatives of the energy by themselves, the body's axes turned by far and deflections large.
TEST(ElasticBody, ForcesAreTheSlopeOfOnePotential) {
  const Manipulator robot = robot_with_body(frame_robot, frame().json()).manipulator;
  ElasticBody body = robot.elastic_bodies().at(0);
  samples::RandomChains random(12);
  body.frame = random.pose(0.4);
  const Pose origin = random.pose(0.7);
  const Vector3 gravity(3, -5, 7);
  VectorXd d(body.stiffness.rows());
  for (double& x : d) x = random.uniform(-0.1, 0.1);
  const auto potential = [&](const Vector6& step, const VectorXd& more) {
    const Pose at = spatial::displaced(origin, step);
    return elastic_forces(body, at, d + more, gravity).energy -
           work_of_weight(body, at, d + more, gravity);
  };
  const ElasticForces forces = elastic_forces(body, origin, d, gravity);
  const double h = 1e-5;
  const VectorXd none = VectorXd::Zero(d.size());
  for (Eigen::Index k = 0; k < d.size(); ++k) {
    const VectorXd step = h * VectorXd::Unit(d.size(), k);
    const double slope =
        (potential(Vector6::Zero(), step) - potential(Vector6::Zero(), -step)) / (2 * h);
    EXPECT_NEAR(forces.on_deflections[k], -slope, 1e-6 * forces.on_deflections.norm());
  }
  const ElasticTangent tangent = elastic_tangent(body, origin, d, gravity);
  for (int k = 0; k < 6; ++k) {
    const Vector6 step = h * Vector6::Unit(k);
    const double slope = (potential(step, none) - potential(-step, none)) / (2 * h);
    EXPECT_NEAR(forces.on_origin[k], -slope, 1e-4 * forces.on_origin.norm());
    if (k < 3) continue;
    const ElasticForces above = elastic_forces(body, spatial::displaced(origin, step), d, gravity),
                        below = elastic_forces(body, spatial::displaced(origin, -step), d, gravity);
    const VectorXd by_turn = (above.on_deflections - below.on_deflections) / (2 * h);
    EXPECT_LT((tangent.by_turn.col(k - 3) - by_turn).norm(), 1e-4 * by_turn.norm());
    const Vector3 moment = (above.on_origin - below.on_origin).tail<3>() / (2 * h);
    EXPECT_LT((tangent.moment.col(k - 3) - moment).norm(), 1e-6 * tangent.moment.norm());
  }
}

// Mass, centre and the deflections' share of the weight are those of the particles.
TEST(ElasticBody, WeighsWhatItsParticlesDo) {
  const BodyBetweenPoints sample = frame();
  const ElasticBody body =
      robot_with_body(frame_robot, sample.json()).manipulator.elastic_bodies().at(0);
  double mass = 0;
  Vector3 moment = Vector3::Zero();
  for (const auto& [m, place] : sample.particles) {
    mass += m;
    moment += m * place;
  }
  EXPECT_NEAR(body.mass, mass, 1e-10 * mass);
  EXPECT_LT((body.center - moment / mass).norm(), 1e-10);
  // Under the weight alone the frame deflects as the linear structure does under the forces that
  // each particle puts on the two points it moves with; the legs have no mass.
  const Manipulator robot = robot_with_body(frame_robot, sample.json()).manipulator;
  constexpr double little = 1e-5;
  const Equilibrium e = equilibrium_under_load(robot, posture_of(robot), {.gravity = little});
  ASSERT_EQ(e.status, EquilibriumStatus::converged) << e.reason;
  VectorXd gravity = VectorXd::Zero(24);
  for (Eigen::Index i = 0; i < 24; i += 6) gravity.segment<3>(i) = little * robot.gravity();
  const VectorXd forces = (sample.inertia * gravity).head<18>();
  // The legs resist too: the work of the weight is twice the energy of all springs.
  VectorXd d(18);
  for (Eigen::Index i = 0; i < 3; ++i)
    d.segment<6>(6 * i) = e.chains[3 + static_cast<std::size_t>(i)].coordinates;
  EXPECT_NEAR(forces.dot(d), 2 * e.energy, 1e-4 * e.energy);
}

TEST(ElasticBody, HasItsShareOfTheCompliance) {
  const Manipulator robot = robot_with_body(plate_robot, plate().json()).manipulator;
  const Posture posture = posture_of(robot);
  const std::vector<SpringShare> shares = spring_shares(robot, posture, Vector3::UnitX());
  double sum = 0, of_plate = 0;
  for (const SpringShare& share : shares) {
    sum += share.share;
    if (name_of(robot, share) == "plate") of_plate += share.share;
  }
  EXPECT_NEAR(sum, 1, 1e-6);
  // A hundredth stiffer takes a hundredth of the share away: share = -d ln c / d ln K.
  const auto compliance = [&](double factor) {
    BodyBetweenPoints body = plate();
    body.stiffness *= factor;
    const Manipulator other = robot_with_body(plate_robot, body.json()).manipulator;
    return unloaded_stiffness(other, posture_of(other)).compliance.value().matrix()(0, 0);
  };
  EXPECT_NEAR(of_plate, -std::log(compliance(1.01) / compliance(1 / 1.01)) / (2 * std::log(1.01)),
              1e-4);
}

}  // namespace
}  // namespace kinetostat::vjm::elastic_body_test
