// Links of an imported robot from the meshes that its description names.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "kinetostat/apps/cli/command.h"
#include "kinetostat/vjm/exchange/robot_import.h"

namespace kinetostat::apps {

/// Where packages are that meshes are named in (package://NAME/...).
using Packages = std::vector<std::pair<std::string, std::filesystem::path>>;

/// The file of a mesh, or of the folder of the package that is named above the description. Empty
/// where no package of the name is known.
std::filesystem::path mesh_file(const std::string& name, const std::filesystem::path& description,
                                const Packages& packages);

/// "steel", "aluminium" and "cast-iron" as link files have them, "{E: 70 GPa, nu: 0.33}"; others of
/// that form as they are. Throws UsageError for --material.
std::string link_material(const std::string& text);
/// "5 %" as it is; a plain number is in percent. Throws UsageError for --accuracy.
std::string link_accuracy(const std::string& text);

struct MeshLinkRequest {
  Packages packages;
  std::string material;              // as link files have it
  std::string accuracy;              // "5 %"
  std::filesystem::path robot_file;  // of the import; the links go beside it
  bool no_cache = false;
};

struct MeshLinks {
  std::map<std::string, std::string> links, reasons;  // as ImportOptions has them
  std::vector<std::string> words;                     // what was found, a sentence for each body
};

/// For every body of the robot: its mesh in the frame behind the joint before it (STL), a link file
/// that holds it about the axis of that joint and loads it about that of the next, or near the tip,
/// and what identify makes of that, in the folder STEM_links beside the robot file. A body whose
/// meshes cannot be found, bound no solid or have nothing near a joint gets the reason instead.
MeshLinks identify_bodies(const vjm::RobotDescription& robot,
                          const std::vector<vjm::ImportedBody>& bodies,
                          const MeshLinkRequest& request, Run& run);

}  // namespace kinetostat::apps
