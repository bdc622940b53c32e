// What a campaign file says about its readings. Internal to this module.
#pragma once

#include <limits>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "kinetostat/calibration/campaign/campaign.h"
#include "kinetostat/calibration/campaign/column_names.h"
#include "kinetostat/calibration/sensors/weight.h"
#include "kinetostat/io/csv.h"

namespace kinetostat::calibration {

/// How exact an instrument is.
struct Instrument {
  /// Standard deviations [m; rad]; NaN where not stated.
  spatial::Vector6 sigma = spatial::Vector6::Constant(std::numeric_limits<double>::quiet_NaN());
  std::optional<spatial::Matrix6> correlation = {};
};

/// In what the wrenches of the readings are given.
struct WrenchFrame {
  bool on_platform = false;  // it turns with the posture; else it stands on the base
  spatial::Matrix3 axes = spatial::Matrix3::Identity();
  std::optional<spatial::Vector3> origin =
      {};  // point that wrenches are about, on the same body [m]
  std::optional<spatial::Vector3> point = {};  // the same on the platform, when stated on its own
};

/// How exact the stated wrenches are: standard deviation of each component, independent of all
/// others, in the axes and about the point that it is given in.
struct WrenchNoise {
  double force = 0, moment = 0;  // [N], [N m]
  double share = 0;              // of what the component reads; adds to the above in square

  bool is_stated() const { return force > 0 || moment > 0 || share > 0; }
};

/// Whose the columns x, y, z, roll, pitch, yaw are where drives have these names.
enum class PostureColumns { unstated, platform, joints };

/// What the campaign file says about its readings. `sensor_sigma`: standard deviations of what
/// `sensors:` describes, one entry a component of the campaign, NaN where not stated.
struct ReadingsContext {
  Eigen::VectorXd sensor_sigma = Eigen::VectorXd::Constant(6, not_a_number);
  std::vector<Weight> weights = {};
  std::vector<Cylinder> cylinders = {};
  std::vector<Torque> torques = {};
  std::map<std::string, Instrument> instruments = {};  // by name; "": where a reading names none
  WrenchFrame wrench = {};
  WrenchNoise wrench_noise = {};
  std::size_t controlled = 0;  // which of fx ... mz is read where Campaign::control is set
  std::map<std::string, Role> roles = {};  // of sessions
  PostureColumns posture = PostureColumns::unstated;
  std::map<std::string, StatedColumn> columns = {};  // `columns:`, by names in the header
  io::TableFormat table = {};                        // what `missing`, `decimal` and `sheet` say
  int units_line = 0;                                // of the campaign file
  bool angle_stated = false, time_stated = false;    // units that the campaign file names
};

/// A column of loads beside the wrench: what it is, what its name is, and what it is given in.
struct LoadColumn {
  const char* kind;  // "weight", "cylinder", "torque"
  std::string name;
  spatial::Dimension dimension;
};
/// Of weights, then of cylinders, then of torques.
std::vector<LoadColumn> load_columns(const ReadingsContext& context);

/// Reads a campaign file except for its readings: fills `campaign` as far as it says so. Throws
/// common::InputError.
ReadingsContext read_context(const std::filesystem::path& file, const vjm::Manipulator& manipulator,
                             Campaign& campaign);

/// Sets Reading::known_load in the sessions that the campaign file names under `known_loads`.
/// Throws common::InputError.
void read_known_loads(const std::filesystem::path& file, Campaign& campaign);

/// Symmetric with unit diagonal as given; positive definite?
bool is_correlation(const spatial::Matrix6& matrix);
/// Of one of role_names.
Role role_named(std::string_view name);

}  // namespace kinetostat::calibration
