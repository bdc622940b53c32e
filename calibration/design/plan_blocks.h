// Load cycles that could be measured next: reachable postures, directions of load, and histories.
#pragma once

#include <array>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "kinetostat/calibration/campaign/campaign.h"
#include "kinetostat/common/progress.h"
#include "kinetostat/vjm/io/robot_file.h"

namespace kinetostat::calibration {

/// Cost of measuring [min], and the loads that the robot may bear.
struct MeasuringOptions {
  double minutes_per_pose = 5, minutes_per_load = 1, minutes_per_reading = 0.5;
  double hold = 10;  // how long a load is held where time matters [min]
  /// Largest force [N] and moment [N m]; 0: the largest of the campaign.
  double most_force = 0, most_moment = 0;
  /// The robot must stand, and be stable, under so many times the load.
  double margin = 1.5;
  /// How far coordinates may go, where not as far as in the campaign: "chain.joint" [m or rad], or
  /// x, y, z of the platform [m].
  std::map<std::string, std::array<double, 2>> within = {};
};

/// One reading of a cycle: its share of the largest load, and how long the load has been held.
struct CycleStep {
  double level = 0;
  double held = 0;  // [min]
};

/// How a load comes and goes.
struct LoadPattern {
  std::string name;  // "up and down"
  std::vector<CycleStep> steps;

  bool takes_back() const;  // some of the load
  bool reverses() const;    // pulls where it pushed
};

/// One load cycle, or one reading without load.
struct PlanBlock {
  std::size_t configuration = 0;         // in the planned campaign
  spatial::Vector6 load;                 // the largest: [N; N m] about the campaign's point
  std::string direction;                 // "+fx"; empty without load
  const LoadPattern* pattern = nullptr;  // of load_patterns()
  double minutes = 0;                    // without the change of posture

  /// How large it is [N or N m].
  double level() const {
    return load.head<3>().isZero(0) ? load.tail<3>().norm() : load.head<3>().norm();
  }
};

/// "up", "up and down", "reversed", "small and reversed", "held", "without load".
const std::vector<LoadPattern>& load_patterns();

/// Postures beyond those of a campaign.
struct PlanPlaces {
  std::vector<spatial::Pose> work_at = {};  // where the model is used
  std::vector<std::string> joints = {};     // "chain.joint": turned alone, through their ranges
};

/// Everything that may be measured.
struct PlanChoices {
  std::vector<Configuration> configurations;
  std::vector<PlanBlock> blocks;
  std::vector<std::string> left_out;  // what the robot cannot bear or reach, in sentences
};

/// Postures of the campaign and others between and about them (where the model is used, too, if the
/// campaign gives its postures as poses; else joints of `places` turned alone, which are read
/// without load); forces along the base axes, and moments where the campaign has
/// any, at the point where most of its loads act; all patterns. Postures that are out of reach and
/// loads that the robot cannot bear with the margin are left out.
PlanChoices plan_choices(const vjm::Robot& robot, const Campaign& campaign,
                         const PlanPlaces& places, const MeasuringOptions& options, int threads,
                         common::Progress& progress);

/// The readings of blocks in their order, one cycle each, in one session, with the time that each
/// takes. They measure `components`, with `sigma`. `each_at` [min]: blocks after the first are not
/// taken one after the other but each at that time, as choices among which some will be taken.
Campaign planned_readings(const Campaign& like, DisplacementKind displacement,
                          const std::vector<Configuration>& configurations,
                          const std::vector<PlanBlock>& blocks,
                          const std::vector<Eigen::Index>& components, const Eigen::VectorXd& sigma,
                          const MeasuringOptions& options, std::optional<double> each_at = {});

}  // namespace kinetostat::calibration
