// A bounding-volume hierarchy: which of many boxes touch a given one, without looking at all.
#pragma once

#include <cstddef>
#include <vector>

#include "kinetostat/fea/surface/surface_mesh.h"

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
  /// Calls visit(index) for boxes nearer to the point than the square root of `squared_limit`,
  /// which visit may lower as it goes; nearer parts of the tree come first.
  template <class Visit>
  void visit_near(const Vector3& point, const double& squared_limit, Visit visit) const {
    if (!nodes_.empty()) approach(0, point, squared_limit, visit);
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

  template <class Visit>
  void approach(int index, const Vector3& point, const double& limit, const Visit& visit) const {
    const Node& node = nodes_[static_cast<std::size_t>(index)];
    if (node.box.squaredExteriorDistance(point) >= limit) return;
    if (node.left == 0) {
      for (int i = node.first; i < node.last; ++i) {
        const int item = order_[static_cast<std::size_t>(i)];
        if (boxes_[static_cast<std::size_t>(item)].squaredExteriorDistance(point) < limit)
          visit(item);
      }
      return;
    }
    const auto distance = [&](int child) {
      return nodes_[static_cast<std::size_t>(child)].box.squaredExteriorDistance(point);
    };
    const bool left_first = distance(node.left) <= distance(node.right);
    approach(left_first ? node.left : node.right, point, limit, visit);
    approach(left_first ? node.right : node.left, point, limit, visit);
  }

  std::vector<Box> boxes_;
  std::vector<int> order_;
  std::vector<Node> nodes_;
};

/// The boxes of a mesh's facets, grown on all sides by `margin` [m].
std::vector<Box> facet_boxes(const SurfaceMesh& mesh, double margin);

}  // namespace kinetostat::fea
