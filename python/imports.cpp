// Robots that other programs describe.
#include <algorithm>
#include <map>
#include <optional>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>
#include <variant>

#include <fmt/format.h>

#include "kinetostat/apps/cli/command.h"
#include "kinetostat/apps/results/mesh_links.h"
#include "kinetostat/python/bindings.h"
#include "kinetostat/python/robot_questions.h"
#include "kinetostat/spatial/units.h"
#include "kinetostat/vjm/exchange/description_file.h"
#include "kinetostat/vjm/exchange/robot_import.h"

namespace kinetostat::python {
namespace {

namespace py = pybind11;
using Joints = std::map<std::string, double>;
using Path = std::filesystem::path;
using GivenNumber = std::variant<double, std::string>;  // "5e4 N m/rad"
using GivenStiffness = std::variant<std::monostate, GivenNumber, std::vector<GivenNumber>,
                                    std::map<std::string, GivenNumber>>;

[[noreturn]] void fail_stiffness(const std::string& what) {
  throw py::value_error("joint_stiffness " + what);
}

double in_si(const vjm::DescribedJoint& drive, const GivenNumber& given) {
  double value = 0;
  if (const auto* text = std::get_if<std::string>(&given)) try {
      value = spatial::parse_quantity(*text,
                                      turns(drive) ? spatial::dimension::torsional_stiffness
                                                   : spatial::dimension::linear_stiffness,
                                      turns(drive) ? "N m/rad" : "N/m");
    } catch (const std::invalid_argument& error) {
      fail_stiffness(fmt::format("of {}: {}", drive.name, error.what()));
    }
  else
    value = std::get<double>(given);
  if (!(value > 0)) fail_stiffness(fmt::format("of {} is not positive: {}", drive.name, value));
  return value;
}

// By the names of drives, each one's own.
Joints stiffness_by_name(const std::vector<vjm::DescribedJoint>& drives,
                         const GivenStiffness& given) {
  Joints result;
  if (const auto* each = std::get_if<std::map<std::string, GivenNumber>>(&given)) {
    for (const auto& [name, k] : *each) {
      const auto drive = std::find_if(drives.begin(), drives.end(),
                                      [&name = name](const auto& d) { return d.name == name; });
      if (drive == drives.end()) fail_stiffness(fmt::format("names '{}', which is no drive", name));
      result[name] = in_si(*drive, k);
    }
  } else if (const auto* one = std::get_if<GivenNumber>(&given)) {
    for (const vjm::DescribedJoint& drive : drives) {
      if (vjm::turns(drive) != vjm::turns(drives.front()))
        fail_stiffness("is one for drives that turn and drives that slide: give a dict by name");
      result[drive.name] = in_si(drive, *one);
    }
  } else if (const auto* all = std::get_if<std::vector<GivenNumber>>(&given)) {
    if (all->size() != drives.size())
      fail_stiffness(
          fmt::format("has {} values for {} drives: give one for all, one for each from base to "
                      "tip, or a dict by name",
                      all->size(), drives.size()));
    for (std::size_t d = 0; d < drives.size(); ++d)
      result[drives[d].name] = in_si(drives[d], (*all)[d]);
  }
  return result;
}

// How links are found from their shapes.
struct GivenMeshes {
  std::map<std::string, Path> packages;
  bool identify = false;
  std::string material, accuracy;
  std::optional<Path> out;
  bool cache = true;
};

apps::MeshLinkRequest request_of(const GivenMeshes& given) {
  if (!given.out)
    throw py::value_error(
        "identify: the links go into a folder beside the robot file, name that by "
        "out='robot.yaml'");
  if (given.material.empty())
    throw py::value_error("identify: a mesh does not say what it is made of, add material='steel'");
  apps::MeshLinkRequest request{.packages = {},
                                .material = apps::link_material(given.material),
                                .accuracy = apps::link_accuracy(given.accuracy),
                                .robot_file = *given.out,
                                .no_cache = !given.cache};
  for (const auto& [name, folder] : given.packages) {
    if (!std::filesystem::is_directory(folder))
      throw py::value_error(
          fmt::format("packages: there is no folder '{}' of {}", folder.string(), name));
    request.packages.emplace_back(name, folder);
  }
  return request;
}

apps::MeshLinks identified(const vjm::RobotDescription& model,
                           const std::vector<vjm::ImportedBody>& bodies, const GivenMeshes& given,
                           int threads, const py::object& progress) {
  apps::MeshLinks links;
  if (!given.identify) {
    if (!given.material.empty()) throw py::value_error("material is of links that are identified");
    return links;
  }
  const apps::MeshLinkRequest request = request_of(given);
  run_command(threads, progress,
              [&](apps::Run& run) { links = apps::identify_bodies(model, bodies, request, run); });
  std::vector<std::string> unknown;
  for (const auto& [name, reason] : links.reasons)
    unknown.push_back(fmt::format("link {} was not identified: {}", name, reason));
  warn_of(unknown);
  return links;
}

void require_stiffness(const std::vector<vjm::DescribedJoint>& drives, const Joints& stiffness,
                       const Path& file) {
  for (const vjm::DescribedJoint& drive : drives)
    if (!drive.stiffness && !stiffness.contains(drive.name))
      throw py::value_error(
          fmt::format("joint_stiffness says nothing of drive '{}', of which {} has no spring",
                      drive.name, file.string()));
}

RobotValue from_urdf(const Path& file, const GivenStiffness& stiffness, const std::string& base,
                     const std::string& tip, const GivenMeshes& meshes, int threads,
                     const py::object& progress) {
  const vjm::RobotDescription model = vjm::read_robot_description(file);
  const vjm::DescribedChain chain = vjm::find_chain(model, base, tip);
  const vjm::ImportedRobot bare = vjm::import_robot(model, chain);
  vjm::ImportOptions options;
  options.stiffness = stiffness_by_name(bare.drives, stiffness);
  require_stiffness(bare.drives, options.stiffness, file);
  apps::MeshLinks links = identified(model, bare.bodies, meshes, threads, progress);
  options.links = std::move(links.links);
  options.reasons = std::move(links.reasons);
  const std::string text = vjm::import_robot(model, chain, options).text;
  if (meshes.out) return write_robot(*meshes.out, text, {});
  return {vjm::parse_robot(text, file), text};
}

}  // namespace

void add_import(py::class_<RobotValue>& robot) {
  robot.def_static(
      "from_urdf",
      [](const Path& file, const GivenStiffness& stiffness, const std::string& base,
         const std::string& tip, const std::map<std::string, Path>& packages, bool identify,
         const std::string& material, const std::string& accuracy, const std::optional<Path>& out,
         bool cache, int threads, const py::object& progress) {
        return from_urdf(file, stiffness, base, tip,
                         {packages, identify, material, accuracy, out, cache}, threads, progress);
      },
      py::arg("file"), py::arg("joint_stiffness") = GivenStiffness(), py::arg("base") = "",
      py::arg("tip") = "", py::kw_only(), py::arg("packages") = std::map<std::string, Path>(),
      py::arg("identify") = false, py::arg("material") = "", py::arg("accuracy") = "5 %",
      py::arg("out") = py::none(), py::arg("cache") = true, py::arg("threads") = 0,
      py::arg("progress") = py::none(),
      "A robot from URDF, SDF, MJCF or a Denavit-Hartenberg table, written to `out` where that is "
      "given. `joint_stiffness` [N m/rad, N/m] is one for all drives, one for each or by name. "
      "With "
      "`identify` and a `material` the compliance of links is found from their meshes, which stand "
      "in `packages`, {'NAME': FOLDER}; they go into a folder beside `out`.");
}

}  // namespace kinetostat::python
