// kinetostat import: a robot that another program describes, as a robot file.
#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <memory>
#include <set>

#include <fmt/format.h>

#include "kinetostat/apps/cli/command.h"
#include "kinetostat/apps/cli/option_values.h"
#include "kinetostat/apps/commands/commands.h"
#include "kinetostat/apps/results/mesh_links.h"
#include "kinetostat/common/error.h"
#include "kinetostat/common/spelling.h"
#include "kinetostat/io/text_file.h"
#include "kinetostat/report/manipulators/imported_robot.h"
#include "kinetostat/report/screen/wording.h"
#include "kinetostat/vjm/exchange/description_file.h"
#include "kinetostat/vjm/exchange/robot_import.h"

namespace kinetostat::apps {
namespace {

namespace dimension = spatial::dimension;
using vjm::DescribedJoint;

struct ImportRequest {
  std::string file, base, tip, stiffness, wind_up, material, accuracy = "5 %";
  std::vector<std::string> packages;
  bool identify = false, no_cache = false;
};

constexpr char stiffness_option[] = "--joint-stiffness";
constexpr char effort_option[] = "--joint-stiffness-by-effort";

double stiffness_of(const DescribedJoint& drive, const std::string& text) {
  const double value =
      quantity(stiffness_option, text,
               turns(drive) ? dimension::torsional_stiffness : dimension::linear_stiffness, {});
  if (!(value > 0) || !std::isfinite(value))
    throw UsageError(stiffness_option, fmt::format("'{}' is no stiffness of {}", text, drive.name),
                     "Give a positive one, for example '5e4 N m/rad'");
  return value;
}

const DescribedJoint& drive_named(const std::vector<DescribedJoint>& drives,
                                  const std::string& name) {
  std::vector<std::string> names;
  for (const DescribedJoint& drive : drives) {
    if (drive.name == name) return drive;
    names.push_back(drive.name);
  }
  const std::string near = common::nearest_spelling(name, names);
  throw UsageError(stiffness_option, fmt::format("there is no drive '{}'", name),
                   near.empty() ? "" : fmt::format("Did you mean '{}'?", near));
}

// A drive that turns and one that slides, where there are both.
std::optional<std::pair<std::string, std::string>> both_sorts(
    const std::vector<DescribedJoint>& drives) {
  const auto is_turning = [](const DescribedJoint& drive) { return turns(drive); };
  const auto turning = std::find_if(drives.begin(), drives.end(), is_turning);
  const auto sliding = std::find_if_not(drives.begin(), drives.end(), is_turning);
  if (turning == drives.end() || sliding == drives.end()) return std::nullopt;
  return std::pair(turning->name, sliding->name);
}

// No stiffness with a unit is that of drives of both sorts.
void require_one_sort(const std::vector<DescribedJoint>& drives, const std::string& value) {
  const auto sorts = both_sorts(drives);
  if (!sorts || value.find_first_of(" Nm/") == std::string::npos) return;
  throw UsageError(
      stiffness_option,
      fmt::format("'{}' cannot be that of '{}', which turns, and of '{}', which slides", value,
                  sorts->first, sorts->second),
      fmt::format("Give '{}=5e4 N m/rad,{}=1e7 N/m', and so on for the others", sorts->first,
                  sorts->second));
}

// What one number for drives of both sorts stands for; empty where there is one sort.
std::string one_number_for_both(const std::vector<DescribedJoint>& drives,
                                const std::string& text) {
  const auto sorts = both_sorts(drives);
  if (!sorts || text.empty() || text.find_first_of("=,") != std::string::npos) return {};
  return fmt::format(
      "--joint-stiffness {} is taken as so many N m/rad for '{}', which turns, and as so many N/m "
      "for '{}', which slides, of which few are so soft. Give '{}=...,{}=...' for each its own.",
      text, sorts->first, sorts->second, sorts->first, sorts->second);
}

// One for all drives, one for each, or NAME=VALUE for some.
void read_stiffness(const std::vector<DescribedJoint>& drives, const std::string& text,
                    std::map<std::string, double>& result) {
  const std::vector<std::string> parts = split(text);
  const bool by_name = text.find('=') != std::string::npos;
  if (!by_name && parts.size() != 1 && parts.size() != drives.size())
    throw UsageError(stiffness_option,
                     fmt::format("has {} values for {} drives", parts.size(), drives.size()),
                     "Give one for all, one for each from base to tip, or NAME=VALUE");
  if (!by_name && parts.size() == 1) require_one_sort(drives, parts.front());
  for (std::size_t d = 0; !by_name && d < drives.size(); ++d)
    result[drives[d].name] = stiffness_of(drives[d], parts[parts.size() == 1 ? 0 : d]);
  std::set<std::string> named;
  for (std::size_t p = 0; by_name && p < parts.size(); ++p) {
    const std::size_t sign = parts[p].find('=');
    if (sign == std::string::npos)
      throw UsageError(stiffness_option, fmt::format("'{}' is not NAME=VALUE", parts[p]));
    const DescribedJoint& drive = drive_named(drives, parts[p].substr(0, sign));
    if (!named.insert(drive.name).second)
      throw UsageError(stiffness_option, fmt::format("'{}' is given twice", drive.name));
    result[drive.name] = stiffness_of(drive, parts[p].substr(sign + 1));
  }
}

// What similar drives yield under their largest effort: the angle of those that turn, the way of
// those that slide.
struct WindUp {
  double angle = 0, way = 0;
};

WindUp read_wind_up(const std::string& text) {
  WindUp wind_up;
  for (const std::string& part : split(text)) {
    double number = 0;
    const char* const end = part.data() + part.size();
    if (std::from_chars(part.data(), end, number).ptr == end)
      throw UsageError(effort_option, fmt::format("'{}' has no unit", part),
                       "Give '5 mrad' for drives that turn, '0.1 mm' for those that slide");
    double& value = part.ends_with('m') && !part.ends_with("rad") ? wind_up.way : wind_up.angle;
    value = quantity(effort_option, part,
                     &value == &wind_up.way ? dimension::length : dimension::angle, {});
    if (!(value > 0)) throw UsageError(effort_option, fmt::format("'{}' is not above 0", part));
  }
  return wind_up;
}

// It gives no drive a stiffness; one of them has an effort, but is of the other sort.
[[noreturn]] void refuse_effort(const std::string& text, const DescribedJoint* of_other_sort) {
  if (of_other_sort == nullptr)
    throw UsageError(effort_option, "the description gives no drive a limit of its effort",
                     fmt::format("Use {}", stiffness_option));
  const bool turning = turns(*of_other_sort);
  throw UsageError(effort_option,
                   fmt::format("'{}' says nothing of '{}', which {}", text, of_other_sort->name,
                               turning ? "turns" : "slides"),
                   turning ? "Give an angle, '5 mrad'" : "Give a length, '0.1 mm'");
}

void add_by_effort(const std::vector<DescribedJoint>& drives, const std::string& text,
                   std::map<std::string, double>& result) {
  const WindUp wind_up = read_wind_up(text);
  bool any = false;
  const DescribedJoint* of_other_sort = nullptr;
  for (const DescribedJoint& drive : drives) {
    any = any || drive.stiffness;
    if (drive.stiffness) continue;  // that is none to be guessed
    const double yields = turns(drive) ? wind_up.angle : wind_up.way;
    if (!(drive.effort.value_or(0) > 0)) continue;
    if (!(yields > 0)) of_other_sort = &drive;
    if (!(yields > 0)) continue;
    result[drive.name] = *drive.effort / yields;
    any = true;
  }
  if (!any) refuse_effort(text, of_other_sort);
}

Packages read_packages(const std::vector<std::string>& texts) {
  Packages packages;
  for (const std::string& text : texts) {
    const std::size_t sign = text.find('=');
    if (sign == std::string::npos || sign == 0 || sign + 1 == text.size())
      throw UsageError("--package", fmt::format("'{}' is not NAME=FOLDER", text),
                       "Write --package ur_description=/opt/ur_description");
    packages.emplace_back(text.substr(0, sign), text.substr(sign + 1));
    if (!std::filesystem::is_directory(packages.back().second))
      throw UsageError("--package",
                       fmt::format("there is no folder '{}'", packages.back().second.string()),
                       "Give the folder that the package is in");
  }
  return packages;
}

vjm::ImportOptions stiffnesses(const ImportRequest& request,
                               const std::vector<DescribedJoint>& drives) {
  vjm::ImportOptions options;
  if (!request.wind_up.empty()) {
    add_by_effort(drives, request.wind_up, options.stiffness);
    options.notes.push_back(fmt::format(
        "Stiffness of drives by effort: the limit of the effort over {}. Similar drives (all "
        "lengths in one ratio) of one material bear a torque as d^3 and wind up by the same angle "
        "under it. An estimate: replace it by what the data sheet says.",
        request.wind_up));
  }
  if (!request.stiffness.empty()) read_stiffness(drives, request.stiffness, options.stiffness);
  return options;
}

void check_request(const ImportRequest& request, const Run& run) {
  if (!request.identify) return;
  if (!run.out())
    throw UsageError("--identify", "the links go into a folder beside the robot file",
                     "Name that with -o robot.yaml");
  if (request.material.empty())
    throw UsageError("--identify", "a mesh does not say what it is made of",
                     "Add --material aluminium");
}

io::Json import(const ImportRequest& request, Run& run) {
  check_request(request, run);
  const Packages packages = read_packages(request.packages);
  const vjm::RobotDescription model = vjm::read_robot_description(request.file);
  const vjm::DescribedChain chain = vjm::find_chain(model, request.base, request.tip);
  vjm::ImportedRobot robot = vjm::import_robot(model, chain);
  vjm::ImportOptions options = stiffnesses(request, robot.drives);
  if (const std::string doubt = one_number_for_both(robot.drives, request.stiffness);
      !doubt.empty()) {
    run.remark(doubt);
    options.notes.push_back(doubt);
  }
  MeshLinks links;
  if (request.identify) {
    links = identify_bodies(model, robot.bodies,
                            {.packages = packages,
                             .material = link_material(request.material),
                             .accuracy = link_accuracy(request.accuracy),
                             .robot_file = *run.out(),
                             .no_cache = request.no_cache},
                            run);
    options.links = links.links;
    options.reasons = links.reasons;
  }
  robot = vjm::import_robot(model, chain, options);
  if (run.out()) {
    io::write_atomically(*run.out(), robot.text);
    const auto moving = std::count_if(chain.joints.begin(), chain.joints.end(), [&](std::size_t j) {
      return model.joints[j].type != vjm::JointType::fixed;
    });
    run.print(fmt::format("{}: '{}' to '{}', {} joints that move, written to {}\n", model.name,
                          chain.base, chain.tip, moving, run.out()->string()));
  } else {
    run.print(robot.text + "\n");
  }
  for (const std::string& words : links.words) run.print(report::wrapped(words + ".", 2, 4));
  run.print(report::text(model, robot));
  io::Json json = report::to_json(model, chain, robot);
  json["identified"] = links.words;
  return json;
}

void add_identify_options(OptionList& app, ImportRequest& request) {
  app.add_option("--package", request.packages,
                 "Where the package NAME of mesh files (package://NAME/...) is; a folder of that "
                 "name above the description is found without")
      .type_name("NAME=FOLDER")
      .hide_default()
      .one_at_a_time();
  const Option identify =
      app.add_flag("--identify", request.identify,
                   "Find the compliance of links from their shapes, held and loaded about the axes "
                   "of their joints");
  app.add_option("--material", request.material,
                 "Of links that are identified: steel, aluminium, cast-iron, or as in link files "
                 "'{E: 70 GPa, nu: 0.33, density: 2700 kg/m^3}'")
      .type_name("MATERIAL")
      .needs(identify);
  app.add_option("--accuracy", request.accuracy, "Of links that are identified, in percent")
      .type_name("PERCENT")
      .show_default()
      .needs(identify);
  app.add_flag("--no-cache", request.no_cache, "Make the volume meshes anew, and do not keep them");
}

}  // namespace

void add_import(Program& program) {
  const auto request = std::make_shared<ImportRequest>();
  OptionList app =
      program.add({.name = "import",
                   .summary = "A robot file from URDF, SDF, MJCF or a Denavit-Hartenberg table",
                   .example = "kinetostat import data/urdf/six_axis.urdf --tip flange "
                              "--joint-stiffness 5e4 -o arm.yaml",
                   .out = "Write the robot file (YAML)"},
                  [request](Run& run) { return import(*request, run); });
  app.add_option("FILE", request->file,
                 "URDF (expanded, no xacro), SDF, MJCF, or a table of Denavit and Hartenberg's "
                 "parameters (YAML, CSV)")
      .required();
  app.add_option("--base", request->base, "Link that does not move (default: the root)")
      .type_name("LINK");
  app.add_option("--tip", request->tip,
                 "Link that carries the tool (default: the only one without children, or tool0)")
      .type_name("LINK");
  app.add_option(
         stiffness_option, request->stiffness,
         "Stiffness of the drives, one for all, one for each from base to tip or NAME=VALUE "
         "for some, separated by commas: '5e4 N m/rad' (default: as the description has "
         "it, else to be added by hand)")
      .type_name("STIFFNESS");
  app.add_option(effort_option, request->wind_up,
                 "Stiffness of the other drives from the limit of their effort: what they yield "
                 "under it, '5 mrad', and of those that slide '0.1 mm'")
      .type_name("YIELD");
  add_identify_options(app, *request);
}

}  // namespace kinetostat::apps
