// How a link vibrates by itself: natural frequencies and modes of its finite-element model.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "kinetostat/fea/elasticity/solver.h"
#include "kinetostat/fea/interface/coupling.h"

namespace kinetostat::fea {

/// What holds the link while it vibrates. A held interface that is not rigid has no mean motion
/// (average_motion.h), or the body behind its elastic layer rests.
enum class Support {
  first_interface,  // clamped as identify holds it
  none,             // free-free; the six rigid motions are not among the modes
  all_interfaces,   // the fixed-interface modes of Craig and Bampton
};

/// "clamped", "free", "held".
const char* name(Support support);

/// Modes with the lowest frequencies, in ascending order: K x = omega^2 M x.
struct LinkModes {
  Eigen::VectorXd omega_squared;  // [rad^2/s^2]
  /// Displacements of all nodes of the mesh, with a modal mass of 1 kg: x' M x = 1 [1/sqrt(kg)].
  /// The largest component is positive.
  std::vector<Eigen::Matrix3Xd> shapes;
  std::size_t unknowns = 0;
  FactorisationStats factor = {};

  double frequency(std::size_t mode) const;  // [Hz]
};

/// The lowest `count` modes, fewer where the mesh has no more, of the model that respond() solves:
/// K with the couplings of `interfaces`, M the consistent mass of the elements. A rigid interface
/// that is not held moves as a body without a mass of its own, and the body of a `body` coupling
/// has none. By Lanczos' method (block_lanczos.h) on the Cholesky factors of K: always positive
/// definite, because a link that no rigid interface holds is supported by six springs that carry
/// nothing. Throws std::invalid_argument when the first material has no density, NoStiffBody,
/// MemoryLimit, SingularStiffness, std::bad_alloc, common::NoConvergence, Cancelled.
LinkModes link_modes(const TetMesh& mesh, const std::vector<Material>& materials,
                     const std::vector<CoupledInterface>& interfaces, Support support, int count,
                     const SolverOptions& options, common::Progress& progress);

}  // namespace kinetostat::fea
