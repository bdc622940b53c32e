#include "kinetostat/fea/mesh/edge_division.h"

#include <algorithm>
#include <limits>
#include <map>
#include <queue>
#include <tuple>
#include <utility>

#include "kinetostat/common/index.h"
#include "kinetostat/fea/surface/box_tree.h"
#include "kinetostat/fea/surface/surface_topology.h"

namespace kinetostat::fea {
namespace {

using common::at;

constexpr double most_sizes_per_edge = 2;
constexpr int most_halvings = 12;

class Wishes {
 public:
  explicit Wishes(const SizeField& sizes) : sizes_(sizes), tree_(boxes(sizes.points)) {}

  double at(const Vector3& point) const {
    double nearest = std::numeric_limits<double>::infinity(), wish = nearest;
    tree_.visit_near(point, nearest, [&](int i) {
      const double distance = (sizes_.points[common::at(i)] - point).squaredNorm();
      if (distance >= nearest) return;
      nearest = distance;
      wish = sizes_.sizes[common::at(i)];
    });
    return wish;
  }

 private:
  static std::vector<Box> boxes(const std::vector<Vector3>& points) {
    std::vector<Box> boxes;
    boxes.reserve(points.size());
    for (const Vector3& p : points) boxes.emplace_back(p);
    return boxes;
  }

  const SizeField& sizes_;
  BoxTree tree_;
};

class Division {
 public:
  Division(const SurfaceMesh& surface, const SizeField& sizes) : wishes_(sizes) {
    result_.mesh.points = surface.points;
  }

  void divide_edge(int low, int high) {
    std::vector<int> between;
    halve(low, high, most_halvings, between);
    if (!between.empty()) between_[{low, high}] = std::move(between);
  }

  void add_facet(const Triangle& t, int parent) {
    parent_ = parent;
    cut(t, {side(t[0], t[1]), side(t[1], t[2]), side(t[2], t[0])});
  }

  DividedSurface result() && { return std::move(result_); }

 private:
  using Sides = std::array<std::vector<int>, 3>;  // points between the corners k and k + 1

  void halve(int a, int b, int halvings, std::vector<int>& between) {
    const Vector3 &p = result_.mesh.points[at(a)], &q = result_.mesh.points[at(b)];
    const Vector3 middle = 0.5 * (p + q);
    if (halvings == 0 || (q - p).norm() <= most_sizes_per_edge * wishes_.at(middle)) return;
    const int number = static_cast<int>(result_.mesh.points.size());
    result_.mesh.points.push_back(middle);
    halve(a, number, halvings - 1, between);
    between.push_back(number);
    halve(number, b, halvings - 1, between);
  }

  std::vector<int> side(int from, int to) const {
    const auto found = between_.find(std::minmax(from, to));
    if (found == between_.end()) return {};
    return from < to ? found->second
                     : std::vector<int>(found->second.rbegin(), found->second.rend());
  }

  // From the middle one of the points on the side with the most, to the corner across.
  void cut(const Triangle& t, const Sides& sides) {
    std::size_t k = 0;
    for (std::size_t s = 1; s < 3; ++s)
      if (sides[s].size() > sides[k].size()) k = s;
    if (sides[k].empty()) {
      result_.mesh.triangles.push_back(t);
      result_.parent.push_back(parent_);
      return;
    }
    const std::vector<int>& points = sides[k];
    const auto middle = points.begin() + static_cast<std::ptrdiff_t>(points.size() / 2);
    const std::size_t next = (k + 1) % 3, last = (k + 2) % 3;
    cut({t[k], *middle, t[last]}, {std::vector<int>(points.begin(), middle), {}, sides[last]});
    cut({*middle, t[next], t[last]}, {std::vector<int>(middle + 1, points.end()), sides[next], {}});
  }

  Wishes wishes_;
  DividedSurface result_;
  std::map<std::pair<int, int>, std::vector<int>> between_;  // from the lower to the higher end
  int parent_ = 0;
};

constexpr double plane = 1e-5;        // [rad] between normals of facets in one
constexpr double fairly_high = 0.02;  // of facets over a new diagonal, beside its length
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
    std::vector<Edge> touched{edge(a, middle), edge(b, middle)};
    const std::vector<int> beside = facets_.extract(whole).mapped();
    for (const int facet : beside) {
      const int c = across(facet, whole);
      split(facet, whole, middle);
      touched.insert(touched.end(), {edge(c, middle), edge(a, c), edge(b, c)});
    }
    enqueue(edge(a, middle));
    enqueue(edge(b, middle));
    exchange(std::move(touched));
  }

  // Into the part at the lower end of the edge, which keeps the number, and the other one.
  void split(int facet, const Edge& whole, int middle) {
    const auto [a, b] = whole;
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
      if (is_worth(e, found->second)) {
        const std::vector<Edge> touched = turn(e, found->second[0], found->second[1]);
        open.insert(open.end(), touched.begin(), touched.end());
      } else {
        enqueue(e);
      }
    }
  }

  // The diagonal of two facets; gives all edges of both.
  std::vector<Edge> turn(const Edge& e, int f, int g) {
    const auto [a, b] = ends_along(e, f);
    const int c = across(f, e), d = across(g, e);
    facets_.erase(e);
    result_.triangles[at(f)] = {a, d, c};
    result_.triangles[at(g)] = {d, b, c};
    move(edge(b, c), f, g);
    move(edge(a, d), g, f);
    facets_[edge(c, d)] = {f, g};
    return {edge(a, c), edge(b, c), edge(a, d), edge(b, d), edge(c, d)};
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
    const double least = fairly_high * normal.norm() * across_it.squaredNorm();
    return side(a) < -least && side(b) > least;
  }

  double longest_;
  SurfaceMesh result_;
  std::map<Edge, std::vector<int>> facets_;  // beside each edge
  // Edges that are too long: whether it is between planes, its length.
  std::priority_queue<std::tuple<bool, double, Edge>> waiting_;
};

}  // namespace

DividedSurface divide_edges(const SurfaceMesh& surface, const std::vector<std::int32_t>& face_of,
                            const SizeField& sizes) {
  Division division(surface, sizes);
  if (!sizes.empty())
    for_each_edge(edge_uses(surface), [&](auto first, auto last) {
      for (auto use = first; use != last; ++use)
        if (face_of[at(use->facet)] != face_of[at(first->facet)])
          return division.divide_edge(first->low, first->high);
    });
  for (std::size_t f = 0; f < surface.triangles.size(); ++f)
    division.add_facet(surface.triangles[f], static_cast<int>(f));
  return std::move(division).result();
}

SurfaceMesh halve_edges(const SurfaceMesh& surface, double longest) {
  return Halving(surface, longest).run();
}

}  // namespace kinetostat::fea
