#include "kinetostat/vjm/statics/segments.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace kinetostat::vjm {

double SegmentStudy::extrapolated() const {
  if (values.size() < 2) throw std::logic_error("Richardson's estimate needs two values");
  const std::size_t last = values.size() - 1;
  const double ratio = static_cast<double>(multiples[last]) / multiples[last - 1];
  return values[last] + (values[last] - values[last - 1]) / (ratio * ratio - 1);
}

double SegmentStudy::error(std::size_t i) const { return values[i] / extrapolated() - 1; }

std::optional<double> SegmentStudy::observed_order() const {
  const std::size_t n = values.size();
  if (n < 3 || multiples[n - 1] != 2 * multiples[n - 2] || multiples[n - 2] != 2 * multiples[n - 3])
    return std::nullopt;
  const double ratio = (values[n - 3] - values[n - 2]) / (values[n - 2] - values[n - 1]);
  return ratio > 0 ? std::optional(std::log2(ratio)) : std::nullopt;
}

SegmentStudy study_segments(const std::vector<int>& multiples,
                            const std::function<std::optional<double>(int)>& result) {
  SegmentStudy study;
  for (const int multiple : multiples) {
    const std::optional<double> value = result(multiple);
    if (!value && study.values.empty()) study.without.push_back(multiple);
    if (!value && !study.values.empty()) break;
    if (!value) continue;
    study.multiples.push_back(multiple);
    study.values.push_back(*value);
  }
  return study;
}

bool take_stability(const Equilibrium& finer, bool platform_held, Equilibrium& given) {
  Stability& own = platform_held ? given.held : given.free;
  Stability seen = platform_held ? finer.held : finer.free;
  // Beyond a limit point, the finer model stands at the last equilibrium before it.
  if (finer.status != EquilibriumStatus::converged) seen = {std::max(1, seen.unstable), 0, 0.0};
  if (seen.unstable <= own.unstable) return false;
  own = seen;
  return true;
}

std::optional<double> lumping_error(const Equilibrium& given, const Equilibrium& twice,
                                    bool platform_held) {
  if (given.status != EquilibriumStatus::converged || twice.status != EquilibriumStatus::converged)
    return std::nullopt;
  const auto error = [](const spatial::Vector3& a, const spatial::Vector3& b) {
    return a.isZero(0) ? std::nullopt : std::optional(4.0 / 3 * (a - b).norm() / a.norm());
  };
  if (platform_held) {
    const auto of_force = error(given.wrench.force, twice.wrench.force);
    return of_force ? of_force : error(given.wrench.moment, twice.wrench.moment);
  }
  const auto of_translation = error(given.displacement.translation, twice.displacement.translation);
  return of_translation ? of_translation
                        : error(given.displacement.rotation, twice.displacement.rotation);
}

}  // namespace kinetostat::vjm
