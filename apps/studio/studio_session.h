// A session of the studio: effects are added to a model, fitted with everything that is uncertain,
// and saved.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "kinetostat/calibration/search/candidate_fitter.h"
#include "kinetostat/io/json.h"
#include "kinetostat/vjm/io/robot_file.h"

namespace kinetostat::apps {

/// A robot and a campaign, and the models of them that were tried. Not for several threads at once.
/// Mistakes of the other side end in common::InputError. A request names a model by
/// {"effects": ["clearance at x.rho"]}, of which each is one of opening()["effects"].
class StudioSession {
 public:
  /// Throws what the comparison throws, and common::InputError when nobody knows the noise.
  StudioSession(vjm::Robot robot, calibration::Campaign campaign, std::filesystem::path folder,
                int threads, common::Progress& progress);
  StudioSession(const StudioSession&) = delete;
  StudioSession& operator=(const StudioSession&) = delete;

  const vjm::Robot& robot() const { return robot_; }
  const calibration::Campaign& campaign() const { return campaign_; }
  const std::filesystem::path& folder() const { return folder_; }

  /// The comparison, its readings, the cards of the models without anything added ("nominal" and
  /// "fitted"), and every effect that can be added: its law in words and as a formula, its usual
  /// size in these readings, and the joints where it would act.
  const io::Json& opening() const { return opening_; }

  /// Fits a model: {"card", "model"}, the residuals at the best values, and the card of the model:
  /// values, rms error in units of the noise, degrees of freedom, and the probability against the
  /// same model without the last effect, the two alone and alike beforehand. Throws
  /// common::Cancelled.
  io::Json fit(const io::Json& request, common::Progress& progress);
  /// A fitted model with other "values" of its effects, a list for each, everything else as it was
  /// fitted: {"error", "model"}.
  io::Json try_values(const io::Json& request, common::Progress& progress) const;
  /// The robot of a model in the posture number "pose" of the campaign, unloaded and under the
  /// largest force that it was read under there: {"skeletons", "load"}; null where it has no
  /// equilibrium.
  io::Json posture(const io::Json& request) const;
  /// A fitted model, into the robot file "file" in the folder. A name is a plain file name that
  /// ends with .yaml; a file that is there already and is not of this session is left alone, and
  /// an effect of size zero is not saved.
  io::Json save(const io::Json& request);

 private:
  struct Model {
    std::vector<calibration::Candidate> effects;  // with the values and deviations of the fit
    calibration::BaseFit fit;
  };
  struct Trial {
    Model model;
    bool is_settled = false;
    std::string failure = {};
  };

  std::vector<std::string> names_in(const io::Json& request) const;
  const calibration::Candidate& candidate(const std::string& name) const;
  const Model& fitted_model(const io::Json& request) const;
  const Model& model(const std::vector<std::string>& names, common::Progress& progress);
  std::vector<calibration::Candidate> starts_of(const Model& before,
                                                const calibration::Candidate& added,
                                                std::size_t most, common::Progress& progress) const;
  void fit_further(std::vector<Trial>& trials, int evaluations, common::Progress& progress) const;
  Model with(const Model& before, const calibration::Candidate& added,
             common::Progress& progress) const;
  vjm::Manipulator manipulator_of(const Model& model) const;
  io::Json card(const std::vector<std::string>& names, const Model& model) const;
  io::Json effect_json(const calibration::Candidate& candidate) const;
  io::Json residuals(const std::string& name, const calibration::BaseFit& fit) const;

  vjm::Robot robot_;
  calibration::Campaign campaign_, training_;  // all readings, and those to fit by
  calibration::Noise noise_;
  std::filesystem::path folder_;
  int threads_;
  std::vector<calibration::Candidate> candidates_;
  std::optional<calibration::CandidateFitter> fitter_;
  std::map<std::vector<std::string>, Model> models_;
  io::Json opening_;
  std::vector<std::string> saved_;
};

}  // namespace kinetostat::apps
