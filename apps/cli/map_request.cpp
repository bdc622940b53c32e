#include "kinetostat/apps/cli/map_request.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "kinetostat/apps/cli/command.h"
#include "kinetostat/apps/cli/option_values.h"
#include "kinetostat/apps/cli/pose_list.h"
#include "kinetostat/common/spelling.h"
#include "kinetostat/io/text_file.h"
#include "kinetostat/report/manipulators/manipulator.h"
#include "kinetostat/report/manipulators/pose.h"
#include "kinetostat/vjm/vibration/natural_modes.h"

namespace kinetostat::apps {
namespace {

using report::NamedIndex;
using vjm::MapIndex;

enum class Argument { none, direction, length };

struct IndexWord {
  const char* word;
  MapIndex::Kind kind;
  Argument argument;
};

constexpr IndexWord index_words[] = {
    {"stiffness", MapIndex::Kind::stiffness, Argument::direction},
    {"rotational-stiffness", MapIndex::Kind::rotational, Argument::direction},
    {"weakest-translation", MapIndex::Kind::weakest_translation, Argument::none},
    {"weakest-rotation", MapIndex::Kind::weakest_rotation, Argument::none},
    {"weakest", MapIndex::Kind::weakest, Argument::length},
    {"condition", MapIndex::Kind::condition, Argument::length},
    {"deflection", MapIndex::Kind::deflection, Argument::none},
    {"rotation", MapIndex::Kind::rotation, Argument::none},
    {"first-frequency", MapIndex::Kind::first_frequency, Argument::none},
    {"critical-force", MapIndex::Kind::critical_force, Argument::direction},
};

const IndexWord& find_word(const std::string& word) {
  std::vector<std::string> known;
  for (const IndexWord& candidate : index_words) {
    if (word == candidate.word) return candidate;
    known.emplace_back(candidate.word);
  }
  const std::string near = common::nearest_spelling(word, known);
  throw UsageError("--index", fmt::format("there is no index '{}'", word),
                   near.empty() ? fmt::format("Known are {}", fmt::join(known, ", "))
                                : fmt::format("Did you mean '{}'?", near));
}

// The unit in which values of a dimension are written.
std::string unit_of(const spatial::Dimension& dimension, const spatial::UnitSystem& units) {
  namespace d = spatial::dimension;
  if (dimension == d::linear_stiffness) return fmt::format("{}/{}", units.force, units.length);
  if (dimension == d::torsional_stiffness)
    return fmt::format("{} {}/rad", units.force, units.length);
  if (dimension == d::length) return units.length;
  if (dimension == d::angle) return units.angle;
  if (dimension == d::force) return units.force;
  if (dimension == spatial::Dimension{.time = -1}) return "Hz";
  return "";
}

// What an index takes after its '=': nothing, a direction or a length.
spatial::Vector3 read_direction(const IndexWord& word, const std::string& text,
                                const std::string& argument, const spatial::UnitSystem& units) {
  if (argument.empty())
    throw UsageError("--index", fmt::format("'{}' needs a direction", word.word),
                     fmt::format("Write {}=1,0,0, base axes", word.word));
  const spatial::Vector3 direction =
      three_values("--index", argument, spatial::dimension::none, units);
  if (direction.isZero(0)) throw UsageError("--index", fmt::format("'{}' has no length", text));
  return direction.normalized();
}

void read_argument(const IndexWord& word, const std::string& text, const std::string& argument,
                   const spatial::UnitSystem& units, MapIndex& index) {
  if (word.argument == Argument::direction)
    index.direction = read_direction(word, text, argument, units);
  if (word.argument == Argument::length) {
    if (argument.empty())
      throw UsageError(
          "--index", fmt::format("'{}' needs a length", word.word),
          fmt::format("Write {}=100, the length that rotations are multiplied by", word.word));
    index.length = quantity("--index", argument, spatial::dimension::length, units);
    if (!(index.length > 0) || std::isinf(index.length))
      throw UsageError("--index", fmt::format("the length in '{}' is not above zero", text));
  }
}

// "stiffness=1,0,0", "weakest=100", "deflection". In names, commas are blanks.
NamedIndex read_index(const std::string& text, const spatial::UnitSystem& units) {
  const std::size_t equals = text.find('=');
  const IndexWord& word = find_word(text.substr(0, equals));
  if (word.argument == Argument::none && equals != std::string::npos)
    throw UsageError("--index", fmt::format("'{}' takes no value", word.word));
  NamedIndex named{.name = text, .index = {.kind = word.kind}, .unit = {}};
  std::replace(named.name.begin(), named.name.end(), ',', ' ');
  read_argument(word, text, equals == std::string::npos ? "" : text.substr(equals + 1), units,
                named.index);
  named.unit = unit_of(dimension_of(word.kind), units);
  if (!named.unit.empty()) named.factor = spatial::parse_unit(named.unit).factor;
  return named;
}

// How far critical forces are sought [N].
double read_up_to(const std::string& text, const spatial::UnitSystem& units,
                  const vjm::PoseList& list) {
  if (text.empty())
    throw UsageError("--up-to", "a critical force is sought up to a force that you state",
                     "Give --up-to 5000, the largest that matters");
  const double force = quantity("--up-to", text, spatial::dimension::force, units);
  if (!(force > 0) || std::isinf(force))
    throw UsageError("--up-to", fmt::format("'{}' is not a force above zero", text));
  if (list.has_wrench)
    throw UsageError("--index", "a critical force grows from nothing, not from a wrench",
                     "Leave the wrench away; weight and --node-load act beside the growing force");
  return force;
}

bool is_loaded(const vjm::Robot& robot, const vjm::PoseList& list) {
  return !robot.manipulator.is_relaxed_when_unloaded() || list.has_wrench ||
         (!list.poses.empty() && !list.poses.front().load.nodes.empty());
}

}  // namespace

void MapRequest::add_options(OptionList& app) {
  app.add_option("ROBOT", robot_file, "Robot file (YAML)").required();
  app.add_option(
         "--grid", grid,
         "Poses x=FROM:TO:POINTS,y=...,z=...,rx=...; one value, z=10, keeps a coordinate; or "
         "drives of a robot of one chain, q2=-60:60:13,q3=90")
      .type_name("GRID");
  app.add_option("--path", path,
                 "Poses from a CSV file with columns x,y,z,rx,ry,rz, or drives, and loads "
                 "fx,fy,fz,mx,my,mz")
      .type_name("FILE");
  app.add_option("--index", indices,
                 "stiffness=DX,DY,DZ, rotational-stiffness=DX,DY,DZ, weakest-translation, "
                 "weakest-rotation, weakest=LENGTH, condition=LENGTH, deflection, rotation, "
                 "first-frequency, critical-force=DX,DY,DZ; may be repeated")
      .type_name("INDEX")
      .required()
      .one_at_a_time();
  load.add_load_options(app);
  app.add_option("--up-to", up_to, "Seek critical forces up to this force").type_name("FORCE");
}

vjm::PoseList MapRequest::read_poses(const vjm::Robot& robot, const io::Part& part) const {
  const vjm::Load acting = load.load(robot);
  if (grid.empty() == path.empty())
    throw UsageError("--grid",
                     grid.empty() ? "neither a grid nor a path is given"
                                  : "a grid and a path exclude each other",
                     "Give --grid x=-50:50:11,y=0,z=0 or --path FILE.csv");
  return grid.empty() ? read_path(path, robot, acting, part)
                      : read_grid(grid, robot, acting, "--grid", part);
}

std::vector<NamedIndex> MapRequest::read_indices(const vjm::Robot& robot,
                                                 const vjm::PoseList& list) const {
  std::vector<NamedIndex> named;
  for (const std::string& text : indices) named.push_back(read_index(text, robot.units));
  for (NamedIndex& index : named)
    if (index.index.kind == MapIndex::Kind::critical_force)
      index.index.up_to = read_up_to(up_to, robot.units, list);
  const bool loaded = is_loaded(robot, list);
  for (const NamedIndex& index : named) {
    if (index.index.kind == MapIndex::Kind::first_frequency &&
        !(vjm::mass_of(robot.manipulator) > 0))
      throw UsageError("--index",
                       fmt::format("'{}' needs masses, and this robot has none", index.name),
                       "Give its links a 'density' or a 'mass' in the robot file");
    if (!loaded && (index.index.kind == MapIndex::Kind::deflection ||
                    index.index.kind == MapIndex::Kind::rotation))
      throw UsageError("--index",
                       fmt::format("'{}' is zero: there is no load and no weight", index.name),
                       "Give --wrench Fx,Fy,Fz[,Mx,My,Mz], or loads in the path file");
  }
  return named;
}

}  // namespace kinetostat::apps
