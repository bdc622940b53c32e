#include "kinetostat/calibration/search/placement.h"

#include <algorithm>

#include "kinetostat/calibration/campaign/datum.h"
#include "kinetostat/calibration/regression/instrument_lag.h"
#include "kinetostat/calibration/regression/reading_offsets.h"

namespace kinetostat::calibration {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

constexpr std::size_t most_placements = 400;
constexpr Index axes_of_readings = 6;

// Signatures of offsets of some readings, and what they explain beside a fit.
class OffsetSignatures {
 public:
  OffsetSignatures(const Candidate& candidate, const Campaign& campaign, const Noise& noise,
                   const BaseFit& fit)
      : values_(values_in_use(campaign)),
        moments_(moments_of(campaign)),
        shared_(noise, values_),
        space_(-fit.at.residual, fit.at.jacobian),
        of_all_(MatrixXd::Zero(static_cast<Index>(values_.size()), axes_of_readings)) {
    for (std::size_t v = 0; v < values_.size(); ++v)
      if (may_lag(campaign, values_[v].component)) {
        const Index axis = campaign.component(values_[v].component).axis;
        of_all_(static_cast<Index>(v), axis) = candidate.deviations[static_cast<std::size_t>(axis)];
      }
    whiten_singly(noise, values_, of_all_);
  }

  MatrixXd columns(const vjm::Effect& effect) const {
    MatrixXd result = MatrixXd::Zero(of_all_.rows(), axes_of_readings);
    for (std::size_t v = 0; v < values_.size(); ++v)
      if (effect.kind->is_off(moments_[values_[v].reading], effect.values))
        result.row(static_cast<Index>(v)) = of_all_.row(static_cast<Index>(v));
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
  std::vector<vjm::ReadingMoment> moments_;
  SharedNoise shared_;
  ResidualSpace space_;
  MatrixXd of_all_;  // each reading whitened by itself
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

}  // namespace

std::optional<Placement> best_placement(const Candidate& candidate, const Campaign& campaign,
                                        const Noise& noise, const BaseFit& fit) {
  const std::vector<vjm::Effect> all = placements(candidate.effect, campaign);
  if (all.empty()) return std::nullopt;
  const OffsetSignatures offsets(candidate, campaign, noise, fit);
  const std::size_t stride = (all.size() + most_placements - 1) / most_placements;
  std::size_t best = best_among(offsets, all, 0, all.size(), stride);
  if (stride > 1)
    best = best_among(offsets, all, best - std::min(best, stride - 1),
                      std::min(all.size(), best + stride), 1);
  Placement placement{candidate, offsets.columns(all[best])};
  placement.columns.col(0) = placement.columns.rowwise().sum().eval();
  placement.candidate.effect = all[best];
  return placement;
}

}  // namespace kinetostat::calibration
