// Candidates side by side: the evidence of each fit, and the candidates that the readings do not
// distinguish.
#pragma once

#include <vector>

#include "kinetostat/calibration/regression/held_out.h"
#include "kinetostat/calibration/search/candidate_fitter.h"
#include "kinetostat/calibration/search/correlated_noise.h"
#include "kinetostat/calibration/search/diagnosis_step.h"

namespace kinetostat::calibration {

/// The weight of readings that makes the evidence of several models comparable: that of the one
/// which leaves least. Fits without values do not count.
double common_exponent(const BaseFit& without, const std::vector<BaseFit>& fits);

/// Fits of candidates, an entry each; without values where there is none.
struct CandidateFits {
  explicit CandidateFits(std::size_t count) : alone(count), with_order(count) {}
  std::vector<BaseFit> alone;       // with the candidate
  std::vector<BaseFit> with_order;  // and with the order of its series that does most beside it
};

/// Evidence, held-out score and discriminability of every candidate that has a fit, and evidence of
/// the unmodelled smooth error. Where it is larger, evidence and discriminability are those of the
/// fit with one order more. Under each the noise may be correlated. Where the best has an unusual
/// size, any size is as likely as the usual one, but for a factor unusual / (times usual). Returns
/// the index of the best; the number of candidates when none has a fit.
std::size_t weigh(const BaseFit& without, const CandidateFits& fits, const HeldOutGroups& groups,
                  const FreeForm& free_form, const CorrelatedNoise& correlated,
                  DiagnosisStep& step);

/// Whether both act at one joint.
bool act_at_one_joint(const Candidate& a, const Candidate& b);
/// Whether both are laws of one joint without memory: the readings must then distinguish the shapes
/// of two laws.
bool are_laws_of_one_joint(const Candidate& a, const Candidate& b);

/// Sorts ranking and fits, the best first, and finds the candidates c that remain beside the best
/// b:
///
///   L_b - L_c < 4.6,   or   d'_c < l and |r_c|^2 - |r_b|^2 < l^2,   l = 4
///
/// For two laws of one joint l^2 = 4^2 + (0.1 d'_b)^2; and where b is at the end of its range, each
/// relative remains that explains more than half as much. Candidates that are confounded with the
/// best remain, too, where they may explain as much to 9.2.
void arrange(DiagnosisStep& step, std::vector<BaseFit>& fits);

}  // namespace kinetostat::calibration
