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

// Of triangles between points, made coarser.
struct Surface {
  std::vector<int> nodes;                         // of those given, one a point
  std::vector<std::array<std::size_t, 3>> faces;  // of points
  std::vector<std::size_t> of;                    // which of the triangles given each is
};

// Corners of one cell of a grid become one point; triangles that collapse are left out.
Surface joined(const fea::SurfaceMesh& given, double cell) {
  Surface surface;
  std::map<std::array<long long, 3>, std::size_t> known;
  const auto point = [&](int node) {
    const Vector3& p = given.points[static_cast<std::size_t>(node)];
    const std::array<long long, 3> key{std::llround(p.x() / cell), std::llround(p.y() / cell),
                                       std::llround(p.z() / cell)};
    const auto [at, is_new] = known.emplace(key, surface.nodes.size());
    if (is_new) surface.nodes.push_back(node);
    return at->second;
  };
  for (std::size_t t = 0; t < given.triangles.size(); ++t) {
    const fea::Triangle& triangle = given.triangles[t];
    const std::array<std::size_t, 3> corners{point(triangle[0]), point(triangle[1]),
                                             point(triangle[2])};
    if (corners[0] == corners[1] || corners[1] == corners[2] || corners[2] == corners[0]) continue;
    surface.faces.push_back(corners);
    surface.of.push_back(t);
  }
  return surface;
}

double size_of(const fea::SurfaceMesh& given) {
  return given.points.empty() ? 0 : fea::bounding_box(given.points).sizes().norm();
}

Surface surface_of(const fea::SurfaceMesh& given, double size, std::size_t most_points) {
  double cell = 1e-6 * size;
  Surface surface = joined(given, cell);
  for (cell = size / 1000; surface.nodes.size() > most_points; cell *= 1.3)
    surface = joined(given, cell);
  return surface;
}

// Points and triangles, and the face that each of these is of.
Json triangles_json(const fea::SurfaceMesh& given, const Surface& surface, double unit,
                    const FaceSelectors& faces) {
  Json json{{"point_unit", unit},
            {"points", Json::array()},
            {"triangles", Json::array()},
            {"faces", faces.selectors},
            {"of_face", Json::array()}};
  for (const int node : surface.nodes)
    for (const double x : given.points[static_cast<std::size_t>(node)])
      json["points"].push_back(std::llround(x / unit));
  for (const auto& face : surface.faces)
    for (const std::size_t corner : face) json["triangles"].push_back(corner);
  for (const std::size_t t : surface.of) json["of_face"].push_back(faces.of_facets[t]);
  return json;
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

// Of the corners of its elements.
fea::SurfaceMesh boundary_of(const TetMesh& mesh) {
  fea::SurfaceMesh boundary{.points = mesh.nodes};
  for (const BoundaryFace& face : mesh.boundary)
    boundary.triangles.push_back({face.nodes[0], face.nodes[1], face.nodes[2]});
  return boundary;
}

FaceSelectors selectors_of(fea::SurfaceMesh boundary, const std::string& unit) {
  drop_unused_points(boundary);
  return face_selectors(boundary, {unit, spatial::parse_unit(unit).factor});
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
  const fea::SurfaceMesh boundary = boundary_of(result.mesh);
  const double size = size_of(boundary);
  const Surface surface = surface_of(boundary, size, most_points);
  Json json =
      triangles_json(boundary, surface, size / point_steps, selectors_of(boundary, result.unit));
  json.update(
      {{"of_interface", Json::array()}, {"interfaces", Json::array()}, {"shapes", Json::array()}});
  for (const std::size_t f : surface.of)
    json["of_interface"].push_back(interface_of(result, result.mesh.boundary[f].tag));
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

Json surface_picture(const fea::SurfaceMesh& surface, const fea::SurfaceReport& report,
                     const MeshCheckUnits& units, std::size_t most_points) {
  const double size = size_of(surface);
  if (!(size > 0)) return Json::object();
  const Surface shown = surface_of(surface, size, most_points);
  Json json = triangles_json(surface, shown, size / point_steps, face_selectors(surface, units));
  json["defects"] = Json::array();
  std::vector<int> of_facets(surface.triangles.size(), -1);
  for (std::size_t d = 0; d < report.defects.size(); ++d) {
    json["defects"].push_back(fea::name(report.defects[d].kind));
    for (const int facet : report.defects[d].facets)
      of_facets[static_cast<std::size_t>(facet)] = static_cast<int>(d);
  }
  for (const std::size_t t : shown.of) json["of_defect"].push_back(of_facets[t]);
  return json;
}

}  // namespace kinetostat::report
