// The bodies of a file that holds several.
#pragma once

#include <string>
#include <vector>

#include "kinetostat/fea/surface/surface_check.h"
#include "kinetostat/fea/surface/surface_mesh.h"

namespace kinetostat::fea {

/// A piece of the surface that stands for itself: a solid of a CAD file, by its name or else its
/// number; what goes by one name in a file of another kind; or, where names do not distinguish the
/// shells, an outermost shell with what lies within it, named "1", "2", ... in the order of the
/// file.
struct Body {
  std::string name;
  std::vector<int> facets;  // ascending
  double volume = 0;        // [m^3] of its shells, signed
  Box box;                  // [m]
};

/// At least one for a surface that has facets.
std::vector<Body> find_bodies(const SurfaceMesh& mesh, const std::vector<Shell>& shells);

/// Leaves only the facets of the body. Points stay.
void keep_body(SurfaceMesh& mesh, const Body& body);

/// "base (120 x 80 x 20 mm), cover (...)": the largest first, at most twelve; lengths in `unit`.
std::string list_bodies(std::vector<Body> bodies, const std::string& unit);

}  // namespace kinetostat::fea
