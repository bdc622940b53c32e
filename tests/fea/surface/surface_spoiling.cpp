#include "fea/surface/surface_spoiling.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <queue>
#include <set>

#include "kinetostat/common/index.h"
#include "kinetostat/fea/surface/surface_topology.h"

namespace kinetostat::fea::hard {
namespace {

using common::at;

bool is_at_end(const Box& box, const Vector3& p) {
  const double near = 1e-5 * box.diagonal().norm();
  return p.x() < box.min().x() + near || p.x() > box.max().x() - near;
}

bool touches_end(const SurfaceMesh& mesh, const Box& box, std::size_t f) {
  for (std::size_t k = 0; k < 3; ++k)
    if (is_at_end(box, mesh.corner(f, k))) return true;
  return false;
}

// Divides the edge `side` of facet f, and that of its neighbour, at a new point.
void divide(SurfaceMesh& mesh, std::size_t f, std::size_t side, const Vector3& place) {
  const int a = mesh.triangles[f][side], b = mesh.triangles[f][(side + 1) % 3];
  const int middle = static_cast<int>(mesh.points.size());
  mesh.points.push_back(place);
  const std::size_t before = mesh.triangles.size();
  for (std::size_t g = 0; g < before; ++g)
    for (std::size_t k = 0; k < 3; ++k) {
      const int p = mesh.triangles[g][k], q = mesh.triangles[g][(k + 1) % 3];
      if (!((p == a && q == b) || (p == b && q == a))) continue;
      const int tip = mesh.triangles[g][(k + 2) % 3];
      mesh.triangles[g] = {p, middle, tip};
      mesh.triangles.push_back({middle, q, tip});
      break;
    }
}

// A facet that is no sliver yet.
std::size_t wide_facet(const SurfaceMesh& mesh, Random& random) {
  const double least = 1e-3 * bounding_box(mesh.points).diagonal().norm();
  for (int trial = 0; trial < 1000; ++trial) {
    const std::size_t f = random.below(mesh.triangles.size());
    double longest = 0;
    for (std::size_t k = 0; k < 3; ++k)
      longest = std::max(longest, (mesh.corner(f, k) - mesh.corner(f, (k + 1) % 3)).norm());
    if (2 * mesh.area_vector(f).norm() / longest > least) return f;
  }
  return random.below(mesh.triangles.size());
}

}  // namespace

std::uint64_t Random::next() {
  std::uint64_t z = (state_ += 0x9e3779b97f4a7c15u);
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  return z ^ (z >> 31);
}
double Random::uniform(double low, double high) {
  return low + (high - low) * (static_cast<double>(next() >> 11) * 0x1p-53);
}
std::size_t Random::below(std::size_t n) { return next() % n; }

SurfaceMesh subdivided(const SurfaceMesh& mesh) {
  SurfaceMesh fine{.points = mesh.points};
  std::map<std::pair<int, int>, int> middles;
  const auto middle = [&](int a, int b) {
    const auto [entry, is_new] =
        middles.try_emplace(std::minmax(a, b), static_cast<int>(fine.points.size()));
    if (is_new) fine.points.push_back(0.5 * (mesh.points[at(a)] + mesh.points[at(b)]));
    return entry->second;
  };
  for (const Triangle& t : mesh.triangles) {
    const int ab = middle(t[0], t[1]), bc = middle(t[1], t[2]), ca = middle(t[2], t[0]);
    fine.triangles.insert(fine.triangles.end(),
                          {{t[0], ab, ca}, {t[1], bc, ab}, {t[2], ca, bc}, {ab, bc, ca}});
  }
  return fine;
}

void add_slivers(SurfaceMesh& mesh, int count, double part, Random& random) {
  for (int i = 0; i < count; ++i) {
    const std::size_t f = wide_facet(mesh, random), side = random.below(3);
    const Vector3 from = mesh.corner(f, side), to = mesh.corner(f, (side + 1) % 3);
    divide(mesh, f, side, from + part * random.uniform(0.5, 1) * (to - from));
  }
}

void add_needles(SurfaceMesh& mesh, int count, double part, Random& random) {
  for (int i = 0; i < count; ++i) {
    const std::size_t f = wide_facet(mesh, random), side = random.below(3);
    const Triangle t = mesh.triangles[f];
    const int a = t[side], b = t[(side + 1) % 3], c = t[(side + 2) % 3];
    const double along = random.uniform(0.2, 0.8), up = part * random.uniform(0.5, 1);
    const int inside = static_cast<int>(mesh.points.size());
    mesh.points.push_back((1 - up) *
                              ((1 - along) * mesh.points[at(a)] + along * mesh.points[at(b)]) +
                          up * mesh.points[at(c)]);
    mesh.triangles[f] = {a, b, inside};
    mesh.triangles.push_back({b, c, inside});
    mesh.triangles.push_back({c, a, inside});
  }
}

void add_noise(SurfaceMesh& mesh, double size, Random& random) {
  for (Vector3& p : mesh.points)
    for (Eigen::Index k = 0; k < 3; ++k) p[k] += random.uniform(-size, size);
}

void add_folds(SurfaceMesh& mesh, int count, double size, Random& random) {
  for (int i = 0; i < count; ++i) {
    const std::size_t f = wide_facet(mesh, random), side = random.below(3);
    const Vector3 from = mesh.corner(f, side), to = mesh.corner(f, (side + 1) % 3);
    divide(mesh, f, side, from - size * random.uniform(0.3, 1) * (to - from).normalized());
  }
}

void round_to_single(SurfaceMesh& mesh) {
  for (Vector3& p : mesh.points) p = p.cast<float>().cast<double>();
}

namespace {

using Quadric = Eigen::Matrix4d;

class Decimation {
 public:
  Decimation(const SurfaceMesh& mesh, double most)
      : mesh_(mesh),
        most_(most),
        box_(bounding_box(mesh.points)),
        facets_(mesh.points.size()),
        quadric_(mesh.points.size(), Quadric::Zero()),
        version_(mesh.points.size(), 0),
        alive_(mesh.triangles.size(), true),
        left_(mesh.triangles.size()) {
    for (std::size_t f = 0; f < mesh.triangles.size(); ++f) {
      const Vector3 normal = mesh.area_vector(f).normalized();
      Eigen::Vector4d plane(normal.x(), normal.y(), normal.z(), -normal.dot(mesh.corner(f, 0)));
      for (const int p : mesh.triangles[f]) {
        facets_[at(p)].insert(static_cast<int>(f));
        quadric_[at(p)] += plane * plane.transpose();
      }
    }
    for (std::size_t f = 0; f < mesh.triangles.size(); ++f)
      for (std::size_t k = 0; k < 3; ++k)
        push(mesh.triangles[f][k], mesh.triangles[f][(k + 1) % 3]);
  }

  SurfaceMesh run(std::size_t facets) && {
    while (left_ > facets && !queue_.empty()) {
      const Candidate c = queue_.top();
      queue_.pop();
      if (c.versions != std::pair(version_[at(c.from)], version_[at(c.to)])) continue;
      if (c.cost > most_ * most_) break;
      if (may_collapse(c)) collapse(c);
    }
    std::vector<int> kept(alive_.size(), -1);
    int count = 0;
    for (std::size_t f = 0; f < kept.size(); ++f)
      if (alive_[f]) kept[f] = count++;
    keep_facets(mesh_, kept);
    return std::move(mesh_);
  }

 private:
  struct Candidate {
    double cost;
    int from, to;
    std::pair<int, int> versions;
    Vector3 place;
    bool operator<(const Candidate& other) const {
      return std::tie(cost, from, to) > std::tie(other.cost, other.from, other.to);
    }
  };

  double error(const Quadric& q, const Vector3& p) const {
    return p.homogeneous().dot(q * p.homogeneous());
  }

  void push(int a, int b) {
    if (is_at_end(box_, mesh_.points[at(a)]) || is_at_end(box_, mesh_.points[at(b)])) return;
    const Quadric q = quadric_[at(a)] + quadric_[at(b)];
    const Vector3 &pa = mesh_.points[at(a)], &pb = mesh_.points[at(b)];
    Candidate best{.cost = 1e300,
                   .from = a,
                   .to = b,
                   .versions = {version_[at(a)], version_[at(b)]},
                   .place = pa};
    for (const Vector3& place : {pa, pb, Vector3(0.5 * (pa + pb))})
      if (const double cost = error(q, place) + 1e-9 * (pa - pb).squaredNorm(); cost < best.cost)
        best.cost = cost, best.place = place;
    queue_.push(best);
  }

  std::set<int> around(int p) const {
    std::set<int> points;
    for (const int f : facets_[at(p)])
      for (const int q : mesh_.triangles[at(f)])
        if (q != p) points.insert(q);
    return points;
  }

  bool may_collapse(const Candidate& c) const {
    const std::set<int> a = around(c.from), b = around(c.to);
    std::vector<int> both;
    std::set_intersection(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(both));
    if (!a.contains(c.to) || both.size() != 2) return false;
    return keeps_facing(c.from, c.to, c.place) && keeps_facing(c.to, c.from, c.place);
  }
  bool keeps_facing(int p, int other, const Vector3& place) const {
    for (const int f : facets_[at(p)]) {
      const Triangle& t = mesh_.triangles[at(f)];
      if (std::find(t.begin(), t.end(), other) != t.end()) continue;
      std::array<Vector3, 3> q;
      for (std::size_t k = 0; k < 3; ++k) q[k] = t[k] == p ? place : mesh_.points[at(t[k])];
      const Vector3 before = mesh_.area_vector(at(f)).normalized();
      const Vector3 after = (q[1] - q[0]).cross(q[2] - q[0]);
      if (!(before.dot(after.normalized()) > 0.5) || !(after.norm() > 1e-9)) return false;
    }
    return true;
  }

  void collapse(const Candidate& c) {
    mesh_.points[at(c.to)] = c.place;
    quadric_[at(c.to)] += quadric_[at(c.from)];
    for (const int f : std::set<int>(facets_[at(c.from)])) {
      Triangle& t = mesh_.triangles[at(f)];
      const bool dies = std::find(t.begin(), t.end(), c.to) != t.end();
      if (dies) {
        for (const int p : t) facets_[at(p)].erase(f);
        alive_[at(f)] = false;
        --left_;
        continue;
      }
      std::replace(t.begin(), t.end(), c.from, c.to);
      facets_[at(c.to)].insert(f);
    }
    facets_[at(c.from)].clear();
    ++version_[at(c.from)];
    ++version_[at(c.to)];
    for (const int p : around(c.to)) push(p, c.to);
  }

  SurfaceMesh mesh_;
  double most_;
  Box box_;
  std::vector<std::set<int>> facets_;
  std::vector<Quadric> quadric_;
  std::vector<int> version_;
  std::vector<bool> alive_;
  std::size_t left_;
  std::priority_queue<Candidate> queue_;
};

}  // namespace

SurfaceMesh decimated(const SurfaceMesh& mesh, std::size_t facets, double most) {
  return Decimation(mesh, most).run(facets);
}

SurfaceMesh soup(const SurfaceMesh& mesh, double error, Random& random) {
  SurfaceMesh result;
  for (std::size_t f = 0; f < mesh.triangles.size(); ++f) {
    const int base = static_cast<int>(result.points.size());
    for (std::size_t k = 0; k < 3; ++k)
      result.points.push_back(mesh.corner(f, k) + Vector3(random.uniform(-error, error),
                                                          random.uniform(-error, error),
                                                          random.uniform(-error, error)));
    result.triangles.push_back({base, base + 1, base + 2});
  }
  return result;
}

void remove_facets(SurfaceMesh& mesh, int count, int rings, Random& random) {
  const std::vector<Triangle> neighbours = facet_neighbours(mesh);
  const Box box = bounding_box(mesh.points);
  std::set<int> gone;
  for (int i = 0, trial = 0; i < count && trial < 1000; ++trial) {
    std::set<int> patch{static_cast<int>(random.below(mesh.triangles.size()))};
    for (int ring = 0; ring < rings; ++ring)
      for (const int f : std::set<int>(patch))
        for (const int g : neighbours[at(f)])
          if (g >= 0) patch.insert(g);
    if (std::any_of(patch.begin(), patch.end(),
                    [&](int f) { return touches_end(mesh, box, at(f)); }))
      continue;
    gone.merge(patch);
    ++i;
  }
  std::vector<int> kept(mesh.triangles.size(), -1);
  int number = 0;
  for (std::size_t f = 0; f < kept.size(); ++f)
    if (!gone.contains(static_cast<int>(f))) kept[f] = number++;
  keep_facets(mesh, kept);
}

void flip_facets(SurfaceMesh& mesh, double share, Random& random) {
  for (Triangle& t : mesh.triangles)
    if (random.uniform(0, 1) < share) std::swap(t[1], t[2]);
}

void repeat_facets(SurfaceMesh& mesh, double share, Random& random) {
  const std::size_t before = mesh.triangles.size();
  for (std::size_t f = 0; f < before; ++f)
    if (random.uniform(0, 1) < share) {
      Triangle t = mesh.triangles[f];
      if (random.uniform(0, 1) < 0.5) std::swap(t[0], t[1]);
      mesh.triangles.push_back(t);
    }
}

void add_t_junctions(SurfaceMesh& mesh, int count, Random& random) {
  for (int i = 0; i < count; ++i) {
    const std::size_t f = wide_facet(mesh, random), side = random.below(3);
    const Triangle t = mesh.triangles[f];
    const int a = t[side], b = t[(side + 1) % 3], c = t[(side + 2) % 3];
    const double along = random.uniform(0.2, 0.8);
    const int middle = static_cast<int>(mesh.points.size());
    mesh.points.push_back((1 - along) * mesh.points[at(a)] + along * mesh.points[at(b)]);
    mesh.triangles[f] = {a, middle, c};
    mesh.triangles.push_back({middle, b, c});
  }
}

void add_crack(SurfaceMesh& mesh, double x, double gap) {
  std::map<int, int> copies;
  const std::size_t before = mesh.triangles.size();
  for (std::size_t f = 0; f < before; ++f) {
    if (mesh.centroid(f).x() < x) continue;
    for (int& p : mesh.triangles[f]) {
      const auto [entry, is_new] = copies.try_emplace(p, static_cast<int>(mesh.points.size()));
      if (is_new) mesh.points.push_back(mesh.points[at(p)] + Vector3(gap, 0, 0));
      p = entry->second;
    }
  }
  drop_unused_points(mesh);
}

void push_points(SurfaceMesh& mesh, int count, double depth, Random& random) {
  const Box box = bounding_box(mesh.points);
  std::set<int> moved;
  for (int i = 0, trial = 0; i < count && trial < 1000; ++trial) {
    const std::size_t f = random.below(mesh.triangles.size());
    const int p = mesh.triangles[f][0];
    if (touches_end(mesh, box, f) || moved.contains(p)) continue;
    mesh.points[at(p)] -= depth * mesh.area_vector(f).normalized();
    moved.insert(p);
    ++i;
  }
}

}  // namespace kinetostat::fea::hard
