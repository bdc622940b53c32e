// Sensors anywhere on a robot: what they would read, and how that changes.
#include "kinetostat/calibration/sensors/sensor.h"

#include <gtest/gtest.h>

#include "kinetostat/calibration/campaign/campaign_file.h"
#include "kinetostat/calibration/regression/predict.h"
#include "kinetostat/calibration/regression/simulate.h"
#include "kinetostat/calibration/sensors/sensor_guess.h"
#include "kinetostat/calibration/sensors/weight.h"
#include "kinetostat/common/error.h"

#include "calibration/laboratory.h"
#include "calibration/synthetic.h"
#include "support/matrix_near.h"

namespace kinetostat::calibration {
namespace {

using Eigen::Index;
using Eigen::VectorXd;
using spatial::Vector3;

// A weighty arm on a compliant foundation, with an effect at every kind of place.
const char* arm = R"(kinetostat: 1
name: arm
units: {length: mm, force: N, angle: deg, time: s}
gravity: {direction: [0, 0, -1]}
materials: {steel: {E: 210 GPa, nu: 0.3, density: 7850 kg/m^3}}
links:
  column: {rigid: [0, 0, 400]}
  upper: {beam: {length: 500, section: {rectangle: {y: 60, z: 40}}, material: steel}}
  fore: {beam: {length: 400, section: {rectangle: {y: 40, z: 30}}, material: steel}}
chain_types:
  arm:
    - actuator: {name: q1, axis: Rz, stiffness: 1.0e5 N m/rad, home: 20}
    - link: column
    - actuator: {name: q2, axis: Ry, stiffness: 6.0e4 N m/rad, home: -30}
    - link: upper
    - node: {name: elbow, at: [0, 20, 10]}
    - actuator: {name: q3, axis: Ry, stiffness: 4.0e4 N m/rad, home: 50}
    - link: fore
    - mass: {name: tool, mass: 8 kg, at: [20, 0, 0]}
    - tool: [60, 0, 0]
manipulator:
  chains: [{name: arm, type: arm}]
)";

const char* effects = R"(effects:
  - {effect: base_compliance, at: arm.base, rotation: 4.0e-6 rad/(N m), translation: 2.0e-8 m/N}
  - {effect: bearing_compliance, at: q2, tilt: 2.0e-6 rad/(N m), radial: 1.0e-8 m/N}
  - {effect: geometric_error, at: upper, x: 0.4, rz: 0.05}
  - {effect: geometric_error, at: q1, y: 0.3, rx: 0.04}
  - {effect: eccentricity, at: q3, cosine: 0.02, sine: 0.01, order: 2}
  - {effect: hardening, at: q2, k3: 4.0e9 N m/rad^3}
  - {effect: payload, at: platform, mass: 3 kg, x: 30}
  - {effect: sensor_frame, at: sensor, x: 0.2, rz: 0.1}
  - {effect: wrench_gain, at: load, gain: 1.05}
)";

const char* campaign_head = R"(kinetostat: 1
campaign: sensors
units: {length: mm, force: N, angle: deg, time: s}
wrench_point: reference
readings: readings.csv
)";

// Of every kind, at every kind of place.
const char* all_sensors = R"(sensors:
  tip: {kind: position, on: platform, at: [10, 5, 0]}
  turned: {kind: rotation, on: elbow, axes: [x, y]}
  whole: {kind: pose, on: upper, at: {point: [0, 30, 0], rpy: [10, 20, 30]}, from: arm.base}
  dial: {kind: gauge, on: elbow, at: [5, 0, 20], direction: [1, 2, -2]}
  between: {kind: gauge, on: platform, from: {on: q1, at: [100, 0, 0]}, direction: [0, 0, 1]}
  level: {kind: tilt, on: arm.base}
  tool_level: {kind: tilt, on: fore, at: {rpy: [0, -20, 0]}, axes: [x, y]}
  bent: {kind: tilt, on: fore, at: {rpy: [0, -20, 0]}, axes: [x, y], minus: level}
  ballbar: {kind: distance, on: platform, from: {on: base, at: [600, 300, 100]}}
  wire: {kind: distance, on: elbow, from: {on: arm.base, at: [0, 0, 100]}}
  encoder: {kind: joint, joint: q3}
  motor: {kind: torque, joint: q2}
)";

std::string cells(const std::vector<std::string>& names, const std::string& cell) {
  std::string text;
  for (const std::string& name : names) text += "," + (cell.empty() ? name : cell);
  return text;
}

const std::vector<std::string> all_columns = {
    "tip.dx",   "tip.dy",   "tip.dz",   "turned.rx",     "turned.ry",     "whole.dx",
    "whole.dy", "whole.dz", "whole.rx", "whole.ry",      "whole.rz",      "dial",
    "between",  "level.rx", "level.ry", "tool_level.rx", "tool_level.ry", "bent.rx",
    "bent.ry",  "ballbar",  "wire",     "encoder",       "motor"};

vjm::Robot robot_of(const std::string& text) {
  static const kinetostat::test::TemporaryFolder folder;
  static int count = 0;
  const std::filesystem::path file = folder.path() / fmt::format("robot{}.yaml", ++count);
  io::write_atomically(file, text);
  return vjm::read_robot(file);
}

Predictions predicted(const vjm::Robot& robot, const Campaign& campaign) {
  common::Progress silent;
  return Predictor(robot.manipulator, campaign, 1, silent).predict({}, VectorXd(), false, silent);
}

std::filesystem::path write_readings(const std::string& displacement, const std::string& sensors,
                                     const std::vector<std::string>& columns,
                                     const std::string& cell = "0.01") {
  std::string csv = "q1,q2,q3,fx,fy,fz,mx,my,mz,turn" + cells(columns, "") + "\n";
  for (const char* state :
       {"20,-30,50,120,-80,300,4000,0,9000,60000", "-40,10,80,0,150,-200,0,5000,0,-40000",
        "0,-60,20,60,60,-400,0,0,-6000,"})
    csv += state + cells(columns, cell) + "\n";
  return test::write_campaign(std::string(campaign_head) + "displacement: " + displacement + "\n" +
                                  sensors + "torques: {turn: {joint: q3}}\n",
                              csv);
}

std::vector<Parameter> parameters_of(const vjm::Robot& robot) {
  std::vector<Parameter> all;
  for (const char* spring : {"q2", "upper"})
    all.push_back({.name = spring, .springs = {{0, spring}}, .stiffness = {}});
  for (std::size_t e = 0; e < robot.effects.size(); ++e)
    for (Index v = 0; v < robot.effects[e].values.size(); ++v)
      if (robot.effects[e].values[v] != 0 &&
          !robot.effects[e].kind->parameters[static_cast<std::size_t>(v)].is_shape)
        all.push_back(effect_parameter(robot.effects, e, v, robot.without_effects()));
  return all;
}

class SensorDerivatives : public testing::TestWithParam<const char*> {};

TEST_P(SensorDerivatives, AgreeWithCentralDifferences) {
  const vjm::Robot robot = robot_of(std::string(arm) + effects);
  const Campaign campaign = read_campaign(
      write_readings(GetParam(), std::string(all_sensors), all_columns), robot.manipulator);
  ASSERT_EQ(campaign.size(), std::ssize(all_columns));
  common::Progress silent;
  const Predictor predictor(robot.without_effects(), robot.effects, campaign, 1, silent);
  const std::vector<Parameter> parameters = parameters_of(robot);
  const VectorXd at = starts_of(parameters);
  const Predictions exact = predictor.predict(parameters, at, true, silent);
  ASSERT_FALSE(exact.failure) << exact.failure->reason;
  for (Index p = 0; p < at.size(); ++p) {
    const double h = 2e-3 * (at[p] == 0 ? 1 : std::abs(at[p]));
    const auto shifted = [&](double steps) {
      return predictor
          .predict(parameters, at + steps * h * VectorXd::Unit(at.size(), p), false, silent)
          .displacement;
    };
    const auto f1 = shifted(1), b1 = shifted(-1), f2 = shifted(2), b2 = shifted(-2);
    for (std::size_t i = 0; i < campaign.readings.size(); ++i) {
      const VectorXd differences = (8 * (f1[i] - b1[i]) - (f2[i] - b2[i])) / 12;
      const VectorXd ours = h * exact.derivatives[i].col(p);
      for (Index k = 0; k < campaign.size(); ++k) {
        const bool torque = campaign.component(k).dimension == spatial::dimension::moment;
        EXPECT_NEAR(ours[k], differences[k],
                    1e-7 * std::abs(differences[k]) + (torque ? 2e-8 : 2e-13))
            << parameters[static_cast<std::size_t>(p)].name << " by " << campaign.component(k).name;
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Kinds, SensorDerivatives, testing::Values("difference", "absolute"),
                         [](const auto& kind) { return std::string(kind.param); });

TEST(Sensors, ChangeWithTheWrenchAsTheyDoUnderALittleMore) {
  const vjm::Robot robot = robot_of(std::string(arm) + effects);
  Campaign campaign =
      read_campaign(write_readings("difference", all_sensors, all_columns), robot.manipulator);
  common::Progress silent;
  const auto predict = [&] {
    return Predictor(robot.without_effects(), robot.effects, campaign, 1, silent)
        .predict_with_compliance({}, VectorXd(), silent);
  };
  const Predictions exact = predict();
  for (const Index axis : {0, 2, 4}) {
    const auto shifted = [&](double h) {
      const std::vector<Reading> before = campaign.readings;
      for (Reading& r : campaign.readings)
        (axis < 3 ? r.load.force[axis] : r.load.moment[axis - 3]) += h;
      const Predictions result = predict();
      campaign.readings = before;
      return result;
    };
    const Predictions more = shifted(0.5), less = shifted(-0.5);
    for (std::size_t i = 0; i < campaign.readings.size(); ++i) {
      const VectorXd slope = more.displacement[i] - less.displacement[i];
      const VectorXd ours = exact.by_wrench[i].col(axis);
      for (Index k = 0; k < campaign.size(); ++k)
        EXPECT_NEAR(ours[k], slope[k],
                    1e-6 * slope.cwiseAbs().head(campaign.size() - 1).maxCoeff() +
                        1e-6 * std::abs(slope[k]))
            << campaign.component(k).name;
    }
  }
}

// By poses and coordinates of the equilibrium, which know nothing of sensors.
TEST(Sensors, ReadWhatFollowsFromTheEquilibrium) {
  const vjm::Robot robot = robot_of(arm);
  const Campaign campaign =
      read_campaign(write_readings("difference", all_sensors, all_columns), robot.manipulator);
  const Predictions predictions = predicted(robot, campaign);
  ASSERT_FALSE(predictions.failure) << predictions.failure->reason;
  const vjm::Chain& chain = robot.manipulator.chains()[0];
  for (std::size_t i = 0; i < campaign.readings.size(); ++i) {
    const Reading& reading = campaign.readings[i];
    const vjm::Posture posture =
        posture_from_joints(robot.manipulator,
                            campaign.configurations[reading.configuration].joints)
            .posture;
    const auto state = [&](const vjm::Load& load) {
      return equilibrium_under_load(robot.manipulator, posture, load);
    };
    const vjm::Equilibrium rest = state({}), loaded = state(reading.load);
    const auto read = [&](const std::string& name) {
      for (Index k = 0; k < campaign.size(); ++k)
        if (campaign.component(k).name == name) return predictions.displacement[i][k];
      return std::nan("");
    };
    const auto dial = [&](const vjm::Equilibrium& e) {
      return vjm::frame_behind(chain, e.chains[0].coordinates, chain.joints_to("upper")) *
             Vector3(0.005, 0.02, 0.03);
    };
    EXPECT_NEAR(read("dial"), (dial(loaded) - dial(rest)).dot(Vector3(1, 2, -2) / 3), 1e-13);
    const Vector3 centre(0.6, 0.3, 0.1);
    EXPECT_NEAR(
        read("ballbar"),
        (loaded.platform.position() - centre).norm() - (rest.platform.position() - centre).norm(),
        1e-13);
    const Index q3 = chain.index_of("q3"), q2 = chain.index_of("q2");
    EXPECT_NEAR(read("encoder"), loaded.chains[0].coordinates[q3] - rest.chains[0].coordinates[q3],
                1e-14);
    EXPECT_NEAR(read("motor"),
                -6e4 * (loaded.chains[0].coordinates[q2] - rest.chains[0].coordinates[q2]), 1e-8);
    EXPECT_NEAR(read("level.rx"), 0, 1e-14);
    EXPECT_NEAR(read("bent.ry"), read("tool_level.ry") - read("level.ry"), 1e-14);
  }
}

struct Mistake {
  const char *sensor, *column, *says, *cure;
};

class SensorMistakes : public testing::TestWithParam<Mistake> {};

TEST_P(SensorMistakes, AreNamedWithTheirCure) {
  const vjm::Robot robot = robot_of(arm);
  try {
    (void)read_campaign(
        write_readings("difference", fmt::format("sensors:\n  {}\n", GetParam().sensor),
                       {GetParam().column}),
        robot.manipulator);
    FAIL() << "no mistake was found";
  } catch (const common::InputError& error) {
    EXPECT_NE(std::string(error.what()).find(GetParam().says), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find(GetParam().cure), std::string::npos) << error.what();
  }
}

INSTANTIATE_TEST_SUITE_P(
    All, SensorMistakes,
    testing::Values(
        Mistake{"dial: {on: elbow}", "dial", "no kind is stated", "gauge"},
        Mistake{"dial: {kind: guage, on: elbow}", "dial", "guage", "gauge"},
        Mistake{"dial: {kind: gauge, on: elbov, direction: [0, 0, 1]}", "dial", "elbov", "elbow"},
        Mistake{"dial: {kind: gauge, on: elbow}", "dial", "no direction", "direction: [0, 0, 1]"},
        Mistake{"dial: {kind: gauge, on: elbow, direction: [0, 0, 0]}", "dial", "direction", ""},
        Mistake{"fx: {kind: gauge, on: elbow, direction: [0, 0, 1]}", "fx", "already",
                "another name"},
        Mistake{"q1: {kind: joint, joint: q1}", "q1", "already", "another name"},
        Mistake{"e: {kind: joint, joint: q9}", "e", "q9", "q"},
        Mistake{"bar: {kind: distance, on: platform}", "bar", "between two points", "from:"},
        Mistake{"t: {kind: tilt, on: fore, axes: [x, x]}", "t", "different", "[x, z]"},
        Mistake{"t: {kind: tilt, on: fore, axes: x, minus: u}", "t", "u", ""},
        Mistake{"t: {kind: tilt, on: fore, axes: x, noise: 1 um}", "t", "um", "angle"},
        Mistake{"t: {kind: tilt, on: fore, axes: x, noise: 0 urad}", "t", "not positive", "remove"},
        Mistake{"t: {kind: tilt, on: fore, axes: x}", "dx", "'t' has no column", "columns"},
        Mistake{"dial: {kind: gauge, on: elbow, direction: [0, 0, 1], axes: x}", "dial", "axes",
                ""}));

// Columns in other spellings, units of their own, counted the other way round.
TEST(Sensors, AreReadByTheirColumnsAsLabsWriteThem) {
  const vjm::Robot robot = robot_of(arm);
  const std::filesystem::path file = test::write_campaign(
      std::string(campaign_head) +
          "displacement: difference\nnoise: {translation: 2 um}\n"
          "sensors:\n  dial_1: {kind: gauge, on: elbow, direction: [0, 0, 1], noise: 1 um}\n"
          "  level: {kind: tilt, on: fore, axes: [x, y], noise: 5 urad}\n"
          "columns: {Messuhr 7: -dial_1 [um], N2: level.ry [mrad]}\n",
      "fz,Messuhr 7,Level.rx [urad],N2,dz,sigma_level.rx [urad]\n"
      "100,12,40,0.03,0.02,7\n200,24,80,0.06,0.04,\n");
  const Campaign campaign = read_campaign(file, robot.manipulator);
  ASSERT_EQ(campaign.size(), 9);
  VectorXd expected = VectorXd::Constant(9, std::nan(""));
  expected[2] = 2e-5;
  expected.tail<3>() << -1.2e-5, 4e-5, 3e-5;
  for (Index k = 0; k < 9; ++k) {
    if (std::isnan(expected[k]))
      EXPECT_TRUE(std::isnan(campaign.readings[0].displacement[k])) << k;
    else
      EXPECT_NEAR(campaign.readings[0].displacement[k], expected[k], 1e-18) << k;
  }
  EXPECT_NEAR(campaign.readings[0].sigma[6], 1e-6, 1e-18);
  EXPECT_NEAR(campaign.readings[0].sigma[7], 7e-6, 1e-18);
  EXPECT_NEAR(campaign.readings[1].sigma[7], 5e-6, 1e-18);
  EXPECT_NEAR(campaign.readings[1].sigma[2], 2e-6, 1e-18);
  EXPECT_TRUE(campaign.noise_stated);
}

// Four dial gauges at the corners of a frame that is twisted: dz = y sin(M / k), and softer than
// its file says.
TEST(Sensors, FourDialGaugesShowTheTorsionOfAFrame) {
  constexpr double nominal = 5e4, truth = 0.7 * nominal;  // [N m/rad]
  const vjm::Robot robot = robot_of(
      "kinetostat: 1\nname: frame\nunits: {length: mm, force: N, angle: deg}\n"
      "chain_types: {frame: [{actuator: {name: torsion, axis: Rx, stiffness: 50000 N m/rad}}, "
      "{offset: [400, 0, 0]}]}\nmanipulator: {chains: [{name: f, type: frame}]}\n"
      "uncertain: [{stiffness: torsion}]\n");
  std::string csv = "mx [N m],d1 [um],d2 [um],d3 [um],d4 [um]\n";
  for (const double moment : {50.0, 100.0, -100.0, 200.0}) {
    csv += fmt::format("{}", moment);
    for (const double y : {0.2, -0.2, 0.15, -0.15})
      csv += fmt::format(",{:.9f}", 1e6 * y * std::sin(moment / truth));
    csv += "\n";
  }
  const Campaign campaign =
      read_campaign(test::write_campaign(std::string(campaign_head) +
                                             "displacement: difference\nsensors:\n"
                                             "  d1: {kind: gauge, on: platform, at: [0, 200, 0], "
                                             "direction: [0, 0, 1], noise: 1 um}\n"
                                             "  d2: {kind: gauge, on: platform, at: [0, -200, 0], "
                                             "direction: [0, 0, 1], noise: 1 um}\n"
                                             "  d3: {kind: gauge, on: f.torsion, at: [0, 150, 0], "
                                             "direction: [0, 0, 1], noise: 1 um}\n"
                                             "  d4: {kind: gauge, on: f.torsion, at: [0, -150, 0], "
                                             "direction: [0, 0, 1], noise: 1 um}\n",
                                         csv),
                    robot.manipulator);
  EXPECT_FALSE(campaign.reads_platform());
  common::Progress silent;
  const Comparison comparison = compare(robot, campaign, 1, silent);
  ASSERT_TRUE(comparison.fitted);
  EXPECT_NEAR(std::exp(comparison.fitted->fit.parameters[0].value), 0.7, 1e-9);
  EXPECT_LT(comparison.fitted->fit.squared_error, 1e-10);
  EXPECT_EQ(comparison.nominal.adequacy, Adequacy::inadequate);
}

// Hung on the elbow and on the tool, against loads at nodes that know nothing of campaigns.
TEST(Weights, PullAlongGravityWhereTheyHang) {
  const vjm::Robot robot = robot_of(arm);
  const std::filesystem::path file = test::write_campaign(
      std::string(campaign_head) +
          "displacement: difference\nnoise: {translation: 1 um}\n"
          "weights:\n  hook: {on: elbow}\n  plate: {on: platform, at: [10, 0, 20]}\n",
      "q2,q1,q3,hook [kg],Plate [g],fx,dx,dz\n-30,20,50,6,,0,0.1,0.1\n-30,20,50,0,2500,40,0.1,0.1\n"
      "-30,20,50,6,2500,40,0.1,0.1\n");
  const Campaign campaign = read_campaign(file, robot.manipulator);
  const Predictions predictions = predicted(robot, campaign);
  ASSERT_FALSE(predictions.failure) << predictions.failure->reason;
  const vjm::Posture posture =
      posture_from_joints(robot.manipulator, campaign.configurations[0].joints).posture;
  const std::size_t elbow = robot.manipulator.chains()[0].node_index("elbow");
  const spatial::Pose rest = equilibrium_under_load(robot.manipulator, posture, {}).platform;
  for (std::size_t i = 0; i < 3; ++i) {
    vjm::Load load{.force = {i == 0 ? 0.0 : 40.0, 0, i == 0 ? 0.0 : -2.5 * 9.80665},
                   .point_on_platform = {0.01, 0, 0.02}};
    if (i != 1) load.nodes = {{.chain = 0, .node = elbow, .force = {0, 0, -6 * 9.80665}}};
    if (i == 0) {
      const spatial::Pose loaded =
          equilibrium_under_load(robot.manipulator, posture, load).platform;
      EXPECT_TRUE(kinetostat::test::matrix_near(predictions.displacement[i],
                                                spatial::pose_difference(rest, loaded), 1e-12));
      continue;
    }
    // Both forces on the platform together, as a wrench about the reference point at the pose that
    // is predicted.
    const spatial::Pose there = spatial::displaced(rest, predictions.displacement[i]);
    load.point_on_platform.setZero();
    load.moment = (there.rotation() * Vector3(0.01, 0, 0.02)).cross(Vector3(0, 0, -2.5 * 9.80665));
    const spatial::Pose loaded = equilibrium_under_load(robot.manipulator, posture, load).platform;
    EXPECT_TRUE(kinetostat::test::matrix_near(predictions.displacement[i],
                                              spatial::pose_difference(rest, loaded), 1e-11));
  }
}

// A cylinder between two bodies is two loads at nodes along the line between them.
TEST(Cylinders, PushTheirEndsApart) {
  const vjm::Robot robot = robot_of(arm);
  const std::filesystem::path file = test::write_campaign(
      std::string(campaign_head) +
          "displacement: difference\nnoise: {translation: 1 um}\ncylinders:\n"
          "  brace: {on: elbow, from: q1}\n"
          "  prop: {on: elbow, from: {on: base, at: [700, 0, 0]}}\n",
      "q1,q2,q3,brace [N],Prop [kN],dx,dz\n20,-30,50,400,,0.1,0.1\n20,-30,50,,-0.3,0.1,0.1\n"
      "20,-30,50,-400,,0.1,0.1\n");
  const Campaign campaign = read_campaign(file, robot.manipulator);
  const Predictions predictions = predicted(robot, campaign);
  ASSERT_FALSE(predictions.failure) << predictions.failure->reason;
  const vjm::Posture posture =
      posture_from_joints(robot.manipulator, campaign.configurations[0].joints).posture;
  const vjm::Chain& chain = robot.manipulator.chains()[0];
  const VectorXd x = posture.coordinates_of(chain, 0);
  const Vector3 elbow =
      vjm::frame_behind(chain, posture.coordinates_of(chain, 0), chain.joints_to("upper")) *
      Vector3(0, 0.02, 0.01);
  const Vector3 push = -300 * (elbow - Vector3(0.7, 0, 0)).normalized();
  const auto pose = [&](const vjm::Load& load) {
    return equilibrium_under_load(robot.manipulator, posture, load).platform;
  };
  const spatial::Pose there =
      pose({.nodes = {{.chain = 0, .node = chain.node_index("elbow"), .force = push}}});
  EXPECT_TRUE(kinetostat::test::matrix_near(predictions.displacement[1],
                                            spatial::pose_difference(pose({}), there), 1e-12));
  // Equal and opposite, to first order; one force that cancels is a load all the same.
  EXPECT_TRUE(kinetostat::test::matrix_near(predictions.displacement[0],
                                            VectorXd(-predictions.displacement[2]), 3e-5));
  EXPECT_GT(predictions.displacement[0].norm(), 1e-6);
  EXPECT_NEAR(force_at_nodes(campaign.readings[0].load).norm(), 400, 1e-9);
}

// A torque t in a joint of stiffness k is a command that stands t/k further.
TEST(Torques, AreCommandsFurtherByTheDeflectionOfTheSpring) {
  const vjm::Robot robot = robot_of(arm);
  const auto read = [&](const std::string& more, const std::string& csv) {
    return read_campaign(
        test::write_campaign(std::string(campaign_head) +
                                 "displacement: absolute\nnoise: {translation: 1 um}\n"
                                 "sensors: {encoder: {kind: joint, joint: q2, noise: 1 urad}}\n" +
                                 more,
                             csv),
        robot.manipulator);
  };
  const Campaign driven =
      read("torques: {motor: {joint: q2}}\n",
           "q1,q2,q3,fz,motor [N m],dx,dy,dz,encoder [deg]\n20,-30,50,-100,300,1,1,1,1\n"
           "20,-30,50,-100,,1,1,1,1\n");
  const double shift = 300 / 6e4 * 180 / M_PI;
  const Campaign commanded =
      read("", fmt::format("q1,q2,q3,fz,dx,dy,dz,encoder [deg]\n20,{},50,-100,1,1,1,1\n"
                           "20,-30,50,-100,1,1,1,1\n",
                           -30 + shift));
  const Predictions by_torque = predicted(robot, driven), by_command = predicted(robot, commanded);
  ASSERT_FALSE(by_torque.failure) << by_torque.failure->reason;
  for (std::size_t i = 0; i < 2; ++i)
    EXPECT_TRUE(kinetostat::test::matrix_near(by_torque.displacement[i], by_command.displacement[i],
                                              1e-11));
  EXPECT_GT((by_torque.displacement[0] - by_torque.displacement[1]).norm(), 1e-3);
  EXPECT_NEAR(load_in_joints(driven.readings[0].load).norm(), 300, 1e-9);
}

TEST(Torques, NeedAJointWithASpring) {
  const vjm::Robot robot = robot_of(arm);
  try {
    (void)read_campaign(
        test::write_campaign(std::string(campaign_head) +
                                 "displacement: difference\ntorques: {motor: {joint: q7}}\n",
                             "motor [N m],dz\n1,1\n"),
        robot.manipulator);
    FAIL();
  } catch (const common::InputError& error) {
    EXPECT_NE(std::string(error.what()).find("q7"), std::string::npos) << error.what();
  }
}

TEST(Cylinders, BetweenTheBaseAndItselfAreRefused) {
  const vjm::Robot robot = robot_of(arm);
  try {
    (void)read_campaign(test::write_campaign(std::string(campaign_head) +
                                                 "displacement: difference\ncylinders: {push: {on: "
                                                 "base, from: {on: base, at: [1, 0, 0]}}}\n",
                                             "push,dz\n1,1\n"),
                        robot.manipulator);
    FAIL();
  } catch (const common::InputError& error) {
    EXPECT_NE(std::string(error.what()).find("moves nothing"), std::string::npos) << error.what();
  }
}

// Its axis y lies along the vertical when the arm has turned by a quarter.
TEST(Sensors, ALevelIsRefusedWhereAnAxisOfItStandsUpright) {
  const vjm::Robot robot = robot_of(arm);
  const auto file = [&](const std::string& axes) {
    return write_readings(
        "difference",
        "sensors: {level: {kind: tilt, on: arm.base, at: {rpy: [90, 0, 0]}, axes: " + axes + "}}\n",
        {"level"});
  };
  common::Progress silent;
  const auto predict = [&](const std::string& axes) {
    const Campaign campaign = read_campaign(file(axes), robot.manipulator);
    (void)Predictor(robot.manipulator, campaign, 1, silent);
  };
  EXPECT_NO_THROW(predict("z"));
  try {
    predict("y");
    FAIL() << "a level that is blind";
  } catch (const common::InputError& error) {
    const std::string what = error.what();
    for (const char* part : {"axis y of the level 'level' is vertical", "readings.csv", "axes:"})
      EXPECT_NE(what.find(part), std::string::npos) << what;
  }
}

TEST(Sensors, HaveNoErrorOfTheirDatumWhereZeroIsStated) {
  const vjm::Robot robot = robot_of(arm);
  const auto read = [&](const std::string& datum, const std::string& own) {
    return read_campaign(
        write_readings(
            "difference",
            "datum_noise: " + datum +
                "\nsensors: {dial: {kind: gauge, on: elbow, direction: [0, 0, 1], noise: "
                "1 um" +
                own + "}}\n",
            {"dial"}),
        robot.manipulator);
  };
  EXPECT_EQ(read("0", "").datum_noise[0], 0);
  EXPECT_NEAR(read("0", ", datum_noise: 2 um").datum_noise[0], 2e-6, 1e-18);
  EXPECT_EQ(read("{translation: 0 um}", ", datum_noise: 0").datum_noise[0], 0);
  EXPECT_TRUE(std::isnan(read("{translation: 0 um}", "").datum_noise[0]));
  try {
    (void)read("5 um", "");
    FAIL();
  } catch (const common::InputError& error) {
    EXPECT_NE(std::string(error.what()).find("or 0 where all of them are exact"), std::string::npos)
        << error.what();
  }
}

TEST(SensorGuess, GoesByWordsNumbersAxesAndJoints) {
  const std::vector<std::string> joints = {"A1", "A2", "q3"};
  const auto guess = [&](const char* column) -> std::string {
    const auto found = sensor_guess(column, joints);
    if (!found) return "";
    return found->kind + " " + found->name +
           (found->axis != 0 ? std::string(" ") + found->axis : "") +
           (found->joint.empty() ? "" : " of " + found->joint);
  };
  EXPECT_EQ(guess("dial_1"), "gauge dial_1");
  EXPECT_EQ(guess("Messuhr 3"), "gauge Messuhr_3");
  EXPECT_EQ(guess("tilt_x"), "tilt tilt x");
  EXPECT_EQ(guess("Base Level.ry"), "tilt Base_Level y");
  EXPECT_EQ(guess("ballbar"), "distance ballbar");
  EXPECT_EQ(guess("theta_A2"), "joint theta_A2 of A2");
  EXPECT_EQ(guess("Torque a1"), "torque Torque_a1 of A1");
  for (const char* other : {"theta", "torque_A9", "remark", "dz", "dialect", "x"})
    EXPECT_EQ(guess(other), "") << other;
}

// What is simulated like a campaign is what the model says of each of its sensors.
TEST(SimulateLike, WritesWhatTheModelSaysInTheCellsThatHoldReadings) {
  const vjm::Robot robot = robot_of(arm);
  const std::filesystem::path file = test::write_campaign(
      std::string(campaign_head) +
          "displacement: difference\norigin: measured\nsensors:\n  dial: {kind: gauge, on: elbow, "
          "direction: [0, 0, 1]}\n  level: {kind: tilt, on: fore, axes: [x, y]}\n"
          "weights: {hook: {on: elbow}}\ncolumns: {Uhr: -dial [um]}\n",
      "remark,hook,Uhr,level.rx [urad],level.ry [urad]\nfirst,4,9,9,9\n\"a, b\",8,9,,9\n");
  common::Progress silent;
  const SimulatedCampaign made =
      simulate_like(robot, "robot.yaml", file, std::nullopt, {.seed = 3}, silent);
  const std::filesystem::path again = test::write_campaign(made.yaml, made.readings);
  const Campaign measured = read_campaign(file, robot.manipulator);
  const Campaign simulated = read_campaign(again, robot.manipulator);
  const Predictions predictions =
      Predictor(robot.manipulator, measured, 1, silent).predict({}, VectorXd(), false, silent);
  ASSERT_EQ(simulated.readings.size(), 2U);
  EXPECT_EQ(simulated.covariates.at(0).values.at(1), "a, b");
  for (std::size_t i = 0; i < 2; ++i)
    for (Index k = 0; k < measured.size(); ++k) {
      const double read = simulated.readings[i].displacement[k];
      if (std::isnan(measured.readings[i].displacement[k]))
        EXPECT_TRUE(std::isnan(read));
      else
        EXPECT_NEAR(read, predictions.displacement[i][k], 1e-15);
    }
}

}  // namespace
}  // namespace kinetostat::calibration
