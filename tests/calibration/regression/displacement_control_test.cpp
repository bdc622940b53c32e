// Tests that set a displacement and read the force that it takes.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetostat/calibration/campaign/campaign_file.h"
#include "kinetostat/calibration/campaign/joint_loads.h"
#include "kinetostat/calibration/campaign/replicates.h"
#include "kinetostat/calibration/comparison/compare.h"
#include "kinetostat/calibration/regression/predict.h"
#include "kinetostat/common/error.h"

#include "calibration/laboratory.h"
#include "calibration/synthetic.h"

namespace kinetostat::calibration::displacement_control_test {
namespace {

using Eigen::Index;
using Eigen::VectorXd;
using testing::HasSubstr;

const char* head = R"(kinetostat: 1
campaign: controlled
units: {length: mm, force: N, angle: deg}
displacement: difference
wrench_point: reference
readings: readings.csv
)";

const char* arm = R"(kinetostat: 1
name: arm
units: {length: mm, force: N, angle: deg}
gravity: {direction: [0, 0, -1]}
chain_types:
  arm:
    - actuator: {name: q1, axis: Rz, stiffness: 1.0e5 N m/rad, home: 20}
    - offset: [100, 0, 400]
    - actuator: {name: q2, axis: Ry, stiffness: 6.0e4 N m/rad, home: -30}
    - offset: [500, 0, 0]
    - actuator: {name: q3, axis: Ry, stiffness: 4.0e4 N m/rad, home: 50}
    - mass: {name: tool, mass: 8 kg, at: [20, 0, 0]}
    - offset: [300, 20, 0]
manipulator: {chain: arm}
uncertain: [{stiffness: q2}, {stiffness: q3}]
)";

vjm::Robot robot_of(const std::string& text) {
  static const kinetostat::test::TemporaryFolder folder;
  static int count = 0;
  const std::filesystem::path file = folder.path() / fmt::format("robot{}.yaml", ++count);
  io::write_atomically(file, text);
  return vjm::read_robot(file);
}

Campaign read(const vjm::Robot& robot, const std::string& more, const std::string& csv) {
  return read_campaign(test::write_campaign(head + more, csv), robot.manipulator);
}

std::string spring_table(double factor) {
  std::string csv = "dz,fz\n";
  for (const double d : {-1.0, -0.5, 0.0, 0.5, 1.0, 1.5})
    csv += fmt::format("{},{}\n", d, factor * 1000 * d);
  return csv;
}

// A spring of 1000 N/mm along z takes its stiffness times the way.
TEST(DisplacementControl, ReadsTheForceOfASpring) {
  const vjm::Robot robot = test::bench();
  const Campaign campaign =
      read(robot, "displacement_control: {set: dz, force: fz, noise: 2 N}\n", spring_table(0.8));
  common::Progress silent;
  const Predictions predictions =
      Predictor(robot.manipulator, campaign, 1, silent).predict({}, VectorXd(), false, silent);
  const auto set = campaign.control->set, force = campaign.control->force;
  for (std::size_t i = 0; i < campaign.readings.size(); ++i) {
    EXPECT_FALSE(campaign.readings[i].uses(set));
    EXPECT_NEAR(predictions.displacement[i][set], campaign.control->to[i], 1e-14);
    EXPECT_NEAR(predictions.displacement[i][force], 1e6 * campaign.control->to[i], 1e-6);
  }
  const Comparison comparison = compare(robot, campaign, 1, silent);
  ASSERT_TRUE(comparison.fitted);
  const ParameterEstimate& fitted = comparison.fitted->fit.parameters.at(0);
  EXPECT_NEAR(std::exp(fitted.value), 0.8, 1e-9);
  EXPECT_EQ(comparison.nominal.adequacy, Adequacy::inadequate);
  EXPECT_EQ(comparison.fitted->fit.values, 6);
}

// What loads do is undone: the displacements that they cause take these forces, and everything else
// that is read is where it was.
TEST(DisplacementControl, TakesTheForceThatCausesTheDisplacement) {
  const vjm::Robot robot = robot_of(std::string(arm) +
                                    "effects:\n  - {effect: hardening, at: q2, k3: 4.0e9 "
                                    "N m/rad^3}\n  - {effect: base_compliance, at: arm.base, "
                                    "rotation: 4.0e-6 rad/(N m)}\n  - {effect: "
                                    "eccentricity, at: q3, cosine: 0.02, sine: 0.01, order: 2}\n");
  const std::string sensors =
      "sensors:\n  dial: {kind: gauge, on: q2, at: [50, 0, 20], direction: [0.6, 0, -0.8], noise: "
      "1 um}\n  motor: {kind: torque, joint: q2, noise: 1 N m}\n"
      "noise: {translation: 1 um, rotation: 1 urad}\n";
  const std::string loads = "q1,q2,q3,fx,fy,fz,mx,dx,dz,ry,dial,motor\n";
  const std::array<std::array<double, 4>, 3> wrenches = {
      {{120, -80, 300, 4000}, {0, 150, -400, 0}, {60, 60, 500, -6000}}};
  const std::array<const char*, 3> postures = {"20,-30,50", "-40,10,80", "0,-60,20"};
  const auto row = [&](std::size_t i, const std::string& rest) {
    const auto& w = wrenches[i];
    return fmt::format("{},{},{},{},{},{}\n", postures[i], w[0], w[1], w[2], w[3], rest);
  };
  std::string csv = loads;
  for (std::size_t i = 0; i < 3; ++i) csv += row(i, "1,1,1,1,1");
  const Campaign loaded = read(robot, sensors, csv);
  common::Progress silent;
  const Predictions by_load = Predictor(robot.without_effects(), robot.effects, loaded, 1, silent)
                                  .predict({}, VectorXd(), false, silent);
  ASSERT_FALSE(by_load.failure) << by_load.failure->reason;
  for (const auto& [column, unit] : {std::pair("dz", 1e3), {"ry", 180 / M_PI}, {"dial", 1e3}}) {
    const auto k =
        std::find_if(loaded.components.begin(), loaded.components.end(),
                     [column = column](const Component& c) { return c.name == column; }) -
        loaded.components.begin();
    csv = loads;
    const std::array names = {"dx", "dz", "ry", "dial", "motor"};
    for (std::size_t i = 0; i < 3; ++i) {
      std::string cells;
      for (const char* name : names)
        cells += fmt::format("{}{}", cells.empty() ? "" : ",",
                             name == std::string(column)
                                 ? fmt::format("{:.17g}", unit * by_load.displacement[i][k])
                                 : "1");
      csv += row(i, cells);
    }
    Campaign set = read(
        robot,
        sensors + fmt::format("displacement_control: {{set: {}, force: fz, noise: 2 N}}\n", column),
        csv);
    for (Reading& reading : set.readings) reading.displacement[set.control->force] = 20;  // a start
    const Predictions by_set = Predictor(robot.without_effects(), robot.effects, set, 1, silent)
                                   .predict({}, VectorXd(), false, silent);
    ASSERT_FALSE(by_set.failure) << by_set.failure->reason;
    for (std::size_t i = 0; i < 3; ++i) {
      EXPECT_NEAR(by_set.displacement[i][set.control->force], wrenches[i][2], 1e-6) << column;
      EXPECT_LT((by_set.displacement[i].head(8) - by_load.displacement[i].head(8)).norm(),
                1e-8 * by_load.displacement[i].norm());
    }
  }
}

class ControlDerivatives : public testing::TestWithParam<const char*> {};

TEST_P(ControlDerivatives, AgreeWithCentralDifferences) {
  const vjm::Robot robot = robot_of(std::string(arm) + "effects:\n  - " + GetParam() + "\n");
  const Campaign campaign = read(
      robot,
      "displacement_control: {set: dz, force: fz, noise: 2 N}\nsensors: {dial: {kind: gauge, on: "
      "q2, at: [50, 0, 20], direction: [0.6, 0, -0.8], noise: 1 um}}\nnoise: {translation: 1 "
      "um}\n",
      "cycle,step,q1,q2,q3,fx,fz,dx,dz,dial\na,1,20,-30,50,10,50,1,0.3,1\n"
      "a,2,20,-30,50,10,90,1,0.9,1\na,3,20,-30,50,10,-50,1,0.2,1\na,4,20,-30,50,0,-200,1,-0.8,1\n"
      "b,1,0,-60,20,5,60,1,0.8,1\nb,2,0,-60,20,5,60,1,0.1,1\n");
  std::vector<Parameter> parameters = uncertain_parameters(robot);
  for (Index v = 0; v < robot.effects[0].values.size(); ++v)
    if (robot.effects[0].values[v] != 0 &&
        !robot.effects[0].kind->parameters[static_cast<std::size_t>(v)].is_shape)
      parameters.push_back(effect_parameter(robot.effects, 0, v, robot.without_effects()));
  common::Progress silent;
  const Predictor predictor(robot.without_effects(), robot.effects, campaign, 1, silent);
  const VectorXd at = starts_of(parameters);
  const Predictions exact = predictor.predict(parameters, at, true, silent);
  ASSERT_FALSE(exact.failure) << exact.failure->reason;
  for (Index p = 0; p < at.size(); ++p) {
    const double h = 1e-4 * (at[p] == 0 ? 1 : std::abs(at[p]));
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
        const bool force = k == campaign.control->force;
        EXPECT_NEAR(ours[k], differences[k],
                    1e-6 * std::abs(differences[k]) + (force ? 1e-6 : 1e-12))
            << parameters[static_cast<std::size_t>(p)].name << " by " << campaign.component(k).name
            << " in " << i;
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(
    Effects, ControlDerivatives,
    testing::Values("{effect: hardening, at: q2, k3: 4.0e9 N m/rad^3}",
                    "{effect: base_compliance, at: arm.base, rotation: 4.0e-6 rad/(N m)}",
                    "{effect: wrench_gain, at: load, gain: 1.05}",
                    "{effect: friction, at: q2, force: 20 N m, presliding: 0.02 deg}"),
    [](const auto& test) {
      const std::string text = test.param;
      return text.substr(9, text.find(',') - 9);
    });

// In the play of a joint no force acts, however far it was set: a load of nought could not say
// where.
TEST(DisplacementControl, FindsNoForceWithinAClearance) {
  const vjm::Robot robot = robot_of(
      "kinetostat: 1\nname: slide\nunits: {length: mm, force: N}\n"
      "chain_types: {slide: [{actuator: {name: rho, axis: Tz, stiffness: 1000}}]}\n"
      "manipulator: {chain: slide}\neffects: [{effect: clearance, at: rho, gap: 0.1}]\n");
  const Campaign campaign = read(robot, "displacement_control: {set: dz, force: fz, noise: 2 N}\n",
                                 "dz,fz\n0.05,0\n-0.05,0\n0.6,500\n-0.6,-500\n");
  common::Progress silent;
  const Predictions predictions =
      Predictor(robot.without_effects(), robot.effects, campaign, 1, silent)
          .predict({}, VectorXd(), false, silent);
  ASSERT_FALSE(predictions.failure) << predictions.failure->reason;
  const auto force = [&](std::size_t i) {
    return predictions.displacement[i][campaign.control->force];
  };
  // The edges of the play are a little round.
  EXPECT_NEAR(force(0), 0, 0.05 * 50);
  EXPECT_NEAR(force(1), 0, 0.05 * 50);
  EXPECT_NEAR(force(2), 500, 1);
  EXPECT_NEAR(force(3), -500, 1);
}

// The load cell never reads the same twice, the screw is set to the same.
TEST(DisplacementControl, RepeatsWhatIsSet) {
  const vjm::Robot robot = test::bench();
  const Campaign campaign = read(robot, "displacement_control: {set: dz, force: fz}\n",
                                 "dz,fz\n1,1001\n1,998\n2,2003\n2,1999\n3,3000\n");
  const std::vector<ReplicateGroup> groups = replicate_groups(campaign);
  ASSERT_EQ(groups.size(), 3U);
  EXPECT_EQ(groups[0].readings.size(), 2U);
  EXPECT_EQ(groups[1].readings.size(), 2U);
  EXPECT_EQ(groups[2].readings.size(), 1U);
}

TEST(DisplacementControl, ShowsJointsByTheForce) {
  const vjm::Robot robot = robot_of(arm);
  const Campaign campaign = read(robot, "displacement_control: {set: dz, force: fz, noise: 2 N}\n",
                                 "q1,q2,q3,dz,fz\n20,-30,50,1,100\n0,-60,20,-1,-80\n");
  const std::vector<JointLoad> loads = joint_loads(campaign, robot.manipulator);
  ASSERT_EQ(loads.size(), 3U);
  EXPECT_FALSE(loads[0].is_observable());
  EXPECT_TRUE(loads[1].is_observable());
  EXPECT_TRUE(loads[2].is_observable());
}

std::string refusal(const std::string& more, const std::string& csv) {
  try {
    (void)read(test::bench(), more, csv);
    return "nothing";
  } catch (const common::InputError& error) {
    return error.what();
  }
}

TEST(DisplacementControl, NamesWhatIsMissing) {
  const std::string control = "displacement_control: {set: dz, force: fz, noise: 2 N}\n";
  EXPECT_THAT(refusal(control, "dz,dx\n1,1\n"), HasSubstr("fz"));
  EXPECT_THAT(refusal(control, "dx,fz\n1,1\n"), HasSubstr("dz"));
  EXPECT_THAT(refusal(control, "dz,fz\n1,1\n,5\n"), HasSubstr("does not say where this was set"));
  EXPECT_THAT(refusal(control + "wrench_noise: {force: 2 N}\n", "dz,fz\n1,1\n"),
              HasSubstr("the force is the reading"));
  EXPECT_THAT(refusal("displacement_control: {set: dq, force: fz}\n", "dz,fz\n1,1\n"),
              HasSubstr("dq"));
}

}  // namespace
}  // namespace kinetostat::calibration::displacement_control_test
