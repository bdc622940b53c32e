// Random robots, solved by the product and by the twin: serial arms, legs with spherical joints at
// both ends, loops through inner bodies, weight, geometric errors. The twin moves bodies in maximal
// coordinates and holds joints by stiff springs; what these give is extrapolated away.
#include <optional>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "kinetostat/spatial/rotation.h"
#include "kinetostat/vjm/effects/effect_model.h"
#include "kinetostat/vjm/effects/watcher.h"
#include "kinetostat/vjm/statics/equilibrium.h"

#include "structure.h"
#include "vjm/random_chain.h"

namespace kinetostat {
namespace {

using spatial::Vector3;
using spatial::Vector6;
using vjm::Motion;

constexpr double stiff_translation = 1e10, stiff_rotation = 1e8;  // [N/m], [N m/rad]
constexpr int more_steps = 3;                                     // of the twin, after its search
constexpr double hold_spin = 1e3;  // of a leg about its axis, at its foot [N m/rad]

twin::Pose twin_pose(const spatial::Pose& pose) { return {pose.position(), pose.rotation()}; }

spatial::Pose moved_by(Motion motion, double q) {
  const Vector3 axis = Vector3::Unit(axis_index(motion));
  return is_rotation(motion) ? spatial::Pose(spatial::exp_rotation(q * axis), Vector3::Zero())
                             : spatial::Pose::translation(q * axis);
}

// The same robot for both programs.
struct Pair {
  std::vector<vjm::Chain> chains;
  std::vector<vjm::Span> spans;
  std::vector<std::vector<double>> coordinates;  // of each chain, in its order
  std::vector<spatial::Pose> bodies;             // platform first
  Vector3 gravity = Vector3::Zero();
  vjm::Load load;

  twin::Structure structure;
  std::vector<int> twin_bodies;  // of `bodies`
  std::vector<twin::DeadLoad> dead_loads;

  // What sensors may look at: frames behind joints and links, and joints with springs.
  struct Place {
    std::size_t chain;
    std::string name;
    twin::Mark mark;
    int coupling;  // of a joint, which gives way along `motion`
    int motion = -1;
    double stiffness = 0;
  };
  std::vector<Place> places;

  int add_body(const spatial::Pose& pose) {
    bodies.push_back(pose);
    twin_bodies.push_back(structure.add_body(twin_pose(pose)));
    return static_cast<int>(bodies.size()) - 1;
  }
  spatial::Pose pose_of(int body) const {
    return body < 0 ? spatial::Pose() : bodies[static_cast<std::size_t>(body)];
  }
  int twin_body(int body) const {
    return body < 0 ? twin::ground : twin_bodies[static_cast<std::size_t>(body)];
  }
};

// Builds one chain of both, element by element.
class ChainPair {
 public:
  ChainPair(Pair& pair, const std::string& name, int from, int to, double stiffer)
      : pair_(pair),
        chain_(name),
        at_(pair.pose_of(from)),
        body_(pair.twin_body(from)),
        to_(to),
        stiffer_(stiffer) {
    pair.spans.push_back({from, to});
  }

  ChainPair& offset(const spatial::Pose& pose) {
    chain_.offset(pose);
    at_ = at_ * pose;
    return *this;
  }
  // The rest of the way to a frame.
  ChainPair& offset_to(const spatial::Pose& pose) { return offset(at_.inverse() * pose); }
  ChainPair& error(const spatial::Pose& pose) {
    chain_.error(pose);
    error_ = pose;
    return *this;
  }
  ChainPair& actuator(const std::string& name, Motion motion, double stiffness, double q,
                      bool ends = false) {
    chain_.actuator(name, motion, stiffness, q);
    joint({motion}, {q}, stiffness, ends ? pair_.twin_body(to_) : next_body({motion}, {q}));
    pair_.places.push_back({pair_.chains.size(), name, twin_mark(at_), coupling_,
                            static_cast<int>(motion), stiffness});
    return *this;
  }
  ChainPair& passive(const std::string& name, const std::vector<Motion>& motions,
                     const std::vector<double>& q, bool ends = false) {
    for (std::size_t i = 0; i < motions.size(); ++i)
      chain_.passive(name + std::to_string(i), motions[i], q[i]);
    return joint(motions, q, 0, ends ? pair_.twin_body(to_) : next_body(motions, q),
                 ends ? 0 : hold_spin);
  }
  ChainPair& link(const std::string& name, const spatial::Pose& offset,
                  const spatial::Compliance6& compliance) {
    chain_.link(name, offset, compliance);
    at_ = at_ * offset;
    const int body = pair_.structure.add_body(twin_pose(at_));
    couple(twin_mark(at_), body, compliance.matrix().inverse());
    for (int i = 0; i < 6; ++i) coordinates_.push_back(0);
    pair_.places.push_back({pair_.chains.size(), name, twin_mark(at_), coupling_});
    return *this;
  }
  ChainPair& mass(const std::string& name, double mass, const Vector3& at) {
    chain_.mass(name, mass, at);
    pair_.dead_loads.push_back(
        {twin_mark(at_ * spatial::Pose::translation(at)), mass * pair_.gravity, Vector3::Zero()});
    return *this;
  }
  void finish() {
    pair_.chains.push_back(chain_.build());
    pair_.coordinates.push_back(coordinates_);
  }
  // A serial arm: its last body is the platform.
  int body() const { return body_; }
  const spatial::Pose& at() const { return at_; }

 private:
  int next_body(const std::vector<Motion>& motions, const std::vector<double>& q) {
    return pair_.structure.add_body(twin_pose(at_ * moved(motions, q)));
  }
  static spatial::Pose moved(const std::vector<Motion>& motions, const std::vector<double>& q) {
    spatial::Pose pose;
    for (std::size_t i = 0; i < motions.size(); ++i) pose = pose * moved_by(motions[i], q[i]);
    return pose;
  }
  twin::Mark twin_mark(const spatial::Pose& pose) const {
    return pair_.structure.mark(body_, twin_pose(pose));
  }
  ChainPair& joint(const std::vector<Motion>& motions, const std::vector<double>& q,
                   double stiffness, int next, double about_z = 0) {
    spatial::Matrix6 k = spatial::Matrix6::Zero();
    k.diagonal().head<3>().setConstant(stiffer_ * stiff_translation);
    k.diagonal().tail<3>().setConstant(stiffer_ * stiff_rotation);
    for (const Motion motion : motions)
      k(static_cast<int>(motion), static_cast<int>(motion)) =
          motion == Motion::rz && motions.size() > 1 ? about_z : stiffness;
    // The error lies in front of the joint; the frame on this side stands where q has brought it.
    const spatial::Pose behind = error_ * moved(motions, q);
    const twin::Mark here = twin_mark(at_ * behind);
    error_ = spatial::Pose();
    at_ = at_ * moved(motions, q);
    couple(here, next, k);
    coordinates_.insert(coordinates_.end(), q.begin(), q.end());
    return *this;
  }
  void couple(const twin::Mark& here, int next, const spatial::Matrix6& k) {
    twin::Coupling coupling;
    coupling.a = here;
    coupling.b = pair_.structure.mark(next, twin_pose(at_));
    coupling.stiffness = k;
    coupling_ = pair_.structure.add(coupling);
    body_ = next;
  }

  Pair& pair_;
  vjm::ChainBuilder chain_;
  spatial::Pose at_, error_;
  int body_, to_, coupling_ = -1;
  double stiffer_;
  std::vector<double> coordinates_;
};

class RandomRobot : public vjm::samples::RandomChains {
 public:
  RandomRobot(unsigned seed, double stiffer) : RandomChains(seed), stiffer_(stiffer) {
    pair_.gravity = {0, 0, seed % 2 == 0 ? -9.81 : 0.0};
    pair_.load = {.force = vector(40), .moment = vector(5)};
  }

  Pair arm() {
    pair_.spans.clear();
    ChainPair chain(pair_, "arm", -1, 0, stiffer_);
    const int joints = 3 + static_cast<int>(uniform(0, 3.99));
    for (int i = 0; i < joints; ++i) {
      const std::string number = std::to_string(i);
      const Motion axis = motion();
      chain.offset(pose(0.2)).error(small_error());
      chain.actuator("q" + number, axis, is_rotation(axis) ? uniform(2e3, 2e4) : uniform(2e4, 2e5),
                     is_rotation(axis) ? uniform(-1, 1) : uniform(-0.1, 0.1));
      if (i == 1) chain.link("l", pose(0.2), soft_link());
      chain.mass("m" + number, uniform(0.5, 3), vector(0.1));
    }
    chain.offset(pose(0.2)).finish();
    pair_.bodies = {chain.at()};
    pair_.twin_bodies = {chain.body()};
    return std::move(pair_);
  }

  // Six legs; those with an even number have a spherical joint at both ends.
  Pair hexapod() {
    const spatial::Pose platform(spatial::exp_rotation(vector(0.2)), {0.02, -0.03, 0.6});
    pair_.add_body(platform);
    for (int i = 0; i < 6; ++i) {
      const double a = M_PI / 3 * i + uniform(-0.2, 0.2), b = a + (i % 2 == 0 ? 0.7 : -0.7);
      add_leg("leg" + std::to_string(i), -1, 0, 0.5 * Vector3(std::cos(a), std::sin(a), 0),
              platform * (0.3 * Vector3(std::cos(b), std::sin(b), 0.1)), i % 2 == 0);
    }
    return std::move(pair_);
  }

  // Base - carousel - platform, and a strut with spherical joints across both or the second joint.
  Pair loop() {
    const spatial::Pose carousel(spatial::exp_rotation(vector(0.3)), {0.1, 0.05, 0.3});
    const spatial::Pose platform = carousel * pose(0.4);
    pair_.add_body(platform);
    pair_.add_body(carousel);
    ChainPair column(pair_, "column", -1, 1, stiffer_);
    column.offset(pose(0.2)).error(small_error());
    attach(column, "q0", 1);
    ChainPair arm(pair_, "arm", 1, 0, stiffer_);
    arm.offset(pose(0.2)).actuator("q1", Motion::ry, uniform(2e3, 2e4), uniform(-1, 1));
    arm.mass("m", uniform(1, 4), vector(0.1)).link("l", pose(0.2), soft_link());
    attach(arm, "q2", 0);
    add_leg("strut", uniform(0, 1) < 0.5 ? -1 : 1, 0, Vector3(-0.3, 0.1, 0),
            platform * Vector3(0.05, 0.1, 0.1), true);
    return std::move(pair_);
  }

 private:
  spatial::Pose small_error() { return {spatial::exp_rotation(vector(1e-3)), vector(5e-4)}; }
  // Deflections of the order of 1e-5, where all parametrisations of a spring agree.
  spatial::Compliance6 soft_link() { return spatial::Compliance6(1e-2 * compliance().matrix()); }

  // A joint with a spring whose far side is the body where the chain ends.
  void attach(ChainPair& chain, const std::string& name, int to) {
    chain.actuator(name, Motion::rz, uniform(2e3, 2e4), uniform(-1, 1), true);
    chain.offset_to(pair_.pose_of(to)).finish();
  }

  // Foot and top in base axes. A mass on its axis does not hold a leg that spins.
  void add_leg(const std::string& name, int from, int to, const Vector3& foot, const Vector3& top,
               bool spins) {
    const Vector3 line = top - foot;
    const double length = line.norm();
    ChainPair leg(pair_, name, from, to, stiffer_);
    leg.offset_to(
        {Eigen::Quaterniond::FromTwoVectors(Vector3::UnitZ(), line).toRotationMatrix(), foot});
    leg.error(small_error());
    if (spins) {
      leg.passive("lower", {Motion::rz, Motion::rx, Motion::ry}, {0, 0, 0});
    } else {
      leg.passive("lower", {Motion::rx, Motion::ry}, {0, 0});
    }
    leg.mass("lower", uniform(0, 2), {0, 0, length / 4});
    leg.actuator("length", Motion::tz, uniform(2e5, 2e6), length / 2);
    leg.offset(spatial::Pose::translation({0, 0, length / 2}));
    leg.passive("upper", {Motion::rz, Motion::rx, Motion::ry}, {0, 0, 0}, true);
    leg.offset_to(pair_.pose_of(to)).finish();
  }

  double stiffer_;
  Pair pair_;
};

Pair robot(int number, double stiffer) {
  RandomRobot random(static_cast<unsigned>(number), stiffer);
  return number % 3 == 0 ? random.arm() : number % 3 == 1 ? random.hexapod() : random.loop();
}

vjm::Manipulator manipulator_of(const Pair& pair) {
  std::vector<std::string> inner;
  for (std::size_t b = 1; b < pair.bodies.size(); ++b) inner.push_back("b" + std::to_string(b));
  return vjm::Manipulator("robot", pair.chains, pair.spans, inner).with_gravity(pair.gravity);
}

vjm::Posture posture_of(const Pair& pair) {
  vjm::Posture posture;
  posture.platform = pair.bodies[0];
  for (std::size_t b = 1; b < pair.bodies.size(); ++b)
    posture.inner_bodies.push_back(pair.bodies[b]);
  for (const std::vector<double>& q : pair.coordinates)
    posture.coordinates.push_back(
        Eigen::Map<const Eigen::VectorXd>(q.data(), static_cast<Eigen::Index>(q.size())));
  return posture;
}

vjm::Equilibrium by_product(const Pair& pair) {
  return equilibrium_under_load(manipulator_of(pair), posture_of(pair), pair.load);
}

// Of every place its displacement, then of every joint its motion and the force of its drive: what
// sensors are made of.
using Readings = std::vector<Eigen::VectorXd>;

Readings sensors_by_product(const Pair& pair) {
  vjm::Watch watch;
  const vjm::Manipulator bare = manipulator_of(pair);
  for (const Pair::Place& place : pair.places) {
    watch.frames.push_back({.chain = place.chain, .place = place.name});
    if (place.motion >= 0)
      watch.joints.push_back({place.chain, bare.chains()[place.chain].index_of(place.name)});
  }
  for (std::size_t b = 0; b < pair.bodies.size(); ++b)
    watch.frames.push_back({.body = static_cast<int>(b)});
  vjm::EffectModel model(with_watched(bare, watch), {});
  model.watch(watch);
  const vjm::Posture posture = posture_of(pair);
  const auto watched = [&](const vjm::Load& load) {
    const vjm::Response response = model.respond(posture, load, {}, model.at_rest(0), {}, false);
    EXPECT_TRUE(response.failure.empty()) << response.failure;
    return response.watched;
  };
  const vjm::Watched rest = watched({}), loaded = watched(pair.load);
  Readings readings;
  for (std::size_t f = 0; f < watch.frames.size(); ++f)
    readings.push_back(spatial::pose_difference(rest.frames[f], loaded.frames[f]));
  for (std::size_t j = 0; j < watch.joints.size(); ++j) {
    const auto row = 2 * static_cast<Eigen::Index>(j);
    readings.push_back(loaded.joints.segment<2>(row) - rest.joints.segment<2>(row));
  }
  return readings;
}

Eigen::VectorXd displacement(const twin::Pose& from, const twin::Pose& to) {
  return spatial::pose_difference({from.R, from.x}, {to.R, to.x});
}

// A torque t in a joint of stiffness k moves the rest of its spring by t / k.
void drive_joints(Pair& pair) {
  for (const vjm::JointForce& joint : pair.load.joints)
    for (const Pair::Place& place : pair.places)
      if (place.motion >= 0 && place.chain == joint.chain &&
          pair.chains[place.chain].index_of(place.name) == joint.coordinate)
        pair.structure.coupling(place.coupling).rest[place.motion] += joint.force / place.stiffness;
}

std::optional<Readings> sensors_by_twin(Pair pair) {
  const twin::Mark platform = pair.structure.mark(pair.twin_bodies[0], twin_pose(pair.bodies[0]));
  std::vector<twin::Mark> marks;
  for (const Pair::Place& place : pair.places) marks.push_back(place.mark);
  for (std::size_t b = 0; b < pair.bodies.size(); ++b)
    marks.push_back(pair.structure.mark(pair.twin_bodies[b], twin_pose(pair.bodies[b])));
  const auto seen = [&] {
    Readings poses_and_forces;
    std::vector<twin::Pose> poses;
    for (const twin::Mark& mark : marks) poses.push_back(pair.structure.pose_of(mark));
    for (const Pair::Place& place : pair.places) {
      if (place.motion < 0) continue;
      const twin::Coupling& coupling = pair.structure.coupling(place.coupling);
      const twin::Pose a = pair.structure.pose_of(coupling.a);
      const twin::Pose b = pair.structure.pose_of(coupling.b);
      Vector6 e;
      e << a.R.transpose() * (b.x - a.x), spatial::log_rotation(a.R.transpose() * b.R);
      poses_and_forces.push_back(
          Eigen::Vector2d(e[place.motion], -place.stiffness * e[place.motion]));
    }
    return std::pair(poses, poses_and_forces);
  };
  std::vector<twin::DeadLoad> loads = pair.dead_loads;
  if (!pair.structure.settle(loads, more_steps)) return std::nullopt;
  const auto [rest, rest_joints] = seen();
  drive_joints(pair);
  loads.push_back({platform, pair.load.force, pair.load.moment});
  if (!pair.structure.settle(loads, more_steps)) return std::nullopt;
  const auto [loaded, loaded_joints] = seen();
  Readings readings;
  for (std::size_t m = 0; m < marks.size(); ++m)
    readings.push_back(displacement(rest[m], loaded[m]));
  for (std::size_t j = 0; j < rest_joints.size(); ++j)
    readings.push_back(loaded_joints[j] - rest_joints[j]);
  return readings;
}

std::optional<Vector6> by_twin(int number, double stiffer) {
  Pair pair = robot(number, stiffer);
  const twin::Mark platform = pair.structure.mark(pair.twin_bodies[0], twin_pose(pair.bodies[0]));
  std::vector<twin::DeadLoad> loads = pair.dead_loads;
  loads.push_back({platform, pair.load.force, pair.load.moment});
  if (!pair.structure.settle(loads)) return std::nullopt;
  const twin::Pose end = pair.structure.pose_of(platform);
  return spatial::pose_difference(pair.bodies[0], {end.R, end.x});
}

TEST(RandomRobots, DeflectAsTheTwinSays) {
  int solved = 0;
  for (int number = 0; number < 300; ++number) {
    const vjm::Equilibrium ours = by_product(robot(number, 1));
    const auto once = by_twin(number, 1), twice = by_twin(number, 2);
    EXPECT_EQ(ours.status, vjm::EquilibriumStatus::converged) << number << ": " << ours.reason;
    if (ours.status != vjm::EquilibriumStatus::converged || !once || !twice) continue;
    ++solved;
    const Vector6 exact = 2 * *twice - *once;
    EXPECT_LT((ours.displacement.coordinates() - exact).norm(), 1e-4 * exact.norm()) << number;
  }
  EXPECT_GE(solved, 290);
}

// Torques in all joints with springs.
void add_torques(Pair& pair) {
  double torque = 3;
  for (const Pair::Place& place : pair.places)
    if (place.motion >= 0)
      pair.load.joints.push_back({.chain = place.chain,
                                  .coordinate = pair.chains[place.chain].index_of(place.name),
                                  .force = torque *= -1.3});
}

// A hundredth of the load, so that all is linear in it, torques in joints included.
TEST(RandomRobots, MoveUnderSensorsAsTheTwinSays) {
  int compared = 0;
  double worst = 0;
  for (int number = 1; number < 120; number += 2) {  // without weight
    if (number % 3 == 1) continue;                   // all legs
    const auto lightly = [number](double stiffer) {
      Pair pair = robot(number, stiffer);
      // A leg between two spherical joints may spin.
      std::erase_if(pair.places, [&](const Pair::Place& place) {
        return pair.chains[place.chain].name() == "strut";
      });
      if (number % 4 == 1) add_torques(pair);
      pair.load = pair.load.scaled(0.01);
      return pair;
    };
    const Readings ours = sensors_by_product(lightly(1));
    const auto once = sensors_by_twin(lightly(1)), twice = sensors_by_twin(lightly(2));
    if (!once || !twice) continue;
    ASSERT_EQ(ours.size(), once->size());
    for (std::size_t r = 0; r < ours.size(); ++r) {
      const Eigen::VectorXd exact = 2 * (*twice)[r] - (*once)[r];
      // A force is as exact as the deflection that shows it.
      const double unit = exact.size() == 2 ? 1e-5 : 1;
      Eigen::VectorXd error = (ours[r] - exact).cwiseAbs();
      if (exact.size() == 2) error[1] *= unit;
      worst = std::max(worst, error.maxCoeff());
      EXPECT_LT(error.maxCoeff(), 1e-9) << number << ", " << r;
      ++compared;
    }
  }
  RecordProperty("worst", fmt::format("{:.2g}", worst));
  EXPECT_GT(compared, 200);
}

// Of the poses of all places and of the joints under the load, by the logarithm of the stiffness of
// the first joint: exact ones of the product, differences of the twin.
struct Slopes {
  std::vector<Vector6> frames;
  std::vector<Eigen::Vector2d> joints;
};

Slopes slopes_by_product(const Pair& pair) {
  vjm::Watch watch;
  const vjm::Manipulator bare = manipulator_of(pair);
  for (const Pair::Place& place : pair.places) {
    watch.frames.push_back({.chain = place.chain, .place = place.name});
    if (place.motion >= 0)
      watch.joints.push_back({place.chain, bare.chains()[place.chain].index_of(place.name)});
  }
  vjm::EffectModel model(with_watched(bare, watch), {});
  model.watch(watch);
  const vjm::ModelParameter parameter{.springs = {{pair.places[0].chain, pair.places[0].name}}};
  const vjm::Response response =
      model.respond(posture_of(pair), pair.load, {}, model.at_rest(1), {parameter}, true);
  EXPECT_TRUE(response.failure.empty()) << response.failure;
  const Eigen::VectorXd all = response.watched.derivatives.col(0);
  Slopes slopes;
  for (std::size_t f = 0; f < watch.frames.size(); ++f)
    slopes.frames.push_back(all.segment<6>(6 * static_cast<Eigen::Index>(f)));
  for (std::size_t j = 0; j < watch.joints.size(); ++j)
    slopes.joints.push_back(
        all.segment<2>(6 * std::ssize(watch.frames) + 2 * static_cast<Eigen::Index>(j)));
  return slopes;
}

struct Standing {
  std::vector<spatial::Pose> frames;
  std::vector<Eigen::Vector2d> joints;
};

std::optional<Standing> standing_by_twin(Pair pair, double log_factor) {
  Pair::Place& first = pair.places[0];
  first.stiffness *= std::exp(log_factor);
  pair.structure.coupling(first.coupling).stiffness(first.motion, first.motion) = first.stiffness;
  drive_joints(pair);
  const twin::Mark platform = pair.structure.mark(pair.twin_bodies[0], twin_pose(pair.bodies[0]));
  std::vector<twin::DeadLoad> loads = pair.dead_loads;
  loads.push_back({platform, pair.load.force, pair.load.moment});
  if (!pair.structure.settle(loads, more_steps)) return std::nullopt;
  Standing standing;
  for (const Pair::Place& place : pair.places) {
    const twin::Pose pose = pair.structure.pose_of(place.mark);
    standing.frames.emplace_back(pose.R, pose.x);
    if (place.motion < 0) continue;
    const twin::Coupling& coupling = pair.structure.coupling(place.coupling);
    const twin::Pose a = pair.structure.pose_of(coupling.a);
    const twin::Pose b = pair.structure.pose_of(coupling.b);
    Vector6 e;
    e << a.R.transpose() * (b.x - a.x), spatial::log_rotation(a.R.transpose() * b.R);
    standing.joints.emplace_back(e[place.motion], -place.stiffness * e[place.motion]);
  }
  return standing;
}

std::optional<Slopes> slopes_by_twin(const Pair& pair) {
  constexpr double h = 0.02;
  const auto f1 = standing_by_twin(pair, h), b1 = standing_by_twin(pair, -h),
             f2 = standing_by_twin(pair, 2 * h), b2 = standing_by_twin(pair, -2 * h);
  if (!f1 || !b1 || !f2 || !b2) return std::nullopt;
  Slopes slopes;
  for (std::size_t f = 0; f < f1->frames.size(); ++f) {
    const Vector6 near = spatial::pose_difference(b1->frames[f], f1->frames[f]);
    const Vector6 far = spatial::pose_difference(b2->frames[f], f2->frames[f]);
    slopes.frames.push_back((8 * near - far) / (12 * h));
  }
  for (std::size_t j = 0; j < f1->joints.size(); ++j)
    slopes.joints.push_back(
        (8 * (f1->joints[j] - b1->joints[j]) - (f2->joints[j] - b2->joints[j])) / (12 * h));
  return slopes;
}

TEST(RandomRobots, ChangeUnderSensorsAsTheTwinSays) {
  int compared = 0;
  for (int number = 3; number < 90; number += 6) {  // arms without weight
    const auto lightly = [number](double stiffer) {
      Pair pair = robot(number, stiffer);
      add_torques(pair);
      pair.load = pair.load.scaled(0.01);
      return pair;
    };
    const Slopes ours = slopes_by_product(lightly(1));
    const auto once = slopes_by_twin(lightly(1)), twice = slopes_by_twin(lightly(2));
    if (!once || !twice) continue;
    for (std::size_t f = 0; f < ours.frames.size(); ++f) {
      const Vector6 exact = 2 * twice->frames[f] - once->frames[f];
      EXPECT_LT((ours.frames[f] - exact).norm(), 1e-7) << number << ", " << f;
      compared += exact.norm() > 1e-6;
    }
    for (std::size_t j = 0; j < ours.joints.size(); ++j) {
      const Eigen::Vector2d exact = 2 * twice->joints[j] - once->joints[j];
      EXPECT_NEAR(ours.joints[j][0], exact[0], 1e-7) << number << ", " << j;
      // A force is as exact as the deflection that shows it.
      EXPECT_NEAR(ours.joints[j][1], exact[1], 1e-7 * 1e5) << number << ", " << j;
    }
  }
  EXPECT_GT(compared, 50);
}

}  // namespace
}  // namespace kinetostat
