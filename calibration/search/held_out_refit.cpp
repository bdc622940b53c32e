#include "kinetostat/calibration/search/held_out_refit.h"

#include <algorithm>
#include <cmath>

namespace kinetostat::calibration {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr std::size_t most_parts = 8;

// Two campaigns: all readings but those of a part, and these alone.
struct Split {
  Campaign others, part;
};

Split split_at(const Campaign& campaign, const std::vector<Value>& values,
               const std::vector<Index>& part) {
  Split split{campaign, campaign};
  std::vector<bool> is_part(campaign.readings.size());
  for (const Index v : part) is_part[values[static_cast<std::size_t>(v)].reading] = true;
  for (std::size_t i = 0; i < is_part.size(); ++i)
    (is_part[i] ? split.others : split.part).readings[i].masked = true;
  return split;
}

}  // namespace

std::vector<std::vector<Index>> HeldOutRefit::parts() const {
  std::vector<std::vector<Index>> parts(std::min(most_parts, groups_.members.size()));
  for (std::size_t g = 0; g < groups_.members.size(); ++g) {
    std::vector<Index>& part = parts[g % parts.size()];
    part.insert(part.end(), groups_.members[g].begin(), groups_.members[g].end());
  }
  for (std::vector<Index>& part : parts) std::sort(part.begin(), part.end());
  return parts;
}

std::optional<VectorXd> HeldOutRefit::error(const std::vector<Candidate>& added, const BaseFit& fit,
                                            common::Progress& progress) const {
  const std::vector<Value> values = values_in_use(fitter_.campaign());
  if (groups_.members.size() < 2) return std::nullopt;
  VectorXd error = VectorXd::Zero(static_cast<Index>(values.size()));
  for (const std::vector<Index>& part : parts()) {
    const Split split = split_at(fitter_.campaign(), values, part);
    const std::optional<BaseFit> predicted = if_possible([&] {
      const CandidateFitter others(robot_, split.others, fitter_.noise(), threads_, progress);
      return fitter_.predicted(split.part, others.fit(added, &fit, progress), added, progress);
    });
    if (!predicted || predicted->at.residual.size() != std::ssize(part)) return std::nullopt;
    error(part) = -predicted->at.residual;
  }
  return error;
}

void HeldOutRefit::score(const VectorXd& without, const VectorXd& with, CandidateFit& fit) const {
  std::vector<double> gains;
  for (const std::vector<Index>& part : parts())
    gains.push_back(0.5 * (without(part).squaredNorm() - with(part).squaredNorm()));
  const auto count = static_cast<double>(gains.size());
  fit.log_score_gain = 0;
  for (const double gain : gains) fit.log_score_gain += gain;
  double squares = 0;
  for (const double gain : gains) squares += std::pow(gain - fit.log_score_gain / count, 2);
  fit.log_score_deviation = count > 1 ? std::sqrt(squares * count / (count - 1)) : 0;
}

}  // namespace kinetostat::calibration
