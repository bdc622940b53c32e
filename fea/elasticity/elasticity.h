// Linear elasticity on one tetrahedron.
#pragma once

#include <array>
#include <optional>

#include <Eigen/Core>

#include "kinetostat/fea/surface/surface_mesh.h"

namespace kinetostat::fea {

/// An isotropic material. Throws std::invalid_argument unless young > 0 and -1 < poisson < 0.5.
class Material {
 public:
  Material(double young, double poisson, std::optional<double> density = {});

  double young() const { return young_; }                            // [Pa]
  double poisson() const { return poisson_; }                        // [1]
  const std::optional<double>& density() const { return density_; }  // [kg/m^3]
  /// Lame's constants [Pa].
  double lambda() const { return young_ * poisson_ / ((1 + poisson_) * (1 - 2 * poisson_)); }
  double mu() const { return young_ / (2 * (1 + poisson_)); }

 private:
  double young_, poisson_;
  std::optional<double> density_;
};

/// Gradients of the four barycentric coordinates [1/m], one column each.
using BarycentricGradients = Eigen::Matrix<double, 3, 4>;
BarycentricGradients barycentric_gradients(const std::array<Vector3, 4>& corners);

/// Gradients of the 4 or 10 shape functions [1/m], one column each, at the point with the given
/// barycentric coordinates.
Eigen::Matrix3Xd shape_gradients(const BarycentricGradients& gradients, int order,
                                 const Eigen::Vector4d& point);

/// Stiffness of an element with `Nodes` nodes [N/m]; unknowns x, y, z of each node in turn.
template <int Nodes>
using ElementStiffness = Eigen::Matrix<double, 3 * Nodes, 3 * Nodes>;

/// The constant-strain tetrahedron. Corners [m], right-handed (tet_mesh.h).
ElementStiffness<4> stiffness_tet4(const std::array<Vector3, 4>& corners, const Material& material);

/// The quadratic tetrahedron whose mid nodes lie on the middles of its edges; the four-point rule
/// integrates it exactly.
ElementStiffness<10> stiffness_tet10(const std::array<Vector3, 4>& corners,
                                     const Material& material);

/// The same with mid nodes anywhere: the isoparametric element, integrated by the four-point rule
/// as CalculiX's C3D10 is. All nodes [m], in the order of tet_mesh.h.
ElementStiffness<10> stiffness_curved_tet10(const std::array<Vector3, 10>& nodes,
                                            const Material& material);

}  // namespace kinetostat::fea
