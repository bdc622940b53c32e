#include "kinetostat/fea/section/link_axis.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "kinetostat/common/index.h"
#include "kinetostat/fea/elasticity/potential.h"
#include "kinetostat/fea/section/section_mesh.h"

namespace kinetostat::fea {
namespace {

using common::at;

// Pieces of one section may differ by so much of the potential between the interfaces.
constexpr double same_section = 0.1;
constexpr int corrections = 2;
// A centroid farther from the axis, in terms of the root of the area, is that of a section with
// more than the axis' own material in it, at a flange or a rib: no reason to bend the axis.
constexpr double largest_correction = 0.2;

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
  const double step = length_ / static_cast<double>(points_.size() - 1);
  // To both sides alike, or the ends of a curved axis would lean.
  const double reach = std::max(std::min({2 * step, arc, length_ - arc}), 1e-3 * step);
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
  Section section{.frame = section_frame(point, tangent, up_),
                  .pieces = {},
                  .area = 0,
                  .centroid = Vector3::Zero()};
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
  section.area = area;
  section.centroid = in_space(moment / area, section.frame);
  return section;
}

// Elements in the order of their potential, in groups of equal volume. Where nothing flows, in a
// flange or beyond a bore, there is no axis either: the squared gradient is the weight.
std::vector<Vector3> SectionCutter::slice_centres(int slices) const {
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
  std::vector<Vector3> centres;
  Vector3 moment = Vector3::Zero();
  double in_slice = 0, flow = 0;
  for (const std::size_t e : order) {
    const std::array<Vector3, 4> c = mesh.corners(e);
    const double weight = volume(c) * gradient(mesh, e, potential_).squaredNorm();
    moment += weight * (c[0] + c[1] + c[2] + c[3]) / 4;
    flow += weight;
    in_slice += volume(c);
    if (in_slice < total / slices) continue;
    centres.emplace_back(moment / flow);
    moment.setZero();
    in_slice = flow = 0;
  }
  return centres;
}

Curve SectionCutter::find_axis(int points) const {
  const int slices = std::clamp(static_cast<int>(body_.mesh.element_count() / 40), 4, points);
  const Vector3 start = flow_centre(body_.mesh, potential_, body_.fixed.nodes),
                end = flow_centre(body_.mesh, potential_, body_.loaded.nodes);
  Curve axis(between(start, slice_centres(slices), end), points);
  for (int correction = 0; correction < corrections; ++correction) {
    std::vector<Vector3> corrected = axis.points();
    int met = 0;
    for (int k = 1; k + 1 < points; ++k) {
      Vector3& point = corrected[at(k)];
      const auto section = section_at(point, axis.tangent(axis.length() * k / (points - 1)));
      if (!section) continue;
      ++met;
      if ((section->centroid - point).norm() < largest_correction * std::sqrt(section->area))
        point = section->centroid;
    }
    if (2 * met < points)
      throw SectionError("the planes across the line between the interfaces miss the link");
    axis = Curve(corrected, points);
  }
  return axis;
}

}  // namespace kinetostat::fea
