// Which physical effect is missing from a model?
#pragma once

#include <string>
#include <vector>

#include "kinetostat/calibration/goodness_of_fit.h"
#include "kinetostat/calibration/profile.h"
#include "kinetostat/calibration/search.h"
#include "kinetostat/calibration/structure.h"
#include "kinetostat/calibration/waterfall.h"

namespace kinetostat::calibration {

enum class Verdict { no_effect_needed, named_effect, ambiguous, none_of_the_above, cannot_tell };
std::string to_string(Verdict verdict);

/// An effect that was found.
struct FoundEffect {
  Candidate candidate;  // with the fitted values
  Eigen::VectorXd deviations;
  double probability = 0;  // among the rivals, beside the other effects that were found
  double gate_p_value = 1;
  std::vector<std::string> instead = {};  // what it may be instead
};

struct Diagnosis {
  Verdict verdict = Verdict::cannot_tell;
  std::vector<FoundEffect> found;      // in the order of their finding
  std::vector<std::string> ambiguous;  // where one may be something else: itself, then the others
  std::vector<std::string> missing;    // what readings would have to have, in sentences
  std::vector<std::string> set_aside;  // readings that no candidate explains, with reasons
  std::vector<DiagnosisStep> steps;
  std::vector<std::string> weak;  // combinations that the base fit hardly knows
  NoiseSource noise = NoiseSource::unknown;
  std::optional<ChiSquareTest> before, after;  // of the base fit, and with what was found
  StructureTest structure;                     // of what is left at the end
  std::vector<WaterfallStage> waterfall;
  std::string held_out;  // what was left out together: "configurations"
  std::vector<Profile> profiles;
};

/// Refits what is uncertain under every rival, screens all candidates with score tests, passes a
/// gate that knows how many were tried, fits what survives with the full model, ranks by evidence,
/// and names an effect only when the readings tell it from every rival. `robot` and `campaign` as
/// read. Throws what fit_base() throws for the model as it stands.
Diagnosis diagnose(const vjm::Robot& robot, const Campaign& campaign,
                   const DiagnosisOptions& options, int threads, files::Progress& progress);

}  // namespace kinetostat::calibration
