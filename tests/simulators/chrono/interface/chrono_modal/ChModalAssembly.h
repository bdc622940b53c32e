// Declarations of Chrono's interface: an assembly whose nodes inside are replaced by modes.
#pragma once

#include <stdexcept>

#include <Eigen/Core>

#include "chrono/fea/ChMesh.h"

namespace chrono::modal {

class ChModalDamping {};
class ChModalDampingNone : public ChModalDamping {};

class ChModalAssembly : public ChPhysicsItem {
 public:
  enum class ReductionType { HERTING, CRAIG_BAMPTON };

  void SetReductionType(ReductionType type) { reduction = type; }
  void SetInternalNodesUpdate(bool flag) { updates_internal_nodes = flag; }
  void SetModalAutomaticGravity(bool flag) { has_gravity = flag; }
  void Add(std::shared_ptr<ChPhysicsItem> item) {
    outside_ = std::dynamic_pointer_cast<fea::ChMesh>(item);
  }
  void AddInternal(std::shared_ptr<ChPhysicsItem> item) {
    inside_ = std::dynamic_pointer_cast<fea::ChMesh>(item);
  }

  /// Turns the matrices into the floating frame: that of the first node outside where nothing has a
  /// mass. The modes follow from the block of the nodes inside.
  template <class ModalSolver>
  void DoModalReduction(ChSparseMatrix& full_M, ChSparseMatrix& full_K, ChSparseMatrix& full_Cq,
                        const ModalSolver& solver,
                        const ChModalDamping& /*damping*/ = ChModalDampingNone()) {
    const auto &outside = outside_->GetNodes(), &inside = inside_->GetNodes();
    const auto size = static_cast<Eigen::Index>(6 * (outside.size() + inside.size()));
    if (full_M.rows() != size || full_M.cols() != size || full_K.rows() != size ||
        full_K.cols() != size || full_Cq.cols() != size || full_Cq.rows() != 0)
      throw std::logic_error("the matrices have another size than the nodes");
    // Its Krylov-Schur method has a subspace of twice as many, which must be a part of the whole.
    if (2 * solver.modes + 1 > static_cast<Eigen::Index>(6 * inside.size()))
      throw std::logic_error("there are too few coordinates inside for these modes");
    for (const auto* nodes : {&outside, &inside})
      for (const auto& node : *nodes)
        if (node->GetMass() != 0 || !node->GetInertia().isZero(0))
          throw std::logic_error("a node has a mass, which the floating frame would follow");
    Eigen::MatrixXd turn = Eigen::MatrixXd::Identity(size, size);
    for (Eigen::Index node = 0; node < size; node += 6)
      turn.block<3, 3>(node, node) = outside.front()->Frame().GetRotMat();
    local_M = turn.transpose() * Eigen::MatrixXd(full_M) * turn;
    local_K = turn.transpose() * Eigen::MatrixXd(full_K) * turn;
  }

  // For tests: what was set, and the matrices in the floating frame.
  ReductionType reduction = ReductionType::HERTING;
  bool updates_internal_nodes = true, has_gravity = true;
  Eigen::MatrixXd local_M, local_K;

 private:
  std::shared_ptr<fea::ChMesh> outside_, inside_;
};

}  // namespace chrono::modal
