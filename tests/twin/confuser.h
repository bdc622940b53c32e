// How much of what an effect shows another one can show, too.
#pragma once

#include <string>

#include "experiment.h"

namespace twin {

/// Nearest confounder of an effect, and the cosine between the signature of the effect and the
/// nearest signature that the other can have, whatever its values.
struct Confuser {
  std::string name;
  double cosine = 0;
};

/// Nearest confounder of an effect at its size, in that campaign on that robot, whose other effects
/// do not count; beams are short ones, since an angle between signatures needs no fine ones.
/// Searched among all effects the twin knows, wherever they can act, at their usual sizes, or at
/// ten times these where that hardly shows; those that take long to compute come last, and the
/// search ends where a cosine is above `enough`. Throws std::runtime_error when the robot
/// collapses.
Confuser confuser_of(const HiddenEffect& effect, World world, const Plan& plan, double enough = 1);

}  // namespace twin
