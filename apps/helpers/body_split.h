// Bodies that share edges, as welded corners make them: each with corners of its own.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <map>
#include <numeric>
#include <utility>
#include <vector>

#include <Eigen/Dense>

namespace kinetostat::helpers {

/// Triangles by their corners, and these by their points.
struct Triangles {
  std::vector<Eigen::Vector3d> points;
  std::vector<std::array<std::size_t, 3>> corners;
};

namespace body_split {

// A triangle at an edge that goes from the lower corner to the higher: along it, then the material
// is where angles about the edge are smaller, or against it.
struct AtEdge {
  std::size_t triangle = 0, from = 0, to = 0;  // places 0 to 2 of the lower and the higher corner
  bool is_along = false;
  double angle = 0;
};

using Edges = std::map<std::pair<std::size_t, std::size_t>, std::vector<AtEdge>>;

inline Edges edges_of(const Triangles& mesh) {
  Edges edges;
  for (std::size_t t = 0; t < mesh.corners.size(); ++t)
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t next = (k + 1) % 3;
      const bool is_along = mesh.corners[t][k] < mesh.corners[t][next];
      const auto [from, to] = is_along ? std::pair(k, next) : std::pair(next, k);
      edges[{mesh.corners[t][from], mesh.corners[t][to]}].push_back({t, from, to, is_along});
    }
  return edges;
}

inline void measure_angles(const Triangles& mesh, std::vector<AtEdge>& edge) {
  const auto point = [&](const AtEdge& at, std::size_t place) {
    return mesh.points[mesh.corners[at.triangle][place]];
  };
  const Eigen::Vector3d origin = point(edge[0], edge[0].from);
  const Eigen::Vector3d axis = (point(edge[0], edge[0].to) - origin).normalized();
  const Eigen::Vector3d first = axis.unitOrthogonal(), second = axis.cross(first);
  for (AtEdge& at : edge) {
    const Eigen::Vector3d side = point(at, 3 - at.from - at.to) - origin;
    at.angle = std::atan2(side.dot(second), side.dot(first));
  }
}

// Those between which material lies. Faces that lie on one another bound two bodies: there the one
// that ends comes before the one that starts.
inline std::vector<std::pair<std::size_t, std::size_t>> wedges(std::vector<AtEdge> edge) {
  constexpr double same = 1e-6;  // [rad]
  std::vector<std::pair<std::size_t, std::size_t>> pairs;
  const auto starts = [](const AtEdge& at) { return !at.is_along; };
  std::vector<bool> is_taken(edge.size(), false);
  for (std::size_t b = 0; b < edge.size(); ++b) {
    if (!starts(edge[b])) continue;
    std::size_t nearest = edge.size();
    double least = 0;
    for (std::size_t e = 0; e < edge.size(); ++e) {
      if (starts(edge[e]) || is_taken[e]) continue;
      double width = edge[e].angle - edge[b].angle;
      while (width <= same) width += 2 * M_PI;
      if (nearest == edge.size() || width < least) nearest = e, least = width;
    }
    if (nearest == edge.size()) continue;
    is_taken[nearest] = true;
    pairs.emplace_back(b, nearest);
  }
  return pairs;
}

// Which corners are one.
class Corners {
 public:
  explicit Corners(std::size_t count) : parents_(count) {
    std::iota(parents_.begin(), parents_.end(), 0);
  }
  std::size_t root(std::size_t corner) {
    while (parents_[corner] != corner) corner = parents_[corner] = parents_[parents_[corner]];
    return corner;
  }
  // Along an edge that two triangles share.
  void join(const AtEdge& a, const AtEdge& b) {
    parents_[root(3 * a.triangle + a.from)] = root(3 * b.triangle + b.from);
    parents_[root(3 * a.triangle + a.to)] = root(3 * b.triangle + b.to);
  }

 private:
  std::vector<std::size_t> parents_;
};

}  // namespace body_split

/// The same triangles, of which no two bodies share a corner: at an edge of more than two triangles
/// those belong together between which material lies. All must be oriented; where they are not, at
/// an edge, it stays as it is.
inline void split_bodies(Triangles& mesh) {
  body_split::Corners corners(3 * mesh.corners.size());
  for (auto& [ends, edge] : body_split::edges_of(mesh)) {
    const auto along = std::count_if(edge.begin(), edge.end(),
                                     [](const body_split::AtEdge& at) { return at.is_along; });
    if (edge.size() <= 2 || 2 * along != std::ssize(edge)) {
      for (const body_split::AtEdge& at : edge) corners.join(edge[0], at);
      continue;
    }
    body_split::measure_angles(mesh, edge);
    for (const auto& [start, end] : body_split::wedges(edge)) corners.join(edge[start], edge[end]);
  }
  std::map<std::size_t, std::size_t> numbers;  // of new corners, by their roots
  const std::vector<Eigen::Vector3d> before = std::exchange(mesh.points, {});
  for (std::size_t t = 0; t < mesh.corners.size(); ++t)
    for (std::size_t k = 0; k < 3; ++k) {
      const auto [found, is_new] = numbers.emplace(corners.root(3 * t + k), mesh.points.size());
      if (is_new) mesh.points.push_back(before[mesh.corners[t][k]]);
      mesh.corners[t][k] = found->second;
    }
}

}  // namespace kinetostat::helpers
