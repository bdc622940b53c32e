#include "kinetostat/fea/mesh/edge_division.h"

#include <limits>
#include <map>
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

}  // namespace kinetostat::fea
