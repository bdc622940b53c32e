// kinetostat map: indices of stiffness over a grid or along a path.
#include <algorithm>
#include <cmath>
#include <memory>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "kinetostat/apps/cli/command.h"
#include "kinetostat/apps/cli/option_values.h"
#include "kinetostat/apps/cli/pose_list.h"
#include "kinetostat/apps/commands/commands.h"
#include "kinetostat/common/error.h"
#include "kinetostat/common/spelling.h"
#include "kinetostat/io/text_file.h"
#include "kinetostat/io/vtu.h"
#include "kinetostat/report/manipulator.h"
#include "kinetostat/report/text.h"
#include "kinetostat/spatial/rotation.h"

namespace kinetostat::apps {
namespace {

using vjm::MapIndex;
using vjm::MapPoint;
using vjm::MapState;

struct MapRequest {
  std::string robot_file, grid, path, up_to, vtu, checkpoint;
  std::vector<std::string> indices;
  LoadRequest load;
};

// An index as it was asked for, with the unit in which it is written.
struct NamedIndex {
  std::string name;  // as written, commas as blanks
  MapIndex index;
  std::string unit;  // empty for a plain number
  double factor = 1;
};

struct IndexWord {
  const char* word;
  MapIndex::Kind kind;
  enum class Argument { none, direction, length } argument;
};

constexpr IndexWord index_words[] = {
    {"stiffness", MapIndex::Kind::stiffness, IndexWord::Argument::direction},
    {"rotational-stiffness", MapIndex::Kind::rotational, IndexWord::Argument::direction},
    {"weakest-translation", MapIndex::Kind::weakest_translation, IndexWord::Argument::none},
    {"weakest-rotation", MapIndex::Kind::weakest_rotation, IndexWord::Argument::none},
    {"weakest", MapIndex::Kind::weakest, IndexWord::Argument::length},
    {"condition", MapIndex::Kind::condition, IndexWord::Argument::length},
    {"deflection", MapIndex::Kind::deflection, IndexWord::Argument::none},
    {"rotation", MapIndex::Kind::rotation, IndexWord::Argument::none},
    {"critical-force", MapIndex::Kind::critical_force, IndexWord::Argument::direction},
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
  return "";
}

// "stiffness=1,0,0", "weakest=100", "deflection".
NamedIndex read_index(const std::string& text, const spatial::UnitSystem& units) {
  using Argument = IndexWord::Argument;
  const std::size_t equals = text.find('=');
  const IndexWord& word = find_word(text.substr(0, equals));
  const std::string argument = equals == std::string::npos ? "" : text.substr(equals + 1);
  NamedIndex named{.name = text, .index = {.kind = word.kind}, .unit = {}};
  std::replace(named.name.begin(), named.name.end(), ',', ' ');
  if (word.argument == Argument::none && equals != std::string::npos)
    throw UsageError("--index", fmt::format("'{}' takes no value", word.word));
  if (word.argument == Argument::direction && argument.empty())
    throw UsageError("--index", fmt::format("'{}' needs a direction", word.word),
                     fmt::format("Write {}=1,0,0, base axes", word.word));
  if (word.argument == Argument::length && argument.empty())
    throw UsageError(
        "--index", fmt::format("'{}' needs a length", word.word),
        fmt::format("Write {}=100, the length that rotations are multiplied by", word.word));
  if (word.argument == Argument::direction) {
    const spatial::Vector3 direction =
        three_values("--index", argument, spatial::dimension::none, units);
    if (direction.isZero(0)) throw UsageError("--index", fmt::format("'{}' has no length", text));
    named.index.direction = direction.normalized();
  }
  if (word.argument == Argument::length) {
    named.index.length = quantity("--index", argument, spatial::dimension::length, units);
    if (!(named.index.length > 0) || std::isinf(named.index.length))
      throw UsageError("--index", fmt::format("the length in '{}' is not above zero", text));
  }
  named.unit = unit_of(dimension_of(word.kind), units);
  if (!named.unit.empty()) named.factor = spatial::parse_unit(named.unit).factor;
  return named;
}

bool has_wrench(const vjm::TargetPose& pose) {
  return !pose.load.force.isZero(0) || !pose.load.moment.isZero(0);
}

// How far critical forces are sought [N].
double read_up_to(const MapRequest& request, const spatial::UnitSystem& units,
                  const PoseList& list) {
  if (request.up_to.empty())
    throw UsageError("--up-to", "a critical force is sought up to a force that you state",
                     "Give --up-to 5000, the largest that matters");
  const double force = quantity("--up-to", request.up_to, spatial::dimension::force, units);
  if (!(force > 0) || std::isinf(force))
    throw UsageError("--up-to", fmt::format("'{}' is not a force above zero", request.up_to));
  if (std::any_of(list.poses.begin(), list.poses.end(), has_wrench))
    throw UsageError("--index", "a critical force grows from nothing, not from a wrench",
                     "Leave the wrench away; weight and --node-load act beside the growing force");
  return force;
}

std::vector<NamedIndex> read_indices(const MapRequest& request, const vjm::Robot& robot,
                                     const PoseList& list, bool loaded) {
  std::vector<NamedIndex> indices;
  for (const std::string& text : request.indices) indices.push_back(read_index(text, robot.units));
  for (NamedIndex& index : indices)
    if (index.index.kind == MapIndex::Kind::critical_force)
      index.index.up_to = read_up_to(request, robot.units, list);
  for (const NamedIndex& index : indices)
    if (!loaded && (index.index.kind == MapIndex::Kind::deflection ||
                    index.index.kind == MapIndex::Kind::rotation))
      throw UsageError("--index",
                       fmt::format("'{}' is zero: there is no load and no weight", index.name),
                       "Give --wrench Fx,Fy,Fz[,Mx,My,Mz], or loads in the path file");
  return indices;
}

PoseList read_poses(const MapRequest& request, const vjm::Robot& robot) {
  const vjm::Load load = request.load.load(robot);
  if (request.grid.empty() == request.path.empty())
    throw UsageError("--grid",
                     request.grid.empty() ? "neither a grid nor a path is given"
                                          : "a grid and a path exclude each other",
                     "Give --grid x=-50:50:11,y=0,z=0 or --path FILE.csv");
  return request.grid.empty() ? read_path(request.path, robot, load)
                              : read_grid(request.grid, robot, load);
}

bool is_loaded(const vjm::Robot& robot, const PoseList& list) {
  if (!robot.manipulator.is_relaxed_when_unloaded()) return true;
  return std::any_of(list.poses.begin(), list.poses.end(), [](const vjm::TargetPose& pose) {
    return has_wrench(pose) || !pose.load.nodes.empty();
  });
}

spatial::Vector6 coordinates_of(const spatial::Pose& pose) {
  spatial::Vector6 c;
  c << pose.position(), spatial::log_rotation(pose.rotation());
  return c;
}

// Everything that determines the values of the map.
std::string request_hash(const vjm::Robot& robot, const PoseList& list,
                         const std::vector<NamedIndex>& indices) {
  fmt::memory_buffer text;
  const auto out = std::back_inserter(text);
  fmt::format_to(out, "{}\n", report::provenance(robot).dump());
  for (const NamedIndex& index : indices)
    fmt::format_to(out, "{} {}\n", index.name, index.index.up_to);
  for (const vjm::TargetPose& pose : list.poses) {
    for (const double c : coordinates_of(pose.platform)) fmt::format_to(out, "{} ", c);
    for (const double c : pose.load.at_reference_point(spatial::Pose()))
      fmt::format_to(out, "{} ", c);
    for (const double c : pose.load.point_on_platform) fmt::format_to(out, "{} ", c);
    for (const vjm::NodeLoad& node : pose.load.nodes)
      fmt::format_to(out, "{} {} {} {} {} {} {} {} ", node.chain, node.node, node.force.x(),
                     node.force.y(), node.force.z(), node.moment.x(), node.moment.y(),
                     node.moment.z());
    fmt::format_to(out, "\n");
  }
  return io::sha256(fmt::to_string(text));
}

// A number as it is written in tables: 12 significant digits, nothing where there is none.
std::string cell(double value) { return std::isnan(value) ? "" : fmt::format("{:.12g}", value); }

std::string heading(const std::string& name, const std::string& unit) {
  return io::csv_cell(unit.empty() ? name : fmt::format("{} [{}]", name, unit));
}

std::string table_text(const vjm::Robot& robot, const PoseList& list,
                       const std::vector<NamedIndex>& indices,
                       const std::vector<MapPoint>& points) {
  const double length = spatial::parse_unit(robot.units.length).factor;
  const double angle = spatial::parse_unit(robot.units.angle).factor;
  fmt::memory_buffer text;
  const auto out = std::back_inserter(text);
  std::vector<std::string> headings;
  for (const std::string& name : pose_columns)
    headings.push_back(heading(name, name.size() == 1 ? robot.units.length : robot.units.angle));
  headings.emplace_back("state");
  for (const NamedIndex& index : indices) headings.push_back(heading(index.name, index.unit));
  fmt::format_to(out, "{}\n", fmt::join(headings, ","));
  for (std::size_t i = 0; i < points.size(); ++i) {
    const spatial::Vector6 c = coordinates_of(list.poses[i].platform);
    for (Eigen::Index k = 0; k < 6; ++k)
      fmt::format_to(out, "{},", cell(c[k] / (k < 3 ? length : angle)));
    fmt::format_to(out, "{}", to_string(points[i].state));
    for (std::size_t k = 0; k < indices.size(); ++k)
      fmt::format_to(out, ",{}", cell(points[i].values[k] / indices[k].factor));
    fmt::format_to(out, "\n");
  }
  return fmt::to_string(text);
}

// Cells between the neighbours of a grid of positions; a polyline along a path; else points alone.
void add_cells(const PoseList& list, io::VtuGrid& grid) {
  const auto& shape = list.shape;
  std::vector<int> step;  // between neighbours, along each axis that varies
  std::vector<std::size_t> size;
  const bool turns = shape[3] * shape[4] * shape[5] > 1;
  for (std::size_t i = 0; i < 3; ++i) {
    if (shape[i] == 1) continue;
    int distance = 1;
    for (std::size_t k = 5; k > i; --k) distance *= static_cast<int>(shape[k]);
    step.push_back(distance);
    size.push_back(shape[i] - 1);
  }
  constexpr io::VtuCell kinds[] = {io::VtuCell::vertex, io::VtuCell::line, io::VtuCell::quad,
                                   io::VtuCell::hexahedron};
  // VTK's order of corners: around the first face, then around the opposite one.
  constexpr int corners[8][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0},
                                 {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
  if (turns) {
    step.clear();
    size.assign(1, list.poses.size());
  }
  const std::size_t directions = step.size();
  grid.cell = kinds[directions];
  grid.nodes_per_cell = 1 << directions;
  size.resize(3, 1);
  const int along = turns ? 1 : 0;
  step.resize(3, 0);
  for (std::size_t c = 0; c < size[2]; ++c)
    for (std::size_t b = 0; b < size[1]; ++b)
      for (std::size_t a = 0; a < size[0]; ++a) {
        const int first = static_cast<int>(a) * (step[0] + along) + static_cast<int>(b) * step[1] +
                          static_cast<int>(c) * step[2];
        for (int k = 0; k < grid.nodes_per_cell; ++k)
          grid.connectivity.push_back(first + corners[k][0] * step[0] + corners[k][1] * step[1] +
                                      corners[k][2] * step[2]);
      }
}

void write_vtu(const std::string& file, const PoseList& list,
               const std::vector<NamedIndex>& indices, const std::vector<MapPoint>& points) {
  io::VtuGrid grid;
  io::VtuField state{.name = "state"};
  for (std::size_t i = 0; i < points.size(); ++i) {
    for (const double x : list.poses[i].platform.position()) grid.points.push_back(x);
    state.values.push_back(static_cast<double>(points[i].state));
  }
  grid.point_fields.push_back(std::move(state));
  for (std::size_t k = 0; k < indices.size(); ++k) {
    const std::string& unit = indices[k].unit;
    io::VtuField field{.name = unit.empty() ? indices[k].name
                                            : fmt::format("{} [{}]", indices[k].name, unit)};
    for (const MapPoint& point : points)
      field.values.push_back(point.values[k] / indices[k].factor);
    grid.point_fields.push_back(std::move(field));
  }
  add_cells(list, grid);
  io::write_vtu(file, grid);
}

std::string place_text(const vjm::Robot& robot, const spatial::Pose& pose) {
  const double length = spatial::parse_unit(robot.units.length).factor;
  const double angle = spatial::parse_unit(robot.units.angle).factor;
  const spatial::Vector6 c = coordinates_of(pose);
  std::string text = fmt::format("{}, {}, {}", report::number(c[0] / length),
                                 report::number(c[1] / length), report::number(c[2] / length));
  if (!c.tail<3>().isZero(1e-12))
    text += fmt::format(", {}, {}, {}", report::number(c[3] / angle), report::number(c[4] / angle),
                        report::number(c[5] / angle));
  return text;
}

io::Json pose_json(const spatial::Pose& pose) {
  return {{"position", io::to_json(pose.position())},
          {"rotation_vector", io::to_json(spatial::log_rotation(pose.rotation()))}};
}

io::Json states_json(const std::vector<MapPoint>& points) {
  io::Json json = io::Json::object();
  for (const MapState state : {MapState::reached, MapState::free_motion, MapState::unstable,
                               MapState::no_equilibrium, MapState::unreachable})
    json[to_string(state)] = std::count_if(points.begin(), points.end(),
                                           [state](const MapPoint& p) { return p.state == state; });
  return json;
}

// Counts of states and the range of every index, for people and for programs.
io::Json summary(const vjm::Robot& robot, const PoseList& list,
                 const std::vector<NamedIndex>& indices, const std::vector<MapPoint>& points,
                 Run& run) {
  io::Json json{{"inputs", report::provenance(robot)},
                {"poses", points.size()},
                {"states", states_json(points)},
                {"indices", io::Json::array()}};
  run.print(fmt::format("{}: {} poses", robot.name, points.size()));
  for (const auto& [state, count] : json["states"].items())
    if (count != 0) run.print(fmt::format(", {} {}", count.get<std::size_t>(), state));
  run.print("\n\n");
  report::Table table(
      {"index", "unit", "smallest", "smallest at", "mean", "largest", "largest at"});
  for (std::size_t k = 0; k < indices.size(); ++k) {
    const vjm::MapRange range = range_of(points, k);
    io::Json entry{{"index", indices[k].name}, {"finite_values", range.count}};
    std::vector<std::string> row{indices[k].name, indices[k].unit, "-", "-", "-", "-", "-"};
    if (range.count > 0) {
      const auto shown = [&](double v) { return report::number(v / indices[k].factor, 6); };
      const spatial::Pose& low = list.poses[range.smallest_at].platform;
      const spatial::Pose& high = list.poses[range.largest_at].platform;
      row = {indices[k].name,        indices[k].unit,   shown(range.smallest),
             place_text(robot, low), shown(range.mean), shown(range.largest),
             place_text(robot, high)};
      entry["smallest"] = range.smallest;
      entry["smallest_at"] = pose_json(low);
      entry["mean"] = range.mean;
      entry["largest"] = range.largest;
      entry["largest_at"] = pose_json(high);
    }
    table.add_row(row);
    json["indices"].push_back(entry);
  }
  run.print(table.text());
  return json;
}

io::Json picture(const vjm::Robot& robot, const PoseList& list,
                 const std::vector<NamedIndex>& indices, const std::vector<MapPoint>& points) {
  io::Json poses = io::Json::array(), states = io::Json::array(), values = io::Json::array();
  const double length = spatial::parse_unit(robot.units.length).factor;
  for (std::size_t i = 0; i < points.size(); ++i) {
    poses.push_back(io::to_json(spatial::Vector3(list.poses[i].platform.position() / length)));
    states.push_back(to_string(points[i].state));
  }
  for (std::size_t k = 0; k < indices.size(); ++k) {
    io::Json list_of_values = io::Json::array();
    for (const MapPoint& point : points)
      list_of_values.push_back(point.values[k] / indices[k].factor);
    values.push_back({{"name", indices[k].name},
                      {"unit", indices[k].unit},
                      {"values", std::move(list_of_values)}});
  }
  return {{"map",
           {{"shape", list.shape},
            {"length", robot.units.length},
            {"positions", std::move(poses)},
            {"states", std::move(states)},
            {"indices", std::move(values)}}}};
}

// With the beams in two and in four times the segments.
std::vector<vjm::Manipulator> finer_models(const vjm::Robot& robot) {
  std::vector<vjm::Manipulator> finer;
  if (!robot.has_beams) return finer;
  for (const int multiple : {2, 4})
    finer.push_back(vjm::read_robot(robot.file, {.segment_multiple = multiple}).manipulator);
  return finer;
}

io::Json map(const MapRequest& request, Run& run) {
  const vjm::Robot robot = vjm::read_robot(request.robot_file);
  const PoseList list = read_poses(request, robot);
  const std::vector<NamedIndex> named = read_indices(request, robot, list, is_loaded(robot, list));
  std::vector<MapIndex> indices;
  for (const NamedIndex& index : named) indices.push_back(index.index);
  vjm::MapCheckpoint checkpoint{.file = request.checkpoint, .request = {}};
  if (request.checkpoint.empty() && run.out()) checkpoint.file = run.out()->string() + ".part";
  const bool saves = !checkpoint.file.empty();
  if (saves) {
    io::require_writable(checkpoint.file);  // before hours are spent
    checkpoint.request = request_hash(robot, list, named);
  }
  const std::vector<MapPoint> points =
      workspace_map(robot.manipulator, list.poses, indices, run.threads(), run.progress(),
                    saves ? &checkpoint : nullptr, finer_models(robot));
  if (run.out()) io::write_atomically(*run.out(), table_text(robot, list, named, points));
  if (!request.vtu.empty()) write_vtu(request.vtu, list, named, points);
  if (run.wants_page()) run.draw(picture(robot, list, named, points));
  return summary(robot, list, named, points, run);
}

}  // namespace

void add_map(Program& program) {
  const auto request = std::make_shared<MapRequest>();
  OptionList app = program.add(
      {.name = "map",
       .summary = "Indices of stiffness over a grid of poses or along a path",
       .example = "kinetostat map data/robots/orthoglide.yaml --grid x=-60:60:5,y=-60:60:5,z=0 "
                  "--index weakest-translation --index stiffness=1,1,1",
       .out = "Write one row a pose (CSV); FILE.part lets an interrupted map go on"},
      [request](Run& run) { return map(*request, run); });
  app.add_option("ROBOT", request->robot_file, "Robot file (YAML)").required();
  app.add_option("--grid", request->grid,
                 "Poses x=FROM:TO:POINTS,y=...,z=...,rx=...; one value, z=10, keeps a coordinate");
  app.add_option("--path", request->path,
                 "Poses from a CSV file with columns x,y,z,rx,ry,rz and loads fx,fy,fz,mx,my,mz");
  app.add_option("--index", request->indices,
                 "stiffness=DX,DY,DZ, rotational-stiffness=DX,DY,DZ, weakest-translation, "
                 "weakest-rotation, weakest=LENGTH, condition=LENGTH, deflection, rotation, "
                 "critical-force=DX,DY,DZ; may be repeated")
      .required()
      .one_at_a_time();
  request->load.add_load_options(app);
  app.add_option("--up-to", request->up_to, "Seek critical forces up to this force")
      .type_name("FORCE");
  app.add_output("--vtu", request->vtu, "Write the map for ParaView");
  app.add_option("--checkpoint", request->checkpoint,
                 "Where an interrupted map goes on from, when not beside --out")
      .type_name("FILE");
}

}  // namespace kinetostat::apps
