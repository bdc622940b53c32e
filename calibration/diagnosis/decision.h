// From the fitted candidates of one round to what can be said of them: class, places, law.
#pragma once

#include <string>
#include <vector>

#include "kinetostat/calibration/search/ranking.h"

namespace kinetostat::calibration {

/// The numbers that a decision rests on.
struct DecisionRules {
  double level = 0.95;  // probability that an answer must have, alone or as a list
  /// Power-posterior exponent: the weight of a model is exp(exponent * log evidence).
  double exponent = learning_rate;
  /// Prior odds of "nothing is missing" over one kind of effect: as many as there are kinds.
  double odds_of_nothing = 44;
  /// d' below which two places of a class make the same predictions in these readings.
  double same_place = 2;
  std::size_t most_answers = 5;  // a list of more is none
  /// How many times as probable as any answer "nothing is missing" must be to be the verdict.
  double lead_of_nothing = 1;
};

/// A rule as the theory page shows it: where its value comes from, and what it decides.
struct DescribedRule {
  std::string name;
  double value = 0;
  std::string unit, source, sensitivity;  // the last: when it is halved or doubled
};
std::vector<DescribedRule> described(const DecisionRules& rules = {});

/// A law within an answer, with its share of the answer's probability.
struct LawShare {
  std::size_t candidate = 0;  // in the ranking
  std::string effect, at;     // "clearance", "x.rho"
  double share = 0;
  bool is_at_limit = false;  // its fit ends at a bound, and so counts for another class
};

/// One thing that may be missing: an effect class at one place, or at several that these readings
/// do not distinguish.
struct Answer {
  std::string effect_class;  // "backlash", "backlash, or stiffens or softens under load"
  /// Of several classes that move the platform alike, whatever is read there: see moves_like.
  bool is_inseparable = false;
  std::vector<std::string> places = {};  // the most probable first
  std::vector<LawShare> laws = {};       // the most probable first
  double probability = 0;
};

/// What the evidence of one round supports.
struct Decision {
  std::vector<Answer> answers = {};  // most probable first, until they hold DecisionRules::level
  double nothing = 0;                // posterior probability that nothing is missing
  double unexplained = 0;            // ... that something is that the catalogue lacks
  std::string depends_on = {};       // what that would depend on
  bool is_identified = false;        // one answer holds the level
  bool is_narrowed_down = false;     // a short list does
  bool is_none_needed = false;       // "nothing is missing" is the most probable answer of all
};

/// The class that readings of the platform show.
inline vjm::EffectClass shown_class(const vjm::EffectKind& kind) {
  return kind.moves_like.value_or(kind.effect_class);
}

/// Kinds that a decision counts together: backlash and stiffening are laws of one curve of load
/// over deflection, else those of a class.
std::string family_of(const vjm::EffectKind& kind);

/// Adds up posterior probabilities over laws and over places. With evidence Z_i of candidate i,
/// which includes its prior, the weights are w_i = Z_i^exponent; "nothing" has (odds_of_nothing
/// Z_0) ^exponent with the evidence Z_0 of the model as it is, and the smooth model discrepancy its
/// own. The discrepancy counts for the drive whose load-deflection law it is, for creep where it is
/// a memory of earlier loads, for the best of time or of temperature where it depends on these, as
/// long as a law there explains something by itself, and as unexplained otherwise. Kinds of one
/// family_of() are counted together; the answer names the class that holds the level. A law whose
/// size ends at a bound of its range stands for a relative: it counts for the class of the best law
/// of the answer that has another class and ends at none. With the best go laws of other classes
/// that in principle move the platform as it does (EffectKind::moves_like) and that these readings
/// do not distinguish from it. Candidates that were not fitted because they do what the best does
/// count as it does, less what their signatures cannot explain of that. A pure function of the
/// round: `step` as arrange() leaves it.
Decision decide(const DiagnosisStep& step, const DecisionRules& rules = {});

}  // namespace kinetostat::calibration
