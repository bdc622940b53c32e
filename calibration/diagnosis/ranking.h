// Rivals side by side: what each fit is worth, and which of them readings cannot tell apart.
#pragma once

#include <vector>

#include "kinetostat/calibration/diagnosis/correlated_noise.h"
#include "kinetostat/calibration/diagnosis/diagnosis_step.h"
#include "kinetostat/calibration/diagnosis/rivals.h"
#include "kinetostat/calibration/regression/held_out.h"

namespace kinetostat::calibration {

/// The weight of readings that makes the evidence of several models comparable: that of the one
/// which leaves least. Fits without values do not count.
double common_temper(const BaseFit& without, const std::vector<BaseFit>& fits);

/// Evidence, held-out scores and what tells the best from the others, of all that have a fit (one
/// entry a rival; without values where there is none), and of the free-form rival. Under each the
/// noise may be correlated. Where the best has an unusual size, any size is as likely as the usual
/// one. Returns which is the best, the number of rivals when none has a fit.
std::size_t weigh(const BaseFit& without, const std::vector<BaseFit>& fits,
                  const HeldOutGroups& groups, const FreeForm& free_form,
                  const CorrelatedNoise& correlated, DiagnosisStep& step);

/// Of one joint, which neither remembers anything: what readings must tell is the shape of a law.
bool are_laws_of_one_joint(const Candidate& a, const Candidate& b);

/// Brings ranking and fits in order, the best first, and says what may be it.
void arrange(DiagnosisStep& step, std::vector<BaseFit>& fits);

}  // namespace kinetostat::calibration
