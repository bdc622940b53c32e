// A bounding-volume hierarchy: which of many boxes touch a given one, without looking at all.
#pragma once

#include <cstddef>
#include <vector>

#include "kinetostat/fea/surface_mesh.h"

namespace kinetostat::fea {

class BoxTree {
 public:
  explicit BoxTree(std::vector<Box> boxes);

  /// Calls visit(index) for every box for which touches(box) is true; touches must be true for
  /// every box that contains one for which it is true.
  template <class Touches, class Visit>
  void visit_if(Touches touches, Visit visit) const {
    if (!nodes_.empty()) descend(0, touches, visit);
  }
  /// Calls visit(index) for every box that shares a point with `box`.
  template <class Visit>
  void visit_overlapping(const Box& box, Visit visit) const {
    visit_if([&box](const Box& other) { return box.intersects(other); }, visit);
  }

 private:
  struct Node {
    Box box;
    int first, last;          // range of order_
    int left = 0, right = 0;  // 0: a leaf
  };

  int build(int first, int last);
  template <class Touches, class Visit>
  void descend(int index, const Touches& touches, const Visit& visit) const {
    const Node& node = nodes_[static_cast<std::size_t>(index)];
    if (!touches(node.box)) return;
    if (node.left != 0) {
      descend(node.left, touches, visit);
      descend(node.right, touches, visit);
      return;
    }
    for (int i = node.first; i < node.last; ++i) {
      const int item = order_[static_cast<std::size_t>(i)];
      if (touches(boxes_[static_cast<std::size_t>(item)])) visit(item);
    }
  }

  std::vector<Box> boxes_;
  std::vector<int> order_;
  std::vector<Node> nodes_;
};

/// The boxes of a mesh's facets, grown on all sides by `margin` [m].
std::vector<Box> facet_boxes(const SurfaceMesh& mesh, double margin);

}  // namespace kinetostat::fea
