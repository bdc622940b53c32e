// The helper program kinetostat-cgal: operations on surfaces by CGAL.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "kinetostat/common/progress.h"
#include "kinetostat/fea/surface/surface_mesh.h"

namespace kinetostat::fea {

struct CgalCall {
  std::string operation;                            // of cgal_protocol.h
  std::vector<double> numbers = {};                 // of the operation
  std::vector<int> markers = {};                    // of the facets, where the operation takes them
  double time_limit = 120;                          // [s] > 0
  std::size_t memory_limit = std::size_t{6} << 30;  // [bytes]
  std::filesystem::path helper = {};                // kinetostat-cgal; empty: find_helper()
};

struct CgalResult {
  std::string fault = {};      // why there is no surface; empty when there is one
  bool out_of_memory = false;  // that is why
  SurfaceMesh mesh = {};       // identical corners are one; without groups
  std::vector<int> markers = {};
  std::vector<std::int64_t> counts = {};
};

/// Throws only Cancelled, and common::OutOfMemory when there is none for another process.
CgalResult ask_cgal(const SurfaceMesh& surface, const CgalCall& call, const std::string& phase,
                    common::Progress& progress);

}  // namespace kinetostat::fea
