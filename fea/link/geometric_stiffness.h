// How a load that a link already carries changes its stiffness, up to buckling.
#pragma once

#include <array>
#include <stdexcept>
#include <vector>

#include "kinetostat/fea/link/link_response.h"

namespace kinetostat::fea {

/// The preload is beyond what the link bears even with both interfaces held.
class BeyondBuckling : public std::runtime_error {
 public:
  explicit BeyondBuckling(double factor);
};

/// All at the point of the loaded interface, mesh axes, [force; moment] per [translation;
/// rotation vector]. The stress is that of the linear model under the preload; what the preload's
/// own deflection does to the shape is left out, as in every linear buckling analysis. The matrices
/// are second derivatives of the energy, hence symmetric: the tangent for dead forces and
/// semi-tangential moments. A moment M that keeps its direction adds -1/2 [M]x to the rotational
/// block, one that turns with the interface +1/2 [M]x.
struct GeometricStiffness {
  /// Change of the stiffness per unit of Fx Fy Fz Mx My Mz, at no load.
  std::array<Matrix6, 6> per_load;
  /// Under the preload, exact in its size.
  Matrix6 stiffness;
  /// Smallest positive multiple of the preload at which the link buckles, the fixed interface
  /// held: with the loaded one free, and with it held as well. Infinite when none does.
  double buckling_free, buckling_held;
};

/// Geometric stiffness of a link with two rigid interfaces; `response` is that of the same model.
/// `preload` is the wrench on the loaded interface at its point. Two factorisations, and a few tens
/// of solutions. Throws std::invalid_argument for other interfaces, BeyondBuckling, and what
/// Factorisation throws.
GeometricStiffness geometric_stiffness(const TetMesh& mesh, const std::vector<Material>& materials,
                                       const std::vector<CoupledInterface>& interfaces,
                                       const LinkResponse& response, const Vector6& preload,
                                       common::Progress& progress);

}  // namespace kinetostat::fea
