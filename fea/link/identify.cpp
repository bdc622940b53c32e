#include "kinetostat/fea/link/identify.h"

#include <algorithm>
#include <chrono>

#include <fmt/format.h>

#include "kinetostat/common/index.h"
#include "kinetostat/fea/elasticity/element_mass.h"
#include "kinetostat/fea/link/link_model.h"

namespace kinetostat::fea {
namespace {

// Collects the wall-clock time of each phase.
class Stopwatch {
 public:
  explicit Stopwatch(double surface_seconds) : laps_{{"surface", surface_seconds}} {}
  void lap(std::string phase) {
    const auto now = Clock::now();
    laps_.emplace_back(std::move(phase), std::chrono::duration<double>(now - last_).count());
    last_ = now;
  }
  std::vector<std::pair<std::string, double>> laps() && { return std::move(laps_); }

 private:
  using Clock = std::chrono::steady_clock;
  Clock::time_point last_ = Clock::now();
  std::vector<std::pair<std::string, double>> laps_;
};

void add_meshing_warnings(LinkResult& result) {
  const MeshingRecord& meshing = result.meshing;
  if (meshing.failures.empty()) return;
  const MeshingFailure& first = meshing.failures.front();
  result.warnings.push_back(fmt::format("{} failed: {}. Meshed by attempt {}: {}", first.way,
                                        first.reason, meshing.failures.size() + 1, meshing.way));
  if (meshing.deviation)
    result.warnings.push_back(fmt::format(
        "the surface that was meshed is an approximation: at most {:.2g} m from the given one "
        "({:.2g} m allowed), its volume differs by {:+.2g} %",
        meshing.deviation->distance, meshing.deviation->allowed,
        100 * meshing.deviation->volume_change));
}

void add_warnings(const LinkSpec& spec, const SurfaceReport& report, LinkResult& result) {
  if (spec.order == 1)
    result.warnings.push_back(
        fmt::format("4-node elements are too stiff: here an entry of the compliance may be off by "
                    "{:.2g} %. Use order 2",
                    100 * result.accuracy.bars.relative_error));
  if (std::string doubt = doubt_about_unit(report.box, spec.unit); !doubt.empty())
    result.warnings.push_back(std::move(doubt));
  for (const Defect& defect : report.defects)
    result.warnings.push_back(
        fmt::format("{} {}s in the surface", defect.count, name(defect.kind)));
  if (!result.weld.collapsed.empty())
    result.warnings.push_back(fmt::format("{} facets collapsed in welding and were left out",
                                          result.weld.collapsed.size()));
  if (result.mesh.straightened > 0)
    result.warnings.push_back(
        fmt::format("{} of {} elements stay straight at curved faces: they would turn inside out",
                    result.mesh.straightened, result.mesh.element_count()));
  if (result.mesh.gaps.empty() &&
      std::abs(result.geometry.volume / result.surface_volume - 1) > 1e-6)
    result.warnings.push_back(
        fmt::format("the volume of the mesh is {:.3g} % off the surface's",
                    100 * (result.geometry.volume / result.surface_volume - 1)));
  if (result.geometric_stiffness && result.geometric_stiffness->buckling_free < 1)
    result.warnings.push_back(
        fmt::format("the link buckles at {:.3g} times the preload when nothing holds its loaded "
                    "interface",
                    result.geometric_stiffness->buckling_free));
  add_meshing_warnings(result);
  if (result.quality.least_dihedral < 2)
    result.warnings.push_back(fmt::format("the flattest element has an angle of {:.2g} degrees",
                                          result.quality.least_dihedral));
}

bool is_wanted(BracketWanted wanted, const TetMesh& mesh) {
  return wanted == BracketWanted::always ||
         (wanted == BracketWanted::when_cheap && 3 * mesh.nodes.size() <= cheap_bracket_unknowns);
}

// What is known of the link before anything is computed.
LinkResult started(const LinkSpec& spec, const LinkGeometry& geometry) {
  LinkResult result(spec.name, materials_of(spec));
  result.preload = spec.preload;
  result.material_name = spec.material_name;
  result.young_deviation = spec.young_deviation;
  result.element_size = spec.size.value_or(0);
  result.surface_volume = geometry.report.volume;
  result.weld = geometry.imported.weld;
  result.facets = geometry.report.facets;
  result.warnings = geometry.notes;
  result.link_sha256 = spec.sha256;
  result.mesh_sha256 = geometry.imported.sha256;
  result.mesh_file = spec.mesh_name;
  result.unit = spec.unit;
  return result;
}

void add_mass(LinkResult& result) {
  result.center_of_mass = result.geometry.centroid;
  const std::optional<RigidMass> mass = rigid_mass(result.mesh, result.materials);
  if (!mass) return;
  result.mass = mass->mass;
  result.center_of_mass = mass->center;
  result.inertia = mass->inertia;
}

void add_bodies(const LinkSpec& spec, LinkResult& result) {
  for (const LinkSpec& body : spec.bodies)
    result.bodies.push_back({.name = body.name,
                             .material = body.material,
                             .material_name = body.material_name,
                             .young_deviation = body.young_deviation,
                             .volume = mass_properties(result.mesh, result.bodies.size()).volume});
  if (!result.bodies.empty())
    for (std::size_t e = 0; e < result.mesh.element_count(); ++e)
      ++result.bodies[result.mesh.material_of(e)].elements;
  for (const JointSpec& joint : spec.joints)
    result.joints.push_back(
        {.bodies = {spec.bodies[joint.bodies[0]].name, spec.bodies[joint.bodies[1]].name},
         .layer = joint.layer});
  for (const FaceContact& contact : result.mesh.contacts) {
    JointResult& joint = result.joints[common::at(contact.joint)];
    joint.area += contact.area();
    joint.gap = std::max(joint.gap, contact.gap);
  }
}

void take(RefinedModel refined, LinkResult& result) {
  result.mesh = std::move(refined.model.mesh);
  result.interfaces = std::move(refined.model.interfaces);
  result.response = std::move(refined.model.response);
  result.accuracy = std::move(refined.accuracy);
  result.geometry = mass_properties(result.mesh);
  result.quality = quality(result.mesh);
  result.symmetry_defect = spatial::symmetry_defect(result.response.compliance());
  result.compliance = compliance_of(result.response.flexibility, result.interfaces, 1);
  add_mass(result);
}

void add_bracket(const LinkSpec& spec, const IdentifyOptions& options, common::Progress& progress,
                 LinkResult& result) {
  explained(spec, result.mesh, [&] {
    result.bracket = coupling_bracket(result.mesh, result.materials, result.interfaces,
                                      result.response, options.solver, progress);
  });
}

void add_geometric_stiffness(const LinkSpec& spec, common::Progress& progress, LinkResult& result) {
  explained(spec, result.mesh, [&] {
    result.geometric_stiffness = geometric_stiffness(
        result.mesh, result.materials, result.interfaces, result.response, *spec.preload, progress);
  });
}

}  // namespace

LinkResult identify(const LinkSpec& spec, const LinkGeometry& geometry,
                    const IdentifyOptions& options, common::Progress& progress) {
  Stopwatch watch(geometry.reading_seconds);
  LinkResult result = started(spec, geometry);
  LinkMesher mesher(geometry);
  const Respond respond_on = [&](const LinkModel& model) {
    return respond(model.mesh, model.materials, model.interfaces, options.solver, progress);
  };
  take(model_as_asked(spec, geometry, mesher, respond_on,
                      {.meshing = options.meshing,
                       .refinement = options.refinement,
                       .threads = options.solver.threads},
                      progress),
       result);
  add_bodies(spec, result);
  result.meshing = mesher.record();
  if (geometry.is_meshed()) result.element_size = result.quality.mean_edge;
  watch.lap("model");
  // Whoever stopped the refinement gets what it reached, and does not wait for the bracket. A
  // cancelled run that was not refining has nothing less to give than the whole result.
  const bool stopped = progress.cancelled();
  if (stopped && result.accuracy.shortfall.empty()) throw common::Cancelled();
  common::Progress silent;
  common::Progress& rest = stopped ? silent : progress;
  if (is_wanted(options.bracket, result.mesh) && !stopped) {
    add_bracket(spec, options, rest, result);
    watch.lap("bracket");
  }
  if (spec.preload) {
    add_geometric_stiffness(spec, rest, result);
    watch.lap("geometric stiffness");
  }
  add_warnings(spec, geometry.report, result);
  result.blas = blas_info();
  result.timings = std::move(watch).laps();
  return result;
}

}  // namespace kinetostat::fea
