// Natural frequencies of a link as its link file describes it, with error bars.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "kinetostat/fea/link/link_geometry.h"
#include "kinetostat/fea/link/modes.h"
#include "kinetostat/fea/link/reduced_model.h"
#include "kinetostat/fea/link/refinement.h"

namespace kinetostat::fea {

struct ModalOptions {
  Support support = Support::first_interface;
  int modes = 6;                       // at least 1
  TetrahedralizeOptions meshing = {};  // edge_length and sizes are set from the link file
  SolverOptions solver = {};           // threads and memory of it; the factors are always made
  RefinementOptions refinement = {};   // accuracy is set from the link file
};

struct NaturalMode {
  double frequency = 0;  // [Hz]
  double error = 0;      // half width of its error bar, of the frequency
  /// Shares of its kinetic energy in motion along the mesh axes; they add up to 1.
  Vector3 motion = Vector3::Zero();
  /// Of the mass of the link, what takes part when the support shakes along the mesh axes
  /// (effective modal mass). Over all modes they add up to at most 1; 0 for a free link.
  Vector3 effective_mass = Vector3::Zero();
};

struct ModalResult {
  std::string name;
  Support support;
  std::vector<NaturalMode> modes;            // ascending
  LinkModes shapes;                          // of the last mesh
  Accuracy accuracy;                         // of 1 / omega^2 [s^2]: its `flexibility`
  double mass;                               // [kg]
  Vector3 center_of_mass;                    // [m]
  Matrix3 inertia;                           // [kg m^2] about the centre of mass, mesh axes
  std::vector<Material> materials;           // of the bodies, as the elements name them
  std::vector<CoupledInterface> interfaces;  // the fixed one first
  TetMesh mesh;
  std::vector<std::string> warnings;
  std::string link_sha256, mesh_sha256, mesh_file, unit;

  /// The largest error of a frequency.
  double error() const;
};

/// The energy of the error of mode i on a mesh is lambda_h - lambda to leading order, with a modal
/// mass of 1: so meshes are refined and judged as identify's, by the recovered stresses and by the
/// sequence, for the flexibilities 1 / omega^2. Throws as identify() does, InputError also where
/// the material has no density.
ModalResult modal_study(const LinkSpec& spec, const LinkGeometry& geometry,
                        const ModalOptions& options, common::Progress& progress);

/// Craig and Bampton's model of the link on the last mesh, with `options.modes` modes. Throws as
/// modal_study() does.
ReducedModel reduced_link(const LinkSpec& spec, const ModalResult& result,
                          const ModalOptions& options, common::Progress& progress);

}  // namespace kinetostat::fea
