// Effects whose law a user writes: as a formula, or as a function of a program.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "kinetostat/vjm/effects/effect.h"
#include "kinetostat/vjm/effects/kinds/expression.h"

namespace kinetostat::vjm::effects {

/// Meaning of the formula of a user's effect, about one joint, SI.
enum class UserLaw {
  force,      // that the joint resists with, beside its drive [N or N m]
  offset,     // by which the drive leads the joint elsewhere [m or rad]
  compliance  // in series with the spring of the joint [m/N or rad/(N m)]
};

/// The variables of a formula: those of the law, then `covariates`, then `parameters`.
std::vector<std::string> user_variables(UserLaw law, const std::vector<std::string>& covariates,
                                        const std::vector<EffectParameter>& parameters);

/// Name, summary and parameters are for the caller to set. `covariates` are columns of the
/// readings; one that a reading does not have counts as zero. Throws ExpressionError when the
/// formula does not parse, depends on nothing, or is not finite for a joint at rest at 20 degrees
/// with the parameters at `typical`.
std::shared_ptr<EffectKind> user_effect(UserLaw law, const std::string& formula,
                                        const std::vector<std::string>& covariates,
                                        std::vector<EffectParameter> parameters,
                                        const Eigen::VectorXd& typical);
/// The same by any function of those variables. Throws std::invalid_argument when it uses none of
/// them, or is not finite at rest.
std::shared_ptr<EffectKind> user_effect(UserLaw law, std::shared_ptr<const SmoothFunction> function,
                                        const std::vector<std::string>& covariates,
                                        std::vector<EffectParameter> parameters,
                                        const Eigen::VectorXd& typical);

}  // namespace kinetostat::vjm::effects
