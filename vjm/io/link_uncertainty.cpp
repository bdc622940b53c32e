#include "kinetostat/vjm/io/link_uncertainty.h"

#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

namespace kinetostat::vjm {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

// "foot" of foot.link.json.
std::string link_name(const std::filesystem::path& file) {
  const std::string name = file.filename().string();
  return name.substr(0, name.find('.'));
}

MatrixXd without_negative_eigenvalues(const MatrixXd& m) {
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(0.5 * (m + m.transpose()));
  return eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0).asDiagonal() *
         eigen.eigenvectors().transpose();
}

// The part of D that leaves nine tenths of it below the compliance: what bends least stays so.
double largest_share(const MatrixXd& compliance, const MatrixXd& error) {
  constexpr double most = 0.9;
  const Eigen::LLT<MatrixXd> factor(compliance);
  const MatrixXd half = factor.matrixL().solve(error);
  const MatrixXd relative = factor.matrixL().solve(half.transpose());
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(
      MatrixXd(0.5 * (relative + relative.transpose())), Eigen::EigenvaluesOnly);
  const double largest = eigen.eigenvalues().maxCoeff();
  return largest > most ? most / largest : 1;
}

// How alike the errors of two load cases are. One that the recovery does not see stands alone.
MatrixXd correlation(const MatrixXd& recovery) {
  const MatrixXd error = without_negative_eigenvalues(recovery);
  MatrixXd alike = MatrixXd::Identity(error.rows(), error.cols());
  for (Index i = 0; i < error.rows(); ++i)
    for (Index j = 0; j < error.cols(); ++j) {
      const double size = std::sqrt(error(i, i) * error(j, j));
      if (i != j && size > 0) alike(i, j) = error(i, j) / size;
    }
  return alike;
}

MatrixXd mesh_error(const io::LinkErrorBars& bars) {
  const Eigen::VectorXd size = bars.bar.diagonal().cwiseMax(0).cwiseSqrt();
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

// Young's modulus beside the one that was computed with: all of the compliance goes with its
// inverse.
UncertaintySource young_modulus(const std::filesystem::path& file, double deviation) {
  return {.name = "E of " + link_name(file),
          .place = file.string() + ": E",
          .kind = SourceKind::material,
          .spread = Spread::log_normal,
          .value = 1,
          .estimate = 1,
          .deviation = deviation};
}

// The flexibility for values of the sources; none while they are being listed.
std::optional<MatrixXd> other_flexibility(const MatrixXd& nominal,
                                          const std::optional<io::LinkBracket>& bracket,
                                          const std::optional<io::LinkErrorBars>& bars,
                                          double young_deviation, const std::filesystem::path& file,
                                          SourceList& sources) {
  std::optional<MatrixXd> flexibility;
  if (bracket)
    if (const auto t = sources.meet(between("clamping", file, SourceKind::clamping, 0, 1)))
      flexibility = (1 - *t) * bracket->rigid + *t * bracket->distributing;
  if (bars && bars->bar.diagonal().maxCoeff() > 0)
    if (const auto m = sources.meet(between("mesh", file, SourceKind::mesh, -1, 1))) {
      if (!flexibility) flexibility = nominal;
      const MatrixXd error = mesh_error(*bars);
      *flexibility += *m * largest_share(*flexibility, error) * error;
    }
  if (young_deviation > 0)
    if (const auto young = sources.meet(young_modulus(file, young_deviation))) {
      if (!flexibility) flexibility = nominal;
      *flexibility /= *young;
    }
  return flexibility;
}

}  // namespace

spatial::Compliance6 uncertain_compliance(const io::IdentifiedLink& link,
                                          const std::filesystem::path& file, SourceList& sources) {
  const auto other = other_flexibility(link.compliance.matrix(), link.bracket, link.error,
                                       link.young_deviation, file, sources);
  return other ? spatial::Compliance6(*other, link.compliance.frame()) : link.compliance;
}

Eigen::MatrixXd uncertain_stiffness(const io::ReducedLink& link, const std::filesystem::path& file,
                                    SourceList& sources) {
  const auto other = other_flexibility(link.flexibility, link.bracket, link.error,
                                       link.young_deviation, file, sources);
  return other ? io::free_stiffness(link, *other) : link.stiffness;
}

}  // namespace kinetostat::vjm
