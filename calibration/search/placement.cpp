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
  // Of the squared residual, less what as many columns of noise would: of each effect.
  std::vector<double> explained(const std::vector<const vjm::Effect*>& effects) const {
    std::vector<double> all;
    space_.for_each_left(
        effects.size(), [&](std::size_t i) { return columns(*effects[i]); },
        [&](std::size_t, const MatrixXd&, const MatrixXd& left) {
          const MatrixXd span = span_of(left, least_visible);
          all.push_back((span.transpose() * space_.residual()).squaredNorm() -
                        static_cast<double>(span.cols()));
        });
    return all;
  }

 private:
  std::vector<Value> values_;
  ReadingOffsets offsets_;
  const Noise& noise_;
  SharedNoise shared_;
  ResidualSpace space_;
  Eigen::Matrix<double, 1, axes_of_readings> deviations_;
};

// The one of some that explains most.
struct Best {
  std::size_t number = 0;
  double explained = 0;
};

// Of every so many between two.
Best best_among(const OffsetSignatures& offsets, const std::vector<vjm::Effect>& all,
                std::size_t from, std::size_t to, std::size_t stride) {
  std::vector<const vjm::Effect*> some;
  for (std::size_t i = from; i < to; i += stride) some.push_back(&all[i]);
  const std::vector<double> explained = offsets.explained(some);
  const auto most = std::max_element(explained.begin(), explained.end());
  return {from + stride * static_cast<std::size_t>(most - explained.begin()), *most};
}

Best best_of(const OffsetSignatures& offsets, const std::vector<vjm::Effect>& all) {
  const std::size_t stride = (all.size() + most_placements - 1) / most_placements;
  const Best rough = best_among(offsets, all, 0, all.size(), stride);
  if (stride == 1) return rough;
  return best_among(offsets, all, rough.number - std::min(rough.number, stride - 1),
                    std::min(all.size(), rough.number + stride), 1);
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
    const Best best = best_of(offsets, all);
    const bool stands_out = best.explained > far_more_than_noise;
    if (!result.empty() && !stands_out) break;
    result.push_back({candidate, offsets.columns(all[best.number])});
    Placement& placement = result.back();
    placement.candidate.effect = all[best.number];
    explained = beside(explained, placement.columns);
    placement.columns.col(0) = placement.columns.rowwise().sum().eval();
    may_be_more = stands_out && result.size() < most_at_once;
  }
  return result;
}

}  // namespace kinetostat::calibration
