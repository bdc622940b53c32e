// Cases are what their list says: reproducible, and as detectable as wanted.
#include "case.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <set>
#include <sstream>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "campaign_text.h"
#include "confuser.h"
#include "plan_table.h"
#include "support/temporary_folder.h"

namespace twin {
namespace {

std::string content(const std::filesystem::path& file) {
  std::ostringstream text;
  text << std::ifstream(file).rdbuf();
  return text.str();
}

Case first_with(const std::string& part) {
  for (const Case& c : suite())
    if (c.name.find(part) != std::string::npos) return c;
  ADD_FAILURE() << part;
  return {};
}

TEST(TwinCases, HaveNamesOfTheirOwnAndSeedsOfTheirOwn) {
  std::set<std::string> names;
  std::set<std::uint64_t> seeds;
  for (const Case& c : suite()) {
    EXPECT_TRUE(names.insert(c.name).second) << c.name;
    EXPECT_TRUE(seeds.insert(c.seed).second) << c.name;
  }
  EXPECT_GT(names.size(), 900u);
}

TEST(TwinCases, AreTheSameAgain) {
  const kinetostat::test::TemporaryFolder folder;
  const Case c = first_with("bench_single_friction_d5");
  write_case(c, folder.path() / "a", folder.path() / "a.json");
  write_case(c, folder.path() / "b", folder.path() / "b.json");
  for (const char* file : {"robot.yaml", "campaign.yaml", "readings.csv"})
    EXPECT_EQ(content(folder.path() / "a" / file), content(folder.path() / "b" / file)) << file;
  EXPECT_EQ(content(folder.path() / "a.json"), content(folder.path() / "b.json"));
  Case other = c;
  ++other.seed;
  write_case(other, folder.path() / "c", folder.path() / "c.json");
  EXPECT_NE(content(folder.path() / "a" / "readings.csv"),
            content(folder.path() / "c" / "readings.csv"));
}

// Numbers of another processor may differ in their last digit.
TEST(TwinCases, ShippedStoryIsWhatTheyMake) {
  const kinetostat::test::TemporaryFolder folder;
  write_case(stories().front(), folder.path() / "a", folder.path() / "a.json");
  std::istringstream made(content(folder.path() / "a" / "readings.csv")),
      shipped(content(std::filesystem::path(KINETOSTAT_SOURCE_DIR) /
                      "data/measurements/arm_backlash_soft_base/readings.csv"));
  int rows = 0;
  for (std::string ours, theirs; std::getline(made, ours); ++rows) {
    ASSERT_TRUE(std::getline(shipped, theirs));
    std::istringstream a(ours), b(theirs);
    for (std::string x, y; std::getline(a, x, ',');) {
      ASSERT_TRUE(std::getline(b, y, ','));
      if (x == y) continue;
      ASSERT_NEAR(std::stod(x), std::stod(y), 1e-7 * (1 + std::abs(std::stod(y)))) << theirs;
    }
  }
  EXPECT_EQ(rows, 113);
}

// d' is what a matched filter sees, in standard deviations: its mean over campaigns with the
// effect, and one standard deviation of it without.
TEST(TwinCases, DetectabilityIsTheOutputOfAMatchedFilter) {
  Random random(5);
  World world{.robot = bench(), .factors = {1.1, 0.95}, .effects = {}};
  const Plan plan = cycle_plan(world.robot, random);
  const Responses base = respond(world, plan, true);
  Eigen::Matrix<double, 6, Eigen::Dynamic> noise = stated_noise(world.robot, base);
  const Whitened whitened(plan, base, noise);
  World hidden = world;
  hidden.effects = {{"clearance", "q1", 2e-5}};
  const Responses with = respond(hidden, plan, false);
  const Eigen::VectorXd mark = whitened.mark_of(with);
  double sum = 0, squares = 0;
  constexpr int campaigns = 400;
  for (int i = 0; i < campaigns; ++i) {
    Responses noisy = with;
    for (Eigen::Index k = 0; k < noisy.read.size(); ++k)
      noisy.read(k) += noise(k) * random.normal();
    const double seen = whitened.mark_of(noisy).dot(mark.normalized());
    sum += seen;
    squares += seen * seen;
  }
  const double mean = sum / campaigns;
  EXPECT_NEAR(mean, mark.norm(), 4 / std::sqrt(1. * campaigns));
  EXPECT_NEAR(std::sqrt(squares / campaigns - mean * mean), 1, 0.15);
}

// Fitted parameters leave no signature: neither stiffness nor, as forces go, a gain of the load
// cell.
TEST(TwinCases, WhatIsFittedIsNotDetectable) {
  Random random(5);
  World world{.robot = arm_3r(), .factors = std::vector<double>(6, 1.), .effects = {}};
  const Plan plan = cycle_plan(world.robot, random);
  const Responses base = respond(world, plan, true);
  const auto noise = stated_noise(world.robot, base);
  const Whitened whitened(plan, base, noise);
  World other = world;
  other.effects = {{"wrench_gain", "load", 0.05}};
  EXPECT_LT(whitened.mark_of(respond(other, plan, false)).norm(), 0.2);
  other.effects = {};
  other.factors[3] = 1.02;
  EXPECT_LT(whitened.mark_of(respond(other, plan, false)).norm(), 0.2);
  other.factors[3] = 1;
  other.effects = {{"base_compliance", "base", 3e-6}};
  EXPECT_GT(whitened.mark_of(respond(other, plan, false)).norm(), 1);
}

// What can be hidden is among what it can look like, and so is what points elsewhere.
TEST(TwinCases, ShapesOfAnEffectMakeUpItsSignature) {
  Random random(5);
  World world{.robot = arm_3r(), .factors = std::vector<double>(6, 1.), .effects = {}};
  const Plan plan = pose_plan(world.robot, random);
  const Responses base = respond(world, plan, true);
  const Whitened whitened(plan, base, stated_noise(world.robot, base));
  const auto mark_of = [&](const HiddenEffect& effect) {
    world.effects = {effect};
    return whitened.mark_of(respond(world, plan, false));
  };
  for (HiddenEffect hidden : std::vector<HiddenEffect>{{"geometric_error", "q2"},
                                                       {"eccentricity", "q2"},
                                                       {"application_point", "load"},
                                                       {"wrench_misalignment", "load"},
                                                       {"target_lever_arm", "sensor"},
                                                       {"session_drift", "sensor"},
                                                       {"base_compliance", "base"},
                                                       {"payload", "platform"}}) {
    hidden.size = usual_size(world.robot, hidden);
    const Eigen::VectorXd mark = mark_of(hidden);
    ASSERT_GT(mark.norm(), 0.01) << hidden.name;
    double least = mark.norm();
    for (const std::vector<HiddenEffect>& looks : looks_of(world.robot, hidden)) {
      Eigen::MatrixXd all(mark.size(), 0);
      for (const HiddenEffect& look : looks) {
        all.conservativeResize(Eigen::NoChange, all.cols() + 1);
        all.rightCols<1>() = mark_of(look);
      }
      const Eigen::VectorXd left = mark - all * all.colPivHouseholderQr().solve(mark);
      least = std::min(least, left.norm());
    }
    EXPECT_LT(least, 0.03 * mark.norm()) << hidden.name;
  }
}

// A balancer's moment is as periodic as the error of an eccentric gear.
TEST(TwinCases, CosineIsThatOfTheNearestLook) {
  const Confuser found = confuser_in(first_with("arm_3r_single_eccentricity_d8"), 2e-4, 0.95);
  EXPECT_EQ(found.name, "gravity_compensator at q2");
  EXPECT_GT(found.cosine, 0.95);
}

// A moment about one axis that also turns the arm about another one looks like an axis that is not
// where it should be, by more than is usual.
TEST(TwinCases, CosineIsThatOfALookOfUnusualSize) {
  const Confuser found = confuser_in(first_with("arm_3r_outside_cross_coupling_d8"), 0.05, 0.95);
  EXPECT_TRUE(found.name.starts_with("geometric_error at q")) << found.name;
  EXPECT_GT(found.cosine, 0.95);
}

// Other postures, another angle between what creep does and what friction does.
TEST(TwinCases, CosineIsThatOfTheCampaignAtHand) {
  Case c = first_with("bench_single_creep_d8");
  const Confuser here = confuser_in(c, 0.05);
  ++c.seed;
  const Confuser there = confuser_in(c, 0.05);
  EXPECT_EQ(here.name, "friction at q1");
  EXPECT_EQ(there.name, here.name);
  EXPECT_GT(std::abs(there.cosine - here.cosine), 1e-3);
}

// As the product writes it: a comment for each cycle, names of its own for session and columns that
// the twin need not know.
std::string table_of(const RobotSpec& robot, const Plan& plan) {
  std::string table = "# Readings to take\nid,session,cycle,step,time,replicate";
  for (const Item& item : robot.chains[0].items)
    if (item.kind == Item::actuator) table += "," + item.name;
  table += ",fx,fy,fz\n";
  for (const Row& row : plan.rows) {
    if (row.starts) table += "# p: a load that comes and goes; d' 1 to 6\n";
    table += fmt::format("p{0}-{1},planned,p{0},{1},{2},1", row.cycle, row.step, row.time);
    for (const double q : plan.postures[static_cast<std::size_t>(row.posture)].q[0])
      table += fmt::format(",{:.12g}", q * 180 / std::numbers::pi);
    table += fmt::format(",{},{},{}\n", row.force.x(), row.force.y(), row.force.z());
  }
  return table;
}

TEST(TwinCases, APlanIsMeasuredAsItIsAskedFor) {
  const kinetostat::test::TemporaryFolder folder;
  Random random(3), other(4);
  World world{.robot = arm_3r(), .factors = {}, .effects = {{"friction", "q2", 5}}};
  world.factors.assign(world.robot.springs().size(), 1.1);
  const Plan asked = push_plan(world.robot, random);
  write_text(folder.path() / "plan.csv", table_of(world.robot, asked));
  const Plan measured = plan_of_table(folder.path() / "plan.csv", world.robot, "later", other);
  ASSERT_EQ(measured.rows.size(), asked.rows.size());
  for (const Row& row : measured.rows) EXPECT_EQ(row.session, "later");
  EXPECT_LT((respond(world, measured, false).read - respond(world, asked, false).read)
                .cwiseAbs()
                .maxCoeff(),
            1e-12);
}

// Poses see a thousandth of a degree.
TEST(TwinCases, AReadingSaysThePostureInWhichItWasTaken) {
  const kinetostat::test::TemporaryFolder folder;
  const Case c = first_with("bench_single_friction_d5");
  write_case(c, folder.path() / "first", folder.path() / "truth.json");
  write_text(folder.path() / "plan.csv",
             "id,session,cycle,step,time,q1,fx,fy,fz\np1-1,planned,p1,1,30,-7.91754545,0,0,0\n");
  write_follow_up(c, {5}, {.from = folder.path() / "first", .table = folder.path() / "plan.csv"},
                  folder.path() / "next");
  EXPECT_NE(content(folder.path() / "next" / "readings.csv").find(",-7.91754545,"),
            std::string::npos);
}

TEST(TwinCases, WhatIsMeasuredNextStandsBehindTheRest) {
  const kinetostat::test::TemporaryFolder folder;
  const Case c = first_with("bench_single_friction_d5");
  const auto first = folder.path() / "first";
  write_case(c, first, folder.path() / "truth.json");
  write_text(folder.path() / "plan.csv",
             "id,session,cycle,step,time,q1,fx,fy,fz\np1-1,planned,p1,1,30,0,0,0,0\n"
             "p1-2,planned,p1,2,60,0,0,0,50\n");
  const auto measured = [&](double size, const char* name) {
    write_follow_up(c, {size}, {.from = first, .table = folder.path() / "plan.csv"},
                    folder.path() / name);
    return content(folder.path() / name / "readings.csv");
  };
  const std::string before = content(first / "readings.csv"), after = measured(5, "a");
  ASSERT_TRUE(after.starts_with(before));
  const std::string added = after.substr(before.size());
  EXPECT_EQ(std::count(added.begin(), added.end(), '\n'), 2) << added;
  EXPECT_EQ(content(folder.path() / "a" / "campaign.yaml"), content(first / "campaign.yaml"));
  EXPECT_EQ(measured(5, "b"), after);
  EXPECT_NE(measured(10, "c"), after);
}

// Poses have a frame and a weight that differences do not have; weights have no load cell.
TEST(TwinCases, PosesAfterDifferencesAreACampaignOfTheirOwn) {
  const kinetostat::test::TemporaryFolder folder;
  const Case c = first_with("bench_single_friction_d5");
  const auto first = folder.path() / "first";
  write_case(c, first, folder.path() / "truth.json");
  write_text(folder.path() / "plan.csv",
             "id,session,cycle,step,time,q1,fx,fy,fz\np1-1,planned,p1,1,30,0,0,0,0\n");
  FollowUp next{
      .from = first, .table = folder.path() / "plan.csv", .absolute = true, .known_loads = true};
  write_follow_up(c, {5}, next, folder.path() / "a");
  const std::string campaign = content(folder.path() / "a" / "campaign.yaml");
  EXPECT_NE(campaign.find("displacement: absolute\nsession_frame: estimate"), std::string::npos);
  EXPECT_NE(campaign.find("known_loads: [planned1]"), std::string::npos);
  const std::string alone = content(folder.path() / "a" / "readings.csv");
  EXPECT_EQ(std::count(alone.begin(), alone.end(), '\n'), 2) << alone;
  next.from = folder.path() / "a";
  next.number = 2;
  write_follow_up(c, {5}, next, folder.path() / "b");
  EXPECT_TRUE(content(folder.path() / "b" / "readings.csv").starts_with(alone));
  EXPECT_NE(content(folder.path() / "b" / "campaign.yaml").find("[planned2, planned1]"),
            std::string::npos);
}

TEST(TwinCases, KnownWeightsHaveNoLoadCell) {
  const World world{.robot = arm_3r(), .factors = {}, .effects = {{"wrench_gain", "load", 0.1}}};
  Row row;
  row.force = {0, 0, -100};
  Row weighed = row;
  weighed.weighed = true;
  const Mark platform{};
  EXPECT_NEAR(actual_load(world.effects, row, platform).force.z(), -110, 1e-12);
  EXPECT_EQ(actual_load(world.effects, weighed, platform).force.z(), -100);
}

TEST(TwinCases, NothingLooksLikeNothing) {
  EXPECT_THROW(confuser_in(first_with("bench_clean"), 1), std::invalid_argument);
}

TEST(TwinCases, NobodyCanHideWhatNobodyKnows) {
  EXPECT_THROW(usual_size(bench(), {"gremlins", "q1"}), std::invalid_argument);
}

}  // namespace
}  // namespace twin
