// Readings that nothing likely explains: slips of the target, of the operator, of the pen.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <vector>

#include "kinetostat/calibration/statistics/residual_space.h"

namespace kinetostat::calibration {

inline constexpr double outlying = 5;  // standard deviations, of an outlier

/// Values that neither the fitted model predicts from the others (robust_residual.h) nor the model
/// with up to three effects. An effect enters where it makes the readings more probable under a
/// mixture of noise and 1 % of outliers of any size, by more than its columns and the choice among
/// all effects cost:
///
///   sum_i min(left_i^2 / 2, c) falls by more than  rank/2 ln n + ln(candidates)
///
/// with c = -ln(0.01 / 200 sqrt(2 pi)), an outlier being anything within a hundred deviations: one
/// reading that is off is less than an effect, several that are off as an effect says are it.
/// `residual`, `fitted`: as in ResidualSpace; `effect`: of each of so many candidates the columns
/// of its signatures at usual sizes, made when asked for. Indices of values, ascending.
using EffectColumns = std::function<Eigen::MatrixXd(std::size_t)>;
/// What else decides of an effect whether it enters.
struct EffectEntry {
  double handicap = 0;                     // what it costs beside that
  std::optional<std::size_t> beside = {};  // only beside this other one
};
/// `entries`: one an effect; empty: nothing of that.
std::vector<std::size_t> outliers(const Eigen::VectorXd& residual, const Eigen::MatrixXd& fitted,
                                  std::size_t effects, const EffectColumns& effect,
                                  const std::vector<EffectEntry>& entries = {});

}  // namespace kinetostat::calibration
