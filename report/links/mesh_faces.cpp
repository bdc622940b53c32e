#include "kinetostat/report/links/mesh_faces.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "kinetostat/fea/surface/surface_faces.h"

namespace kinetostat::report::mesh_faces {
namespace {

using fea::CadFace;
using fea::FaceKind;
using io::Json;
using spatial::Vector3;

// Faces of files that have none of their own.
constexpr std::size_t most_found = 40;
constexpr double least_share =
    0.005;  // of the area of all facets: smaller ones are parts of others

struct ListedFace {
  CadFace face;
  std::size_t number = 0;  // in the CAD file; 0: none
  std::string selector;
  std::vector<int> facets = {};  // where the facets show the face
};

double clean(double x) { return std::abs(x) < 5e-7 ? 0.0 : x; }

std::string triple(const Vector3& v, double unit = 1) {
  return fmt::format("[{:.6g}, {:.6g}, {:.6g}]", clean(v.x() / unit), clean(v.y() / unit),
                     clean(v.z() / unit));
}

std::string plane_selector(const Vector3& point, const Vector3& normal, double unit) {
  return fmt::format("plane: {{point: {}, normal: {}}}", triple(point, unit), triple(normal));
}

// By its name, where no other face has that.
std::string selector_of(const std::vector<CadFace>& faces, std::size_t f) {
  const std::string& name = faces[f].name;
  const auto same = std::count_if(faces.begin(), faces.end(),
                                  [&name](const CadFace& face) { return face.name == name; });
  const bool is_number = name.find_first_not_of("0123456789") == std::string::npos;
  const bool is_plain = name.find_first_of("\"\\\n\r\t") == std::string::npos;
  return same == 1 && !is_number && is_plain ? fmt::format("face: \"{}\"", name)
                                             : fmt::format("face: {}", f + 1);
}

std::vector<ListedFace> of_file(const std::vector<CadFace>& faces) {
  std::vector<ListedFace> list;
  for (std::size_t f = 0; f < faces.size(); ++f)
    list.push_back({faces[f], f + 1, selector_of(faces, f)});
  return list;
}

ListedFace listed(const fea::FlatFace& flat, double unit) {
  return {{.kind = FaceKind::plane,
           .area = flat.area,
           .centre = flat.centroid,
           .point = flat.centroid,
           .direction = flat.normal},
          0,
          plane_selector(flat.centroid, flat.normal, unit),
          flat.facets};
}

ListedFace listed(const fea::SurfaceMesh& surface, const fea::RoundFace& round, double unit) {
  ListedFace face{
      {.kind = FaceKind::cylinder,
       .centre = round.axis_point,
       .point = round.axis_point,
       .direction = round.axis,
       .radius = round.radius},
      0,
      fmt::format("cylinder: {{axis_point: {}, axis: {}, radius: {:.6g}, length: {:.6g}}}",
                  triple(round.axis_point - 0.5 * round.length * round.axis, unit),
                  triple(round.axis), round.radius / unit, round.length / unit),
      round.facets};
  for (const int f : round.facets)
    face.face.area += surface.area_vector(static_cast<std::size_t>(f)).norm();
  return face;
}

// Round faces, and the flat ones that are no part of them.
std::vector<ListedFace> found_in(const fea::SurfaceMesh& surface, double unit) {
  const auto flat = fea::flat_faces(surface, fea::weld_tolerance(surface.points));
  std::vector<bool> is_round(surface.triangles.size(), false);
  std::vector<ListedFace> list;
  for (const fea::RoundFace& round : fea::round_faces(surface, flat)) {
    for (const int f : round.facets) is_round[static_cast<std::size_t>(f)] = true;
    list.push_back(listed(surface, round, unit));
  }
  for (const fea::FlatFace& face : flat)
    if (!is_round[static_cast<std::size_t>(face.facets.front())])
      list.push_back(listed(face, unit));
  std::stable_sort(list.begin(), list.end(), [](const ListedFace& a, const ListedFace& b) {
    return a.face.area > b.face.area;
  });
  double area = 0;
  for (const ListedFace& face : list) area += face.face.area;
  std::erase_if(list, [area](const ListedFace& f) { return f.face.area < least_share * area; });
  if (list.size() > most_found) list.resize(most_found);
  return list;
}

std::vector<ListedFace> all(const fea::SurfaceMesh& surface, double unit) {
  return surface.faces.empty() ? found_in(surface, unit) : of_file(surface.faces);
}

std::string line_of(const ListedFace& listed, const MeshCheckUnits& units) {
  const CadFace& face = listed.face;
  std::string line = listed.number > 0 ? fmt::format("{:>4}  ", listed.number) : "  ";
  line += fmt::format("{:<8}", fea::face_kinds[static_cast<std::size_t>(face.kind)]);
  line += fmt::format("  {:>10.5g} {}^2", face.area / (units.length * units.length), units.unit);
  line += "  centre " + triple(face.centre, units.length);
  if (face.direction != Vector3::Zero())
    line += (face.kind == FaceKind::plane ? ", normal " : ", axis ") + triple(face.direction);
  if (face.radius > 0) line += fmt::format(", radius {:.6g}", face.radius / units.length);
  if (!face.colour.empty()) line += ", colour \"" + face.colour + "\"";
  return line + "\n        " + listed.selector + "\n";
}

}  // namespace
}  // namespace kinetostat::report::mesh_faces

namespace kinetostat::report {

std::string faces_text(const fea::SurfaceMesh& surface, const MeshCheckUnits& units) {
  using namespace mesh_faces;
  const auto faces = all(surface, units.length);
  std::string text =
      surface.faces.empty()
          ? fmt::format("{} faces that the facets show, the largest first:\n", faces.size())
          : fmt::format("{} faces of the file:\n", faces.size());
  for (const ListedFace& face : faces) text += line_of(face, units);
  return text;
}

io::Json faces_json(const fea::SurfaceMesh& surface, const MeshCheckUnits& units) {
  using namespace mesh_faces;
  Json list = Json::array();
  for (const ListedFace& listed : all(surface, units.length)) {
    const CadFace& face = listed.face;
    Json json{{"kind", fea::face_kinds[static_cast<std::size_t>(face.kind)]},
              {"area", face.area},
              {"centre", io::to_json(face.centre)},
              {"selector", listed.selector},
              {"number", nullptr},
              {"name", nullptr},
              {"colour", nullptr},
              {"direction", nullptr},
              {"radius", nullptr}};
    if (listed.number > 0) json["number"] = listed.number;
    if (!face.name.empty()) json["name"] = face.name;
    if (!face.colour.empty()) json["colour"] = face.colour;
    if (face.direction != Vector3::Zero()) json["direction"] = io::to_json(face.direction);
    if (face.radius > 0) json["radius"] = face.radius;
    list.push_back(std::move(json));
  }
  return list;
}

FaceSelectors face_selectors(const fea::SurfaceMesh& boundary, const MeshCheckUnits& units) {
  FaceSelectors found{{}, std::vector<int>(boundary.triangles.size(), -1)};
  for (const mesh_faces::ListedFace& face : mesh_faces::found_in(boundary, units.length)) {
    for (const int f : face.facets)
      found.of_facets[static_cast<std::size_t>(f)] = static_cast<int>(found.selectors.size());
    found.selectors.push_back(face.selector);
  }
  return found;
}

}  // namespace kinetostat::report
