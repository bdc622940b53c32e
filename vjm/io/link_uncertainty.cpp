#include "kinetostat/vjm/io/link_uncertainty.h"

#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

namespace kinetostat::vjm {
namespace {

using spatial::Matrix6;
using spatial::Vector6;

// "foot" of foot.link.json.
std::string link_name(const std::filesystem::path& file) {
  const std::string name = file.filename().string();
  return name.substr(0, name.find('.'));
}

Matrix6 without_negative_eigenvalues(const Matrix6& m) {
  const Eigen::SelfAdjointEigenSolver<Matrix6> eigen(0.5 * (m + m.transpose()));
  return eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0).asDiagonal() *
         eigen.eigenvectors().transpose();
}

// The part of D that leaves nine tenths of it below the compliance: what bends least stays so.
double largest_share(const Matrix6& compliance, const Matrix6& error) {
  constexpr double most = 0.9;
  const Eigen::LLT<Matrix6> factor(compliance);
  const Matrix6 half = factor.matrixL().solve(error);
  const Matrix6 relative = factor.matrixL().solve(Matrix6(half.transpose()));
  const Eigen::SelfAdjointEigenSolver<Matrix6> eigen(
      Matrix6(0.5 * (relative + relative.transpose())), Eigen::EigenvaluesOnly);
  const double largest = eigen.eigenvalues()[5];
  return largest > most ? most / largest : 1;
}

// How alike the errors of two load cases are. One that the recovery does not see stands alone.
Matrix6 correlation(const Matrix6& recovery) {
  const Matrix6 error = without_negative_eigenvalues(recovery);
  Matrix6 alike = Matrix6::Identity();
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 6; ++j) {
      const double size = std::sqrt(error(i, i) * error(j, j));
      if (i != j && size > 0) alike(i, j) = error(i, j) / size;
    }
  return alike;
}

Matrix6 mesh_error(const io::LinkErrorBars& bars) {
  const Vector6 size = bars.bar.diagonal().cwiseMax(0).cwiseSqrt();
  return size.asDiagonal() * correlation(bars.recovery) * size.asDiagonal();
}

UncertaintySource between(const std::string& what, const std::filesystem::path& file,
                          SourceKind kind, double lower, double upper) {
  return {.name = what + " of " + link_name(file),
          .place = file.string() + ": " + what,
          .kind = kind,
          .spread = Spread::rectangular,
          .value = 0,
          .estimate = (lower + upper) / 2,
          .deviation = (upper - lower) / std::sqrt(12.0)};
}

}  // namespace

spatial::Compliance6 uncertain_compliance(const io::IdentifiedLink& link,
                                          const std::filesystem::path& file, SourceList& sources) {
  Matrix6 compliance = link.compliance.matrix();
  if (link.bracket) {
    const auto t = sources.meet(between("clamping", file, SourceKind::clamping, 0, 1));
    if (t) compliance = (1 - *t) * link.bracket->rigid + *t * link.bracket->distributing;
  }
  if (link.error && link.error->bar.diagonal().maxCoeff() > 0) {
    const auto m = sources.meet(between("mesh", file, SourceKind::mesh, -1, 1));
    const Matrix6 error = mesh_error(*link.error);
    if (m) compliance += *m * largest_share(compliance, error) * error;
  }
  return spatial::Compliance6(compliance, link.compliance.frame());
}

}  // namespace kinetostat::vjm
