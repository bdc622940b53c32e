// Declarations of Chrono's interface: nodes, and the elements between them.
#pragma once

#include "chrono/fea/ChNodeFEAxyzrot.h"

namespace chrono::fea {

class ChMesh : public ChPhysicsItem {
 public:
  void AddNode(std::shared_ptr<ChNodeFEAxyzrot> node) { nodes_.push_back(std::move(node)); }
  const std::vector<std::shared_ptr<ChNodeFEAxyzrot>>& GetNodes() const { return nodes_; }

 private:
  std::vector<std::shared_ptr<ChNodeFEAxyzrot>> nodes_;
};

}  // namespace chrono::fea
