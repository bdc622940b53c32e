#include "kinetostat/vjm/vibration/mass_spectrum.h"

namespace kinetostat::vjm {
namespace mass_spectrum {
namespace {

constexpr double shift = 1e-9;      // of omega^2, beside the largest stiffness over mass
constexpr double massless = 1e-13;  // theta, beside the largest

double shift_of(const Eigen::MatrixXd& stiffness, const Eigen::MatrixXd& mass) {
  return shift * (stiffness.norm() > 0 ? stiffness.norm() : 1) / mass.norm();
}

spatial::SymmetricEigen eigen_of(const Eigen::LLT<Eigen::MatrixXd>& factor,
                                 const Eigen::MatrixXd& mass) {
  const Eigen::MatrixXd half = factor.matrixL().solve(mass);
  const Eigen::MatrixXd whole = factor.matrixL().solve(half.transpose());
  return spatial::symmetric_eigen(0.5 * (whole + whole.transpose()));
}

}  // namespace
}  // namespace mass_spectrum

MassSpectrum::MassSpectrum(const Eigen::MatrixXd& stiffness, const Eigen::MatrixXd& mass)
    : shift_(mass_spectrum::shift_of(stiffness, mass)),
      factor_(stiffness + shift_ * mass),
      eigen_(mass_spectrum::eigen_of(factor_, mass)) {}

bool MassSpectrum::has_mass(Eigen::Index i) const {
  return theta(i) > mass_spectrum::massless * eigen_.values.maxCoeff();
}

}  // namespace kinetostat::vjm
