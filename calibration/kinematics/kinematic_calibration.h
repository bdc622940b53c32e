// Kinematic calibration: the geometry of a robot from readings of its pose.
#pragma once

#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "kinetostat/calibration/kinematics/geometric_parameter.h"
#include "kinetostat/calibration/kinematics/identifiable.h"
#include "kinetostat/calibration/kinematics/pose_error.h"
#include "kinetostat/calibration/regression/base_fit.h"
#include "kinetostat/common/progress.h"
#include "kinetostat/vjm/io/robot_file.h"

namespace kinetostat::calibration {

struct KinematicOptions {
  /// In so many parts poses are held out in turn; 0: none are. At most one part a pose.
  int folds = 10;
  /// Standard tolerances; not positive: a thousandth of the reach, a milliradian.
  Tolerance tolerance = {};
  /// Each parameter is known to its tolerance beside the readings (ridge regression).
  bool prior = false;
  Loss loss = Loss::squares;
};

/// A model that was fitted, and how far it is off.
struct KinematicStage {
  std::string name;  // "nominal", "uncertain values", "base and tool", "joint offsets", "links",
                     // "drives"
  Eigen::Index fitted = 0;            // parameters, without frames and zero offsets
  PoseError at_fitted;                // on the readings that it was fitted to
  std::optional<PoseError> held_out;  // on poses that were left out in turn, if any
};

/// A geometric parameter with its value [m, rad or 1].
struct CalibratedGeometry {
  GeometricParameter what;
  double before = 0;  // in the robot file
  double value = 0, deviation = 0;

  /// Its change is larger than two standard deviations.
  bool is_significant() const { return std::abs(value - before) > 2 * deviation; }
};

/// Why a parameter stays as the robot file has it.
enum class LeftOut {
  redundant,   // by the kinematics: no pose whatever distinguishes it from others
  confounded,  // with others, in these readings
  unseen,      // no reading depends on it to speak of
  unneeded,    // the poses that were held out are predicted no better with its group
  too_many     // for so few readings
};

struct LeftOutGeometry {
  GeometricParameter what;
  LeftOut why = LeftOut::redundant;
  std::vector<std::string> like;  // phrases: what it cannot be distinguished from
};

struct KinematicCalibration {
  std::vector<KinematicStage> stages;  // each with all of those before it
  std::size_t taken = 0;               // the last that lowers the held-out error
  bool is_judged = true;               // on poses that were held out

  std::vector<CalibratedGeometry> geometry;  // of the stage taken
  std::vector<ParameterEstimate> others;     // fitted beside it: uncertain stiffnesses, values
  std::vector<std::string> others_kept;      // that stay as the file has them, in sentences
  std::vector<LeftOutGeometry> left_out;
  Eigen::MatrixXd correlation;         // of `geometry`, then `others`
  std::vector<std::string> weak;       // combinations that are known poorly
  ObservabilityIndices observability;  // of `geometry` and `others`
  Tolerance tolerance;
  double reach = 0;  // [m]

  Eigen::Index values = 0, poses = 0, readings = 0;
  NoiseSource noise_source = NoiseSource::unknown;
  /// What the fit leaves, in units of the noise (robustly for a robust loss); where it is above 1
  /// the standard deviations are as many times larger (Birge's ratio). With an unknown noise [m or
  /// rad].
  double residual_ratio = 1;
  std::optional<PoseError> confirmed_before, confirmed;  // readings that are kept to confirm
  /// Of the stage taken: all effects with the values found, and their deviations.
  std::vector<vjm::Effect> effects;
  std::size_t own_effects = 0;  // how many of them, the first, the robot file has already

  /// Number of the stage before calibration: with base and tool, which no robot file knows.
  std::size_t before_stage() const;
  const KinematicStage& before() const { return stages[before_stage()]; }
  const KinematicStage& after() const { return stages[taken]; }
  Eigen::Index count(LeftOut why) const;
};

/// Fits the geometry of a robot, and what its file declares uncertain beside it:
///
/// 1. candidate parameters (geometric_parameter.h), their derivatives exact;
/// 2. those that no pose distinguishes are left out, by the derivatives of whole poses at random
///    postures of a serial robot (at those of the campaign otherwise), then those that these
///    readings do not determine to their tolerance (identifiable.h), what the fit leaves counted as
///    noise where it is larger;
/// 3. what the file declares uncertain, with base and tool, with joint offsets, with link geometry,
///    with the ratios of drives are fitted (fit_base), each also without every part of the poses in
///    turn, which it then predicts; the last stage is taken whose error there is lower than that of
///    the one taken before, beyond two standard errors of their difference pose by pose.
///
/// Readings of other roles than fit are not fitted. Throws what Predictor and fit_base throw, and
/// common::NotIdentifiable where readings determine no geometric parameter: with what would.
KinematicCalibration calibrate_kinematics(const vjm::Robot& robot, const Campaign& campaign,
                                          const KinematicOptions& options, int threads,
                                          common::Progress& progress);

}  // namespace kinetostat::calibration
