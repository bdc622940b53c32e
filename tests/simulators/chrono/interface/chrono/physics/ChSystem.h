// Declarations of Chrono's interface: frames, sparse matrices, a system.
#pragma once

#include <memory>
#include <utility>
#include <vector>

#include <Eigen/Geometry>
#include <Eigen/SparseCore>

namespace chrono_types {

template <class T, class... Arguments>
std::shared_ptr<T> make_shared(Arguments&&... arguments) {
  return std::make_shared<T>(std::forward<Arguments>(arguments)...);
}

}  // namespace chrono_types

namespace chrono {

using ChVector3d = Eigen::Vector3d;
using ChSparseMatrix = Eigen::SparseMatrix<double, Eigen::RowMajor, int>;

template <class Real = double>
using ChMatrix33 = Eigen::Matrix<Real, 3, 3, Eigen::RowMajor>;

template <class Real = double>
using ChQuaternion = Eigen::Quaternion<Real>;

template <class Real = double>
class ChFrame {
 public:
  explicit ChFrame(const ChVector3d& position = ChVector3d::Zero(),
                   const ChQuaternion<Real>& rotation = ChQuaternion<Real>::Identity())
      : position_(position), rotation_(rotation), matrix_(rotation.toRotationMatrix()) {}

  const ChVector3d& GetPos() const { return position_; }
  const ChQuaternion<Real>& GetRot() const { return rotation_; }
  const ChMatrix33<Real>& GetRotMat() const { return matrix_; }
  ChVector3d TransformPointLocalToParent(const ChVector3d& point) const {
    return position_ + matrix_ * point;
  }

 private:
  ChVector3d position_;
  ChQuaternion<Real> rotation_;
  ChMatrix33<Real> matrix_;
};

class ChPhysicsItem {
 public:
  virtual ~ChPhysicsItem() = default;
};

class ChSystem {
 public:
  void Add(std::shared_ptr<ChPhysicsItem> item) { items.push_back(std::move(item)); }

  std::vector<std::shared_ptr<ChPhysicsItem>> items;
};

}  // namespace chrono
