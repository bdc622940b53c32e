#include "kinetostat/calibration/comparison/column_error.h"

#include <cmath>
#include <functional>
#include <random>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetostat/calibration/comparison/compare.h"
#include "kinetostat/calibration/regression/predict.h"
#include "kinetostat/spatial/rotation.h"

#include "calibration/laboratory.h"

namespace kinetostat::calibration::column_error_test {
namespace {

using spatial::Vector3;
using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr char arm[] = R"(kinetostat: 1
name: arm
units: {length: mm, force: N, angle: deg}
links: {column: {rigid: [0, 0, 400]}, upper: {rigid: [500, 0, 0]}, fore: {rigid: [400, 0, 100]}}
chain_types:
  arm:
    - actuator: {name: q1, axis: Rz, stiffness: 4e5 N m/rad}
    - link: column
    - actuator: {name: q2, axis: Ry, stiffness: 2e5 N m/rad}
    - link: upper
    - actuator: {name: q3, axis: Ry, stiffness: 1e5 N m/rad}
    - link: fore
manipulator: {chain: arm}
)";

class Arm : public test::Laboratory {
 public:
  Arm() : Laboratory(arm) { options().components = {true, true, true, false, false, false}; }

  // Twelve postures, in each a push along every axis.
  Campaign pushed() {
    std::mt19937_64 engine(7);
    const auto angle = [&](double range) {
      return range * (2 * static_cast<double>(engine() >> 11) * 0x1p-53 - 1);
    };
    std::string plan = "q1,q2,q3,fx,fy,fz\n";
    for (int i = 0; i < 12; ++i) {
      const std::string at = fmt::format("{},{},{}", angle(90), angle(60), angle(80));
      for (const char* push : {"300,0,0", "0,300,0", "0,0,-300"}) plan += at + "," + push + "\n";
    }
    return measure(plan);
  }
  std::string slip(const Campaign& campaign) const {
    common::Progress silent;
    return compare(robot(), campaign, 2, silent).unit_error;
  }
};

void turn_joint(Campaign& campaign, const std::string& joint,
                const std::function<double(double)>& turn) {
  for (Configuration& configuration : campaign.configurations) {
    double& q = configuration.joints.at(joint);
    q = turn(q);
  }
}

TEST(ColumnError, AnAxisOfTheReadingsIsNamed) {
  Arm laboratory;
  const Campaign right = laboratory.pushed();
  EXPECT_THAT(laboratory.slip(right), IsEmpty());
  Campaign reversed = right, exchanged = right, turned = right;
  for (Reading& reading : reversed.readings) reading.displacement[1] *= -1;
  EXPECT_THAT(laboratory.slip(reversed), HasSubstr("if 'dy' is -dy:"));
  for (Reading& reading : exchanged.readings)
    std::swap(reading.displacement[0], reading.displacement[2]);
  EXPECT_THAT(laboratory.slip(exchanged), HasSubstr("if 'dx' is dz and 'dz' is dx:"));
  for (Reading& reading : turned.readings) {
    std::swap(reading.displacement[0], reading.displacement[1]);
    reading.displacement[1] *= -1;
  }
  EXPECT_THAT(laboratory.slip(turned), HasSubstr("if 'dx' is dy and 'dy' is -dx:"));
  // No effect stands beside it.
  const Diagnosis d = laboratory.diagnose(reversed, {"friction", "base_compliance"});
  EXPECT_EQ(d.verdict, Verdict::unexplained);
  EXPECT_THAT(d.unit_error, HasSubstr("'dy' is -dy"));
}

TEST(ColumnError, AnAxisInAnotherUnitIsNamed) {
  Arm laboratory;
  for (const auto& [factor, said] :
       {std::pair(1 / 25.4, "if 'dy' is in a unit 25.4 times as large as it says:"),
        {1e3, "if 'dy' is in a unit 1000 times as small as it says:"}}) {
    Campaign wrong = laboratory.pushed();
    for (Reading& reading : wrong.readings) reading.displacement[1] *= factor;
    EXPECT_THAT(laboratory.slip(wrong), HasSubstr(said));
  }
  // Twice as much is no unit.
  Campaign soft = laboratory.pushed();
  for (Reading& reading : soft.readings) reading.displacement[1] *= 2;
  EXPECT_THAT(laboratory.slip(soft), IsEmpty());
}

TEST(ColumnError, AnAxisOfTheForceIsNamed) {
  Arm laboratory;
  Campaign reversed = laboratory.pushed(), exchanged = reversed;
  for (Reading& reading : reversed.readings) reading.load.force.y() *= -1;
  EXPECT_THAT(laboratory.slip(reversed), HasSubstr("if 'fy' is -fy:"));
  for (Reading& reading : exchanged.readings)
    std::swap(reading.load.force.x(), reading.load.force.z());
  EXPECT_THAT(laboratory.slip(exchanged), HasSubstr("if 'fx' is fz and 'fz' is fx:"));
}

// Of a load cell that turns with the platform, axes are its own; or they are not its own at all.
TEST(ColumnError, AnAxisOfACellOnThePlatformIsNamed) {
  Arm laboratory;
  const Campaign right = laboratory.pushed();
  common::Progress silent;
  const Predictor predictor(laboratory.robot().manipulator, right, 1, silent);
  Campaign reversed = right, in_base_axes = right;
  for (std::size_t i = 0; i < right.readings.size(); ++i) {
    const spatial::Matrix3 cell = predictor.posture_of(i).platform.rotation();
    const Vector3 force = right.readings[i].load.force;
    reversed.readings[i].load.cell = in_base_axes.readings[i].load.cell = cell;
    in_base_axes.readings[i].load.force = cell * force;
    reversed.readings[i].load.force =
        cell * (cell.transpose() * force).cwiseProduct(Vector3(1, -1, 1));
  }
  EXPECT_THAT(laboratory.slip(reversed), HasSubstr("if 'fy' is -fy:"));
  EXPECT_THAT(laboratory.slip(in_base_axes), HasSubstr("'wrench_frame: base'"));
}

TEST(ColumnError, AJointThatCountsTheOtherWayIsNamed) {
  Arm laboratory;
  const Campaign right = laboratory.pushed();
  for (const char* joint : {"q1", "q2", "q3"}) {
    Campaign reversed = right;
    turn_joint(reversed, fmt::format("arm.{}", joint), [](double q) { return -q; });
    EXPECT_THAT(laboratory.slip(reversed),
                HasSubstr(fmt::format("if '{}' counts the other way:", joint)));
  }
  Campaign offset = right, in_rad = right, exchanged = right;
  for (Configuration& configuration : exchanged.configurations)
    std::swap(configuration.joints.at("arm.q2"), configuration.joints.at("arm.q3"));
  EXPECT_THAT(laboratory.slip(exchanged), HasSubstr("if 'q2' and 'q3' are exchanged:"));
  turn_joint(offset, "arm.q2", [](double q) { return q - M_PI / 2; });
  EXPECT_THAT(laboratory.slip(offset), HasSubstr("if 'q2' has its zero 90 deg elsewhere:"));
  for (const char* joint : {"arm.q1", "arm.q2", "arm.q3"})
    turn_joint(in_rad, joint, [](double q) { return q * M_PI / 180; });
  EXPECT_THAT(laboratory.slip(in_rad), HasSubstr("if the joints are in rad:"));
  Campaign one_in_rad = right;
  turn_joint(one_in_rad, "arm.q2", [](double q) { return q * M_PI / 180; });
  EXPECT_THAT(laboratory.slip(one_in_rad), HasSubstr("if 'q2' is in rad:"));
}

// What stands in the axes of the tool.
TEST(ColumnError, AFrameOfThePlatformIsNamed) {
  Arm laboratory;
  const Campaign right = laboratory.pushed();
  common::Progress silent;
  const Predictor predictor(laboratory.robot().manipulator, right, 1, silent);
  Campaign wrenches = right, displacements = right;
  for (std::size_t i = 0; i < right.readings.size(); ++i) {
    const spatial::Matrix3 turn = predictor.posture_of(i).platform.rotation().transpose();
    wrenches.readings[i].load.force = turn * right.readings[i].load.force;
    displacements.readings[i].displacement.head<3>() =
        turn * right.readings[i].displacement.head<3>();
  }
  EXPECT_THAT(laboratory.slip(wrenches), HasSubstr("'wrench_frame: platform'"));
  EXPECT_THAT(laboratory.slip(displacements), HasSubstr("'displacement_frame: platform'"));
}

// A joint that counts from elsewhere, which other effects could make up for.
TEST(ColumnError, NoEffectStandsBesideIt) {
  Arm laboratory;
  laboratory.options().displacement = DisplacementKind::absolute;
  Campaign campaign = laboratory.pushed();
  turn_joint(campaign, "arm.q3", [](double q) { return q - M_PI / 2; });
  const Diagnosis d = laboratory.diagnose(campaign, {"joint_offset", "preload"});
  EXPECT_EQ(d.verdict, Verdict::unexplained);
  EXPECT_THAT(d.unit_error, HasSubstr("'q3' has its zero 90 deg elsewhere"));
}

// Poses from an instrument that stands anywhere.
TEST(ColumnError, IsSeenInPosesWithAFrameOfTheirOwn) {
  Arm laboratory;
  laboratory.options().displacement = DisplacementKind::absolute;
  Campaign campaign = laboratory.pushed();
  campaign.session_frame = SessionFrame::estimated;
  const Vector3 turn(0.3, -0.2, 2);
  for (Reading& reading : campaign.readings)
    reading.displacement.head<3>() =
        (spatial::exp_rotation(turn) * reading.displacement.head<3>() + Vector3(2, 1, 0.3)).eval();
  EXPECT_THAT(laboratory.slip(campaign), IsEmpty());
  Campaign reversed = campaign, mirrored = campaign;
  turn_joint(reversed, "arm.q3", [](double q) { return -q; });
  EXPECT_THAT(laboratory.slip(reversed), HasSubstr("if 'q3' counts the other way:"));
  for (Reading& reading : mirrored.readings) reading.displacement[1] *= -1;
  EXPECT_THAT(laboratory.slip(mirrored), HasSubstr("left-handed"));
}

// Stiffnesses that are wrong, a soft base, play: nothing of that is a column error.
TEST(ColumnError, IsNoPhysicalEffect) {
  const std::vector<std::array<const char*, 3>> hidden = {
      {"base_compliance", "arm.base", "rotation=2e-6 rad/(N m)"},
      {"clearance", "arm.q3", "0.1 deg"},
      {"joint_compliance", "arm.q2", "2e-5 rad/(N m)"},
      {"friction", "arm.q2", "force=40 N m,presliding=1e-5 rad"}};
  for (const auto& [kind, place, size] : hidden) {
    Arm laboratory;
    laboratory.hide(kind, place, size);
    EXPECT_THAT(laboratory.slip(laboratory.pushed()), IsEmpty()) << kind;
  }
}

}  // namespace
}  // namespace kinetostat::calibration::column_error_test
