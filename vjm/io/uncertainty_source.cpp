#include "kinetostat/vjm/io/uncertainty_source.h"

#include <algorithm>
#include <cmath>

#include <boost/math/distributions/normal.hpp>

namespace kinetostat::vjm {

std::string to_string(SourceKind kind) {
  switch (kind) {
    case SourceKind::joint:
      return "joint";
    case SourceKind::material:
      return "material";
    case SourceKind::section:
      return "section";
    case SourceKind::length:
      return "length";
    case SourceKind::mass:
      return "mass";
    case SourceKind::element:
      return "machine element";
    case SourceKind::mesh:
      return "mesh";
    case SourceKind::clamping:
      return "clamping";
    case SourceKind::fitted:
      return "fitted";
    case SourceKind::effect:
      return "effect";
  }
  return {};
}

double UncertaintySource::quantile(double p) const {
  if (spread == Spread::rectangular) return estimate + std::sqrt(3.0) * deviation * (2 * p - 1);
  const double z = boost::math::quantile(boost::math::normal(), p);
  if (spread == Spread::normal) return std::clamp(estimate + deviation * z, lower, upper);
  // With this mean and standard deviation.
  const double relative = deviation / estimate;
  const double variance = std::log1p(relative * relative);
  return estimate * std::exp(std::sqrt(variance) * z - variance / 2);
}

SourceList::SourceList(std::vector<UncertaintySource> known, Eigen::VectorXd values)
    : sources_(std::move(known)), values_(std::move(values)) {
  for (std::size_t i = 0; i < sources_.size(); ++i) numbers_.emplace(sources_[i].place, i);
}

std::optional<double> SourceList::meet(const UncertaintySource& source) {
  const auto [number, is_new] = numbers_.emplace(source.place, sources_.size());
  if (is_new && !values_) sources_.push_back(source);
  if (!values_ || static_cast<Eigen::Index>(number->second) >= values_->size()) return std::nullopt;
  return (*values_)[static_cast<Eigen::Index>(number->second)];
}

}  // namespace kinetostat::vjm
