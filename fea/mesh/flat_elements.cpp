#include "kinetostat/fea/mesh/flat_elements.h"

#include <algorithm>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <vector>

#include "kinetostat/common/index.h"

namespace kinetostat::fea {
namespace {

using common::at;
using Tet = std::array<int, 4>;

bool contains(const Tet& tet, int node) {
  return std::find(tet.begin(), tet.end(), node) != tet.end();
}

// The side opposite to corner k, seen counterclockwise from outside.
Triangle side(const Tet& tet, std::size_t k) {
  static constexpr std::size_t sides[4][3] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};
  return {tet[sides[k][0]], tet[sides[k][1]], tet[sides[k][2]]};
}

// The mesh while it changes: which elements are at a node, which faces are the boundary.
class Workshop {
 public:
  Workshop(const TetMesh& mesh, double bar) : nodes_(mesh.nodes), bar_(bar) {
    elements_of_.resize(nodes_.size());
    for (std::size_t e = 0; e < mesh.element_count(); ++e) {
      const auto tet = mesh.element(e);
      add({tet[0], tet[1], tet[2], tet[3]});
    }
    for (const BoundaryFace& face : mesh.boundary) {
      const Triangle t{face.nodes[0], face.nodes[1], face.nodes[2]};
      boundary_[sorted(t)] = face.tag;
      on_boundary_.insert(t.begin(), t.end());
    }
  }

  std::size_t work() {
    constexpr int most_passes = 8;
    for (int pass = 0; pass < most_passes; ++pass) {
      const std::vector<int> flat = flat_ones();
      if (flat.empty()) return 0;
      bool changed = false;
      for (const int e : flat)
        if (alive_[at(e)] && fullness_of(tets_[at(e)]) < bar_)
          changed = peel(e) || reconnect(e) || move_node(e) || join(e) || changed;
      if (!changed) break;
    }
    return flat_ones().size();
  }

  TetMesh result(const TetMesh& before) const;

 private:
  double fullness_of(const Tet& t) const {
    return fullness({nodes_[at(t[0])], nodes_[at(t[1])], nodes_[at(t[2])], nodes_[at(t[3])]});
  }
  // Below zero for an element that is turned inside out.
  double signed_fullness(const Tet& t) const {
    const double v =
        volume({nodes_[at(t[0])], nodes_[at(t[1])], nodes_[at(t[2])], nodes_[at(t[3])]});
    return v > 0 ? fullness_of(t) : -fullness_of(t);
  }
  std::vector<int> flat_ones() const {
    std::vector<int> flat;
    for (std::size_t e = 0; e < tets_.size(); ++e)
      if (alive_[e] && fullness_of(tets_[e]) < bar_) flat.push_back(static_cast<int>(e));
    return flat;
  }
  double least(const std::vector<Tet>& tets) const {
    double value = std::numeric_limits<double>::infinity();
    for (const Tet& t : tets) value = std::min(value, signed_fullness(t));
    return value;
  }
  double least_of(const std::vector<int>& elements) const {
    double value = std::numeric_limits<double>::infinity();
    for (const int e : elements) value = std::min(value, signed_fullness(tets_[at(e)]));
    return value;
  }

  void add(const Tet& tet) {
    const int number = static_cast<int>(tets_.size());
    tets_.push_back(tet);
    alive_.push_back(true);
    for (const int n : tet) elements_of_[at(n)].push_back(number);
  }
  void remove(int e) {
    alive_[at(e)] = false;
    for (const int n : tets_[at(e)]) std::erase(elements_of_[at(n)], e);
  }
  std::vector<int> around(int a, int b) const {
    std::vector<int> found;
    for (const int e : elements_of_[at(a)])
      if (contains(tets_[at(e)], b)) found.push_back(e);
    return found;
  }
  bool is_boundary_edge(int a, int b) const {
    for (const int e : around(a, b))
      for (std::size_t k = 0; k < 4; ++k) {
        const Triangle t = side(tets_[at(e)], k);
        if (std::find(t.begin(), t.end(), a) != t.end() &&
            std::find(t.begin(), t.end(), b) != t.end() && boundary_.contains(sorted(t)))
          return true;
      }
    return false;
  }

  bool peel(int e);
  bool reconnect(int e);
  bool reconnect_around(int a, int b);
  bool move_node(int e);
  bool join(int e);
  bool join_into(int gone, int stays);

  std::vector<Vector3> nodes_;
  std::vector<Tet> tets_;
  std::vector<bool> alive_;
  std::vector<std::vector<int>> elements_of_;
  std::map<Triangle, int> boundary_;  // sorted corners to tag
  std::set<int> on_boundary_;
  double bar_;
};

// A flat element with two sides in the boundary is the difference between the two diagonals of a
// quadrilateral; one with a single side there, between a facet and a point just behind it; one with
// three, a point just in front of a facet.
bool Workshop::peel(int e) {
  const Tet tet = tets_[at(e)];
  std::vector<std::size_t> outer, inner;
  std::set<int> tags;
  for (std::size_t k = 0; k < 4; ++k) {
    const auto face = boundary_.find(sorted(side(tet, k)));
    (face == boundary_.end() ? inner : outer).push_back(k);
    if (face != boundary_.end()) tags.insert(face->second);
  }
  if (outer.empty() || inner.empty() || tags.size() != 1) return false;
  // What comes to light must not be in the boundary yet: a node, or the other diagonal.
  if (outer.size() == 1 && on_boundary_.contains(tet[outer[0]])) return false;
  if (outer.size() == 2 && is_boundary_edge(tet[outer[0]], tet[outer[1]])) return false;
  // The corner that three outer sides share goes with its only element.
  if (outer.size() == 3 && elements_of_[at(tet[inner[0]])].size() != 1) return false;
  for (const std::size_t k : outer) boundary_.erase(sorted(side(tet, k)));
  for (const std::size_t k : inner) boundary_[sorted(side(tet, k))] = *tags.begin();
  if (outer.size() == 1) on_boundary_.insert(tet[outer[0]]);
  if (outer.size() == 3) on_boundary_.erase(tet[inner[0]]);
  remove(e);
  return true;
}

bool Workshop::reconnect(int e) {
  const Tet tet = tets_[at(e)];
  for (const auto& [i, j] : tet_edges)
    if (reconnect_around(tet[at(i)], tet[at(j)])) return true;
  return false;
}

// The nodes around an edge inside the mesh in order, right-handed about it; empty when they do not
// close a ring.
std::vector<int> ring_of(const std::vector<Tet>& tets, int a, int b) {
  std::map<int, int> next;
  for (Tet t : tets) {
    // Rotated (evenly) until it is {a, b, p, q}: then p comes before q.
    if (t[1] == a) t = {t[1], t[0], t[3], t[2]};
    if (t[2] == a) t = {t[2], t[3], t[0], t[1]};
    if (t[3] == a) t = {t[3], t[2], t[1], t[0]};
    while (t[1] != b) t = {t[0], t[2], t[3], t[1]};
    if (!next.emplace(t[2], t[3]).second) return {};
  }
  std::vector<int> ring{next.begin()->first};
  while (ring.size() <= next.size()) {
    const auto step = next.find(ring.back());
    if (step == next.end()) return {};
    if (step->second == ring.front()) break;
    ring.push_back(step->second);
  }
  return ring.size() == next.size() ? ring : std::vector<int>();
}

// Best triangulation of the ring, by Klincsek's recursion over its chords.
bool Workshop::reconnect_around(int a, int b) {
  if (is_boundary_edge(a, b)) return false;
  const std::vector<int> old = around(a, b);
  constexpr std::size_t largest_ring = 12;
  if (old.size() < 3 || old.size() > largest_ring) return false;
  std::vector<Tet> tets;
  tets.reserve(old.size());
  for (const int e : old) tets.push_back(tets_[at(e)]);
  const std::vector<int> ring = ring_of(tets, a, b);
  const std::size_t n = ring.size();
  if (n < 3) return false;
  const auto pair = [&](std::size_t i, std::size_t k, std::size_t j) {
    return std::array<Tet, 2>{Tet{a, ring[i], ring[k], ring[j]}, Tet{ring[i], ring[k], ring[j], b}};
  };
  std::vector<std::vector<double>> best(n, std::vector<double>(n, 1));
  std::vector<std::vector<std::size_t>> middle(n, std::vector<std::size_t>(n, 0));
  for (std::size_t span = 2; span < n; ++span)
    for (std::size_t i = 0; i + span < n; ++i) {
      const std::size_t j = i + span;
      best[i][j] = -std::numeric_limits<double>::infinity();
      for (std::size_t k = i + 1; k < j; ++k) {
        const auto two = pair(i, k, j);
        const double value =
            std::min({signed_fullness(two[0]), signed_fullness(two[1]), best[i][k], best[k][j]});
        if (value <= best[i][j]) continue;
        best[i][j] = value;
        middle[i][j] = k;
      }
    }
  if (!(best[0][n - 1] > 0) || best[0][n - 1] < 2 * least(tets)) return false;
  std::vector<Tet> made;
  const auto collect = [&](const auto& self, std::size_t i, std::size_t j) -> void {
    if (j < i + 2) return;
    const std::size_t k = middle[i][j];
    for (const Tet& t : pair(i, k, j)) made.push_back(t);
    self(self, i, k);
    self(self, k, j);
  };
  collect(collect, 0, n - 1);
  for (const int e : old) remove(e);
  for (const Tet& t : made) add(t);
  return true;
}

// Along the normals of the opposite sides, by a part of the shortest edge, as long as that helps.
bool Workshop::move_node(int e) {
  const Tet tet = tets_[at(e)];
  bool moved = false;
  for (std::size_t k = 0; k < 4; ++k) {
    const int n = tet[k];
    if (on_boundary_.contains(n)) continue;
    const std::vector<int>& near = elements_of_[at(n)];
    double shortest = std::numeric_limits<double>::infinity();
    for (const int other : near)
      for (const int p : tets_[at(other)])
        if (p != n) shortest = std::min(shortest, (nodes_[at(p)] - nodes_[at(n)]).norm());
    const Triangle t = side(tet, k);
    const Vector3 normal = (nodes_[at(t[1])] - nodes_[at(t[0])])
                               .cross(nodes_[at(t[2])] - nodes_[at(t[0])])
                               .normalized();
    const Vector3 home = nodes_[at(n)];
    Vector3 best = home;
    double value = least_of(near);
    for (const double step : {-0.5, -0.25, -0.1, -0.03, -0.01, 0.01, 0.03, 0.1, 0.25, 0.5}) {
      nodes_[at(n)] = home + step * shortest * normal;
      if (const double now = least_of(near); now > 2 * std::max(value, 0.0))
        value = now, best = nodes_[at(n)];
    }
    nodes_[at(n)] = best;
    moved = moved || best != home;
    if (fullness_of(tet) >= bar_) return true;
  }
  return moved;
}

bool Workshop::join(int e) {
  const Tet tet = tets_[at(e)];
  for (const auto& [i, j] : tet_edges)
    if (join_into(tet[at(i)], tet[at(j)]) || join_into(tet[at(j)], tet[at(i)])) return true;
  return false;
}

// A node inside the mesh becomes one with a neighbour.
bool Workshop::join_into(int gone, int stays) {
  if (on_boundary_.contains(gone)) return false;
  const std::vector<int> old = elements_of_[at(gone)];
  std::vector<Tet> made;
  for (const int e : old) {
    Tet t = tets_[at(e)];
    if (contains(t, stays)) continue;
    std::replace(t.begin(), t.end(), gone, stays);
    made.push_back(t);
  }
  if (made.empty() || !(least(made) > 2 * std::max(least_of(old), 0.0))) return false;
  for (const int e : old) remove(e);
  for (const Tet& t : made) add(t);
  return true;
}

TetMesh Workshop::result(const TetMesh& before) const {
  TetMesh mesh{.made_by = before.made_by};
  std::vector<int> number(nodes_.size(), -1);
  for (std::size_t e = 0; e < tets_.size(); ++e)
    if (alive_[e])
      for (const int n : tets_[e]) number[at(n)] = 0;
  for (std::size_t n = 0; n < number.size(); ++n) {
    if (number[n] < 0) continue;
    number[n] = static_cast<int>(mesh.nodes.size());
    mesh.nodes.push_back(nodes_[n]);
  }
  for (std::size_t e = 0; e < tets_.size(); ++e) {
    if (!alive_[e]) continue;
    for (const int n : tets_[e]) mesh.connectivity.push_back(number[at(n)]);
    for (std::size_t k = 0; k < 4; ++k) {
      const Triangle t = side(tets_[e], k);
      if (const auto face = boundary_.find(sorted(t)); face != boundary_.end())
        mesh.boundary.push_back(
            {.nodes = {number[at(t[0])], number[at(t[1])], number[at(t[2])], -1, -1, -1},
             .tag = face->second});
    }
  }
  return mesh;
}

}  // namespace

double fullness(const std::array<Vector3, 4>& corners) {
  double longest = 0;
  for (const auto& [a, b] : tet_edges)
    longest = std::max(longest, (corners[at(a)] - corners[at(b)]).norm());
  return longest > 0 ? std::abs(volume(corners)) / (longest * longest * longest) : 0;
}

bool has_flat_elements(const TetMesh& mesh) {
  for (std::size_t e = 0; e < mesh.element_count(); ++e)
    if (fullness(mesh.corners(e)) < flat_fullness) return true;
  return false;
}

std::size_t remove_flat_elements(TetMesh& mesh, double bar) {
  bool any = false;
  for (std::size_t e = 0; e < mesh.element_count() && !any; ++e)
    any = fullness(mesh.corners(e)) < bar;
  if (!any) return 0;
  Workshop workshop(mesh, bar);
  const std::size_t left = workshop.work();
  mesh = workshop.result(mesh);
  return left;
}

}  // namespace kinetostat::fea
