#include "kinetostat/report/links/link_picture.h"

#include <cmath>
#include <map>

#include "kinetostat/report/links/mesh_faces.h"
#include "kinetostat/spatial/units.h"

namespace kinetostat::report {
namespace {

using fea::BoundaryFace;
using fea::CoupledInterface;
using fea::LinkResult;
using fea::TetMesh;
using io::Json;
using spatial::Vector3;

constexpr double point_steps = 20000;  // over the size of the link
constexpr double shape_steps = 10000;  // over the largest displacement

struct Surface {
  std::vector<int> nodes;                         // of the mesh, one a point
  std::vector<std::array<std::size_t, 3>> faces;  // of points
  std::vector<int> tags;
  std::vector<std::size_t> of_boundary;  // number of the boundary face
};

// Corners of one cell of a grid become one point; triangles that collapse are left out.
Surface joined(const TetMesh& mesh, double cell) {
  Surface surface;
  std::map<std::array<long long, 3>, std::size_t> known;
  const auto point = [&](int node) {
    const Vector3& p = mesh.nodes[static_cast<std::size_t>(node)];
    const std::array<long long, 3> key{std::llround(p.x() / cell), std::llround(p.y() / cell),
                                       std::llround(p.z() / cell)};
    const auto [at, is_new] = known.emplace(key, surface.nodes.size());
    if (is_new) surface.nodes.push_back(node);
    return at->second;
  };
  for (const BoundaryFace& face : mesh.boundary) {
    const std::array<std::size_t, 3> corners{point(face.nodes[0]), point(face.nodes[1]),
                                             point(face.nodes[2])};
    if (corners[0] == corners[1] || corners[1] == corners[2] || corners[2] == corners[0]) continue;
    surface.faces.push_back(corners);
    surface.tags.push_back(face.tag);
    surface.of_boundary.push_back(static_cast<std::size_t>(&face - mesh.boundary.data()));
  }
  return surface;
}

double size_of(const TetMesh& mesh) {
  Vector3 low = mesh.nodes.front(), high = low;
  for (const Vector3& p : mesh.nodes) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  return (high - low).norm();
}

Surface surface_of(const TetMesh& mesh, double size, std::size_t most_points) {
  double cell = 1e-6 * size;
  Surface surface = joined(mesh, cell);
  for (cell = size / 1000; surface.nodes.size() > most_points; cell *= 1.3)
    surface = joined(mesh, cell);
  return surface;
}

Json shape_json(const Surface& surface, const std::string& name, const Eigen::Matrix3Xd& field) {
  double largest = 0;
  for (const int node : surface.nodes) largest = std::max(largest, field.col(node).norm());
  const double unit = largest > 0 ? largest / shape_steps : 1;
  Json shifts = Json::array();
  for (const int node : surface.nodes)
    for (int k = 0; k < 3; ++k) shifts.push_back(std::llround(field(k, node) / unit));
  return {{"load", name}, {"unit", unit}, {"displacements", std::move(shifts)}};
}

FaceSelectors selectors_of(const LinkResult& result) {
  fea::SurfaceMesh boundary{.points = result.mesh.nodes};
  for (const BoundaryFace& face : result.mesh.boundary)
    boundary.triangles.push_back({face.nodes[0], face.nodes[1], face.nodes[2]});
  drop_unused_points(boundary);
  return face_selectors(boundary, {result.unit, spatial::parse_unit(result.unit).factor});
}

// 0: none, 1: the fixed one, 2 and up: loaded.
int interface_of(const LinkResult& result, int tag) {
  for (std::size_t i = 0; i < result.interfaces.size(); ++i)
    if (result.interfaces[i].geometry.tag == tag) return static_cast<int>(i) + 1;
  return 0;
}

}  // namespace

Json link_picture(const LinkResult& result, std::size_t most_points) {
  static constexpr const char* loads[] = {"Fx", "Fy", "Fz", "Mx", "My", "Mz"};
  const double size = size_of(result.mesh), unit = size / point_steps;
  const Surface surface = surface_of(result.mesh, size, most_points);
  Json json{{"point_unit", unit},          {"points", Json::array()},
            {"triangles", Json::array()},  {"of_interface", Json::array()},
            {"interfaces", Json::array()}, {"shapes", Json::array()},
            {"of_face", Json::array()}};
  for (const int node : surface.nodes)
    for (const double x : result.mesh.nodes[static_cast<std::size_t>(node)])
      json["points"].push_back(std::llround(x / unit));
  for (const auto& face : surface.faces)
    for (const std::size_t corner : face) json["triangles"].push_back(corner);
  for (const int tag : surface.tags) json["of_interface"].push_back(interface_of(result, tag));
  const FaceSelectors faces = selectors_of(result);
  json["faces"] = faces.selectors;
  for (const std::size_t f : surface.of_boundary) json["of_face"].push_back(faces.of_facets[f]);
  for (const CoupledInterface& interface : result.interfaces)
    json["interfaces"].push_back(
        {{"name", interface.name}, {"point", io::to_json(interface.point)}});
  for (std::size_t c = 0; c < result.response.fields.size(); ++c) {
    const std::string where =
        result.interfaces.size() > 2 ? result.interfaces[c / 6 + 1].name + " " : std::string();
    json["shapes"].push_back(shape_json(surface, where + loads[c % 6], result.response.fields[c]));
  }
  return json;
}

}  // namespace kinetostat::report
