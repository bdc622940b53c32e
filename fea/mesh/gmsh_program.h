// The program gmsh, when it is installed: surfaces that TetGen cannot fill may be filled.
#pragma once

#include <cstddef>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

#include "kinetostat/common/child_process.h"
#include "kinetostat/common/progress.h"
#include "kinetostat/fea/mesh/tet_mesh.h"
#include "kinetostat/fea/surface/surface_mesh.h"

namespace kinetostat::fea {

/// The program on PATH; empty when it is not installed.
std::filesystem::path find_gmsh();

/// Why gmsh did not do it.
class GmshError : public std::runtime_error {
 public:
  explicit GmshError(const std::string& what, bool out_of_memory = false)
      : std::runtime_error(what), out_of_memory_(out_of_memory) {}
  bool out_of_memory() const { return out_of_memory_; }

 private:
  bool out_of_memory_;
};

struct GmshLimits {
  double time = 300;                          // [s]
  std::size_t memory = std::size_t{8} << 30;  // [bytes]
};

/// gmsh obeys what lies in the home folder (.gmshrc, .gmsh-options), which may start programs. So
/// it works alone in a folder that is thrown away, and takes that for its home.
///
/// Fills a closed surface with tetrahedra of edges of about `edge_length` [m], 0: any. Facets stay
/// as they are. Each boundary face carries the tag of the facet that it is. Throws GmshError.
TetMesh gmsh_tetrahedra(const SurfaceMesh& surface, const std::vector<int>& tags,
                        double edge_length, const GmshLimits& limits, common::Progress& progress);

}  // namespace kinetostat::fea
