#include "kinetostat/calibration/search/placement.h"

#include <algorithm>

#include "kinetostat/calibration/campaign/datum.h"

namespace kinetostat::calibration {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

constexpr std::size_t most_placements = 400;
constexpr std::size_t most_at_once = 3;
constexpr double far_more_than_noise = 40;  // that one more explains of the squared residual
constexpr Index axes_of_readings = 6;

// Signatures of offsets of some readings, and what they explain beside a fit.
class OffsetSignatures {
 public:
  OffsetSignatures(const Candidate& candidate, const Campaign& campaign, const PlatformAxes& axes,
                   const Noise& noise, const BaseFit& fit, const MatrixXd& explained)
      : values_(values_in_use(campaign)),
        offsets_(campaign, axes),
        noise_(noise),
        shared_(noise, values_),
        space_(-fit.at.residual, beside(fit.at.jacobian, explained)),
        deviations_(Eigen::Map<const Eigen::Matrix<double, 1, axes_of_readings>>(
            candidate.deviations.data())) {}

  MatrixXd columns(const vjm::Effect& effect) const {
    MatrixXd result(static_cast<Index>(values_.size()), axes_of_readings);
    for (std::size_t v = 0; v < values_.size(); ++v)
      result.row(static_cast<Index>(v)) =
          offsets_.shown(effect, values_[v].reading, values_[v].component)
              .cwiseProduct(deviations_);
    whiten_singly(noise_, values_, result);
    shared_.whiten(result);
    return result;
  }
  // Of the squared residual, less what as many columns of noise would.
  double explained(const vjm::Effect& effect) const {
    const MatrixXd span = span_of(space_.left_of(columns(effect)), least_visible);
    return (span.transpose() * space_.residual()).squaredNorm() - static_cast<double>(span.cols());
  }

 private:
  std::vector<Value> values_;
  ReadingOffsets offsets_;
  const Noise& noise_;
  SharedNoise shared_;
  ResidualSpace space_;
  Eigen::Matrix<double, 1, axes_of_readings> deviations_;
};

// The number of the one that explains most, of every so many between two.
std::size_t best_among(const OffsetSignatures& offsets, const std::vector<vjm::Effect>& all,
                       std::size_t from, std::size_t to, std::size_t stride) {
  std::size_t best = from;
  double most = offsets.explained(all[from]);
  for (std::size_t i = from + stride; i < to; i += stride)
    if (const double explained = offsets.explained(all[i]); explained > most) {
      most = explained;
      best = i;
    }
  return best;
}

const vjm::Effect& best_of(const OffsetSignatures& offsets, const std::vector<vjm::Effect>& all) {
  const std::size_t stride = (all.size() + most_placements - 1) / most_placements;
  std::size_t best = best_among(offsets, all, 0, all.size(), stride);
  if (stride > 1)
    best = best_among(offsets, all, best - std::min(best, stride - 1),
                      std::min(all.size(), best + stride), 1);
  return all[best];
}

}  // namespace

std::vector<Placement> best_placements(const Candidate& candidate, const Campaign& campaign,
                                       const PlatformAxes& axes, const Noise& noise,
                                       const BaseFit& fit) {
  const std::vector<vjm::Effect> all = placements(candidate.effect, campaign, axes);
  std::vector<Placement> result;
  MatrixXd explained(fit.at.residual.size(), 0);
  bool may_be_more = !all.empty();
  while (may_be_more) {
    const OffsetSignatures offsets(candidate, campaign, axes, noise, fit, explained);
    const vjm::Effect& best = best_of(offsets, all);
    const bool stands_out = offsets.explained(best) > far_more_than_noise;
    if (!result.empty() && !stands_out) break;
    Placement& placement = result.emplace_back(candidate, offsets.columns(best));
    placement.candidate.effect = best;
    explained = beside(explained, placement.columns);
    placement.columns.col(0) = placement.columns.rowwise().sum().eval();
    may_be_more = stands_out && result.size() < most_at_once;
  }
  return result;
}

}  // namespace kinetostat::calibration
