#include "kinetostat/fea/surface/box_tree.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "kinetostat/common/index.h"

namespace kinetostat::fea {
namespace {

using common::at;

constexpr int leaf_size = 4;

}  // namespace

BoxTree::BoxTree(std::vector<Box> boxes) : boxes_(std::move(boxes)), order_(boxes_.size()) {
  std::iota(order_.begin(), order_.end(), 0);
  if (!boxes_.empty()) build(0, static_cast<int>(boxes_.size()));
}

// Halves the range at the median centre along the longest side of its box; so the depth is bounded
// by the logarithm of the size whatever the shape.
int BoxTree::build(int first, int last) {
  const int index = static_cast<int>(nodes_.size());
  Box box;
  for (int i = first; i < last; ++i) box.extend(boxes_[at(order_[at(i)])]);
  nodes_.push_back({box, first, last});
  if (last - first <= leaf_size) return index;
  Eigen::Index axis = 0;
  box.sizes().maxCoeff(&axis);
  const int middle = first + (last - first) / 2;
  std::nth_element(order_.begin() + first, order_.begin() + middle, order_.begin() + last,
                   [this, axis](int a, int b) {
                     const double ca = boxes_[at(a)].center()[axis];
                     const double cb = boxes_[at(b)].center()[axis];
                     return ca != cb ? ca < cb : a < b;
                   });
  const int left = build(first, middle);
  const int right = build(middle, last);
  nodes_[at(index)].left = left;
  nodes_[at(index)].right = right;
  return index;
}

std::vector<Box> facet_boxes(const SurfaceMesh& mesh, double margin) {
  std::vector<Box> boxes(mesh.triangles.size());
  for (std::size_t f = 0; f < boxes.size(); ++f) {
    for (std::size_t k = 0; k < 3; ++k) boxes[f].extend(mesh.corner(f, k));
    boxes[f].min().array() -= margin;
    boxes[f].max().array() += margin;
  }
  return boxes;
}

}  // namespace kinetostat::fea
