#include "kinetostat/vjm/exchange/matlab_export.h"

#include <cmath>

#include <Eigen/Eigenvalues>
#include <fmt/format.h>

#include "kinetostat/common/printable.h"
#include "kinetostat/vjm/exchange/body_tree.h"
#include "kinetostat/vjm/vibration/natural_modes.h"

namespace kinetostat::vjm::matlab_export {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

// D that damps every mode of K and M with this ratio; M is positive definite on what moves.
MatrixXd damping(const SmallMotions& motions, double ratio) {
  const Index n = motions.stiffness.rows();
  if (!(ratio > 0) || !(motions.mass.norm() > 0)) return MatrixXd::Zero(n, n);
  // M x = theta (K + s M) x, which is defined where a motion has no mass as well.
  const double shift = 1e-9 * motions.stiffness.norm() / motions.mass.norm();
  const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd> modes(
      motions.mass, motions.stiffness + shift * motions.mass);
  MatrixXd sum = MatrixXd::Zero(n, n);
  for (Index i = 0; i < n; ++i) {
    const double theta = modes.eigenvalues()[i];
    if (!(theta > 1e-13 * modes.eigenvalues()[n - 1])) continue;
    const double omega = std::sqrt(std::max(1 / theta - shift, 0.0));
    const Eigen::VectorXd m = motions.mass * modes.eigenvectors().col(i) / std::sqrt(theta);
    sum += 2 * ratio * omega * m * m.transpose();
  }
  return sum;
}

std::string quoted(const std::string& text) {
  std::string out;
  for (const char c : common::printable(text)) {
    if (c == '\'') out += c;
    out += c;
  }
  return "'" + out + "'";
}

std::string matrix_text(const char* name, const MatrixXd& values) {
  std::string text = fmt::format("{} = [\n", name);
  for (Index i = 0; i < values.rows(); ++i) {
    for (Index j = 0; j < values.cols(); ++j) text += fmt::format(" {}", values(i, j) + 0.0);
    text += "\n";
  }
  return text + "];\n";
}

}  // namespace
}  // namespace kinetostat::vjm::matlab_export

namespace kinetostat::vjm {

std::string matlab(const Robot& robot, const Posture& posture, double damping_ratio) {
  using namespace matlab_export;
  const SmallMotions motions = small_motions(robot.manipulator, posture);
  const spatial::Vector3& p = posture.platform.position();
  return fmt::format(
             "% Small motions of a robot about a posture, from kinetostat. SI units, base axes:\n"
             "%   K y + D y' + M y'' = J' F,  F = [force; moment] on the platform at its point,\n"
             "%   its displacement [translation; rotation] is J y. The drives hold their "
             "commands.\n"
             "%   y: motions that all joints and springs allow together, at right angles; no one "
             "joint's.\n"
             "{}name = {};\nplatform = [{} {} {}];\n",
             lost_comment(lost_in_matlab(robot, damping_ratio), "% "), quoted(robot.name), p.x(),
             p.y(), p.z()) +
         matrix_text("K", motions.stiffness) + matrix_text("M", motions.mass) +
         matrix_text("D", damping(motions, damping_ratio)) + matrix_text("J", motions.platform) +
         "compliance = J * (K \\ J');\n"
         "frequencies = sort(sqrt(real(eig(K, M)))) / (2 * pi);\n";
}

std::vector<std::string> lost_in_matlab(const Robot& robot, double damping_ratio) {
  std::vector<std::string> lost = {"large motions: the matrices are those of this posture",
                                   "the stiffness of weight and preloads in the posture"};
  for (std::string& effect : lost_effects(robot)) lost.push_back(std::move(effect));
  if (!(mass_of(robot.manipulator) > 0))
    lost.emplace_back("masses: the robot file has none, so that M is 0 and no frequency is finite");
  if (!(damping_ratio > 0)) lost.emplace_back("damping: the robot file has none");
  return lost;
}

}  // namespace kinetostat::vjm
