#include "kinetostat/fea/link_axis.h"

#include <algorithm>
#include <limits>
#include <numeric>

#include "kinetostat/fea/potential.h"
#include "kinetostat/fea/section_mesh.h"

namespace kinetostat::fea {
namespace {

// Pieces of one section may differ by so much of the potential between the interfaces.
constexpr double same_section = 0.1;
constexpr int corrections = 2;
constexpr double least_progress = 0.3;  // of a step from one centroid to the next

std::size_t at(int i) { return static_cast<std::size_t>(i); }

Vector3 in_space(const Vector2& p, const spatial::Frame& frame) {
  return frame.point + frame.axes.col(1) * p.x() + frame.axes.col(2) * p.y();
}

double distance_from_outline(const SectionPiece& piece, const Vector2& p) {
  double least = std::numeric_limits<double>::infinity();
  for (const Loop& loop : piece.loops)
    for (std::size_t i = 0; i < loop.size(); ++i) {
      const Vector2 &a = loop[i], side = loop[(i + 1) % loop.size()] - a;
      const double along = std::clamp(side.dot(p - a) / side.squaredNorm(), 0.0, 1.0);
      least = std::min(least, (a + along * side - p).norm());
    }
  return least;
}

// The piece around the origin of the plane; a hole around it counts as being inside.
const SectionPiece& piece_at_origin(const std::vector<SectionPiece>& list) {
  const SectionPiece* nearest = nullptr;
  double least = std::numeric_limits<double>::infinity();
  for (const SectionPiece& piece : list) {
    const double distance = inside({piece.loops.front()}, Vector2::Zero())
                                ? 0
                                : distance_from_outline(piece, Vector2::Zero());
    if (distance < least) {
      least = distance;
      nearest = &piece;
    }
  }
  return *nearest;
}

// Area and first moment of polygons.
std::pair<double, Vector2> area_and_moment(const std::vector<SectionPiece>& pieces) {
  double area = 0;
  Vector2 moment = Vector2::Zero();
  for (const SectionPiece& piece : pieces)
    for (const Loop& loop : piece.loops)
      for (std::size_t i = 0; i < loop.size(); ++i) {
        const Vector2 &a = loop[i], &b = loop[(i + 1) % loop.size()];
        const double cross = a.x() * b.y() - a.y() * b.x();
        area += cross / 2;
        moment += cross / 6 * (a + b);
      }
  return {area, moment};
}

// Vertices behind the start of the curve: material beyond a bore, for example.
void drop_backward(const Vector3& start, std::vector<Vector3>& points) {
  std::size_t drop = 0;
  while (drop + 2 < points.size() &&
         (points[drop] - start).dot(points[drop + 2] - points[drop]) <= 0)
    ++drop;
  points.erase(points.begin(), points.begin() + static_cast<std::ptrdiff_t>(drop));
}

std::vector<Vector3> between(const Vector3& start, std::vector<Vector3> points,
                             const Vector3& end) {
  drop_backward(start, points);
  std::reverse(points.begin(), points.end());
  drop_backward(end, points);
  points.push_back(start);
  std::reverse(points.begin(), points.end());
  points.push_back(end);
  return points;
}

}  // namespace

Curve::Curve(const std::vector<Vector3>& polyline, int points) {
  std::vector<double> arc(1, 0);
  for (std::size_t i = 1; i < polyline.size(); ++i)
    arc.push_back(arc.back() + (polyline[i] - polyline[i - 1]).norm());
  length_ = arc.back();
  std::size_t part = 1;
  for (int k = 0; k < points; ++k) {
    const double s = length_ * k / (points - 1);
    while (part + 1 < arc.size() && arc[part] < s) ++part;
    const double step = arc[part] - arc[part - 1];
    const double t = step > 0 ? std::clamp((s - arc[part - 1]) / step, 0.0, 1.0) : 0;
    points_.push_back(polyline[part - 1] + t * (polyline[part] - polyline[part - 1]));
  }
}

Vector3 Curve::point(double arc) const {
  const auto last = static_cast<double>(points_.size() - 1);
  const double place = std::clamp(arc / length_, 0.0, 1.0) * last;
  const auto part = std::min(static_cast<std::size_t>(place), points_.size() - 2);
  const double t = place - static_cast<double>(part);
  return (1 - t) * points_[part] + t * points_[part + 1];
}

Vector3 Curve::tangent(double arc) const {
  const double reach = 2 * length_ / static_cast<double>(points_.size() - 1);
  return (point(arc + reach) - point(arc - reach)).normalized();
}

SectionCutter::SectionCutter(const LinkBody& body)
    : body_(body),
      tolerance_(1e-6 * bounding_box(body.surface.points).diagonal().norm()),
      potential_(potential(body.mesh, body.fixed.nodes, body.loaded.nodes)) {
  // The direction of the bounding box's axes that is farthest from the line between the interfaces.
  Eigen::Index least = 0;
  (body.loaded.centroid - body.fixed.centroid).cwiseAbs().reverse().minCoeff(&least);
  up_ = Vector3::Unit(2 - least);
}

// The mean over the outer loop, each corner taking the value of the nearest node of the boundary.
double SectionCutter::potential_of(const SectionPiece& piece, const spatial::Frame& frame) const {
  const Loop& loop = piece.loops.front();
  const std::size_t step = std::max<std::size_t>(1, loop.size() / 16);
  double sum = 0;
  int count = 0;
  for (std::size_t i = 0; i < loop.size(); i += step, ++count) {
    const Vector3 p = in_space(loop[i], frame);
    double least = std::numeric_limits<double>::infinity(), value = 0;
    for (const BoundaryFace& face : body_.mesh.boundary)
      for (std::size_t k = 0; k < 3; ++k) {
        const int node = face.nodes[k];
        const double distance = (body_.mesh.nodes[at(node)] - p).squaredNorm();
        if (distance >= least) continue;
        least = distance;
        value = potential_[node];
      }
    sum += value;
  }
  return sum / count;
}

std::optional<Section> SectionCutter::section_at(const Vector3& point,
                                                 const Vector3& tangent) const {
  Section section{
      .frame = section_frame(point, tangent, up_), .pieces = {}, .centroid = Vector3::Zero()};
  std::vector<SectionPiece> all = pieces(cut(body_.surface, section.frame, tolerance_));
  if (all.empty()) return std::nullopt;
  if (all.size() > 1) {
    const double here = potential_of(piece_at_origin(all), section.frame);
    std::erase_if(all, [&](const SectionPiece& piece) {
      return std::abs(potential_of(piece, section.frame) - here) > same_section;
    });
  }
  section.pieces = std::move(all);
  const auto [area, moment] = area_and_moment(section.pieces);
  section.centroid = in_space(moment / area, section.frame);
  return section;
}

// Elements in the order of their potential, in groups of equal volume.
std::vector<Vector3> SectionCutter::slice_centroids(int slices) const {
  const TetMesh& mesh = body_.mesh;
  std::vector<std::size_t> order(mesh.element_count());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::vector<double> height(order.size());
  double total = 0;
  for (std::size_t e = 0; e < order.size(); ++e) {
    for (const int node : mesh.element(e).first(4)) height[e] += potential_[node] / 4;
    total += volume(mesh.corners(e));
  }
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return height[a] < height[b]; });
  std::vector<Vector3> centroids;
  Vector3 moment = Vector3::Zero();
  double in_slice = 0;
  for (const std::size_t e : order) {
    const std::array<Vector3, 4> c = mesh.corners(e);
    const double v = volume(c);
    moment += v * (c[0] + c[1] + c[2] + c[3]) / 4;
    in_slice += v;
    if (in_slice < total / slices) continue;
    centroids.emplace_back(moment / in_slice);
    moment.setZero();
    in_slice = 0;
  }
  return centroids;
}

Curve SectionCutter::find_axis(int points) const {
  const int slices = std::clamp(static_cast<int>(body_.mesh.element_count() / 200), 4, points);
  Curve axis(between(body_.fixed.centroid, slice_centroids(slices), body_.loaded.centroid), points);
  for (int correction = 0; correction < corrections; ++correction) {
    const double step = axis.length() / (points - 1);
    std::vector<Vector3> centroids{body_.fixed.centroid};
    int met = 0;
    for (int k = 1; k + 1 < points; ++k) {
      const Vector3 tangent = axis.tangent(k * step);
      const auto section = section_at(axis.points()[at(k)], tangent);
      if (!section) continue;
      ++met;
      // Where the planes of a sharp bend cross within the material, centroids may run backwards.
      if (tangent.dot(section->centroid - centroids.back()) > least_progress * step)
        centroids.push_back(section->centroid);
    }
    if (2 * met < points)
      throw SectionError("the planes across the line between the interfaces miss the link");
    axis = Curve(between(body_.fixed.centroid, {centroids.begin() + 1, centroids.end()},
                         body_.loaded.centroid),
                 points);
  }
  return axis;
}

}  // namespace kinetostat::fea
