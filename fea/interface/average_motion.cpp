#include "kinetostat/fea/interface/average_motion.h"

#include <algorithm>

#include <Eigen/Cholesky>

#include "kinetostat/common/index.h"
#include "kinetostat/fea/interface/face_integral.h"

namespace kinetostat::fea {
namespace {

using common::at;

// Integrals of the products of shape functions over a triangle of unit area.
const Eigen::Matrix3d linear_products = (Matrix3::Ones() + Matrix3::Identity()) / 12;

Eigen::Matrix<double, 6, 6> quadratic_products() {
  Matrix6 m;
  m << 6, -1, -1, 0, -4, 0,  //
      -1, 6, -1, 0, 0, -4,   //
      -1, -1, 6, -4, 0, 0,   //
      0, 0, -4, 32, 16, 16,  //
      -4, 0, 0, 16, 32, 16,  //
      0, -4, 0, 16, 16, 32;
  return m / 180;
}

}  // namespace

AverageMotion::Face AverageMotion::face_of(const TetMesh& mesh, const BoundaryFace& face) {
  const auto p = [&](std::size_t k) { return mesh.nodes[at(face.nodes[k])]; };
  if (!has_curved_faces(mesh))
    return {.area = 0.5 * (p(1) - p(0)).cross(p(2) - p(0)).norm(),
            .products = mesh.order == 1 ? Eigen::MatrixXd(linear_products)
                                        : Eigen::MatrixXd(quadratic_products())};
  Face own{.products = Matrix6::Zero()};
  integrate_face(mesh, face, [&own](const FaceShapes& shapes, const Vector3&, double area) {
    own.area += area;
    own.products += area * shapes * shapes.transpose();
  });
  own.products /= own.area;
  return own;
}

AverageMotion::AverageMotion(const TetMesh& mesh, const Interface& interface, const Vector3& point)
    : nodes_(interface.nodes) {
  for (const BoundaryFace& face : mesh.boundary) {
    if (face.tag != interface.tag) continue;
    Face own = face_of(mesh, face);
    for (std::size_t k = 0; k < mesh.nodes_per_face(); ++k)
      own.nodes.push_back(static_cast<int>(
          std::lower_bound(nodes_.begin(), nodes_.end(), face.nodes[k]) - nodes_.begin()));
    area_ += own.area;
    faces_.push_back(std::move(own));
  }
  // About the centroid, where forces and moments do not mix, and then moved to the point.
  for (const int n : nodes_) arms_.push_back(mesh.nodes[at(n)] - interface.centroid);
  const auto rows = 3 * static_cast<Eigen::Index>(nodes_.size());
  Eigen::MatrixXd rigid(rows, 6), integrals = Eigen::MatrixXd::Zero(rows, 6);
  for (std::size_t n = 0; n < nodes_.size(); ++n)
    rigid.middleRows<3>(3 * static_cast<Eigen::Index>(n)) = spatial::rigid_motion(arms_[n]);
  for (const Face& face : faces_)
    for (std::size_t a = 0; a < face.nodes.size(); ++a)
      for (std::size_t b = 0; b < face.nodes.size(); ++b)
        integrals.middleRows<3>(3 * Eigen::Index{face.nodes[a]}) +=
            face.area * face.products(static_cast<Eigen::Index>(a), static_cast<Eigen::Index>(b)) *
            rigid.middleRows<3>(3 * Eigen::Index{face.nodes[b]});
  const Matrix6 weight = rigid.transpose() * integrals;
  Matrix6 to_centroid = Matrix6::Identity();  // of a wrench at the point
  to_centroid.bottomLeftCorner<3, 3>() = spatial::skew(point - interface.centroid);
  forces_ = integrals * weight.llt().solve(to_centroid);
  for (Vector3& arm : arms_) arm += interface.centroid - point;
}

Eigen::Matrix3Xd AverageMotion::restricted(const Eigen::Matrix3Xd& displacements) const {
  return displacements(Eigen::all, nodes_);
}

Vector6 AverageMotion::of(const Eigen::Matrix3Xd& displacements) const {
  return forces_.transpose() * restricted(displacements).reshaped();
}

double AverageMotion::departure(const Eigen::Matrix3Xd& displacements, const Vector6& q) const {
  Eigen::Matrix3Xd rest = restricted(displacements);
  for (std::size_t n = 0; n < nodes_.size(); ++n)
    rest.col(static_cast<Eigen::Index>(n)) -= spatial::rigid_motion(arms_[n]) * q;
  double integral = 0;
  for (const Face& face : faces_) {
    const Eigen::MatrixXd local = rest(Eigen::all, face.nodes);
    integral += face.area * (local.transpose() * local).cwiseProduct(face.products).sum();
  }
  return std::sqrt(std::max(integral, 0.0) / area_);
}

}  // namespace kinetostat::fea
