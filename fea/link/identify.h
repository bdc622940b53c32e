// A link's mesh in, its 6x6 compliance out.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "kinetostat/common/progress.h"
#include "kinetostat/fea/interface/interface_selection.h"
#include "kinetostat/fea/linear_algebra/blas.h"
#include "kinetostat/fea/link/coupling_bracket.h"
#include "kinetostat/fea/link/geometric_stiffness.h"
#include "kinetostat/fea/link/link_geometry.h"
#include "kinetostat/fea/link/link_response.h"
#include "kinetostat/fea/link/refinement.h"
#include "kinetostat/fea/mesh/solid_mesh.h"
#include "kinetostat/fea/mesh/tetrahedralize.h"
#include "kinetostat/fea/surface/surface_check.h"
#include "kinetostat/io/json.h"
#include "kinetostat/spatial/stiffness.h"

namespace kinetostat::fea {

/// A body of an assembly.
struct BodyResult {
  std::string name;
  Material material;
  std::string material_name = {};  // may be empty
  double young_deviation = 0;      // [Pa] as LinkResult has it
  double volume = 0;               // [m^3] of its elements
  std::size_t elements = 0;
};

/// Two bodies of an assembly and what is between them.
struct JointResult {
  std::array<std::string, 2> bodies = {};
  std::optional<ElasticLayer> layer = {};  // none: they are bonded
  double area = 0;                         // [m^2] where they touch
  double gap = 0;                          // [m] between their faces there, at most
};

struct LinkResult {
  LinkResult(std::string link_name, std::vector<Material> link_materials)
      : name(std::move(link_name)),
        material(link_materials.front()),
        materials(std::move(link_materials)) {}

  std::string name;
  /// Compliance of the first loaded interface at its point, mesh axes; the fixed interface does not
  /// move. It is all of `response.flexibility` where there is one loaded interface, else a part of
  /// it.
  spatial::Compliance6 compliance{Matrix6::Zero()};
  double symmetry_defect = 0;       // of the matrix before it was made symmetric
  Material material;                // of the first body
  std::vector<Material> materials;  // of all, as the elements name them
  std::string material_name = {};   // by which the link file has it; may be empty
  double young_deviation = 0;       // [Pa] one standard deviation of Young's modulus; 0: not stated

  std::vector<BodyResult> bodies = {};   // of an assembly, else empty
  std::vector<JointResult> joints = {};  // in the order of the link file

  std::optional<double> mass;      // [kg]; without a density there is none
  Vector3 center_of_mass;          // [m]
  std::optional<Matrix3> inertia;  // [kg m^2] about the centre of mass, mesh axes

  std::vector<CoupledInterface> interfaces;  // the fixed one first
  TetMesh mesh;
  MassProperties geometry;
  MeshQuality quality;
  MeshingRecord meshing;      // of the mesh file: empty
  double element_size = 0;    // [m] asked for; 0 when accuracy was
  double surface_volume = 0;  // [m^3] enclosed by the input facets
  WeldReport weld;
  std::size_t facets = 0;

  LinkResponse response;  // with the displacement fields
  Accuracy accuracy;      // error bars of the flexibility, and the meshes on the way to it
  std::optional<CouplingBracket> bracket;
  std::optional<Vector6> preload;  // at the loaded interface's point [N; N m]
  std::optional<GeometricStiffness> geometric_stiffness;  // under the preload, if there is one
  std::vector<std::string> warnings;
  std::vector<std::pair<std::string, double>> timings;  // [s], by phase
  BlasInfo blas;

  std::string link_sha256, mesh_sha256, mesh_file, unit;
};

/// Whether to solve twice more for the bracket between rigid and distributing couplings.
enum class BracketWanted {
  when_cheap,  // up to cheap_bracket_unknowns: a few seconds
  always,
  never,
};
inline constexpr std::size_t cheap_bracket_unknowns = 300'000;  // of the link alone

struct IdentifyOptions {
  TetrahedralizeOptions meshing = {};  // edge_length and sizes are set from the link file
  SolverOptions solver = {};
  RefinementOptions refinement = {};  // accuracy is set from the link file, threads from solver
  BracketWanted bracket = BracketWanted::when_cheap;
};

/// `geometry` is that of the link (read_geometry()). Throws SurfaceError and InputError for what
/// the user can correct, common::OutOfMemory, Cancelled.
LinkResult identify(const LinkSpec& spec, const LinkGeometry& geometry,
                    const IdentifyOptions& options, common::Progress& progress);

}  // namespace kinetostat::fea
