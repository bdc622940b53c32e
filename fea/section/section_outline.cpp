#include "kinetostat/fea/section/section_outline.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "kinetostat/common/index.h"

namespace kinetostat::fea {
namespace {

using common::at;

using Edge = std::pair<int, int>;  // of the surface, lower point first

// Where the plane cuts the surface: a crossing leads to the next one, material on the left.
struct Crossings {
  std::map<Edge, Edge> next;
  std::map<Edge, Vector2> point;
};

Edge edge_between(int a, int b) { return {std::min(a, b), std::max(a, b)}; }

// Taken from the lower to the higher point number, so that both facets find the same bytes.
Vector2 crossing_point(const Edge& edge, const std::vector<Vector3>& local) {
  const Vector3 &a = local[at(edge.first)], &b = local[at(edge.second)];
  const Vector3 p = a + (b - a) * (a.x() / (a.x() - b.x()));
  return {p.y(), p.z()};
}

Crossings find_crossings(const SurfaceMesh& surface, const std::vector<Vector3>& local) {
  Crossings crossings;
  const auto above = [&](int p) { return local[at(p)].x() >= 0; };
  for (const Triangle& t : surface.triangles) {
    Edge up, down;
    int count = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const int a = t[k], b = t[(k + 1) % 3];
      if (above(a) == above(b)) continue;
      (above(b) ? up : down) = edge_between(a, b);
      ++count;
    }
    if (count != 2) continue;
    // The outline of the facet is counterclockwise seen from outside; seen against the normal of
    // the plane, material is on the left of the way from where it falls to where it rises.
    crossings.next[down] = up;
    crossings.point.try_emplace(up, crossing_point(up, local));
    crossings.point.try_emplace(down, crossing_point(down, local));
  }
  return crossings;
}

double distance_from_line(const Vector2& p, const Vector2& a, const Vector2& b) {
  const Vector2 line = b - a, arm = p - a;
  const double length = line.norm();
  if (length == 0) return arm.norm();
  return std::abs(line.x() * arm.y() - line.y() * arm.x()) / length;
}

// Without corners that say nothing.
Loop cleaned(const Loop& loop, double tolerance) {
  Loop kept;
  for (const Vector2& p : loop)
    if (kept.empty() || (p - kept.back()).norm() > tolerance) kept.push_back(p);
  while (kept.size() > 1 && (kept.front() - kept.back()).norm() <= tolerance) kept.pop_back();
  for (std::size_t i = 0; kept.size() >= 3 && i < kept.size();) {
    const std::size_t n = kept.size();
    if (distance_from_line(kept[i], kept[(i + n - 1) % n], kept[(i + 1) % n]) <= tolerance)
      kept.erase(kept.begin() + static_cast<std::ptrdiff_t>(i));
    else
      ++i;
  }
  return kept;
}

double perimeter(const Loop& loop) {
  double sum = 0;
  for (std::size_t i = 0; i < loop.size(); ++i)
    sum += (loop[(i + 1) % loop.size()] - loop[i]).norm();
  return sum;
}

}  // namespace

double signed_area(const Loop& loop) {
  double twice = 0;
  for (std::size_t i = 0; i < loop.size(); ++i) {
    const Vector2 &a = loop[i], &b = loop[(i + 1) % loop.size()];
    twice += a.x() * b.y() - a.y() * b.x();
  }
  return twice / 2;
}

bool inside(const std::vector<Loop>& loops, const Vector2& p) {
  bool in = false;
  for (const Loop& loop : loops)
    for (std::size_t i = 0; i < loop.size(); ++i) {
      const Vector2 &a = loop[i], &b = loop[(i + 1) % loop.size()];
      if ((a.y() > p.y()) == (b.y() > p.y())) continue;
      if (p.x() < a.x() + (p.y() - a.y()) * (b.x() - a.x()) / (b.y() - a.y())) in = !in;
    }
  return in;
}

spatial::Frame section_frame(const Vector3& point, const Vector3& tangent, const Vector3& up) {
  const Vector3 x = tangent.normalized();
  Vector3 y = up - x * x.dot(up);
  if (y.norm() < 1e-3 * up.norm() || y.norm() == 0) {
    Eigen::Index least = 0;
    x.cwiseAbs().minCoeff(&least);
    y = Vector3::Unit(least) - x * x[least];
  }
  y.normalize();
  spatial::Frame frame{.point = point, .axes = {}};
  frame.axes << x, y, x.cross(y);
  return frame;
}

namespace {

// The loop through the first of the crossings, which are taken out.
Loop take_loop(Crossings& crossings) {
  Loop loop;
  for (auto at = crossings.next.begin(); at != crossings.next.end();) {
    const Edge next = at->second;
    loop.push_back(crossings.point.at(at->first));
    crossings.next.erase(at);
    at = crossings.next.find(next);
  }
  return loop;
}

}  // namespace

std::vector<Loop> cut(const SurfaceMesh& surface, const spatial::Frame& frame, double tolerance) {
  std::vector<Vector3> local;
  local.reserve(surface.points.size());
  for (const Vector3& p : surface.points)
    local.emplace_back(frame.axes.transpose() * (p - frame.point));
  Crossings crossings = find_crossings(surface, local);
  std::vector<Loop> loops;
  while (!crossings.next.empty()) {
    Loop loop = cleaned(take_loop(crossings), tolerance);
    if (loop.size() >= 3 && std::abs(signed_area(loop)) > tolerance * perimeter(loop))
      loops.push_back(std::move(loop));
  }
  return loops;
}

std::vector<SectionPiece> pieces(const std::vector<Loop>& loops) {
  std::vector<SectionPiece> result;
  for (const Loop& loop : loops)
    if (signed_area(loop) > 0) result.push_back({{loop}});
  for (const Loop& loop : loops) {
    if (signed_area(loop) > 0) continue;
    SectionPiece* around = nullptr;
    for (SectionPiece& piece : result)
      if (inside({piece.loops.front()}, loop.front()) &&
          (around == nullptr ||
           signed_area(piece.loops.front()) < signed_area(around->loops.front())))
        around = &piece;
    if (around != nullptr) around->loops.push_back(loop);
  }
  return result;
}

}  // namespace kinetostat::fea
