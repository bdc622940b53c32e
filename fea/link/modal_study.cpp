#include "kinetostat/fea/link/modal_study.h"

#include <algorithm>
#include <cmath>

#include "kinetostat/common/index.h"
#include "kinetostat/fea/elasticity/element_mass.h"
#include "kinetostat/fea/link/link_model.h"

namespace kinetostat::fea::modal_study_of_link {
namespace {

// Each mode under the load that moves it by itself alone: M x, with the flexibility 1 / omega^2.
LinkResponse response_of(const LinkModes& modes) {
  LinkResponse response;
  response.flexibility = modes.omega_squared.cwiseInverse().asDiagonal();
  for (std::size_t k = 0; k < modes.shapes.size(); ++k)
    response.fields.push_back(modes.shapes[k] / modes.omega_squared[static_cast<Eigen::Index>(k)]);
  response.solver.unknowns = modes.unknowns;
  response.solver.factor = modes.factor;
  return response;
}

LinkModes modes_of(const LinkResponse& response) {
  LinkModes modes{.omega_squared = response.flexibility.diagonal().cwiseInverse(), .shapes = {}};
  for (std::size_t k = 0; k < response.fields.size(); ++k)
    modes.shapes.push_back(response.fields[k] * modes.omega_squared[static_cast<Eigen::Index>(k)]);
  modes.unknowns = response.solver.unknowns;
  modes.factor = response.solver.factor;
  return modes;
}

void require_density(const LinkSpec& spec) {
  for (const LinkSpec& body : spec.bodies) require_density(body);
  if (spec.material.density()) return;
  common::InputError::Details details = spec.material_origin;
  details.what = "there is no density, and without mass nothing vibrates";
  details.cure = "Write 'density: 7850 kg/m^3' for steel";
  throw common::InputError(details);
}

NaturalMode described(const ModalResult& result, std::size_t k) {
  const auto entry = static_cast<Eigen::Index>(k);
  const Accuracy& accuracy = result.accuracy;
  NaturalMode mode{.frequency = result.shapes.frequency(k),
                   .error = accuracy.bars.bar(entry, entry) /
                            accuracy.meshes.back().flexibility(entry, entry) / 2};
  const Eigen::Matrix3Xd momenta =
      inertial_forces(result.mesh, result.materials, result.shapes.shapes[k]);
  mode.motion = momenta.cwiseProduct(result.shapes.shapes[k]).rowwise().sum();
  if (result.support != Support::none)
    mode.effective_mass = momenta.rowwise().sum().cwiseAbs2() / result.mass;
  return mode;
}

ModalResult started(const LinkSpec& spec, const LinkGeometry& geometry, Support support,
                    RefinedModel refined) {
  const RigidMass mass = *rigid_mass(refined.model.mesh, refined.model.materials);
  return {.name = spec.name,
          .support = support,
          .modes = {},
          .shapes = modes_of(refined.model.response),
          .accuracy = std::move(refined.accuracy),
          .mass = mass.mass,
          .center_of_mass = mass.center,
          .inertia = mass.inertia,
          .materials = refined.model.materials,
          .interfaces = std::move(refined.model.interfaces),
          .mesh = std::move(refined.model.mesh),
          .warnings = geometry.notes,
          .link_sha256 = spec.sha256,
          .mesh_sha256 = geometry.imported.sha256,
          .mesh_file = spec.mesh_name,
          .unit = spec.unit};
}

}  // namespace
}  // namespace kinetostat::fea::modal_study_of_link

namespace kinetostat::fea {

double ModalResult::error() const {
  double most = 0;
  for (const NaturalMode& mode : modes) most = std::max(most, mode.error);
  return most;
}

ModalResult modal_study(const LinkSpec& spec, const LinkGeometry& geometry,
                        const ModalOptions& options, common::Progress& progress) {
  using namespace modal_study_of_link;
  require_density(spec);
  LinkMesher mesher(geometry);
  const Respond respond_on = [&](const LinkModel& model) {
    return response_of(link_modes(model.mesh, model.materials, model.interfaces, options.support,
                                  options.modes, options.solver, progress));
  };
  LinkModelOptions asked{.meshing = options.meshing,
                         .refinement = options.refinement,
                         .threads = options.solver.threads};
  asked.refinement.power = 2;
  asked.refinement.quantity = "a frequency";
  ModalResult result = started(spec, geometry, options.support,
                               model_as_asked(spec, geometry, mesher, respond_on, asked, progress));
  for (std::size_t k = 0; k < result.shapes.shapes.size(); ++k)
    result.modes.push_back(described(result, k));
  if (spec.order == 1) result.warnings.emplace_back("4-node elements are too stiff: use order 2");
  return result;
}

ReducedModel reduced_link(const LinkSpec& spec, const ModalResult& result,
                          const ModalOptions& options, common::Progress& progress) {
  const std::vector<Material>& materials = result.materials;
  ReducedModel model;
  explained(spec, result.mesh, [&] {
    const LinkModes held =
        result.support == Support::all_interfaces
            ? result.shapes
            : link_modes(result.mesh, materials, result.interfaces, Support::all_interfaces,
                         options.modes, options.solver, progress);
    model = craig_bampton(
        result.mesh, materials, result.interfaces,
        respond(result.mesh, materials, result.interfaces, options.solver, progress), held);
  });
  return model;
}

}  // namespace kinetostat::fea
