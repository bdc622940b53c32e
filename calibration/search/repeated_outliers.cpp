#include "kinetostat/calibration/search/repeated_outliers.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Eigenvalues>

namespace kinetostat::calibration {
namespace {

using spatial::Matrix3;
using spatial::Vector3;

// The line along which forces act above all; zero where there are none.
Vector3 line_of(const std::vector<Vector3>& forces) {
  Matrix3 sum = Matrix3::Zero();
  for (const Vector3& force : forces) sum += force * force.transpose();
  if (sum.isZero(0)) return Vector3::Zero();
  return Eigen::SelfAdjointEigenSolver<Matrix3>(sum).eigenvectors().col(2);
}

class Repeated {
 public:
  Repeated(const Campaign& campaign, const std::vector<Value>& values,
           const Eigen::VectorXd& residual, const std::vector<std::size_t>& outliers)
      : campaign_(campaign), values_(values), residual_(residual), outliers_(outliers) {}

  bool of(Eigen::Index component) const {
    constexpr std::size_t fewest = 4;
    constexpr double alike = 0.95;  // of the least of their loads
    std::vector<Vector3> forces;
    std::size_t above = 0;
    for (const std::size_t v : outliers_) {
      if (values_[v].component != component) continue;
      forces.push_back(force(v));
      if (residual_[static_cast<Eigen::Index>(v)] > 0) ++above;
    }
    if (forces.size() < fewest || (above > 0 && above < forces.size())) return false;
    const Vector3 line = line_of(forces);
    double least = std::numeric_limits<double>::infinity();
    for (const Vector3& f : forces) least = std::min(least, std::abs(line.dot(f)));
    if (!(least > 0)) return false;
    std::size_t loaded_so = 0;
    for (std::size_t v = 0; v < values_.size(); ++v)
      if (values_[v].component == component && std::abs(line.dot(force(v))) >= alike * least)
        ++loaded_so;
    return 2 * forces.size() >= loaded_so;
  }

 private:
  const Vector3& force(std::size_t v) const {
    return campaign_.readings[values_[v].reading].load.force;
  }

  const Campaign& campaign_;
  const std::vector<Value>& values_;
  const Eigen::VectorXd& residual_;
  const std::vector<std::size_t>& outliers_;
};

}  // namespace

std::vector<std::size_t> without_repeated(const Campaign& campaign,
                                          const std::vector<Value>& values,
                                          const Eigen::VectorXd& residual,
                                          const std::vector<std::size_t>& outliers) {
  constexpr Eigen::Index components = 6;
  const Repeated repeated(campaign, values, residual, outliers);
  std::vector<std::size_t> result = outliers;
  for (Eigen::Index component = 0; component < components; ++component)
    if (repeated.of(component))
      std::erase_if(result, [&](std::size_t v) { return values[v].component == component; });
  return result;
}

}  // namespace kinetostat::calibration
