// The link file: what to identify, as people write it.
//
//     kinetostat: 1
//     link: foot
//     mesh: {file: foot.stl, unit: mm}
//     material: {E: 70 GPa, nu: 0.33, density: 2700 kg/m^3}
//     fixed:  {plane: {point: [0, 0, 0], normal: [-1, 0, 0]}}
//     loaded: {cylinder: {axis_point: [110, 110, 0], axis: [0, 0, 1], radius: 8},
//              point: [110, 110, 0], coupling: rigid}
//     elements: {order: 2, size: 5}
//
// With more than two interfaces, instead of `fixed` and `loaded` (all but the fixed one are
// loaded):
//
//     interfaces:
//       base: {plane: {point: [0, 0, 0], normal: [-1, 0, 0]}, coupling: distributing}
//       left: {cylinder: {axis_point: [110, 40, 0], axis: [0, 0, 1], radius: 8}}
//       right: {cylinder: {axis_point: [110, -40, 0], axis: [0, 0, 1], radius: 8}}
//     fixed: base
//
// An assembly has several bodies instead of one mesh and material, and says what is between them:
//
//     bodies:
//       base: {mesh: {file: base.stl, unit: mm}, material: steel_s235}
//       arm:  {mesh: {file: arm.stl, unit: mm}, material: aluminium_6082}
//     joints:
//       - {between: [base, arm], bonded: true}
//
// Bare lengths are in the mesh's unit, that of the first body. `density`, `point` and `elements`
// may be left out: then there is no mass, the point is the interface's centroid, and the size
// follows from volume over area.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "kinetostat/common/error.h"
#include "kinetostat/fea/elasticity/elasticity.h"
#include "kinetostat/fea/interface/coupling.h"
#include "kinetostat/fea/interface/interface_selection.h"
#include "kinetostat/fea/surface/surface_repair.h"

namespace kinetostat::fea {

struct InterfaceSpec {
  std::string name;
  Selector selector;
  std::optional<Vector3> point;  // [m] reference point; the centroid when not given
  Coupling coupling = Coupling::rigid;
  double modulus_ratio = default_modulus_ratio;  // of a `body` coupling
  ElasticLayer layer = {};                       // of an `elastic` one
  std::optional<std::size_t> body = {};          // of an assembly: the only one it is on, if stated
  common::InputError::Details origin;            // file, line and key, for messages
};

/// Two bodies that touch.
struct JointSpec {
  std::array<std::size_t, 2> bodies = {};  // their numbers
  std::optional<ElasticLayer> layer = {};  // between them; none: they are bonded
  /// [m] Between their faces at most; none: default_gap of the diagonal of the smaller body.
  std::optional<double> within = {};
  static constexpr double default_gap = 1e-3;
  common::InputError::Details origin = {};  // file, line and key, for messages
};

struct LinkSpec {
  explicit LinkSpec(const Material& of) : material(of) {}

  std::string name;
  std::filesystem::path file;                   // the link file
  std::filesystem::path mesh_file;              // where it is
  std::string mesh_name;                        // as the link file spells it
  std::string unit;                             // of the mesh; empty when no file states it
  std::string body;                             // the one of several that is meant; may be empty
  RepairOptions repair;                         // without steps: none
  common::InputError::Details mesh_origin;      // of the key `mesh`, for messages
  common::InputError::Details material_origin;  // of the key `material`
  Material material;
  std::string material_name = {};  // in the table of io/material_table.h; empty: given by values
  double young_deviation = 0;      // [Pa] one standard deviation; 0: not stated
  std::vector<InterfaceSpec> interfaces;  // two or more; the first is fixed, the others loaded
  /// Wrench [force; moment] on the loaded interface at its point [N; N m]; with one, the geometric
  /// stiffness is wanted.
  std::optional<Vector6> preload;
  int order = 2;               // of the elements, 1 or 2
  std::optional<double> size;  // [m] of the elements; else
  static constexpr double usual_accuracy = 0.01;
  double accuracy = usual_accuracy;  // of every significant entry of the result
  std::string sha256;                // of the link file
  std::string meaning;  // of the link file and the files that it names, for caches (yaml.h)

  /// Of an assembly, each a link without interfaces, in the order of the file; what is said above
  /// of mesh and material is then the first one's. Empty: the link is one body.
  std::vector<LinkSpec> bodies = {};
  std::vector<JointSpec> joints = {};
};

/// Those that elements of the link name by number: one for each body.
std::vector<Material> materials_of(const LinkSpec& spec);

/// Throws InputError with file, line and key.
LinkSpec read_link(const std::filesystem::path& file);

/// A material, "{E: 70 GPa, nu: 0.33}", and an accuracy, "5 %", as link files have them. Both throw
/// common::InputError.
Material parse_material(const std::string& text);
double parse_accuracy(const std::string& text);

}  // namespace kinetostat::fea
