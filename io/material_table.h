// Common materials by name, for every file that has a material.
#pragma once

#include <string>
#include <vector>

namespace kinetostat::io {

/// Isotropic, at room temperature.
struct NamedMaterial {
  std::string name;      // "steel_s235"
  std::string words;     // "structural steel S235 (1.0038)"
  double young = 0;      // [Pa]
  double deviation = 0;  // of it from piece to piece, one standard deviation [Pa]
  double poisson = 0;    // [1]
  double density = 0;    // [kg/m^3]
  std::string source;    // of the values
  std::string spread;    // where the deviation comes from
};

/// All, steels first. A range of E in a standard counts as a rectangle, whose deviation is its
/// width over the root of twelve.
const std::vector<NamedMaterial>& named_materials();

/// Their names, in the same order.
std::vector<std::string> material_names();

/// Throws std::out_of_range for a name that is not there.
const NamedMaterial& named_material(const std::string& name);

}  // namespace kinetostat::io
