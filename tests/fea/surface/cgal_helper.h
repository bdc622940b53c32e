// The helper program that repairs surfaces, where it was built.
#pragma once

#include <filesystem>

namespace kinetostat::fea {

/// A path that names nothing where it was not.
inline std::filesystem::path cgal_helper() {
#ifdef KINETOSTAT_CGAL
  return KINETOSTAT_CGAL;
#else
  return "/nonexistent";
#endif
}

}  // namespace kinetostat::fea
