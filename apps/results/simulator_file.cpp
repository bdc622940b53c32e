#include "kinetostat/apps/results/simulator_file.h"

#include <stdexcept>
#include <tuple>
#include <utility>

#include <fmt/format.h>

#include "kinetostat/apps/cli/command.h"
#include "kinetostat/common/error.h"
#include "kinetostat/report/manipulators/manipulator.h"
#include "kinetostat/vjm/exchange/matlab_export.h"
#include "kinetostat/vjm/exchange/tree_export.h"

namespace kinetostat::apps {
namespace {

// A format of serial robots, as trees of bodies.
struct TreeFormat {
  const char* name;       // of --format
  const char* extension;  // of the file
  const char* words;
  std::string (*write)(const vjm::BodyTree& tree);
  std::vector<std::string> (*lost)(const vjm::BodyTree& tree);
};
constexpr TreeFormat tree_formats[] = {
    {"mjcf", ".xml", "for MuJoCo (MJCF)", vjm::mjcf, vjm::lost_in_mjcf},
    {"urdf", ".urdf", "as URDF", vjm::urdf, vjm::lost_in_urdf},
    {"sdf", ".sdf", "for Gazebo (SDF)", vjm::sdf, vjm::lost_in_sdf},
    {"modelica", ".mo", "in Modelica", vjm::modelica, vjm::lost_in_modelica},
};
constexpr char matlab_name[] = "matlab";

// By --format, else by the extension of the file; MJCF where neither says.
std::string format_of(const ExportRequest& request) {
  if (!request.format.empty()) return request.format;
  if (!request.file) return "mjcf";
  const std::string extension = request.file->extension().string();
  if (extension == ".m") return matlab_name;
  for (const TreeFormat& format : tree_formats)
    if (extension == format.extension) return format.name;
  throw UsageError("--out", fmt::format("'{}' does not say the format", extension),
                   "End it with .xml (MJCF), .urdf, .sdf, .mo or .m, or add --format");
}

// Text of a file, and what it lacks.
using Content = std::pair<std::string, std::vector<std::string>>;

Content tree_as(const TreeFormat& format, const vjm::Robot& robot, const vjm::Posture& posture,
                double damping) try {
  const vjm::BodyTree tree = vjm::body_tree(robot, posture, {.damping_ratio = damping});
  return {format.write(tree), format.lost(tree)};
} catch (const std::invalid_argument& error) {
  throw common::InputError(robot.file, error.what(),
                           "Take a serial robot, as data/robots/six_axis.yaml, or MATLAB's "
                           "format (.m), which has any robot");
}

Content content_as(const std::string& format, const vjm::Robot& robot, const vjm::Posture& posture,
                   double damping) {
  for (const TreeFormat& tree : tree_formats)
    if (format == tree.name) return tree_as(tree, robot, posture, damping);
  return {vjm::matlab(robot, posture, damping), vjm::lost_in_matlab(robot, damping)};
}

std::string words_of(const std::string& format) {
  for (const TreeFormat& tree : tree_formats)
    if (format == tree.name) return tree.words;
  return "for MATLAB and GNU Octave";
}

}  // namespace

const std::vector<std::string>& simulator_formats() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> all;
    for (const TreeFormat& format : tree_formats) all.emplace_back(format.name);
    all.emplace_back(matlab_name);
    return all;
  }();
  return names;
}

SimulatorFile simulator_file(const ExportRequest& request, Run& run) {
  SimulatorFile file{.format = format_of(request), .robot = request.robot.read()};
  file.posture = request.robot.posture(file.robot);
  warn_beyond_ranges(file.robot, file.posture, run);
  std::tie(file.text, file.lost) =
      content_as(file.format, file.robot, file.posture, request.damping);
  file.headline = fmt::format("{} {}", file.robot.name, words_of(file.format));
  return file;
}

io::Json to_json(const SimulatorFile& file) {
  io::Json json = report::inputs_and_posture(file.robot, file.posture);
  json.update({{"format", file.format}, {"text", file.text}, {"lost", file.lost}});
  return json;
}

}  // namespace kinetostat::apps
