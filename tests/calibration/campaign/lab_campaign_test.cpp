// What a campaign makes of tables as laboratories write them.
#include <algorithm>
#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetostat/calibration/campaign/campaign_file.h"
#include "kinetostat/calibration/campaign/clock_time.h"
#include "kinetostat/calibration/campaign/column_names.h"
#include "kinetostat/calibration/campaign/joint_loads.h"
#include "kinetostat/calibration/campaign/readings_overview.h"
#include "kinetostat/common/error.h"
#include "kinetostat/vjm/chain/chain_builder.h"

#include "calibration/synthetic.h"

namespace kinetostat::calibration::lab_campaign_test {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

const std::string head =
    "kinetostat: 1\ncampaign: c\nunits: {length: mm, force: N}\ndisplacement: difference\n"
    "readings: readings.csv\n";

vjm::Manipulator arm() {
  vjm::ChainBuilder chain("arm");
  chain.actuator("q1", vjm::Motion::rz, 1e5).offset(spatial::Pose::translation({0.3, 0, 0}));
  chain.actuator("q2", vjm::Motion::ry, 1e5).offset(spatial::Pose::translation({0.4, 0, 0}));
  chain.actuator("q3", vjm::Motion::rx, 1e5).offset(spatial::Pose::translation({0.1, 0, 0}));
  return vjm::Manipulator("arm", {chain.build()});
}

Campaign read(const std::string& csv, const std::string& more = "") {
  return read_campaign(test::write_campaign(head + more, csv), arm());
}

TEST(LabCampaign, EveryColumnHasItsOwnUnit) {
  const Campaign c = read(
      "A1 [deg];A2 (rad);Joint 3 / deg;Fx [kN];Force y [lbf];dx [um];dy (in);Rot z [mrad];T [°C]\n"
      "90;0,5;180;2;10;-12,5;0,01;3;21,5\n");
  const Reading& r = c.readings.at(0);
  const auto& joints = c.configurations.at(0).joints;
  EXPECT_DOUBLE_EQ(joints.at("arm.q1"), M_PI / 2);
  EXPECT_DOUBLE_EQ(joints.at("arm.q2"), 0.5);
  EXPECT_DOUBLE_EQ(joints.at("arm.q3"), M_PI);
  EXPECT_DOUBLE_EQ(r.load.force.x(), 2000);
  EXPECT_DOUBLE_EQ(r.load.force.y(), 44.482216152605);
  EXPECT_DOUBLE_EQ(r.displacement[0], -12.5e-6);
  EXPECT_DOUBLE_EQ(r.displacement[1], 0.000254);
  EXPECT_DOUBLE_EQ(r.displacement[5], 3e-3);
  EXPECT_EQ(r.temperature, 21.5);
  EXPECT_THAT(c.notes, Contains(HasSubstr("'A1 [deg]' is arm.q1 in deg")));
  EXPECT_THAT(c.notes, Contains(HasSubstr("decimal commas")));
}

TEST(LabCampaign, PoundsOfForceAreWeights) {
  const Campaign c = read("Fz (lb),Fx [kg],dz\n10,2,1\n");
  EXPECT_DOUBLE_EQ(c.readings[0].load.force.z(), 44.482216152605);
  EXPECT_DOUBLE_EQ(c.readings[0].load.force.x(), 19.6133);
  EXPECT_THAT(c.notes, Contains(HasSubstr("'Fz (lb)' is in units of mass: the weight of 1 lb")));
}

TEST(LabCampaign, TheCampaignSaysWhatNamesMean) {
  for (const std::string columns :
       {"columns: {Messuhr 1: -dz [um], Pull: fx [kN], time: covariate}\n",
        "columns:\n  Messuhr 1: -dz [um]\n  Pull: fx [kN]\n  time: covariate\n",
        "columns: {\"Messuhr 1\": \"-dz [um]\",\n  Pull: fx [kN], time: ignore}\n"}) {
    const Campaign c = read("Messuhr 1,Pull,time\n5,2,noon\n", columns);
    EXPECT_DOUBLE_EQ(c.readings.at(0).displacement[2], -5e-6) << columns;
    EXPECT_DOUBLE_EQ(c.readings[0].load.force.x(), 2000);
    EXPECT_FALSE(c.readings[0].time);
    EXPECT_THAT(c.covariates.at(0).values, ElementsAre("noon"));
  }
}

TEST(LabCampaign, LinesThatRepeatTheNamesArePassedOver) {
  const Campaign c = read("fz [N],dz [um]\n1,2\nfz [N],dz [um]\n3,4\n");
  ASSERT_EQ(c.readings.size(), 2u);
  EXPECT_DOUBLE_EQ(c.readings[1].load.force.z(), 3);
  EXPECT_EQ(c.readings[1].line, 4);
  EXPECT_THAT(c.notes, Contains(HasSubstr("repeat the names of the columns are passed over (1)")));
}

TEST(LabCampaign, JointsAndMassesAreNotOverlooked) {
  const Campaign c = read("Achse 1,fz,dz\n10,1,2\n");
  EXPECT_THAT(c.warnings, Contains(HasSubstr("If it is the joint q1, say 'columns: {Achse 1: q1 "
                                             "[deg]}'")));
  const Campaign mass = read("Payload mass [kg],fz,dz\n10,1,2\n");
  EXPECT_THAT(mass.warnings, Contains(HasSubstr("say 'weights: {Payload_mass: {on: platform}}'")));
  const Campaign hyphen = read("Q-1 [deg],q2 [deg],q 3 [deg],fz,dz\n90,0,0,1,2\n");
  EXPECT_DOUBLE_EQ(hyphen.configurations.at(0).joints.at("arm.q1"), M_PI / 2);
}

TEST(LabCampaign, NamesWithUnitsAreFoundWithoutThem) {
  EXPECT_DOUBLE_EQ(
      read("Gauge [um],fz\n5,2\n", "columns: {Gauge: dx}\n").readings[0].displacement[0], 5e-6);
  EXPECT_DOUBLE_EQ(
      read("Gauge [um],fz\n5,2\n", "columns: {Gauge [um]: dx}\n").readings[0].displacement[0],
      5e-6);
}

TEST(LabCampaign, WhatWasNotMeasuredIsLeftOutAndSaid) {
  const Campaign c = read("fz,dx,dz\n1,-,2\n1,n/a,NaN\n1,3,4\n");
  EXPECT_TRUE(std::isnan(c.readings[0].displacement[0]));
  EXPECT_TRUE(c.readings[1].masked);
  EXPECT_THAT(c.notes, Contains(HasSubstr("are missing values: 'dx' (2), 'dz' (1)")));
  EXPECT_THAT(c.notes, Contains(HasSubstr("1 row without any displacement is left out")));
  const Campaign stated = read("fz,dx,dz\n1,-999,2\n", "missing: -999\n");
  EXPECT_TRUE(std::isnan(stated.readings[0].displacement[0]));
}

TEST(LabCampaign, ClockTimesCountFromTheFirst) {
  const auto times = [](const std::string& column) {
    std::vector<double> result;
    std::string csv = "time;fz;dz\n";
    for (std::size_t begin = 0; begin < column.size();) {
      const std::size_t end = column.find('|', begin);
      csv += column.substr(begin, end - begin) + ";1;1\n";
      begin = end == std::string::npos ? end : end + 1;
    }
    for (const Reading& reading : read(csv).readings) result.push_back(*reading.time);
    return result;
  };
  EXPECT_THAT(times("2026-05-03T14:22:05.1Z|2026-05-03T16:22:05.4+02:00|2026-05-04T14:22:05.1Z"),
              ElementsAre(0, testing::DoubleNear(0.3, 1e-9), testing::DoubleNear(86400, 1e-9)));
  EXPECT_THAT(times("03.05.2026 23:59:59|04.05.2026 00:00:01"), ElementsAre(0, 2));
  EXPECT_THAT(times("23:59:50|00:00:10|12:00:10"), ElementsAre(0, 20, 43220));
  EXPECT_THAT(times("11:59:58 PM|12:00:02 AM"), ElementsAre(0, 4));
  EXPECT_FALSE(read_clock_time("24 h"));
  EXPECT_FALSE(read_clock_time("2026-02-30"));
  EXPECT_TRUE(is_ambiguous_date("5/3/2026 14:22"));
}

// Columns that look like readings and are none are warned of.
TEST(LabCampaign, WarnsOfCovariatesThatLookLikeReadings) {
  const auto warnings = [](const std::string& name) {
    return read("fz,dz," + name + "\n1,1,1\n").warnings;
  };
  EXPECT_THAT(warnings("rz_deg"), ElementsAre(HasSubstr("'columns: {rz_deg: rz [deg]}'")));
  EXPECT_THAT(warnings("tilt_x"), ElementsAre(HasSubstr("If it is rx, say")));
  EXPECT_THAT(warnings("Kraft X"), ElementsAre(HasSubstr("'columns: {Kraft X: fx}'")));
  for (const std::string name : {"operator", "load_kg_note", "humidity", "run", "x_raw", "dz_raw"})
    EXPECT_THAT(warnings(name), IsEmpty()) << name;
}

TEST(ColumnNames, AreTakenApart) {
  const auto unit = [](const std::string& header) {
    return split_header(header).unit.value_or("-");
  };
  EXPECT_EQ(split_header("Force X [N]").name, "Force X");
  EXPECT_EQ(unit("Force X [N]"), "N");
  EXPECT_EQ(unit("dx (um)"), "um");
  EXPECT_EQ(unit("dx (mean)"), "-");
  EXPECT_EQ(unit("Fx / N"), "N");
  EXPECT_EQ(unit("Fx in kN"), "kN");
  EXPECT_EQ(unit("note / remark"), "-");
}

// Only a unit of its kind makes a free name a reading.
TEST(ColumnNames, NeedAUnitWhereTheyAreNoneOfTheFormat) {
  const std::vector<Joint> joints = joints_of(arm());
  const auto meaning = [&](const std::string& header) {
    return understood(header, joints).meaning;
  };
  EXPECT_EQ(meaning("FX"), "fx");
  EXPECT_EQ(meaning("Kraft X [N]"), "fx");
  EXPECT_EQ(meaning("x-force [kN]"), "fx");
  EXPECT_EQ(meaning("Verlagerung X [um]"), "dx");
  EXPECT_EQ(meaning("D\xc3\xa9placement z [mm]"), "dz");
  EXPECT_EQ(meaning("Rotaci\xc3\xb3n-y [mrad]"), "ry");
  EXPECT_EQ(meaning("forza_y [N]"), "fy");
  EXPECT_EQ(meaning("Kraft X [mm]"), "");
  EXPECT_EQ(meaning("Kraft X"), "");
  EXPECT_EQ(meaning("\xce\x94y [um]"), "dy");
  EXPECT_EQ(meaning("Achse 2 [deg]"), "arm.q2");
  EXPECT_EQ(meaning("A2"), "");
  EXPECT_EQ(meaning("A4 [deg]"), "");
  EXPECT_EQ(meaning("A2 [mm]"), "");
}

vjm::Robot robot_of(vjm::Manipulator manipulator) {
  return {.file = {},
          .name = "arm",
          .units = {.length = "mm", .angle = "deg"},
          .manipulator = std::move(manipulator),
          .uncertain = {},
          .link_files = {}};
}

TEST(ReadingsOverview, WritesACampaignThatReadsTheSame) {
  const auto file =
      test::write_campaign("",
                           "Arm 3\n\nZeit;A1 [deg];A2 [deg];A3 [deg];Fz [N];dz [um];note\n"
                           "14:22:05;10;20;30;0;0;a\n14:22:06;10;20;30;-100;-35,5;b\n");
  const auto table = file.parent_path() / "readings.csv";
  const vjm::Robot robot = robot_of(arm());
  const ReadingsOverview overview = look_at_readings({.table = table}, &robot);
  EXPECT_THAT(overview.mistakes, IsEmpty());
  ASSERT_EQ(overview.columns.size(), 7u);
  EXPECT_EQ(overview.columns[0].meaning, "time");
  EXPECT_EQ(overview.columns[2].words, "joint q2");
  EXPECT_EQ(overview.columns[5].unit, "um");
  EXPECT_DOUBLE_EQ((*overview.columns[5].range)[0], -35.5);
  EXPECT_EQ(overview.columns[6].meaning, "");

  const std::string text =
      campaign_text(overview, "arm 3", "", table.filename().string(), robot.units);
  EXPECT_LE(std::count(text.begin(), text.end(), '\n'), 10);
  const auto again =
      test::write_campaign(text,
                           "Arm 3\n\nZeit;A1 [deg];A2 [deg];A3 [deg];Fz [N];dz [um];note\n"
                           "14:22:05;10;20;30;0;0;a\n14:22:06;10;20;30;-100;-35,5;b\n");
  const Campaign campaign = read_campaign(again, robot.manipulator);
  EXPECT_EQ(campaign.readings.at(1).time, 1.0);
  EXPECT_DOUBLE_EQ(campaign.readings[1].displacement[2], -35.5e-6);
  EXPECT_DOUBLE_EQ(campaign.configurations.at(0).joints.at("arm.q2"), M_PI / 9);
}

TEST(ReadingsOverview, AsksForUnits) {
  const auto file = test::write_campaign("", "fz,dz\n1,2\n");
  const auto table = file.parent_path() / "readings.csv";
  const ReadingsOverview unknown = look_at_readings({.table = table}, nullptr);
  ASSERT_EQ(unknown.mistakes.size(), 2u);
  EXPECT_THAT(unknown.mistakes[0].cure, HasSubstr("give --units force=N"));
  const ReadingsOverview stated =
      look_at_readings({.table = table, .units = {{"length", "mm"}, {"force", "N"}}}, nullptr);
  EXPECT_THAT(stated.mistakes, IsEmpty());
}

// A tracker's positions beside joint angles are measured, not commanded.
TEST(ReadingsOverview, TakesPositionsBesideJointsAsMeasured) {
  const auto file = test::write_campaign(
      "", "A1 [deg],A2 [deg],A3 [deg],X [mm],Y [mm],Z [mm]\n1,2,3,700,1,2\n4,5,6,701,1,2\n");
  const vjm::Robot robot = robot_of(arm());
  const ReadingsOverview overview =
      look_at_readings({.table = file.parent_path() / "readings.csv"}, &robot);
  EXPECT_THAT(overview.mistakes, IsEmpty());
  EXPECT_EQ(overview.displacement, DisplacementKind::absolute);
  EXPECT_EQ(overview.columns[3].meaning, "dx");
}

// Along q1 the moment of the load about z, along q3 that about its own axis: for a force through
// the axis none.
// Payloads in kilograms are loads where nothing else is one.
TEST(ReadingsOverview, TakesMassesForWeights) {
  const auto file = test::write_campaign(
      "", "A1 [deg],A2 [deg],A3 [deg],Payload [kg],X [mm],Y [mm],Z [mm]\n1,2,3,5,700,1,2\n");
  const vjm::Robot robot = robot_of(arm());
  const ReadingsOverview overview =
      look_at_readings({.table = file.parent_path() / "readings.csv"}, &robot);
  EXPECT_THAT(overview.mistakes, IsEmpty());
  EXPECT_EQ(overview.columns[3].words, "Payload, a weight");
  const std::string text = campaign_text(overview, "c", "robot.yaml", "readings.csv", robot.units);
  EXPECT_THAT(text, HasSubstr("\nweights: {Payload: {on: platform}}"));
  EXPECT_THAT(text, HasSubstr("# session_frame: estimate"));
}

TEST(JointLoads, AreTheMomentsAboutTheAxes) {
  const Campaign c = read(
      "q1 [deg],q2 [deg],q3 [deg],fx,fy,fz,dx,dy,dz\n"
      "0,0,0,0,0,100,,,1\n0,0,0,0,50,0,,1,\n",
      "wrench_point: reference\n");
  const auto loads = joint_loads(c, arm());
  ASSERT_EQ(loads.size(), 3u);
  EXPECT_NEAR(loads[0].largest, 50 * 0.8, 1e-6);
  EXPECT_NEAR(loads[1].least, -100 * 0.5, 1e-6);
  EXPECT_TRUE(loads[0].is_observable());
  EXPECT_FALSE(loads[2].is_loaded());
}

TEST(JointLoads, KnowTheTorquesInJoints) {
  const Campaign c =
      read("q1 [deg],q2 [deg],q3 [deg],motor [N m],dx,dy,dz\n0,0,0,40,1,1,1\n30,20,10,-15,1,1,1\n",
           "torques: {motor: {joint: q2}}\n");
  const auto loads = joint_loads(c, arm());
  ASSERT_EQ(loads.size(), 3U);
  EXPECT_FALSE(loads[0].is_loaded());
  EXPECT_TRUE(loads[1].is_observable());
  EXPECT_NEAR(loads[1].least, -15, 1e-6);
  EXPECT_NEAR(loads[1].largest, 40, 1e-6);
  EXPECT_EQ(loads[1].postures, 2U);
}

// Poses sag under the weight, of which differences see nothing: m g x about the second axis.
TEST(JointLoads, OfPosesAreThoseOfTheWeightToo) {
  vjm::ChainBuilder chain("arm");
  chain.actuator("q1", vjm::Motion::rz, 1e5).offset(spatial::Pose::translation({0.3, 0, 0}));
  chain.actuator("q2", vjm::Motion::ry, 1e5).offset(spatial::Pose::translation({0.5, 0, 0}));
  chain.mass("tool", 6, spatial::Vector3::Zero());
  const auto heavy = vjm::Manipulator("arm", {chain.build()}).with_gravity({0, 0, -9.81});
  Campaign c = read_campaign(test::write_campaign(head + std::string("wrench_point: reference\n"),
                                                  "q1 [deg],q2 [deg],fz,dx,dy,dz\n0,0,0,1,1,1\n"),
                             heavy);
  EXPECT_FALSE(joint_loads(c, heavy)[1].is_loaded());
  c.displacement = DisplacementKind::absolute;
  const auto loads = joint_loads(c, heavy);
  EXPECT_FALSE(loads[0].is_loaded());
  EXPECT_NEAR(loads[1].largest, 6 * 9.81 * 0.5, 1e-6);
  EXPECT_TRUE(loads[1].is_observable());
}

TEST(JointLoads, SeeOnlyWhatIsMeasured) {
  const Campaign c =
      read("q1 [deg],q2 [deg],q3 [deg],fy,dz\n0,0,0,50,1\n", "wrench_point: reference\n");
  const auto loads = joint_loads(c, arm());
  EXPECT_TRUE(loads[0].is_loaded());
  EXPECT_FALSE(loads[0].is_observable());
}

}  // namespace
}  // namespace kinetostat::calibration::lab_campaign_test
