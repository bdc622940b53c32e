// The motion of an interface that need not stay rigid, as a whole.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "kinetostat/fea/interface/interface_selection.h"
#include "kinetostat/fea/mesh/tet_mesh.h"

namespace kinetostat::fea {

/// The rigid motion q at `point` that fits the displacements u of an interface best: the integral
/// of |u - rigid_motion q|^2 over the area is least, q = G'u. By reciprocity a wrench w at `point`
/// acts as the nodal forces G w, those of a traction that varies linearly over the interface. The
/// integrals are those of the shape functions, so G does not depend on how the faces are meshed.
class AverageMotion {
 public:
  /// Requires an interface with an area that is not all on one line.
  AverageMotion(const TetMesh& mesh, const Interface& interface, const Vector3& point);

  const std::vector<int>& nodes() const { return nodes_; }
  /// G: three rows for each of nodes() [1; 1/m], one column for each of Fx Fy Fz Mx My Mz.
  const Eigen::MatrixXd& nodal_forces() const { return forces_; }

  /// G'u [m; rad] of the displacements of all nodes of the mesh, one column each.
  Vector6 of(const Eigen::Matrix3Xd& displacements) const;
  /// Root of the mean square over the area [m] of what the displacements differ from the rigid
  /// motion q.
  double departure(const Eigen::Matrix3Xd& displacements, const Vector6& q) const;

 private:
  struct Face;
  static Face face_of(const TetMesh& mesh, const BoundaryFace& face);
  Eigen::Matrix3Xd restricted(const Eigen::Matrix3Xd& displacements) const;

  struct Face {
    std::vector<int> nodes = {};  // places in nodes_
    double area = 0;
    Eigen::MatrixXd products = {};  // integrals of those of two shape functions, over the area
  };
  std::vector<int> nodes_;
  std::vector<Vector3> arms_;  // from the point
  std::vector<Face> faces_;
  double area_ = 0;
  Eigen::MatrixXd forces_;
};

}  // namespace kinetostat::fea
