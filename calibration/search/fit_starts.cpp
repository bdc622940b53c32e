#include "kinetostat/calibration/search/fit_starts.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "kinetostat/calibration/search/usual_values.h"
#include "kinetostat/spatial/decomposition.h"

namespace kinetostat::calibration {
namespace {

// As many times as it was looked at a size is sought.
constexpr double least_size = 0.002, largest_size = 20;

// The candidate turned by a quarter, a half and three quarters.
std::vector<Candidate> other_phases(const Candidate& candidate) {
  const auto& parameters = candidate.effect.kind->parameters;
  std::vector<Candidate> result;
  for (std::size_t k = 0; k < parameters.size(); ++k)
    for (const int quarters : {1, 2, -1}) {
      if (!parameters[k].is_phase) continue;
      result.push_back(candidate);
      result.back().effect.values[static_cast<Eigen::Index>(k)] += quarters * std::numbers::pi / 2;
    }
  return result;
}

// What a signature explains of the residual at the size and the shape that it would need: least
// squares, with sizes that only grow, and with each value of the shape as far from where it was
// looked at as its prior allows. A shape acts in proportion to the size, so that b_k = size * z_k
// with z_k ~ N(0, 1) is found for the size of the step before.
class Reach {
 public:
  Reach(const Candidate& as_it_is, const Signature& signature, const ResidualSpace& space,
        const vjm::Manipulator& bare)
      : candidate_(as_it_is), values_(values_of_columns(as_it_is.effect, bare)) {
    const Eigen::MatrixXd left = space.left_of(signature.columns);
    gram_ = left.transpose() * left;
    along_ = left.transpose() * space.residual();
    for (int step = 0; step < 8; ++step) find_shares();
  }

  double explained() const { return 2 * shares_.dot(along_) - shares_.dot(penalised() * shares_); }

  Candidate start() const {
    Candidate start = resized(candidate_, size_);
    for (Eigen::Index c = 1; c < shares_.size(); ++c) {
      const Eigen::Index k = value_of(c);
      const double lower = parameter(c).lower, upper = parameter(c).upper;
      const double change = shares_[c] / (is_shape(c) ? size_ : 1);
      double& value = start.effect.values[k];
      // Not to the end of its range, where laws may have no sense.
      value = std::clamp(value + change * start.deviations[static_cast<std::size_t>(k)],
                         lower + 0.2 * (value - lower), upper - 0.2 * (upper - value));
    }
    return start;
  }

 private:
  Eigen::Index value_of(Eigen::Index column) const {
    return values_[static_cast<std::size_t>(column)];
  }
  const vjm::EffectParameter& parameter(Eigen::Index column) const {
    return candidate_.effect.kind->parameters[static_cast<std::size_t>(value_of(column))];
  }
  bool is_shape(Eigen::Index column) const { return column > 0 && parameter(column).is_shape; }
  bool only_grows(Eigen::Index column) const {
    return !is_shape(column) && can_only_grow(parameter(column));
  }

  Eigen::MatrixXd penalised() const {
    Eigen::MatrixXd a = gram_;
    for (Eigen::Index c = 0; c < a.cols(); ++c)
      if (is_shape(c)) a(c, c) += 1 / (size_ * size_);
    return a;
  }

  // Columns that would have to shrink are left out, the worst first, and how an effect acts with
  // it.
  void find_shares() {
    const Eigen::MatrixXd a = penalised();
    std::vector<Eigen::Index> used;
    for (Eigen::Index c = 0; c < along_.size(); ++c)
      if (std::sqrt(gram_(c, c)) > least_visible) used.push_back(c);
    shares_.setZero(along_.size());
    while (!used.empty()) {
      const Eigen::VectorXd some = spatial::solve_symmetric(a(used, used), along_(used)).col(0);
      std::optional<Eigen::Index> worst;
      double most = 0;
      for (std::size_t u = 0; u < used.size(); ++u) {
        const double beyond =
            -some[static_cast<Eigen::Index>(u)] * std::sqrt(gram_(used[u], used[u]));
        if (only_grows(used[u]) && beyond > most) most = beyond, worst = used[u];
      }
      if (!worst) {
        shares_(used) = some;
        break;
      }
      std::erase_if(used,
                    [&](Eigen::Index c) { return c == *worst || (*worst == 0 && is_shape(c)); });
    }
    size_ = std::clamp(shares_[0], least_size, largest_size);
  }

  const Candidate& candidate_;
  std::vector<Eigen::Index> values_;
  Eigen::MatrixXd gram_;
  Eigen::VectorXd along_, shares_;
  double size_ = 1;
};

// Fits from both would be the same.
bool are_near(const Candidate& a, const Candidate& b) {
  const Eigen::VectorXd &x = a.effect.values, &y = b.effect.values;
  return ((x - y).array().abs() <= 0.1 * x.array().abs().max(y.array().abs())).all();
}

}  // namespace

Candidate resized(Candidate start, double size) {
  const auto& parameters = start.effect.kind->parameters;
  const bool one_sided = can_only_grow(parameters.front());
  const double factor = std::clamp(size, one_sided ? least_size : -largest_size, largest_size);
  for (std::size_t k = 0; k < parameters.size(); ++k) {
    if (!is_size(*start.effect.kind, k)) continue;
    const vjm::EffectParameter& p = parameters[k];
    double& value = start.effect.values[static_cast<Eigen::Index>(k)];
    value = std::clamp(p.none + factor * (value - p.none), p.lower, p.upper);
  }
  return start;
}

FitStarts::FitStarts(const Candidate& candidate, const ResidualSpace& space,
                     const vjm::Manipulator& bare)
    : space_(space), bare_(bare), turned_(other_phases(candidate)) {}

void FitStarts::add(const Candidate& as_it_is, const Signature& signature, double explained) {
  const Eigen::VectorXd left = space_.left_of(signature.columns.col(0));
  const double length = std::max(1e-300, left.norm());
  const double along = left.dot(space_.residual()) / length;
  double promised = explained;
  if (!turned_.empty()) explained = std::pow(std::max(0.0, along), 2);
  if (can_only_grow(as_it_is.effect.kind->parameters.front())) {
    const Reach reach(as_it_is, signature, space_, bare_);
    promised = reach.explained();
    explained = std::min(explained, promised);
    looks_.push_back({promised, as_it_is, reach.start()});
  }
  promised_ = std::max(promised_, promised);
  looks_.push_back({explained, as_it_is, resized(as_it_is, along / length)});
}

void FitStarts::add_other_phases(const CandidateFitter& fitter, const FittedModel& beside,
                                 common::Progress& progress) {
  for (const Candidate& other : turned_) {
    const CandidateSignatures signatures = fitter.signatures_of(other, beside, progress);
    for (std::size_t s = 0; s < signatures.all.size(); ++s)
      add(signatures.starts[s], signatures.all[s], 0);
  }
}

std::vector<Candidate> FitStarts::best(std::size_t most) {
  std::stable_sort(looks_.begin(), looks_.end(),
                   [](const Look& a, const Look& b) { return a.explained > b.explained; });
  std::vector<Candidate> starts;
  const auto keep = [&](const Candidate& start) {
    if (starts.size() < most &&
        std::none_of(starts.begin(), starts.end(),
                     [&](const Candidate& other) { return are_near(start, other); }))
      starts.push_back(start);
  };
  for (const Look& look : looks_) keep(look.resized);
  for (const Look& look : looks_) keep(look.as_it_is);
  return starts;
}

}  // namespace kinetostat::calibration
