#include "kinetostat/report/links/link_result.h"

#include <cmath>

#include "kinetostat/fea/interface/reduced_stiffness.h"
#include "kinetostat/fea/link/reduced_model.h"
#include "kinetostat/report/links/accuracy.h"

namespace kinetostat::report {
namespace {

using fea::CoupledInterface;
using fea::LinkResult;
using fea::MeshingRecord;
using fea::SolverForecast;
using fea::SolverStats;
using io::Json;
using io::rows;
using io::to_json;

constexpr const char* wrench_names[] = {"Fx", "Fy", "Fz", "Mx", "My", "Mz"};

Json layer_json(const fea::ElasticLayer& layer) {
  return {{"normal", layer.normal}, {"tangential", layer.tangential}};
}

Json interface_json(const CoupledInterface& coupled, double fit_residual) {
  const fea::Interface& interface = coupled.geometry;
  Json json{{"area", interface.area},
            {"centroid", to_json(interface.centroid)},
            {"nodes", interface.nodes.size()},
            {"faces", interface.faces},
            {"radii_of_gyration", to_json(interface.gyration)},
            {"principal_axes", rows(interface.principal_axes.transpose())},
            {"coupling", fea::name(coupled.coupling)},
            {"point", to_json(coupled.point)},
            {"fit_residual", fit_residual}};
  if (coupled.coupling == fea::Coupling::body) json["modulus_ratio"] = coupled.modulus_ratio;
  if (coupled.coupling == fea::Coupling::elastic) json["layer"] = layer_json(coupled.layer);
  return json;
}

// Which coordinate a row of the matrices is, with the units of its motion and of its load.
Json freedoms_json(const std::vector<CoupledInterface>& interfaces) {
  static constexpr const char* motions[] = {"tx", "ty", "tz", "rx", "ry", "rz"};
  Json list = Json::array();
  for (const CoupledInterface& interface : interfaces)
    for (int j = 0; j < 6; ++j)
      list.push_back({{"interface", interface.name},
                      {"motion", motions[j]},
                      {"load", wrench_names[j]},
                      {"point", to_json(interface.point)},
                      {"motion_unit", j < 3 ? "m" : "rad"},
                      {"load_unit", j < 3 ? "N" : "N m"}});
  return list;
}

Json reduced_json(const LinkResult& result) {
  const Eigen::MatrixXd& raw = result.response.flexibility;
  Json json{{"degrees_of_freedom", freedoms_json(result.interfaces)},
            {"fixed", result.interfaces.front().name},
            {"stiffness", rows(fea::reduced_stiffness(raw, result.interfaces))},
            {"flexibility", rows(0.5 * (raw + raw.transpose()))}};
  json["mass"] =
      result.mass
          ? rows(fea::guyan_mass(result.mesh, result.materials, result.interfaces, result.response))
          : Json();
  return json;
}

Json bracket_json(const std::optional<fea::CouplingBracket>& bracket) {
  if (!bracket) return {};
  return {{"rigid", rows(bracket->rigid)}, {"distributing", rows(bracket->distributing)}};
}

// No number where nothing buckles.
Json factor_json(double factor) { return std::isfinite(factor) ? Json(factor) : Json(); }

Json preload_json(const LinkResult& result) {
  if (!result.geometric_stiffness) return {};
  const fea::GeometricStiffness& geometric = *result.geometric_stiffness;
  const spatial::Vector6& wrench = *result.preload;
  Json change;
  for (std::size_t j = 0; j < 6; ++j) change[wrench_names[j]] = rows(geometric.per_load[j]);
  return {{"force", to_json(spatial::Vector3(wrench.head<3>()))},
          {"moment", to_json(spatial::Vector3(wrench.tail<3>()))},
          {"moments", "semi-tangential"},
          {"stiffness", rows(geometric.stiffness)},
          {"stiffness_change_per_load", change},
          {"buckling_factor",
           {{"free", factor_json(geometric.buckling_free)},
            {"held", factor_json(geometric.buckling_held)}}}};
}

Json eigen_json(const spatial::Compliance6& compliance) {
  const spatial::EigenStiffness eigen = spatial::eigen_stiffness(compliance);
  return {{"translation", to_json(eigen.translation)},
          {"translation_axes", rows(eigen.translation_axes.transpose())},
          {"rotation", to_json(eigen.rotation)},
          {"rotation_axes", rows(eigen.rotation_axes.transpose())}};
}

// Of a link or of one of its bodies.
template <class Of>
Json material_json(const Of& of) {
  Json json{{"E", of.material.young()}, {"nu", of.material.poisson()}};
  json["density"] = of.material.density() ? Json(*of.material.density()) : Json();
  if (!of.material_name.empty()) json["name"] = of.material_name;
  if (of.young_deviation > 0) json["E_sd"] = of.young_deviation;
  return json;
}

Json bodies_json(const LinkResult& result) {
  Json list = Json::array();
  for (const fea::BodyResult& body : result.bodies)
    list.push_back({{"name", body.name},
                    {"material", material_json(body)},
                    {"volume", body.volume},
                    {"elements", body.elements}});
  return list;
}

Json joints_json(const LinkResult& result) {
  Json list = Json::array();
  for (const fea::JointResult& joint : result.joints)
    list.push_back({{"between", joint.bodies},
                    {"bonded", !joint.layer},
                    {"layer", joint.layer ? layer_json(*joint.layer) : Json()},
                    {"area", joint.area},
                    {"gap", joint.gap}});
  return list;
}

// The ways of meshing that failed before the one that did not.
Json failures_json(const MeshingRecord& meshing) {
  Json list = Json::array();
  for (const fea::MeshingFailure& failure : meshing.failures)
    list.push_back({{"way", failure.way}, {"reason", failure.reason}});
  return list;
}

// Of the surface that was meshed from the given one; null where it is that one.
Json deviation_json(const MeshingRecord& meshing) {
  if (!meshing.deviation) return {};
  return {{"allowed", meshing.deviation->allowed},
          {"distance", meshing.deviation->distance},
          {"volume_change", meshing.deviation->volume_change}};
}

Json mesh_json(const LinkResult& result) {
  return {{"order", result.mesh.order},
          {"mesher", result.mesh.made_by.empty() ? "from the mesh file" : result.mesh.made_by},
          {"failures", failures_json(result.meshing)},
          {"surface_deviation", deviation_json(result.meshing)},
          {"size", result.element_size > 0 ? Json(result.element_size) : Json()},
          {"elements", result.mesh.element_count()},
          {"nodes", result.mesh.nodes.size()},
          {"unknowns", result.response.solver.unknowns},
          {"volume", result.geometry.volume},
          {"surface_volume", result.surface_volume},
          {"surface_facets", result.facets},
          {"weld_tolerance", result.weld.tolerance},
          {"welded_points", result.weld.points_before - result.weld.points_after},
          {"collapsed_facets", result.weld.collapsed.size()},
          {"least_dihedral_deg", result.quality.least_dihedral},
          {"median_dihedral_deg", result.quality.median_dihedral},
          {"largest_edge_ratio", result.quality.largest_edge_ratio},
          {"mean_edge", result.quality.mean_edge}};
}

Json forecast_json(const SolverForecast& forecast) {
  if (forecast.bytes == 0) return {};
  return {{"memory", forecast.bytes}, {"seconds", forecast.seconds}};
}

Json solver_json(const SolverStats& solver) {
  Json json{{"method", fea::name(solver.method)},
            {"reason", solver.reason},
            {"levels", solver.levels},
            {"factor_entries", solver.factor.entries},
            {"reciprocal_condition", solver.factor.reciprocal_condition},
            {"iterations", solver.iterations},
            {"residual", solver.residual}};
  json["forecast"] = {{"direct", forecast_json(solver.direct)},
                      {"multigrid", forecast_json(solver.multigrid)},
                      {"petsc", forecast_json(solver.petsc)}};
  if (solver.most_elements > 0) json["most_elements"] = solver.most_elements;
  return json;
}

// All that may differ between two runs on the same input.
Json timings_json(const LinkResult& result) {
  Json json;
  for (const auto& [phase, seconds] : result.timings) json[phase] = seconds;
  json["ordering"] = result.response.solver.factor.ordering_seconds;
  json["factorisation"] = result.response.solver.factor.factor_seconds;
  json["assembly"] = result.response.solver.assembly_seconds;
  json["solution"] = result.response.solver.solve_seconds;
  json["memory_before_solution"] = result.response.solver.bytes_before;
  json["memory_peak"] = result.response.solver.peak_bytes;
  if (result.response.solver.helper_bytes > 0) {
    json["memory_helper"] = result.response.solver.helper_bytes;
    json["memory_helper_largest"] = result.response.solver.largest_helper_bytes;
  }
  json["blas"] = result.blas.name;
  json["blas_threads"] = result.blas.threads;
  return json;
}

}  // namespace

Json to_json(const LinkResult& result) {
  Json json{{"kinetostat", 1}, {"link", result.name}};
  // The spring of a robot file has two ends.
  if (result.interfaces.size() == 2) {
    const Json matrix = to_json(result.compliance);
    for (const auto& [key, value] : matrix.items()) json[key] = value;
    json["eigen_stiffness"] = eigen_json(result.compliance);
  }
  json["error"] = to_json(result.accuracy);
  json["symmetry_defect"] = result.symmetry_defect;
  json["reduced"] = reduced_json(result);
  json["bracket"] = bracket_json(result.bracket);
  json["preload"] = preload_json(result);
  json["mass"] = result.mass ? Json(*result.mass) : Json();
  json["center_of_mass"] = to_json(result.center_of_mass);
  json["inertia"] = result.inertia ? rows(*result.inertia) : Json();
  if (result.bodies.empty()) {
    json["material"] = material_json(result);
  } else {
    json["bodies"] = bodies_json(result);
    json["joints"] = joints_json(result);
  }
  for (std::size_t i = 0; i < result.interfaces.size(); ++i)
    json["interfaces"][result.interfaces[i].name] =
        interface_json(result.interfaces[i], result.response.fit_residuals[i]);
  json["mesh"] = mesh_json(result);
  json["solver"] = solver_json(result.response.solver);
  json["warnings"] = result.warnings;
  json["timings"] = timings_json(result);
  json["inputs"] = {{"link_sha256", result.link_sha256},
                    {"mesh_file", result.mesh_file},
                    {"mesh_sha256", result.mesh_sha256},
                    {"mesh_unit", result.unit},
                    {"tool", "kinetostat " KINETOSTAT_VERSION}};
  return json;
}

Json with_link_file(Json result, const std::string& link_sha256) {
  if (const auto inputs = result.find("inputs"); inputs != result.end() && inputs->is_object())
    (*inputs)["link_sha256"] = link_sha256;
  return result;
}

}  // namespace kinetostat::report
