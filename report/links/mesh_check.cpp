#include "kinetostat/report/links/mesh_check.h"

#include <cmath>

#include <Eigen/Eigenvalues>
#include <fmt/format.h>

#include "kinetostat/spatial/units.h"

namespace kinetostat::report {
namespace {

using io::Json;
using spatial::Matrix3;
using spatial::Vector3;

std::string vector_text(const Vector3& v, double unit) {
  return fmt::format("[{:.6g}, {:.6g}, {:.6g}]", v.x() / unit, v.y() / unit, v.z() / unit);
}

// A direction without its arbitrary sign: the largest component is positive.
Vector3 shown_axis(Vector3 axis) {
  Eigen::Index largest = 0;
  axis.cwiseAbs().maxCoeff(&largest);
  axis *= axis[largest] < 0 ? -1 : 1;
  return (axis.array().abs() < 5e-7).select(0, axis);
}

std::string mass_text(const fea::MassProperties& mass, const MeshCheckUnits& units) {
  std::string out =
      fmt::format("centre {} {}\n", vector_text(mass.centroid, units.length), units.unit);
  if (!(units.density > 0)) return out;
  const Eigen::SelfAdjointEigenSolver<Matrix3> principal(fea::inertia(mass, units.density));
  out += fmt::format("principal moments of inertia about the centre {} kg m^2\n",
                     vector_text(principal.eigenvalues(), 1));
  for (int k = 0; k < 3; ++k)
    out += fmt::format("  axis {} {}\n", k + 1,
                       vector_text(shown_axis(principal.eigenvectors().col(k)), 1));
  return out;
}

Json mass_json(const fea::MassProperties& mass, double density) {
  Json json{{"volume", mass.volume},
            {"center", io::to_json(mass.centroid)},
            {"mass", Json()},
            {"inertia", Json()}};
  if (!(density > 0)) return json;
  json["mass"] = mass.volume * density;
  json["inertia"] = io::rows(fea::inertia(mass, density));
  return json;
}

Json box_json(const fea::Box& box) {
  return {{"min", io::to_json(Vector3(box.min()))}, {"max", io::to_json(Vector3(box.max()))}};
}

Json weld_json(const fea::WeldReport& weld) {
  return {{"tolerance", weld.tolerance},
          {"points_before", weld.points_before},
          {"points_after", weld.points_after},
          {"collapsed_facets", weld.collapsed.size()}};
}

Json defects_json(const fea::SurfaceReport& report) {
  Json list = Json::array();
  for (const fea::Defect& defect : report.defects) {
    Json facets = Json::array();
    for (const int f : defect.facets) facets.push_back(f + 1);
    list.push_back({{"defect", fea::name(defect.kind)},
                    {"count", defect.count},
                    {"facets", facets},
                    {"cure", fea::cure(defect.kind)}});
  }
  return list;
}

Json bodies_json(const std::vector<fea::Body>& bodies) {
  Json list = Json::array();
  for (const fea::Body& body : bodies)
    list.push_back(
        {{"name", body.name}, {"facets", body.facets.size()}, {"box", box_json(body.box)}});
  return list;
}

Json repair_json(const fea::RepairReport& repair, const fea::RepairOptions& asked) {
  Json actions = Json::array();
  for (const fea::RepairAction& action : repair.actions)
    actions.push_back(
        {{"step", fea::name(action.step)}, {"done", action.done}, {"words", action.words}});
  return {{"actions", actions},
          {"limit", asked.limit},
          {"volume_before", repair.volume_before ? Json(*repair.volume_before) : Json()},
          {"volume_after", repair.volume_after},
          {"distance", repair.distance},
          {"patch_area", repair.patch_area}};
}

Json si_units() { return {{"length", "m"}, {"mass", "kg"}}; }

}  // namespace

std::string text(const fea::SurfaceCheck& check, const fea::RepairOptions& asked,
                 const MeshCheckUnits& units) {
  const fea::WeldReport& weld = check.surface.weld;
  std::string out = fmt::format("welded {} points into {} with tolerance {:.3g} m\n",
                                weld.points_before, weld.points_after, weld.tolerance);
  if (!check.picked.empty()) out += fmt::format("body {} of {}\n", check.picked, check.picked_of);
  if (!asked.steps.empty())
    for (const std::string& line : fea::describe(check.repair, asked)) out += line + "\n";
  for (const std::string& line : fea::describe(check.report, units.unit, units.density))
    out += line + "\n";
  if (check.report.sound()) out += mass_text(check.mass, units);
  if (check.bodies.size() > 1)
    out += fmt::format("bodies: {}\n", fea::list_bodies(check.bodies, units.unit));
  return out;
}

std::string text(const fea::VolumeCheck& check, const MeshCheckUnits& units) {
  const fea::TetMesh& mesh = check.volume.mesh;
  std::string out =
      fmt::format("{} tetrahedra of {} nodes{}, {} nodes, {}\n", mesh.element_count(),
                  mesh.nodes_per_element(), mesh.curved ? " with curved edges" : "",
                  mesh.nodes.size(), check.pieces == 1 ? "in one piece" : "in several pieces");
  out += fmt::format("smallest angle {:.3g} deg, median {:.3g} deg, largest edge ratio {:.3g}\n",
                     check.quality.least_dihedral, check.quality.median_dihedral,
                     check.quality.largest_edge_ratio);
  out += fmt::format("volume {:.6g} {}^3\n", check.mass.volume / std::pow(units.length, 3),
                     units.unit);
  if (units.density > 0) out += fmt::format("mass {:.6g} kg\n", check.mass.volume * units.density);
  out += mass_text(check.mass, units);
  for (const fea::FacetGroup& group : check.volume.surface.groups)
    out += fmt::format("group of faces {}: {}\n", group.name, group.facets.size());
  for (const fea::ElementGroup& group : check.volume.element_groups)
    out += fmt::format("group of elements {}: {}\n", group.name, group.elements.size());
  for (const std::string& warning : check.volume.warnings) out += "warning: " + warning + "\n";
  return out;
}

Json to_json(const fea::SurfaceCheck& check, const fea::RepairOptions& asked, double density) {
  const fea::SurfaceReport& report = check.report;
  Json json{
      {"sound", report.sound()},   {"facets", report.facets},       {"points", report.points},
      {"bodies", report.bodies()}, {"cavities", report.cavities()}, {"box", box_json(report.box)},
      {"area", report.area}};
  if (report.sound())
    json.update(mass_json(check.mass, density));
  else
    json.update({{"volume", Json()}, {"mass", Json()}});
  json["units"] = si_units();
  json["weld"] = weld_json(check.surface.weld);
  json["named_bodies"] = bodies_json(check.bodies);
  json["defects"] = defects_json(report);
  if (!asked.steps.empty()) json["repair"] = repair_json(check.repair, asked);
  json["inputs"] = {{"mesh_sha256", check.surface.sha256}};
  return json;
}

namespace {

std::pair<Json, Json> face_and_element_groups(const fea::VolumeCheck& check) {
  Json faces = Json::object(), elements = Json::object();
  for (const fea::FacetGroup& group : check.volume.surface.groups)
    faces[group.name] = group.facets.size();
  for (const fea::ElementGroup& group : check.volume.element_groups)
    elements[group.name] = group.elements.size();
  return {faces, elements};
}

}  // namespace

Json to_json(const fea::VolumeCheck& check, double density) {
  const auto [faces, elements] = face_and_element_groups(check);
  Json json{{"sound", true},
            {"elements", check.volume.mesh.element_count()},
            {"nodes", check.volume.mesh.nodes.size()},
            {"order", check.volume.mesh.order},
            {"least_dihedral_deg", check.quality.least_dihedral},
            {"median_dihedral_deg", check.quality.median_dihedral},
            {"largest_edge_ratio", check.quality.largest_edge_ratio},
            {"face_groups", faces},
            {"element_groups", elements},
            {"warnings", check.volume.warnings}};
  json.update(mass_json(check.mass, density));
  json["units"] = si_units();
  json["inputs"] = {{"mesh_sha256", check.volume.sha256}};
  return json;
}

}  // namespace kinetostat::report
