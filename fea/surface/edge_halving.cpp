#include "kinetostat/fea/surface/edge_halving.h"

#include <algorithm>
#include <map>
#include <queue>
#include <tuple>
#include <utility>

#include "kinetostat/common/index.h"

namespace kinetostat::fea {
namespace {

using common::at;

constexpr double plane = 1e-5;        // [rad] between normals of facets in one
constexpr double shorter = 1 - 1e-9;  // what makes a diagonal worth its exchange

class Halving {
 public:
  Halving(const SurfaceMesh& surface, double longest) : longest_(longest) {
    result_.points = surface.points;
    for (const Triangle& t : surface.triangles) {
      const int facet = add_facet(t);
      for (std::size_t s = 0; s < 3; ++s) facets_[edge(t[s], t[(s + 1) % 3])].push_back(facet);
    }
    for (const auto& [edge, _] : facets_) enqueue(edge);
  }

  SurfaceMesh run() && {
    while (!waiting_.empty()) {
      const Edge next = std::get<Edge>(waiting_.top());
      waiting_.pop();
      if (facets_.contains(next)) halve(next);
    }
    return std::move(result_);
  }

 private:
  using Edge = std::pair<int, int>;  // from the lower to the higher end

  static Edge edge(int a, int b) { return std::minmax(a, b); }
  const Vector3& point(int number) const { return result_.points[at(number)]; }
  double length(const Edge& e) const { return (point(e.first) - point(e.second)).norm(); }
  int across(int facet, const Edge& e) const {
    const Triangle& t = result_.triangles[at(facet)];
    return t[0] + t[1] + t[2] - e.first - e.second;
  }

  int add_facet(const Triangle& t) {
    result_.triangles.push_back(t);
    return static_cast<int>(result_.triangles.size()) - 1;
  }

  bool is_in_plane(const std::vector<int>& beside) const {
    if (beside.size() != 2) return false;
    const Vector3 one = result_.area_vector(at(beside[0])),
                  other = result_.area_vector(at(beside[1]));
    return one.dot(other) > 0 && one.cross(other).norm() <= plane * one.norm() * other.norm();
  }

  void enqueue(const Edge& e) {
    const double now = length(e);
    if (now > longest_) waiting_.emplace(!is_in_plane(facets_.at(e)), now, e);
  }

  void halve(const Edge& whole) {
    const auto [a, b] = whole;
    const int middle = static_cast<int>(result_.points.size());
    result_.points.push_back(0.5 * (point(a) + point(b)));
    const std::vector<int> beside = facets_.extract(whole).mapped();
    std::vector<Edge> touched{edge(a, middle), edge(b, middle)};
    for (const int facet : beside) {
      const int c = across(facet, whole);
      Triangle second = result_.triangles[at(facet)];
      std::replace(second.begin(), second.end(), a, middle);
      Triangle& first = result_.triangles[at(facet)];
      std::replace(first.begin(), first.end(), b, middle);
      const int added = add_facet(second);
      move(edge(b, c), facet, added);
      facets_[edge(a, middle)].push_back(facet);
      facets_[edge(b, middle)].push_back(added);
      facets_[edge(c, middle)] = {facet, added};
      touched.insert(touched.end(), {edge(c, middle), edge(a, c), edge(b, c)});
    }
    enqueue(edge(a, middle));
    enqueue(edge(b, middle));
    exchange(std::move(touched));
  }

  void move(const Edge& e, int from, int to) {
    std::vector<int>& beside = facets_.at(e);
    std::replace(beside.begin(), beside.end(), from, to);
  }

  // Diagonals for shorter ones, from these edges on. As each makes the sum of all lengths smaller,
  // that ends.
  void exchange(std::vector<Edge> open) {
    while (!open.empty()) {
      const Edge e = open.back();
      open.pop_back();
      const auto found = facets_.find(e);
      if (found == facets_.end()) continue;
      if (!is_worth(e, found->second)) {
        enqueue(e);
        continue;
      }
      const int f = found->second[0], g = found->second[1], c = across(f, e), d = across(g, e);
      const auto [a, b] = ends_along(e, f);
      facets_.erase(found);
      result_.triangles[at(f)] = {a, d, c};
      result_.triangles[at(g)] = {d, b, c};
      move(edge(b, c), f, g);
      move(edge(a, d), g, f);
      facets_[edge(c, d)] = {f, g};
      open.insert(open.end(), {edge(a, c), edge(b, c), edge(a, d), edge(b, d), edge(c, d)});
    }
  }

  // As the facet runs along it.
  Edge ends_along(const Edge& e, int facet) const {
    const Triangle& t = result_.triangles[at(facet)];
    const auto start = std::find(t.begin(), t.end(), e.first) - t.begin();
    return t[at((start + 1) % 3)] == e.second ? e : Edge{e.second, e.first};
  }

  // A shorter diagonal of two facets in one plane that are a convex quadrangle.
  bool is_worth(const Edge& e, const std::vector<int>& beside) const {
    if (!is_in_plane(beside)) return false;
    const int c = across(beside[0], e), d = across(beside[1], e);
    if (c == d || facets_.contains(edge(c, d)) || !(length(edge(c, d)) < shorter * length(e)))
      return false;
    const auto [a, b] = ends_along(e, beside[0]);
    const Vector3 normal = result_.area_vector(at(beside[0])), across_it = point(c) - point(d);
    const auto side = [&](int p) { return normal.dot((point(p) - point(d)).cross(across_it)); };
    const double least = 1e-9 * normal.norm() * across_it.squaredNorm();
    return side(a) < -least && side(b) > least;
  }

  double longest_;
  SurfaceMesh result_;
  std::map<Edge, std::vector<int>> facets_;  // beside each edge
  // Edges that are too long: whether it is between planes, its length.
  std::priority_queue<std::tuple<bool, double, Edge>> waiting_;
};

}  // namespace

SurfaceMesh halve_edges(const SurfaceMesh& surface, double longest) {
  return Halving(surface, longest).run();
}

}  // namespace kinetostat::fea
