#include "kinetostat/calibration/search/fit_starts.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace kinetostat::calibration {
namespace {

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

// Fits from both would be the same.
bool are_near(const Candidate& a, const Candidate& b) {
  const Eigen::VectorXd &x = a.effect.values, &y = b.effect.values;
  return ((x - y).array().abs() <= 0.1 * x.array().abs().max(y.array().abs())).all();
}

}  // namespace

Candidate resized(Candidate start, double size) {
  const auto& parameters = start.effect.kind->parameters;
  const bool one_sided = can_only_grow(parameters.front());
  const double factor = std::clamp(size, one_sided ? 0.002 : -20.0, 20.0);
  for (std::size_t k = 0; k < parameters.size(); ++k) {
    if (!is_size(*start.effect.kind, k)) continue;
    const vjm::EffectParameter& p = parameters[k];
    double& value = start.effect.values[static_cast<Eigen::Index>(k)];
    value = std::clamp(p.none + factor * (value - p.none), p.lower, p.upper);
  }
  return start;
}

FitStarts::FitStarts(const Candidate& candidate, const ResidualSpace& space)
    : space_(space), turned_(other_phases(candidate)) {}

void FitStarts::add(const Candidate& as_it_is, const Signature& signature, double explained) {
  const Eigen::VectorXd left = space_.left_of(signature.columns.col(0));
  const double length = std::max(1e-300, left.norm());
  const double along = left.dot(space_.residual()) / length;
  if (!turned_.empty()) explained = std::pow(std::max(0.0, along), 2);
  looks_.push_back({explained, as_it_is, resized(as_it_is, along / length)});
}

void FitStarts::add_other_phases(const CandidateFitter& fitter,
                                 const std::vector<Candidate>& present, const BaseFit& fit,
                                 common::Progress& progress) {
  for (const Candidate& other : turned_) {
    const CandidateSignatures signatures = fitter.signatures_of(other, present, fit, progress);
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
