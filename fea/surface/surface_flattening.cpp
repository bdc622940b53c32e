#include "kinetostat/fea/surface/surface_flattening.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <vector>

#include <Eigen/Dense>

#include "kinetostat/common/index.h"
#include "kinetostat/fea/surface/surface_faces.h"
#include "kinetostat/fea/surface/surface_topology.h"

namespace kinetostat::fea {
namespace {

using common::at;

// Curved surfaces are tessellated with smaller angles, edges of a solid are sharper.
const double least_angle_cosine = std::cos(5 * M_PI / 180);
// A face grows in the plane of its largest facet, which is only as good as three corners are.
constexpr double reach_of_first_facet = 3;

// Share of a face's edges behind which the surface goes on at a small angle.
constexpr double most_smooth = 0.25;

struct Plane {
  Vector3 normal = Vector3::Zero();
  double offset = 0;  // [m] normal . x = offset on the plane
  bool is_fitted = false;
};

Plane fit(const SurfaceMesh& mesh, const FlatFace& face, double tolerance) {
  std::set<int> corners;
  for (const int f : face.facets)
    for (const int corner : mesh.triangles[at(f)]) corners.insert(corner);
  Vector3 mean = Vector3::Zero();
  for (const int c : corners) mean += mesh.points[at(c)] / static_cast<double>(corners.size());
  Matrix3 moments = Matrix3::Zero();
  for (const int c : corners) {
    const Vector3 arm = mesh.points[at(c)] - mean;
    moments += arm * arm.transpose();
  }
  const Vector3 normal =
      Eigen::SelfAdjointEigenSolver<Matrix3>(moments).eigenvectors().col(0);  // least spread
  double farthest = 0;
  for (const int c : corners)
    farthest = std::max(farthest, std::abs(normal.dot(mesh.points[at(c)] - mean)));
  return {.normal = normal.dot(face.normal) < 0 ? Vector3(-normal) : normal,
          .offset = (normal.dot(face.normal) < 0 ? -1 : 1) * normal.dot(mean),
          .is_fitted = face.facets.size() > 1 && farthest <= tolerance};
}

// Length of the edge between two facets.
double shared_edge(const SurfaceMesh& mesh, std::size_t f, std::size_t g) {
  std::vector<int> both;
  for (const int corner : mesh.triangles[f])
    for (const int other : mesh.triangles[g])
      if (corner == other) both.push_back(corner);
  return both.size() < 2 ? 0 : (mesh.points[at(both[0])] - mesh.points[at(both[1])]).norm();
}

std::vector<Plane> fitted_planes(const SurfaceMesh& mesh, const std::vector<FlatFace>& faces,
                                 const std::vector<int>& face_of, double tolerance) {
  std::vector<Plane> planes;
  planes.reserve(faces.size());
  for (const FlatFace& face : faces) planes.push_back(fit(mesh, face, tolerance));
  const std::vector<Triangle> neighbours = facet_neighbours(mesh);
  std::vector<bool> is_curved(planes.size(), false);
  std::vector<double> perimeter(planes.size(), 0), smooth(planes.size(), 0);
  for (std::size_t f = 0; f < neighbours.size(); ++f)
    for (std::size_t k = 0; k < 3; ++k) {
      const int g = neighbours[f][k];
      if (g < 0 || face_of[at(g)] == face_of[f]) continue;
      const Plane &a = planes[at(face_of[f])], &b = planes[at(face_of[at(g)])];
      if (a.is_fitted && b.is_fitted && a.normal.dot(b.normal) > least_angle_cosine)
        is_curved[at(face_of[f])] = true;
      const double length = shared_edge(mesh, f, at(g));
      perimeter[at(face_of[f])] += length;
      if (mesh.area_vector(f).normalized().dot(mesh.area_vector(at(g)).normalized()) >
          least_angle_cosine)
        smooth[at(face_of[f])] += length;
    }
  // A few facets beside a rounded face lie nearly in its plane; around a part of a curved surface
  // most do, though they be turned by more in its middle.
  for (std::size_t i = 0; i < planes.size(); ++i)
    if (smooth[i] > most_smooth * perimeter[i]) is_curved[i] = true;
  for (std::size_t i = 0; i < planes.size(); ++i)
    if (is_curved[i]) planes[i].is_fitted = false;
  return planes;
}

// The nearest point in all the planes.
Vector3 projected(const Vector3& point, const std::set<int>& around,
                  const std::vector<Plane>& planes) {
  Eigen::MatrixX3d normals(static_cast<Eigen::Index>(around.size()), 3);
  Eigen::VectorXd heights(normals.rows());
  Eigen::Index row = 0;
  for (const int p : around) {
    normals.row(row) = planes[at(p)].normal.transpose();
    heights[row++] = planes[at(p)].offset - planes[at(p)].normal.dot(point);
  }
  // Of least norm where the planes leave a line or a plane of points.
  Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixX3d> planes_at_point(normals.rows(), 3);
  planes_at_point.setThreshold(0.03);
  planes_at_point.compute(normals);
  return point + planes_at_point.solve(heights);
}

}  // namespace

namespace {

// Those whose planes are fitted.
std::vector<std::set<int>> faces_around_points(const SurfaceMesh& mesh,
                                               const std::vector<int>& face_of,
                                               const std::vector<Plane>& planes) {
  std::vector<std::set<int>> around(mesh.points.size());
  for (std::size_t f = 0; f < mesh.triangles.size(); ++f)
    if (planes[at(face_of[f])].is_fitted)
      for (const int corner : mesh.triangles[f]) around[at(corner)].insert(face_of[f]);
  return around;
}

}  // namespace

std::size_t flatten(SurfaceMesh& mesh, double tolerance) {
  const std::vector<FlatFace> faces = flat_faces(mesh, reach_of_first_facet * tolerance);
  std::vector<int> face_of(mesh.triangles.size(), 0);
  for (std::size_t i = 0; i < faces.size(); ++i)
    for (const int f : faces[i].facets) face_of[at(f)] = static_cast<int>(i);
  const std::vector<Plane> planes = fitted_planes(mesh, faces, face_of, tolerance);
  const std::vector<std::set<int>> around = faces_around_points(mesh, face_of, planes);
  std::size_t moved = 0;
  for (std::size_t p = 0; p < around.size(); ++p) {
    if (around[p].empty()) continue;
    const Vector3 place = projected(mesh.points[p], around[p], planes);
    const double distance = (place - mesh.points[p]).norm();
    if (!(distance <= tolerance) || distance == 0) continue;
    mesh.points[p] = place;
    ++moved;
  }
  return moved;
}

}  // namespace kinetostat::fea
