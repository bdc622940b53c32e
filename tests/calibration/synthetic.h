// Campaigns made for a test: written as files, as a user would, in any units.
#pragma once

#include <cmath>
#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "kinetostat/calibration/campaign/campaign_file.h"
#include "kinetostat/calibration/comparison/compare.h"
#include "kinetostat/io/text_file.h"
#include "kinetostat/spatial/rotation.h"
#include "kinetostat/vjm/chain/chain_builder.h"
#include "kinetostat/vjm/manipulator/posture.h"

#include "support/random.h"
#include "support/temporary_folder.h"

namespace kinetostat::calibration::test {

/// Writes campaign.yaml and readings.csv; returns the former.
inline std::filesystem::path write_campaign(const std::string& yaml, const std::string& csv) {
  static const kinetostat::test::TemporaryFolder temporary;
  static int count = 0;
  const std::filesystem::path folder = temporary.path() / std::to_string(++count);
  io::write_atomically(folder / "readings.csv", csv);
  io::write_atomically(folder / "campaign.yaml", yaml);
  return folder / "campaign.yaml";
}

/// One spring along z, stiffness 1e6 N/m, declared uncertain.
inline vjm::Robot bench(double stiffness = 1e6) {
  vjm::ChainBuilder chain("cell");
  chain.actuator("spring", vjm::Motion::tz, stiffness);
  vjm::Robot robot{.file = "bench.yaml",
                   .name = "bench",
                   .units = {},
                   .manipulator = vjm::Manipulator("bench", {chain.build()}),
                   .uncertain = {{"spring", {{0, "spring"}}}},
                   .link_files = {}};
  return robot;
}

/// The shipped Orthoglide with the legs and the actuator x uncertain.
inline vjm::Robot orthoglide() {
  vjm::Robot robot =
      vjm::read_robot(std::string(KINETOSTAT_SOURCE_DIR) + "/data/robots/orthoglide.yaml");
  robot.uncertain = {{"leg", {{0, "leg"}, {1, "leg"}, {2, "leg"}}}, {"x.rho", {{0, "rho"}}}};
  return robot;
}

/// The robot with its uncertain stiffnesses multiplied.
inline vjm::Robot scaled(vjm::Robot robot, const std::vector<double>& factors) {
  for (std::size_t i = 0; i < factors.size(); ++i)
    robot.manipulator = vjm::with_scaled(robot.manipulator, robot.uncertain[i], factors[i]);
  return robot;
}

/// One planned reading, SI.
struct Planned {
  spatial::Vector3 position = spatial::Vector3::Zero();
  vjm::Load load;
  spatial::Vector6 displacement = spatial::Vector6::Zero();  // filled by measure()
};

/// Random loads in random poses of the Orthoglide's workspace.
inline std::vector<Planned> orthoglide_plan(int poses, int loads, unsigned seed) {
  kinetostat::test::Random random(seed);
  std::vector<Planned> plan;
  for (int p = 0; p < poses; ++p) {
    const spatial::Vector3 position = random.vector(0.06);
    for (int l = 0; l < loads; ++l)
      plan.push_back({.position = position,
                      .load = {random.vector(300), random.vector(20), random.vector(0.05)}});
  }
  return plan;
}

/// Reading of an ideal instrument: the change of the platform pose from the unloaded posture.
inline void measure(const vjm::Manipulator& manipulator, std::vector<Planned>& plan) {
  for (Planned& reading : plan) {
    const vjm::PostureResult start =
        vjm::posture_at(manipulator, spatial::Pose::translation(reading.position));
    ASSERT_TRUE(start.reached) << start.reason;
    const vjm::Equilibrium e =
        vjm::equilibrium_under_load(manipulator, start.posture, reading.load);
    ASSERT_EQ(e.status, vjm::EquilibriumStatus::converged) << e.reason;
    reading.displacement = e.displacement.coordinates();
  }
}

/// How a campaign is written down.
struct Writing {
  std::string length = "mm", force = "N", angle = "deg";
  std::string more = "";                // further lines of the campaign file
  std::vector<std::size_t> order = {};  // of the rows; as planned when empty
  std::size_t cycle = 0;   // readings of one load cycle, in the order of the plan; 0: no cycles
  bool with_point = true;  // columns px, py, pz
};

inline std::filesystem::path write(const std::vector<Planned>& plan, const Writing& writing) {
  const double l = spatial::parse_unit(writing.length).factor;
  const double f = spatial::parse_unit(writing.force).factor;
  const double a = spatial::parse_unit(writing.angle).factor;
  std::string csv = "id,x,y,z,fx,fy,fz,mx,my,mz";
  if (writing.with_point) csv += ",px,py,pz";
  csv += ",dx,dy,dz,rx,ry,rz";
  if (writing.cycle > 0) csv += ",cycle,step";
  csv += "\n";
  for (std::size_t row = 0; row < plan.size(); ++row) {
    const std::size_t i = writing.order.empty() ? row : writing.order[row];
    const Planned& r = plan[i];
    csv += fmt::format("r{}", i);
    const auto add = [&csv](const spatial::Vector3& v, double unit) {
      for (const double x : v) csv += fmt::format(",{}", x / unit);
    };
    add(r.position, l);
    add(r.load.force, f);
    add(r.load.moment, f * l);
    if (writing.with_point) add(r.load.point_on_platform, l);
    add(r.displacement.head<3>(), l);
    add(r.displacement.tail<3>(), a);
    if (writing.cycle > 0) csv += fmt::format(",c{},{}", i / writing.cycle, i % writing.cycle);
    csv += "\n";
  }
  return write_campaign(
      fmt::format("kinetostat: 1\ncampaign: synthetic\nunits: {{length: {}, force: {}, angle: "
                  "{}}}\ndisplacement: difference\nreadings: readings.csv\n{}",
                  writing.length, writing.force, writing.angle, writing.more),
      csv);
}

inline Comparison compare_files(const vjm::Robot& robot, const std::filesystem::path& campaign,
                                int threads = 1) {
  common::Progress silent;
  return compare(robot, read_campaign(campaign, robot.manipulator), threads, silent);
}

}  // namespace kinetostat::calibration::test
