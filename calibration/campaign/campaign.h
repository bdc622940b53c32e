// A measurement campaign: what was done to a robot, and what was read.
#pragma once

#include <array>
#include <filesystem>
#include <initializer_list>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "kinetostat/calibration/sensors/observation.h"
#include "kinetostat/calibration/sensors/sensor.h"
#include "kinetostat/spatial/pose.h"
#include "kinetostat/spatial/units.h"
#include "kinetostat/vjm/statics/equilibrium.h"

namespace kinetostat::calibration {

/// The six components of a displacement [translation; rotation vector].
inline constexpr std::array<const char*, 6> component_names = {"dx", "dy", "dz", "rx", "ry", "rz"};
inline constexpr bool is_rotation(Eigen::Index component) { return component >= 3; }

inline constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

/// One number that a reading may have.
struct Component {
  std::string name;              // its column: "dx"
  spatial::Dimension dimension;  // length, angle, force or moment
  std::size_t sensor = 0;        // in Campaign::sensors
  Eigen::Index axis = 0;         // of what the sensor sees, in the order of component_names

  bool operator==(const Component&) const = default;
};

/// Reference from which a displacement is counted.
enum class DisplacementKind {
  difference,  // the unloaded posture: gravity, geometry and thermal offsets cancel
  absolute     // the base frame: the pose of the platform itself
};

enum class ZeroReading {
  known,     // the readings are counted from the unloaded state
  estimated  // they are off by one unknown constant per session and component
};

enum class SessionFrame {
  known,     // displacements are given in the frame that the campaign states
  estimated  // each session was measured in an unknown rigid frame of its own
};

enum class TargetPose {
  known,     // what is measured of the platform is where the campaign states
  estimated  // it sits elsewhere on the platform, nobody knows where
};

enum class LoadDirection { unstated, loading, unloading };

/// Purpose of a reading: training (`fit`), validation (`select`) or test (`confirm`). Only readings
/// to fit by are fitted; the others are predicted.
enum class Role {
  fit,
  select,  // to choose between models
  confirm  // kept back until the model stands, to judge it
};
inline constexpr std::array<const char*, 3> role_names = {"fit", "select", "confirm"};

/// The command of the controller: a platform pose, or joint coordinates (home values where not
/// given).
struct Configuration {
  std::optional<spatial::Pose> target;   // base axes
  std::map<std::string, double> joints;  // "chain.joint" [m or rad]
};

/// One reading; one row of the table.
struct Reading {
  std::string id;
  int line = 0;             // in the file of readings
  std::size_t session = 0;  // in Campaign::sessions
  std::string cycle, setting, replicate;
  std::optional<double> step, time, temperature;  // [-], [s], [K]
  LoadDirection direction = LoadDirection::unstated;
  std::size_t configuration = 0;  // in Campaign::configurations
  vjm::Load load;
  bool known_load = false;  // by weights, not by what a load cell says
  /// One entry a component of the campaign, SI: what was read, NaN where nothing was, and the
  /// standard deviation of its noise, NaN where not stated.
  Eigen::VectorXd displacement = Eigen::VectorXd::Constant(6, not_a_number);
  Eigen::VectorXd sigma = displacement;
  /// Index into Campaign::correlations of the noise between components; none: independent.
  std::optional<std::size_t> correlation;
  Role role = Role::fit;
  std::string instrument;  // its name; empty: the one that the campaign has
  bool masked = false;     // kept and shown, but not used
  std::string mask_reason;

  bool uses(Eigen::Index component) const;  // measured and not masked
};

/// A test that sets a displacement and reads the force which that takes. Reading::load has the
/// force as it was read; what is set is no value to fit.
struct DisplacementControl {
  Eigen::Index set = 0, force = 0;  // components: what is set, and what the load cell reads
  std::vector<double> to;           // where it was set, one entry a reading [m or rad]
  std::vector<vjm::Load> beside;    // the loads without that force, one entry a reading
  /// The unit force [force; moment], base axes, about the point of the loads; one a configuration.
  std::vector<spatial::Vector6> along;

  /// The load of a reading in which this force acts.
  vjm::Load with_force(std::size_t reading, std::size_t configuration, double newtons) const;
};

/// Its components in use, ascending.
std::vector<Eigen::Index> components_in_use(const Reading& reading);
/// The same into a list that is kept.
void find_components_in_use(const Reading& reading, std::vector<Eigen::Index>& used);

/// A column that the format does not know, kept as it stands, one text a reading.
struct Covariate {
  std::string name;
  std::vector<std::string> values;

  /// Of a reading; none where the cell is empty or holds anything but a finite number.
  std::optional<double> number(std::size_t reading) const;
  bool is_numeric() const;  // but for empty cells
};

/// Name of the coordinate of a joint in the table.
struct JointInTable {
  std::string column;
  bool turns = false;  // else it slides
  bool operator==(const JointInTable&) const = default;
};

/// The components of the platform's displacement: those of a campaign without further sensors.
std::vector<Component> platform_components();

/// When, by whom, with what and on which machine it was measured, as far as that is stated; texts
/// without line ends.
struct Occasion {
  std::string date;           // ISO 8601: "2026-03-01", "2026-03-01T14:22"
  std::string measured_by;    // `operator`
  std::string measured_with;  // `instrument`
  std::string serial;         // number of the machine

  /// Key of the campaign file and text, of those that are stated.
  std::vector<std::pair<std::string, std::string>> stated() const;
};

struct Campaign {
  std::filesystem::path file, readings_file;
  std::string name;
  Occasion occasion = {};
  std::optional<std::filesystem::path> robot;  // as named in the file, relative to its folder
  spatial::UnitSystem units;
  Observation observation;
  DisplacementKind displacement = DisplacementKind::difference;
  ZeroReading zero = ZeroReading::known;
  SessionFrame session_frame = SessionFrame::known;
  TargetPose target_pose = TargetPose::known;
  /// Cycles of a session go on where the one before ended; else each starts relaxed.
  bool history_continues = false;
  /// Every value that is used has a standard deviation, or none has.
  bool noise_stated = false;

  /// What is read: in what order a reading has it, by what sensor, and what those look at.
  std::vector<Component> components = platform_components();
  std::vector<Sensor> sensors = {Sensor()};
  vjm::Watch watch;
  std::vector<Reading> readings;              // in the order of the file
  std::vector<Configuration> configurations;  // the distinct ones
  std::vector<std::string> sessions;          // sorted; {""} when there is no such column
  std::vector<Covariate> covariates;
  std::map<std::string, JointInTable> joint_columns;  // by their whole names, "chain.joint"
  std::vector<Eigen::MatrixXd> correlations;          // the distinct ones; positive definite
  /// Covariance of the noise of each reading's wrench [force; moment], base axes, about its point
  /// [N, N m]; empty: wrenches are taken to be exact.
  std::vector<spatial::Matrix6> wrench_covariance;
  std::optional<DisplacementControl> control = {};  // unset: loads are what is set
  /// Standard deviation of the unloaded readings that differences are counted from, one entry a
  /// component; of poses, of where the drives stop (repeatability). NaN: not stated.
  Eigen::VectorXd datum_noise = Eigen::VectorXd::Constant(6, not_a_number);
  std::vector<std::string> notes;     // what was assumed, in sentences
  std::vector<std::string> warnings;  // those of them that may well have been meant otherwise

  Eigen::Index size() const { return std::ssize(components); }  // of every reading
  const Component& component(Eigen::Index k) const {
    return components[static_cast<std::size_t>(k)];
  }
  /// Whether the pose of the platform, as `observation` has it, is among what is read; it is the
  /// first sensor then.
  bool reads_platform() const { return !sensors.empty() && sensors.front().is_platform(); }
  /// Whether it is unknown where that sits which a sensor looks at.
  bool estimates_target(std::size_t sensor) const {
    return sensors[sensor].is_platform() ? target_pose == TargetPose::estimated
                                         : sensors[sensor].target_estimated;
  }
  bool is_of_platform(Eigen::Index k) const { return reads_platform() && component(k).sensor == 0; }
  /// The unit in which its people write a component: "um".
  std::string unit_of(Eigen::Index component) const;
};

/// Takes the platform out of what is read: sensors, components and datum noise.
void leave_out_platform(Campaign& campaign);

/// Components that errors of one kind are in: the translations of one sensor, its rotations.
std::vector<std::vector<Eigen::Index>> component_kinds(const Campaign& campaign);

/// One measured number: a component of a reading in use.
struct Value {
  std::size_t reading = 0;
  Eigen::Index component = 0;
};

/// All of them, in the order of the readings.
std::vector<Value> values_in_use(const Campaign& campaign);

/// Of each of so many readings, which of these values is its first; 0 where it has none.
std::vector<std::size_t> first_values(const std::vector<Value>& values, std::size_t readings);

/// Whether any reading has this role.
bool has_role(const Campaign& campaign, Role role);
/// The campaign with every reading masked that has another role than these.
Campaign only(Campaign campaign, std::initializer_list<Role> roles);

}  // namespace kinetostat::calibration
