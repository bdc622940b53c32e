#include "kinetostat/fea/mesh/gmsh_program.h"

#include <algorithm>
#include <cstdlib>
#include <sstream>

#include <fmt/format.h>

#include "kinetostat/common/error.h"
#include "kinetostat/fea/mesh/volume_mesh.h"

namespace kinetostat::fea {
namespace {

constexpr const char* input = "/proc/self/fd/0";
constexpr const char* second_input = "/proc/self/fd/4";
constexpr const char* output = "/proc/self/fd/3";

// The first error of its words that says something, without its own decoration.
std::string complaint(const std::string& words) {
  std::istringstream lines(words);
  for (std::string line; std::getline(lines, line);)
    if (const std::size_t colon = line.find(':');
        line.starts_with("Error") && colon != std::string::npos &&
        line.find_first_not_of(" -", colon + 1) != std::string::npos)
      return line.substr(colon + 2, 200);
  return "no reason given";
}

// A folder that nobody else may look into, gone with all that is in it at the end of its scope.
class PrivateFolder {
 public:
  PrivateFolder() {
    std::error_code error;
    std::string name = std::filesystem::temp_directory_path(error) / "kinetostat-XXXXXX";
    if (error || mkdtemp(name.data()) == nullptr)
      throw GmshError("no temporary folder can be made for it (see TMPDIR)");
    path_ = name;
  }
  ~PrivateFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  PrivateFolder(const PrivateFolder&) = delete;
  PrivateFolder& operator=(const PrivateFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

// As the home of gmsh; Python, which gmsh may be installed in, still finds what belongs to the
// user.
std::vector<std::string> at_home_in(const PrivateFolder& folder) {
  std::vector<std::string> environment{"HOME=" + folder.path().string()};
  const char* const home = std::getenv("HOME");
  if (home != nullptr && std::getenv("PYTHONUSERBASE") == nullptr)
    environment.push_back(fmt::format("PYTHONUSERBASE={}/.local", home));
  return environment;
}

std::string run_gmsh(std::vector<std::string> arguments, std::string script, std::string mesh,
                     const PrivateFolder& folder, const GmshLimits& limits,
                     common::Progress& progress) {
  const std::filesystem::path gmsh = find_gmsh();
  if (gmsh.empty()) throw GmshError("the program gmsh is not installed");
  // One thread, so that the same input gives the same mesh.
  arguments.insert(arguments.end(), {"-o", output, "-nt", "1", "-v", "2"});
  const common::ChildResult result = common::run_child({.program = gmsh,
                                                        .arguments = std::move(arguments),
                                                        .input = std::move(script),
                                                        .time_limit = limits.time,
                                                        .second_input = std::move(mesh),
                                                        .memory_limit = limits.memory,
                                                        .folder = folder.path(),
                                                        .environment = at_home_in(folder)},
                                                       "gmsh", progress);
  if (result.end == common::ChildResult::End::timed_out)
    throw GmshError(fmt::format("gmsh was stopped after {:.0f} s", limits.time));
  if (result.ran_out_of_memory()) throw GmshError("gmsh needs more memory than there is", true);
  if (result.end == common::ChildResult::End::killed_by_signal) throw GmshError("gmsh crashed");
  if (result.code != 0 || result.answer.empty())
    throw GmshError(fmt::format("gmsh failed: {}", complaint(result.words)));
  return result.answer;
}

// Format 2.2; the facets of a tag are a surface, numbered from 1.
std::string msh_of(const SurfaceMesh& surface, const std::vector<int>& tags) {
  std::string text = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n";
  text += fmt::format("$Nodes\n{}\n", surface.points.size());
  for (std::size_t i = 0; i < surface.points.size(); ++i) {
    const Vector3& p = surface.points[i];
    text += fmt::format("{} {:.17g} {:.17g} {:.17g}\n", i + 1, p.x(), p.y(), p.z());
  }
  text += fmt::format("$EndNodes\n$Elements\n{}\n", surface.triangles.size());
  for (std::size_t f = 0; f < surface.triangles.size(); ++f) {
    const Triangle& t = surface.triangles[f];
    text += fmt::format("{} 2 2 {} {} {} {} {}\n", f + 1, tags[f] + 1, tags[f] + 1, t[0] + 1,
                        t[1] + 1, t[2] + 1);
  }
  return text + "$EndElements\n";
}

// One volume within all surfaces.
std::string script_for(const std::vector<int>& tags) {
  const int last = tags.empty() ? 0 : *std::max_element(tags.begin(), tags.end());
  std::string list;
  for (int tag = 0; tag <= last; ++tag)
    if (std::find(tags.begin(), tags.end(), tag) != tags.end())
      list += fmt::format("{}{}", list.empty() ? "" : ",", tag + 1);
  return fmt::format(
      "Merge \"{}\";\nSurface Loop(1) = {{{}}};\nVolume(1) = {{1}};\nPhysical Volume(1) = {{1}};\n",
      second_input, list);
}

}  // namespace

std::filesystem::path find_gmsh() { return common::find_program("gmsh"); }

TetMesh gmsh_tetrahedra(const SurfaceMesh& surface, const std::vector<int>& tags,
                        double edge_length, const GmshLimits& limits, common::Progress& progress) {
  const PrivateFolder folder;
  std::vector<std::string> arguments{input, "-3", "-format", "msh22"};
  if (edge_length > 0)
    arguments.insert(arguments.end(), {"-clmax", fmt::format("{:.17g}", edge_length)});
  const std::string bytes = run_gmsh(std::move(arguments), script_for(tags), msh_of(surface, tags),
                                     folder, limits, progress);
  try {
    return tagged_volume(parse_msh("the mesh of gmsh", bytes));
  } catch (const common::InputError& error) {
    throw GmshError(fmt::format("its mesh is of no use: {}", error.what()));
  }
}

}  // namespace kinetostat::fea
