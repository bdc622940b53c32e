#include "kinetostat/fea/surface/surface_orientation.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "kinetostat/common/index.h"

namespace kinetostat::fea {
namespace {

using common::at;

// Walks each shell from its first facet and turns every facet to agree with the one it was reached
// from; the smaller party is the one called flipped. Only edges of exactly two facets count.
class OrientationWalk {
 public:
  OrientationWalk(std::size_t facets, const std::vector<EdgeUse>& uses) : turned_(facets, -1) {
    links_.resize(facets);
    for_each_edge(uses, [this](auto first, auto last) {
      if (last - first != 2) return;
      const bool agree = first[0].forward != first[1].forward;
      links_[at(first[0].facet)].push_back({first[1].facet, agree});
      links_[at(first[1].facet)].push_back({first[0].facet, agree});
      if (!agree) ++bad_edges_;
    });
    for (std::size_t f = 0; f < facets; ++f)
      if (turned_[f] < 0) walk(static_cast<int>(f));
  }

  const std::vector<int>& flipped() const { return flipped_; }
  std::size_t bad_edges() const { return bad_edges_; }

 private:
  struct Link {
    int facet;
    bool agree;
  };

  void walk(int start) {
    std::vector<int> reached{start};
    turned_[at(start)] = 0;
    for (std::size_t i = 0; i < reached.size(); ++i)
      for (const Link& link : links_[at(reached[i])]) {
        int& turned = turned_[at(link.facet)];
        const int wanted = turned_[at(reached[i])] ^ (link.agree ? 0 : 1);
        if (turned < 0) {
          turned = wanted;
          reached.push_back(link.facet);
        } else if (turned != wanted) {
          // One-sided, like a Moebius strip: no choice agrees everywhere.
          flipped_.push_back(link.facet);
        }
      }
    const auto is_turned = [this](int f) { return turned_[at(f)] == 1; };
    const auto count = at(std::count_if(reached.begin(), reached.end(), is_turned));
    const bool minority_is_turned = 2 * count <= reached.size();
    for (const int f : reached)
      if (is_turned(f) == minority_is_turned) flipped_.push_back(f);
  }

  std::vector<std::vector<Link>> links_;
  std::vector<int> turned_;  // -1: not reached, 0: as the first of its shell, 1: the other way
  std::vector<int> flipped_;
  std::size_t bad_edges_ = 0;
};

// Six times the volume of the tetrahedra between the facets and a point near the part.
double volume_of(const SurfaceMesh& mesh, const std::vector<int>& facets, const Vector3& origin) {
  double six = 0;
  for (const int facet : facets) {
    const auto f = at(facet);
    six += (mesh.corner(f, 0) - origin)
               .dot((mesh.corner(f, 1) - origin).cross(mesh.corner(f, 2) - origin));
  }
  return six / 6;
}

std::vector<Shell> find_shells(const SurfaceMesh& mesh, const std::vector<EdgeUse>& uses) {
  std::vector<int> parent(mesh.triangles.size());
  std::iota(parent.begin(), parent.end(), 0);
  const auto root = [&parent](int f) {
    while (parent[at(f)] != f) f = parent[at(f)] = parent[at(parent[at(f)])];
    return f;
  };
  for_each_edge(uses, [&](auto first, auto last) {
    for (auto use = first + 1; use != last; ++use) {
      const int a = root(first->facet), b = root(use->facet);
      parent[at(std::max(a, b))] = std::min(a, b);
    }
  });
  std::vector<Shell> shells;
  std::vector<int> shell_of(parent.size(), -1);
  const Vector3 origin = bounding_box(mesh.points).center();
  for (std::size_t f = 0; f < parent.size(); ++f) {
    int& shell = shell_of[at(root(static_cast<int>(f)))];
    if (shell < 0) {
      shell = static_cast<int>(shells.size());
      shells.emplace_back();
    }
    Shell& mine = shells[at(shell)];
    mine.facets.push_back(static_cast<int>(f));
    for (std::size_t k = 0; k < 3; ++k) mine.box.extend(mesh.corner(f, k));
  }
  for (Shell& shell : shells) shell.volume = volume_of(mesh, shell.facets, origin);
  return shells;
}

// Times the shell winds around the point (van Oosterom and Strackee's solid angle).
double winding_number(const SurfaceMesh& mesh, const Shell& shell, const Vector3& point) {
  double angle = 0;
  for (const int facet : shell.facets) {
    const auto f = at(facet);
    const Vector3 a = mesh.corner(f, 0) - point, b = mesh.corner(f, 1) - point,
                  c = mesh.corner(f, 2) - point;
    const double la = a.norm(), lb = b.norm(), lc = c.norm();
    angle += 2 * std::atan2(a.dot(b.cross(c)),
                            la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb);
  }
  return angle / (4 * std::numbers::pi);
}

// A file whose facets share no corners has as many shells as facets; but what encloses anything has
// four facets.
void nest_shells(const SurfaceMesh& mesh, std::vector<Shell>& shells) {
  std::vector<const Shell*> enclosing;
  for (const Shell& shell : shells)
    if (shell.facets.size() >= 4) enclosing.push_back(&shell);
  for (Shell& inner : shells)
    for (const Shell* outer : enclosing) {
      if (&inner == outer || !outer->box.contains(inner.box)) continue;
      const Vector3& probe = mesh.corner(at(inner.facets.front()), 0);
      if (std::abs(winding_number(mesh, *outer, probe)) > 0.5) ++inner.depth;
    }
}

void turn(Triangle& t) { std::swap(t[1], t[2]); }

}  // namespace

FlippedFacets flipped_facets(std::size_t facet_count, const std::vector<EdgeUse>& uses) {
  const OrientationWalk walk(facet_count, uses);
  return {walk.flipped(), walk.bad_edges()};
}

std::vector<Shell> nested_shells(const SurfaceMesh& mesh, const std::vector<EdgeUse>& uses) {
  std::vector<Shell> shells = find_shells(mesh, uses);
  nest_shells(mesh, shells);
  return shells;
}

std::size_t orient_outward(SurfaceMesh& mesh) {
  const std::vector<Triangle> before = mesh.triangles;
  std::vector<int> flipped = flipped_facets(mesh.triangles.size(), edge_uses(mesh)).facets;
  std::sort(flipped.begin(), flipped.end());
  flipped.erase(std::unique(flipped.begin(), flipped.end()), flipped.end());
  for (const int f : flipped) turn(mesh.triangles[at(f)]);
  const std::vector<Shell> shells = nested_shells(mesh, edge_uses(mesh));
  const bool inside_out = std::any_of(shells.begin(), shells.end(), [](const Shell& shell) {
    return shell.depth == 0 && shell.volume < 0;
  });
  for (const Shell& shell : shells) {
    const bool should_be_positive = shell.depth % 2 == 0;
    const bool wrong = should_be_positive ? shell.volume < 0 : shell.volume > 0;
    if (wrong && (should_be_positive || inside_out))
      for (const int f : shell.facets) turn(mesh.triangles[at(f)]);
  }
  std::size_t turned = 0;
  for (std::size_t f = 0; f < before.size(); ++f) turned += before[f] != mesh.triangles[f] ? 1 : 0;
  return turned;
}

}  // namespace kinetostat::fea
