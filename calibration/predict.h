// What a model says that each reading of a campaign should be.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "kinetostat/calibration/campaign.h"
#include "kinetostat/calibration/parameter.h"
#include "kinetostat/files/progress.h"
#include "kinetostat/vjm/posture.h"

namespace kinetostat::calibration {

/// A reading of which the model has no prediction.
struct PredictionFailure {
  std::size_t reading = 0;
  std::string reason;
};

/// One entry a reading, in the order of the campaign.
struct Predictions {
  /// Displacement of the platform's reference point [m; rad], in the sense of the campaign: change
  /// from the state without load (weight, preloads and geometric errors act in both), or position
  /// and rotation vector of the pose. Of the equivalent rotation vectors the one nearest to the
  /// measured. NaN for a masked reading that fails.
  std::vector<spatial::Vector6> displacement;
  /// Its derivatives with respect to the parameters; empty when not asked for.
  std::vector<Eigen::Matrix<double, 6, Eigen::Dynamic>> derivatives;
  /// The first reading in use that fails, if one does; the rest is then not to be used.
  std::optional<PredictionFailure> failure;
};

/// The full nonlinear model: unloaded posture by kinematics, then loaded equilibrium. Postures are
/// found once per distinct configuration, equilibria once per distinct load in it.
class Predictor {
 public:
  /// Finds the unloaded postures. Throws files::InputError naming the line of the first reading in
  /// use whose pose is out of reach. Keeps references to both arguments.
  Predictor(const vjm::Manipulator& manipulator, const Campaign& campaign, int threads,
            files::Progress& progress);

  /// For the manipulator with its parameters at `values`.
  Predictions predict(const std::vector<Parameter>& parameters, const Eigen::VectorXd& values,
                      bool with_derivatives, files::Progress& progress) const;

 private:
  // What several readings may share.
  struct LoadCase {
    std::size_t configuration = 0;
    vjm::Load load;
  };
  struct CaseResult;

  void find_postures(files::Progress& progress);
  void find_cases();
  CaseResult solve(const vjm::Manipulator& manipulator, const LoadCase& load_case,
                   const std::vector<Parameter>& parameters, bool with_derivatives) const;
  std::vector<CaseResult> references(const vjm::Manipulator& manipulator,
                                     const std::vector<Parameter>& parameters,
                                     bool with_derivatives, files::Progress& progress) const;
  void observe(spatial::Pose& pose, Eigen::Matrix<double, 6, Eigen::Dynamic>& derivatives) const;
  void subtract(const CaseResult& from, CaseResult& to) const;
  void enter(const CaseResult& result, const Reading& reading, std::size_t index,
             Predictions& predictions) const;

  const vjm::Manipulator& manipulator_;
  const Campaign& campaign_;
  int threads_;
  std::vector<vjm::PostureResult> postures_;  // one a configuration
  std::vector<LoadCase> cases_;
  std::vector<std::size_t> case_of_reading_;
};

/// The rotation vector that stands for the same rotation as `vector` and is nearest to `measured`
/// in those components that are not NaN.
spatial::Vector3 nearest_rotation_vector(const spatial::Vector3& vector,
                                         const spatial::Vector3& measured);

}  // namespace kinetostat::calibration
