// A closed surface filled with tetrahedra by TetGen, which runs in a process of its own.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "kinetostat/common/progress.h"
#include "kinetostat/fea/mesh/size_field.h"
#include "kinetostat/fea/mesh/tet_mesh.h"
#include "kinetostat/io/cache.h"

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

/// Demands on the shape of the elements. Sharp corners of the part can make an angle impossible,
/// and TetGen then may never end; and good elements are no larger than a wall is thick.
enum class ElementShape {
  good,   // radius_edge_ratio and least_dihedral
  fair,   // radius_edge_ratio
  rough,  // a ratio of 2
  kept,   // rough, and the facets, divided to the wished size, stay as they are
  any,    // nothing: only the facets are divided to the wished size
};

struct TetrahedralizeOptions {
  double edge_length = 0;  // [m] no element larger than a regular tetrahedron of it; 0: any size
  SizeField sizes = {};    // no element larger than wished for where it lies
  double radius_edge_ratio = 1.4;  // >= 1.2: of circumscribed sphere to shortest edge
  double least_dihedral = 14;      // [deg] asked for, 0 to 18; given up when it cannot be had
  std::vector<ElementShape> shapes = {ElementShape::good, ElementShape::fair, ElementShape::rough};
  double time_limit = 300;  // [s] for all attempts together, > 0; each but the last has half of the
                            // time that is left
  bool name_facets = true;  // of a failure, by crossing_facets(), within the limit
  std::size_t memory_limit = std::size_t{8} << 30;  // [bytes] of the helper; 0: none
  std::size_t largest_element_count = 20'000'000;   // refused beforehand when more are expected
  std::size_t most_elements = 0;  // of a solid (solid_mesh.h): with more it counts as not meshed
  std::filesystem::path helper = {};    // kinetostat-tetgen; empty: find_helper()
  std::filesystem::path remesher = {};  // kinetostat-cgal; empty: find_helper()
  const io::Cache* cache = nullptr;     // of meshes made before; none: every mesh is made anew
};

/// Fills the surface, of order 1, with the first of the shapes that TetGen manages. `surface` must
/// be sound (surface_check.h), cavities included. `tags` has one number per facet; each boundary
/// face of the result carries the number of the facets it lies on, and no face crosses from one
/// number to another. The same input gives the same mesh. Elements that are flat are removed
/// (flat_elements.h), or there is no mesh. Throws MeshingError.
TetMesh tetrahedralize(const SurfaceMesh& surface, const std::vector<int>& tags,
                       const TetrahedralizeOptions& options, common::Progress& progress);

/// The facets that cross others according to TetGen, whose search names them where its meshing just
/// crashes; searches for up to `time` [s]. Empty when it finds none.
std::vector<int> crossing_facets(const SurfaceMesh& surface, const std::vector<int>& tags,
                                 const TetrahedralizeOptions& options, double time,
                                 common::Progress& progress);

}  // namespace kinetostat::fea
