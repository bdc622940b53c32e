// Synthetic readings of a plan: what an instrument with a known noise would read if the model were
// right.
#pragma once

#include <cstdint>

#include "kinetostat/calibration/campaign/campaign.h"
#include "kinetostat/common/progress.h"
#include "kinetostat/vjm/io/robot_file.h"

namespace kinetostat::calibration {

struct SimulationOptions {
  DisplacementKind displacement = DisplacementKind::difference;
  /// Standard deviation of every translation [m] and rotation [rad]; 0: exact.
  double translation_noise = 0, rotation_noise = 0;
  /// Standard deviation of every force [N] and moment [N m] of the plan, and as a share of it: the
  /// robot feels another wrench than is written down.
  double force_noise = 0, moment_noise = 0, wrench_share = 0;
  /// Which components are written, in the order of component_names.
  std::array<bool, 6> components = {true, true, true, true, true, true};
  std::uint64_t seed = 1;
  int threads = 1;
  /// Effects that act beside those of the robot file, and that the campaign does not mention.
  std::vector<vjm::Effect> hidden = {};
};

/// Change by hidden effects of one component that is written, SI.
struct HiddenTrace {
  Component component;
  std::string unit;  // in which its people write it
  double rms = 0, max = 0;
  std::string worst_reading = {};  // its id
};

/// A campaign as two files.
struct SimulatedCampaign {
  std::string yaml;                     // refers to readings.csv beside it
  std::string readings;                 // the plan with columns of displacement
  std::vector<std::string> warnings;    // columns of the plan that may be meant otherwise
  std::vector<HiddenTrace> trace = {};  // one a component; empty without hidden effects
  /// Norm of their change of all readings in units of the noise, the d' of diagnosis; where there
  /// is noise.
  std::optional<double> detectability = {};
};

/// What a robot reads in a campaign with effects beside its own [SI], one entry a reading. Throws
/// common::NoConvergence where there is no equilibrium.
std::vector<Eigen::VectorXd> predicted_readings(const vjm::Robot& robot,
                                                const std::vector<vjm::Effect>& more,
                                                const Campaign& campaign, int threads,
                                                common::Progress& progress);

/// `plan` is a table of readings without displacements (docs/reference/campaign-file.md), in the
/// units of the robot file; wrenches without a point act at the platform's reference point.
/// `robot_name`: how the campaign file shall call the robot file. Gaussian noise by Box and Muller
/// from the 64-bit Mersenne twister: the same for any number of threads. Throws common::InputError
/// for a mistake in the plan, common::NoConvergence where there is no equilibrium.
SimulatedCampaign simulate(const vjm::Robot& robot, const std::string& robot_name,
                           const std::filesystem::path& plan, const SimulationOptions& options,
                           common::Progress& progress);

/// The same like the readings of a campaign file: its sensors, weights, frames, units and noise (of
/// `options` seed, threads and hidden effects count), in the rows of its own table or of `plan`,
/// which has its columns without the readings, in the units of the robot file. Cells that hold no
/// reading stay as they are. Throws common::InputError for a mistake in the campaign as well.
SimulatedCampaign simulate_like(const vjm::Robot& robot, const std::string& robot_name,
                                const std::filesystem::path& campaign,
                                const std::optional<std::filesystem::path>& plan,
                                const SimulationOptions& options, common::Progress& progress);

}  // namespace kinetostat::calibration
