// A closed surface filled with tetrahedra by TetGen, which runs in a process of its own.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "kinetostat/fea/size_field.h"
#include "kinetostat/fea/tet_mesh.h"
#include "kinetostat/files/cache.h"
#include "kinetostat/files/progress.h"

namespace kinetostat::fea {

/// Why there is no mesh: said in what(), with the facets concerned when TetGen names them.
class MeshingError : public std::runtime_error {
 public:
  enum class Cause { refused, crashed, timed_out, out_of_memory, too_many_elements, no_helper };
  MeshingError(Cause cause, const std::string& what, const std::string& cure,
               std::vector<int> facets = {});

  Cause cause() const { return cause_; }
  const std::string& cure() const { return cure_; }
  const std::vector<int>& facets() const { return facets_; }

 private:
  Cause cause_;
  std::string cure_;
  std::vector<int> facets_;
};

struct TetrahedralizeOptions {
  double edge_length = 0;  // [m] no element larger than a regular tetrahedron of it; 0: any size
  SizeField sizes = {};    // no element larger than wished for where it lies
  double radius_edge_ratio = 1.4;  // >= 1.2: of circumscribed sphere to shortest edge
  double least_dihedral = 14;      // [deg] asked for, 0 to 18; given up when it cannot be had
  double time_limit = 300;         // [s] for all attempts, > 0
  std::size_t memory_limit = std::size_t{8} << 30;  // [bytes] of the helper; 0: none
  std::size_t largest_element_count = 20'000'000;   // refused beforehand when more are expected
  std::filesystem::path helper = {};                // kinetostat-tetgen; empty: find_helper()
  const files::Cache* cache = nullptr;  // of meshes made before; none: every mesh is made anew
};

/// Fills the surface, of order 1. `surface` must be sound (surface_check.h), cavities included.
/// `tags` has one number per facet; each boundary face of the result carries the number of the
/// facets it lies on, and no face crosses from one number to another. The same input gives the same
/// mesh. Throws MeshingError.
TetMesh tetrahedralize(const SurfaceMesh& surface, const std::vector<int>& tags,
                       const TetrahedralizeOptions& options, files::Progress& progress);

}  // namespace kinetostat::fea
