#include "kinetostat/fea/section/section_mesh.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <unordered_map>

#include <fmt/format.h>

#include "kinetostat/common/index.h"
#include "kinetostat/fea/mesh/delaunay.h"

namespace kinetostat::fea {
namespace {

using common::at;

constexpr double grid_extent = 1 << 26;
constexpr int most_points = 100'000;
constexpr double worst_ratio =
    1.4143;  // of circumradius to shortest side: angles above 20.7 degrees

double squared(const GridPoint& a, const GridPoint& b) {
  const auto x = static_cast<double>(a.x - b.x), y = static_cast<double>(a.y - b.y);
  return x * x + y * y;
}

GridPoint rounded(double x, double y) { return {std::llround(x), std::llround(y)}; }

// A part of a side of the outline.
struct Segment {
  int a, b;
};

// From metres to the grid and back.
class Grid {
 public:
  explicit Grid(const Loop& outline) {
    Eigen::AlignedBox2d box;
    for (const Vector2& p : outline) box.extend(p);
    origin_ = box.center();
    scale_ = grid_extent / box.sizes().maxCoeff();
  }
  GridPoint on(const Vector2& p) const {
    const Vector2 q = (p - origin_) * scale_;
    return rounded(q.x(), q.y());
  }
  Vector2 off(const GridPoint& p) const {
    return origin_ + Vector2(static_cast<double>(p.x), static_cast<double>(p.y)) / scale_;
  }
  double scale() const { return scale_; }

 private:
  Vector2 origin_;
  double scale_ = 1;
};

// Ruppert's refinement: sides are halved until every one of them is a side of the triangulation
// with an empty diametral circle; then triangles that are too large or too narrow get a point at
// their circumcentre, unless that would crowd a side, which is halved instead.
class Refinement {
 public:
  Refinement(const SectionPiece& piece, double size)
      : grid_(piece.loops.front()), longest_(size * grid_.scale()) {
    for (const Loop& loop : piece.loops) add_loop(loop);
  }

  SectionMesh run() {
    for (std::size_t s = 0; s < segments_.size(); ++s) crowded_.push_back(s);
    keep_sides();
    queue_.clear();
    for (int f = 0; f < static_cast<int>(delaunay_.faces().size()); ++f) queue_.push_back(f);
    while (!queue_.empty()) {
      const int face = queue_.front();
      queue_.pop_front();
      if (delaunay_.alive(face) && is_bad(face) && contains(face)) improve(face);
    }
    return result();
  }

 private:
  void add_loop(const Loop& loop) {
    std::vector<int> numbers;
    std::vector<GridPoint> corners;
    for (const Vector2& p : loop) {
      const int number = delaunay_.insert(grid_.on(p), made_);
      if (!numbers.empty() && numbers.back() == number) continue;
      numbers.push_back(number);
    }
    if (numbers.size() > 1 && numbers.front() == numbers.back()) numbers.pop_back();
    const std::size_t n = numbers.size();
    is_sharp_.resize(at(delaunay_.point_count()), false);
    for (std::size_t i = 0; i < n; ++i) {
      add_segment(numbers[i], numbers[(i + 1) % n]);
      corners.push_back(delaunay_.point(numbers[i]));
      is_sharp_[at(numbers[i])] =
          is_sharp(numbers[(i + n - 1) % n], numbers[i], numbers[(i + 1) % n]);
    }
    Loop on_grid;
    for (const GridPoint& p : corners)
      on_grid.emplace_back(static_cast<double>(p.x), static_cast<double>(p.y));
    outline_.push_back(std::move(on_grid));
  }

  // Sides that meet below 60 degrees.
  bool is_sharp(int before, int corner, int after) const {
    const GridPoint &p = delaunay_.point(corner), &q = delaunay_.point(before),
                    &r = delaunay_.point(after);
    const double dot = static_cast<double>(q.x - p.x) * static_cast<double>(r.x - p.x) +
                       static_cast<double>(q.y - p.y) * static_cast<double>(r.y - p.y);
    return dot > 0.5 * std::sqrt(squared(p, q) * squared(p, r));
  }
  bool is_sharp(int p) const { return at(p) < is_sharp_.size() && is_sharp_[at(p)]; }

  // Is the segment missing from the triangulation, or crowded by the corner of a face at it?
  bool must_split(const Segment& s) const {
    for (const auto& [a, b] : {std::pair(s.a, s.b), std::pair(s.b, s.a)}) {
      const int face = delaunay_.face_with_side(a, b);
      if (face < 0) return true;
      if (in_diametral_circle(delaunay_.point(a), delaunay_.point(b),
                              delaunay_.point(delaunay_.apex(face, a, b))))
        return true;
    }
    return false;
  }

  void keep_sides() {
    while (!crowded_.empty()) {
      const std::size_t s = crowded_.front();
      crowded_.pop_front();
      while (must_split(segments_[s]) && split(s)) crowded_.push_back(segments_.size() - 1);
    }
  }

  static std::uint64_t key(int a, int b) {
    return (static_cast<std::uint64_t>(std::min(a, b)) << 32) |
           static_cast<std::uint64_t>(std::max(a, b));
  }

  void add_segment(int a, int b) {
    segment_at_[key(a, b)] = segments_.size();
    segments_.push_back({a, b});
  }

  // The segments that p would crowd are sides of faces whose circles contain p.
  std::vector<std::size_t> crowded_by(const GridPoint& p) {
    std::vector<std::size_t> list;
    for (const int face : delaunay_.cavity(p))
      for (std::size_t k = 0; k < 3; ++k) {
        const std::array<int, 3>& corners = delaunay_.faces()[at(face)].point;
        const int a = corners[k], b = corners[(k + 1) % 3];
        const auto found = segment_at_.find(key(a, b));
        if (found != segment_at_.end() &&
            in_diametral_circle(delaunay_.point(a), delaunay_.point(b), p))
          list.push_back(found->second);
      }
    return list;
  }

  // Halves a segment; next to a sharp corner at a power of two from it, so that the two sides that
  // meet there do not crowd each other for ever. False when it is too short.
  // Where to divide a segment of this length: on a shell about its only sharp end, or half way.
  double division(const Segment& segment, double length) const {
    if (is_sharp(segment.a) == is_sharp(segment.b)) return 0.5;
    const double shell = std::exp2(std::round(std::log2(0.5 * length))) / length;
    return is_sharp(segment.a) ? shell : 1 - shell;
  }

  bool split(std::size_t s) {
    const Segment segment = segments_[s];
    const GridPoint a = delaunay_.point(segment.a), b = delaunay_.point(segment.b);
    const double length = std::sqrt(squared(a, b));
    if (length < 4) return false;
    const double part = division(segment, length);
    const GridPoint middle =
        rounded(static_cast<double>(a.x) + part * static_cast<double>(b.x - a.x),
                static_cast<double>(a.y) + part * static_cast<double>(b.y - a.y));
    const int number = insert(middle);
    if (number == segment.a || number == segment.b) return false;
    segment_at_.erase(key(segment.a, segment.b));
    segments_[s] = {segment.a, number};
    segment_at_[key(segment.a, number)] = s;
    add_segment(number, segment.b);
    return true;
  }

  int insert(const GridPoint& p) {
    if (delaunay_.point_count() > most_points)
      throw SectionError("its outline is too intricate to be filled with triangles");
    for (const std::size_t s : crowded_by(p)) crowded_.push_back(s);
    made_.clear();
    const int number = delaunay_.insert(p, made_);
    queue_.insert(queue_.end(), made_.begin(), made_.end());
    return number;
  }

  const GridPoint& corner(int face, std::size_t k) const {
    return delaunay_.point(delaunay_.faces()[at(face)].point[k]);
  }

  bool is_bad(int face) const {
    const GridPoint &a = corner(face, 0), &b = corner(face, 1), &c = corner(face, 2);
    const double ab = squared(a, b), bc = squared(b, c), ca = squared(c, a);
    if (std::max({ab, bc, ca}) > longest_ * longest_) return true;
    const double twice_area = static_cast<double>(turn(a, b, c));
    const double shortest = std::min({ab, bc, ca});
    // R = product of sides / (4 area). Slivers far below the size are those of the outline.
    if (std::sqrt(shortest) < longest_ / 256) return false;
    return ab * bc * ca > 4 * twice_area * twice_area * worst_ratio * worst_ratio * shortest;
  }

  bool contains(int face) const {
    const GridPoint &a = corner(face, 0), &b = corner(face, 1), &c = corner(face, 2);
    return inside(outline_, {static_cast<double>(a.x + b.x + c.x) / 3,
                             static_cast<double>(a.y + b.y + c.y) / 3});
  }

  GridPoint circumcentre(int face) const {
    const GridPoint &a = corner(face, 0), &b = corner(face, 1), &c = corner(face, 2);
    const auto bx = static_cast<double>(b.x - a.x), by = static_cast<double>(b.y - a.y),
               cx = static_cast<double>(c.x - a.x), cy = static_cast<double>(c.y - a.y);
    const double d = 2 * (bx * cy - by * cx), bb = bx * bx + by * by, cc = cx * cx + cy * cy;
    return rounded(static_cast<double>(a.x) + (cy * bb - by * cc) / d,
                   static_cast<double>(a.y) + (bx * cc - cx * bb) / d);
  }

  void improve(int face) {
    const GridPoint centre = circumcentre(face);
    if (std::max(std::abs(centre.x), std::abs(centre.y)) > std::int64_t{1} << 27) return;
    const int before = delaunay_.point_count();
    const std::vector<std::size_t> crowded = crowded_by(centre);
    for (const std::size_t s : crowded) {
      split(s);
      keep_sides();
    }
    if (crowded.empty() &&
        inside(outline_, {static_cast<double>(centre.x), static_cast<double>(centre.y)}))
      insert(centre);
    // Where nothing could be added, the triangle stays as it is.
    if (delaunay_.point_count() > before && delaunay_.alive(face)) queue_.push_back(face);
  }

  SectionMesh result() const {
    SectionMesh mesh;
    std::vector<int> number(at(delaunay_.point_count()), -1);
    for (int f = 0; f < static_cast<int>(delaunay_.faces().size()); ++f) {
      if (!delaunay_.alive(f) || !contains(f)) continue;
      Triangle triangle;
      for (std::size_t k = 0; k < 3; ++k) {
        const int p = delaunay_.faces()[at(f)].point[k];
        if (number[at(p)] < 0) {
          number[at(p)] = static_cast<int>(mesh.points.size());
          mesh.points.push_back(grid_.off(delaunay_.point(p)));
        }
        triangle[k] = number[at(p)];
      }
      mesh.triangles.push_back(triangle);
    }
    return mesh;
  }

  Grid grid_;
  double longest_;  // side of a triangle, in steps of the grid
  Delaunay delaunay_;
  std::vector<Segment> segments_;
  std::unordered_map<std::uint64_t, std::size_t> segment_at_;  // by its end points
  std::deque<std::size_t> crowded_;                            // segments to look at
  std::vector<bool> is_sharp_;                                 // by number of point
  std::vector<Loop> outline_;                                  // on the grid
  std::deque<int> queue_;
  std::vector<int> made_;
};

double area(const SectionMesh& mesh) {
  double sum = 0;
  for (const Triangle& t : mesh.triangles)
    sum += signed_area({mesh.points[at(t[0])], mesh.points[at(t[1])], mesh.points[at(t[2])]});
  return sum;
}

}  // namespace

SectionMesh triangulate(const SectionPiece& piece, double size) {
  double expected = 0;
  for (const Loop& loop : piece.loops) expected += signed_area(loop);
  if (!(expected > 0) || !(size > 0)) throw SectionError("its outline encloses no area");
  // No smaller than what a hundred thousand points can fill.
  const double least = std::sqrt(expected / (0.25 * most_points));
  SectionMesh mesh = Refinement(piece, std::max(size, least)).run();
  // An outline that crosses itself is filled by the even-odd rule, or not at all.
  if (std::abs(area(mesh) - expected) > 1e-5 * expected)
    throw SectionError(fmt::format("its outline crosses itself: triangles fill {:.6g} of its area",
                                   area(mesh) / expected));
  return mesh;
}

}  // namespace kinetostat::fea
