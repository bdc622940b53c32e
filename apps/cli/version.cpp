#include "kinetostat/apps/cli/version.h"

#include <dlfcn.h>
#include <filesystem>
#include <suitesparse/cholmod.h>
#include <tinyxml2.h>
#include <zlib.h>

#include <CLI/Version.hpp>
#include <Eigen/Core>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "kinetostat/common/build_id.h"
#include "kinetostat/io/text_file.h"
#include "kinetostat/report/page.h"

namespace kinetostat::apps {
namespace {

struct Part {
  std::string name, version, licence;
};

std::string dotted(int major, int minor, int patch) {
  return fmt::format("{}.{}.{}", major, minor, patch);
}

// Which library answers for BLAS is decided when the program is loaded, so it is asked, not
// assumed.
Part blas() {
  const auto config =
      reinterpret_cast<const char* (*)()>(::dlsym(RTLD_DEFAULT, "openblas_get_config"));
  const auto parallel = reinterpret_cast<int (*)()>(::dlsym(RTLD_DEFAULT, "openblas_get_parallel"));
  if (config == nullptr || parallel == nullptr)
    return {"BLAS", "unknown", "not OpenBLAS: may be slow"};
  const char* const flavours[] = {"without threads", "pthread", "OpenMP: slow here, use pthread"};
  const std::string words = config();  // "OpenBLAS 0.3.21 NO_LAPACKE ..."
  const std::size_t begin = words.find(' ') + 1;
  return {fmt::format("OpenBLAS ({})", flavours[parallel() % 3]),
          words.substr(begin, words.find(' ', begin) - begin), "BSD-3-Clause"};
}

std::vector<Part> linked_parts() {
  return {
      {"Eigen", dotted(EIGEN_WORLD_VERSION, EIGEN_MAJOR_VERSION, EIGEN_MINOR_VERSION), "MPL-2.0"},
      {"CHOLMOD", dotted(CHOLMOD_MAIN_VERSION, CHOLMOD_SUB_VERSION, CHOLMOD_SUBSUB_VERSION),
       "LGPL-2.1+, its supernodal module GPL-2+"},
      blas(),
      {"assimp", KINETOSTAT_ASSIMP_VERSION, "BSD-3-Clause"},
      {"yaml-cpp", KINETOSTAT_YAML_CPP_VERSION, "MIT"},
      {"nlohmann-json",
       dotted(NLOHMANN_JSON_VERSION_MAJOR, NLOHMANN_JSON_VERSION_MINOR,
              NLOHMANN_JSON_VERSION_PATCH),
       "MIT"},
      {"fmt", dotted(FMT_VERSION / 10000, FMT_VERSION / 100 % 100, FMT_VERSION % 100), "MIT"},
      {"CLI11", CLI11_VERSION, "BSD-3-Clause"},
      {"TinyXML-2", dotted(TIXML2_MAJOR_VERSION, TIXML2_MINOR_VERSION, TIXML2_PATCH_VERSION),
       "Zlib"},
      {"zlib", zlibVersion(), "Zlib"},
      {"cpp-httplib", KINETOSTAT_HTTPLIB_VERSION, "MIT"},
      {"jemalloc", KINETOSTAT_JEMALLOC_VERSION, "BSD-2-Clause"},
      {"libmd", "", "BSD-3-Clause and others"},
  };
}

}  // namespace

std::string version() { return KINETOSTAT_VERSION; }

std::string version_report() {
  std::string text = fmt::format(
      "kinetostat {}: this program is under GPL-3.0, its source code under Apache-2.0\n\nLinked:\n",
      version());
  for (const Part& part : linked_parts())
    text += fmt::format("  {:<24} {:<8} {}\n", part.name, part.version, part.licence);
  text += "\nIn processes of their own:\n";
  for (const Part& part :
       {Part{"TetGen", "1.5", "AGPL-3.0+"}, Part{"CGAL", KINETOSTAT_CGAL_VERSION, "GPL-3.0+"},
        Part{"Open CASCADE", KINETOSTAT_OCCT_VERSION, "LGPL-2.1 with an exception"},
        Part{"PETSc", KINETOSTAT_PETSC_VERSION, "BSD-2-Clause"}})
    text += fmt::format("  {:<24} {:<8} {}\n", part.name, part.version, part.licence);
  text += fmt::format("\nIn pages (--html):\n  {:<24} {:<8} {}\n", "Plotly",
                      report::has_pages() ? KINETOSTAT_PLOTLY_VERSION : "not built", "MIT");
  return text +
         "\nThe program as a whole is under GPL-3.0 because it is linked with the supernodal "
         "module "
         "of CHOLMOD.\n";
}

// Of a library that another program has loaded, such as Python, that library.
std::string this_program() {
  static const char here = 0;
  if (std::string id = common::build_id(); !id.empty()) return id;
  Dl_info found = {};
  const bool known = ::dladdr(&here, &found) != 0 && found.dli_fname != nullptr;
  const std::filesystem::path file = known ? found.dli_fname : "";
  return io::sha256(io::read_text(file.extension() == ".so" ? file : "/proc/self/exe"));
}

}  // namespace kinetostat::apps
