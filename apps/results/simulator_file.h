// A robot as a file for simulators, as `export` writes it.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "kinetostat/apps/cli/robot_request.h"
#include "kinetostat/io/json.h"

namespace kinetostat::apps {

/// The options of `export`.
struct ExportRequest {
  PostureRequest robot;
  std::string format;  // one of simulator_formats(); empty: by the extension of the file
  double damping = 0;  // ratio to critical damping of the dampers beside the springs
  std::optional<std::filesystem::path> file = {};  // its extension; nothing is written
};

/// "mjcf", "urdf", "sdf", "modelica", "matlab".
const std::vector<std::string>& simulator_formats();

struct SimulatorFile {
  std::string format;
  vjm::Robot robot;
  vjm::Posture posture = {};
  std::string text = {};
  std::vector<std::string> lost = {};  // what the format cannot hold, in words
  std::string headline = {};           // "six_axis for MuJoCo (MJCF)"
};

/// Throws UsageError where nothing says the format, and common::InputError for a robot that the
/// format cannot hold.
SimulatorFile simulator_file(const ExportRequest& request, Run& run);
/// As `export --json` has it.
io::Json to_json(const SimulatorFile& file);

}  // namespace kinetostat::apps
