#include "kinetostat/fea/surface/surface_faces.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>

#include <Eigen/Dense>

#include "kinetostat/common/index.h"
#include "kinetostat/fea/surface/surface_topology.h"

namespace kinetostat::fea {
namespace {

using common::at;

using Neighbours = std::vector<Triangle>;

// Facets by falling area, so that every face grows from the facet with the best-known normal.
std::vector<int> largest_first(const SurfaceMesh& mesh) {
  std::vector<double> area(mesh.triangles.size());
  for (std::size_t f = 0; f < area.size(); ++f) area[f] = mesh.area_vector(f).norm();
  std::vector<int> order(area.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(),
                   [&area](int a, int b) { return area[at(a)] > area[at(b)]; });
  return order;
}

bool lies_in_plane(const SurfaceMesh& mesh, std::size_t facet, const Vector3& point,
                   const Vector3& normal, double tolerance) {
  for (std::size_t k = 0; k < 3; ++k)
    if (std::abs(normal.dot(mesh.corner(facet, k) - point)) > tolerance) return false;
  return mesh.area_vector(facet).dot(normal) >= 0;
}

FlatFace grow(const SurfaceMesh& mesh, const Neighbours& neighbours, int seed, double tolerance,
              std::vector<bool>& taken) {
  FlatFace face;
  const Vector3 normal = mesh.area_vector(at(seed)).normalized();
  const Vector3 point = mesh.centroid(at(seed));
  face.facets.push_back(seed);
  taken[at(seed)] = true;
  for (std::size_t i = 0; i < face.facets.size(); ++i)
    for (const int next : neighbours[at(face.facets[i])]) {
      if (next < 0 || taken[at(next)] || !lies_in_plane(mesh, at(next), point, normal, tolerance))
        continue;
      taken[at(next)] = true;
      face.facets.push_back(next);
    }
  std::sort(face.facets.begin(), face.facets.end());
  Vector3 area = Vector3::Zero(), moment = Vector3::Zero();
  double weight = 0;
  for (const int facet : face.facets) {
    const auto f = at(facet);
    const Vector3 part = mesh.area_vector(f);
    area += part;
    weight += part.norm();
    moment += part.norm() * mesh.centroid(f);
  }
  face.area = weight;
  face.normal = area.norm() > 0 ? area.normalized() : normal;
  face.centroid = weight > 0 ? Vector3(moment / weight) : point;
  return face;
}

// Neighbouring faces whose normals differ by a small but real angle, as on a tessellated cylinder.
constexpr double smallest_turn = 0.2, largest_turn = 61;  // [deg]

std::vector<std::set<int>> smooth_links(const Neighbours& neighbours,
                                        const std::vector<FlatFace>& flat) {
  std::vector<int> face_of(neighbours.size());
  for (std::size_t i = 0; i < flat.size(); ++i)
    for (const int f : flat[i].facets) face_of[at(f)] = static_cast<int>(i);
  const double most = std::cos(smallest_turn * M_PI / 180),
               least = std::cos(largest_turn * M_PI / 180);
  std::vector<std::set<int>> links(flat.size());
  for (std::size_t f = 0; f < neighbours.size(); ++f)
    for (const int g : neighbours[f]) {
      if (g < 0) continue;
      const int a = face_of[f], b = face_of[at(g)];
      const double cosine = flat[at(a)].normal.dot(flat[at(b)].normal);
      if (a != b && cosine < most && cosine > least) links[at(a)].insert(b);
    }
  return links;
}

Vector3 canonical(Vector3 axis) {
  for (int k = 0; k < 3; ++k) {
    if (std::abs(axis[k]) < 1e-9) continue;
    return axis[k] < 0 ? Vector3(-axis) : axis;
  }
  return axis;
}

// Least-squares circle through the corners seen along the axis (Kasa's linear fit).
bool fit_cylinder(const SurfaceMesh& mesh, const Vector3& axis, RoundFace& round) {
  std::set<int> corners;
  for (const int f : round.facets)
    for (const int corner : mesh.triangles[at(f)]) corners.insert(corner);
  const Vector3 origin = mesh.points[at(*corners.begin())];
  const Vector3 u = axis.unitOrthogonal(), v = axis.cross(u);
  Eigen::MatrixXd a(static_cast<Eigen::Index>(corners.size()), 3);
  Eigen::VectorXd b(a.rows());
  Eigen::Index row = 0;
  double low = 0, high = 0;
  for (const int corner : corners) {
    const Vector3 arm = mesh.points[at(corner)] - origin;
    const double x = arm.dot(u), y = arm.dot(v), along = arm.dot(axis);
    a.row(row) << 2 * x, 2 * y, 1;
    b(row++) = x * x + y * y;
    low = std::min(low, along);
    high = std::max(high, along);
  }
  const Vector3 fit = a.colPivHouseholderQr().solve(b);
  const double square = fit.z() + fit.x() * fit.x() + fit.y() * fit.y();
  if (!(square > 0)) return false;
  round.radius = std::sqrt(square);
  round.axis = axis;
  round.length = high - low;
  round.axis_point = origin + fit.x() * u + fit.y() * v + 0.5 * (low + high) * axis;
  for (Eigen::Index i = 0; i < a.rows(); ++i) {
    const double distance = std::hypot(a(i, 0) / 2 - fit.x(), a(i, 1) / 2 - fit.y());
    if (std::abs(distance - round.radius) > 0.01 * round.radius) return false;
  }
  return true;
}

// Walks over smooth links from the seed to the faces that `joins` lets in, `most` of them at most.
template <class Joins>
std::vector<int> reached(const std::vector<std::set<int>>& links, int seed, std::size_t most,
                         const std::vector<bool>& taken, Joins joins) {
  std::vector<int> faces{seed};
  std::set<int> seen{seed};
  for (std::size_t i = 0; i < faces.size() && faces.size() < most; ++i)
    for (const int next : links[at(faces[i])]) {
      if (taken[at(next)] || seen.count(next) || !joins(next)) continue;
      seen.insert(next);
      faces.push_back(next);
    }
  return faces;
}

std::vector<int> facets_of(const std::vector<FlatFace>& flat, const std::vector<int>& faces) {
  std::vector<int> facets;
  for (const int face : faces) {
    const std::vector<int>& part = flat[at(face)].facets;
    facets.insert(facets.end(), part.begin(), part.end());
  }
  std::sort(facets.begin(), facets.end());
  return facets;
}

// The direction to which the normals are most nearly perpendicular.
Vector3 axis_of(const std::vector<FlatFace>& flat, const std::vector<int>& faces) {
  Matrix3 sum = Matrix3::Zero();
  for (const int face : faces) {
    const FlatFace& f = flat[at(face)];
    sum += f.area * f.normal * f.normal.transpose();
  }
  return canonical(Eigen::SelfAdjointEigenSolver<Matrix3>(sum).eigenvectors().col(0));
}

bool is_on(const SurfaceMesh& mesh, const FlatFace& face, const RoundFace& round) {
  return std::all_of(face.facets.begin(), face.facets.end(), [&](int facet) {
    for (std::size_t k = 0; k < 3; ++k) {
      const Vector3 arm = mesh.corner(at(facet), k) - round.axis_point;
      const double distance = (arm - round.axis * round.axis.dot(arm)).norm();
      if (std::abs(distance - round.radius) > 0.02 * round.radius) return false;
    }
    return true;
  });
}

constexpr std::size_t first_guess = 24;  // faces for the first fit
constexpr std::size_t fewest = 4;        // faces of a cylinder

// Fits a cylinder near the seed, then takes in all faces that lie on it and fits again.
bool grow_round(const SurfaceMesh& mesh, const std::vector<FlatFace>& flat,
                const std::vector<std::set<int>>& links, int seed, std::vector<bool>& taken,
                RoundFace& round) {
  std::vector<int> faces =
      reached(links, seed, first_guess, taken, [](int /*any*/) { return true; });
  for (int pass = 0; pass < 3; ++pass) {
    if (faces.size() < fewest) return false;
    round.facets = facets_of(flat, faces);
    if (!fit_cylinder(mesh, axis_of(flat, faces), round)) return false;
    faces = reached(links, seed, flat.size(), taken,
                    [&](int face) { return is_on(mesh, flat[at(face)], round); });
  }
  for (const int face : faces) taken[at(face)] = true;
  return true;
}

}  // namespace

std::vector<FlatFace> flat_faces(const SurfaceMesh& mesh, double tolerance) {
  const Neighbours neighbours = facet_neighbours(mesh);
  std::vector<bool> taken(mesh.triangles.size(), false);
  std::vector<FlatFace> faces;
  for (const int seed : largest_first(mesh))
    if (!taken[at(seed)]) faces.push_back(grow(mesh, neighbours, seed, tolerance, taken));
  return faces;
}

std::vector<RoundFace> round_faces(const SurfaceMesh& mesh, const std::vector<FlatFace>& flat) {
  const std::vector<std::set<int>> links = smooth_links(facet_neighbours(mesh), flat);
  std::vector<bool> taken(flat.size(), false);
  std::vector<RoundFace> found;
  for (std::size_t seed = 0; seed < flat.size(); ++seed) {
    RoundFace round;
    if (!taken[seed] && grow_round(mesh, flat, links, static_cast<int>(seed), taken, round))
      found.push_back(std::move(round));
  }
  return found;
}

}  // namespace kinetostat::fea
