#include "kinetostat/fea/solid_mesh.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include <fmt/format.h>

#include "kinetostat/fea/gmsh_program.h"
#include "kinetostat/fea/surface_cleaning.h"

namespace kinetostat::fea {
namespace {

using Cause = MeshingError::Cause;

// Of the time for the first attempt: what a surface may take that defeats TetGen.
constexpr double cleaned_share = 0.25, gmsh_share = 0.5;

// More time, memory or another program would not help where these are the cause.
bool is_about_the_surface(const MeshingError& error) {
  return error.cause() == Cause::refused || error.cause() == Cause::crashed ||
         error.cause() == Cause::timed_out;
}

std::optional<TetMesh> cleaned_and_filled(const SurfaceMesh& surface, const std::vector<int>& tags,
                                          double tolerance, TetrahedralizeOptions options,
                                          files::Progress& progress) {
  const std::optional<CleanSurface> clean = without_thin_facets(surface, tags, tolerance);
  if (!clean) return {};
  options.time_limit *= cleaned_share;
  try {
    TetMesh mesh = tetrahedralize(clean->mesh, clean->tags, options, progress);
    mesh.made_by = fmt::format("TetGen, thin facets removed within {:.2g} m", tolerance);
    return mesh;
  } catch (const MeshingError&) {
    return {};
  }
}

// Gmsh gets one size for all: the mean of what is wished for.
double one_size(const TetrahedralizeOptions& options) {
  const std::vector<double>& sizes = options.sizes.sizes;
  if (sizes.empty()) return options.edge_length;
  const double mean =
      std::accumulate(sizes.begin(), sizes.end(), 0.0) / static_cast<double>(sizes.size());
  return options.edge_length > 0 ? std::min(mean, options.edge_length) : mean;
}

// Why Gmsh's mesh is no mesh of this solid; empty when it is one.
std::string fault(const TetMesh& mesh, const SurfaceMesh& surface) {
  const double wanted = mass_properties(surface).volume, got = mass_properties(mesh).volume;
  if (!(std::abs(got - wanted) <= 1e-6 * wanted))
    return fmt::format("its mesh has {:.4g} times the volume of the surface", got / wanted);
  for (std::size_t e = 0; e < mesh.element_count(); ++e) {
    const auto p = mesh.corners(e);
    double longest = 0;
    for (const auto& [a, b] : tet_edges)
      longest = std::max(longest,
                         (p[static_cast<std::size_t>(a)] - p[static_cast<std::size_t>(b)]).norm());
    if (volume(p) < 1e-9 * longest * longest * longest) return "its mesh has flat elements";
  }
  return "";
}

}  // namespace

TetMesh fill_solid(const SurfaceMesh& surface, const std::vector<int>& tags,
                   const TetrahedralizeOptions& options, files::Progress& progress) {
  try {
    TetMesh mesh = tetrahedralize(surface, tags, options, progress);
    mesh.made_by = "TetGen";
    return mesh;
  } catch (const MeshingError& first) {
    if (!is_about_the_surface(first)) throw;
    const double diagonal = bounding_box(surface.points).diagonal().norm();
    for (const double share : {1e-6, 1e-5})
      if (auto mesh = cleaned_and_filled(surface, tags, share * diagonal, options, progress))
        return *std::move(mesh);
    std::string also = "gmsh, which might do it, is not installed";
    if (!find_gmsh().empty()) try {
        TetMesh mesh = gmsh_tetrahedra(
            surface, tags, one_size(options),
            {.time = gmsh_share * options.time_limit, .memory = options.memory_limit}, progress);
        also = fault(mesh, surface);
        if (also.empty()) {
          mesh = reordered(mesh);
          mesh.made_by = "Gmsh";
          return mesh;
        }
        also = "gmsh fails too: " + also;
      } catch (const GmshError& error) {
        also = error.what();
      }
    throw MeshingError(first.cause(), fmt::format("{}; {}", first.what(), also), first.cure(),
                       first.facets());
  }
}

}  // namespace kinetostat::fea
