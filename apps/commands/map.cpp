// kinetostat map: indices of stiffness over a grid or along a path.
#include "kinetostat/report/manipulators/map.h"

#include <functional>
#include <memory>
#include <utility>

#include <fmt/format.h>

#include "kinetostat/apps/cli/command.h"
#include "kinetostat/apps/cli/map_request.h"
#include "kinetostat/apps/cli/option_values.h"
#include "kinetostat/apps/cli/pose_list.h"
#include "kinetostat/apps/cli/version.h"
#include "kinetostat/apps/commands/commands.h"
#include "kinetostat/apps/commands/link_models.h"
#include "kinetostat/apps/commands/path_freedom.h"
#include "kinetostat/io/table_parts.h"
#include "kinetostat/io/text_file.h"
#include "kinetostat/report/manipulators/manipulator.h"
#include "kinetostat/report/manipulators/path_choice.h"
#include "kinetostat/report/manipulators/uncertainty.h"
#include "kinetostat/report/screen/uncertainty.h"
#include "kinetostat/report/screen/wording.h"

namespace kinetostat::apps {
namespace {

struct GridRequest {
  MapRequest map;
  UncertaintyRequest uncertainty;
  FreedomRequest free;
  std::string vtu, checkpoint, part;
  std::vector<std::string> links;
};

// The poses of the path with what is free chosen for the first index, and its values as given.
struct Chosen {
  vjm::PathChoice path;
  std::vector<vjm::MapPoint> given;
  std::vector<std::string> joints;
  spatial::Pose place;
  vjm::JointStep step;
};

Chosen choose(const GridRequest& request, const vjm::Robot& robot, const report::NamedIndex& index,
              vjm::PoseList& list, Run& run) {
  if (request.map.path.empty())
    throw UsageError(request.free.given(), "what is chosen is chosen along a path",
                     "Give --path FILE");
  if (!list.poses.empty() && list.poses.front().is_by_joints)
    throw UsageError("--path", "joints that are all given leave nothing to choose",
                     "Give the path as poses, x, y, z, rx, ry, rz");
  const vjm::PathFreedom freedom = request.free.read(robot, list.poses);
  Chosen chosen;
  chosen.given =
      workspace_map(robot.manipulator, list.poses, {index.index}, run.threads(), run.progress());
  chosen.path =
      best_path(robot.manipulator, list.poses, index.index, freedom, run.threads(), run.progress());
  for (const vjm::FreeJoint& joint : freedom.joints) chosen.joints.push_back(joint.name);
  chosen.place = freedom.placements[chosen.path.placement];
  list.poses = chosen.path.poses;
  if (!chosen.joints.empty()) chosen.step = largest_turn(robot.manipulator, list.poses);
  return chosen;
}

// With the beams in two and in four times the segments.
std::vector<vjm::Manipulator> finer_models(const vjm::Robot& robot) {
  std::vector<vjm::Manipulator> finer;
  if (!robot.has_beams) return finer;
  for (const int multiple : {2, 4})
    finer.push_back(vjm::read_robot(robot.file, {.segment_multiple = multiple}).manipulator);
  return finer;
}

std::vector<vjm::MapIndex> plain(const std::vector<report::NamedIndex>& named) {
  std::vector<vjm::MapIndex> indices;
  indices.reserve(named.size());
  for (const report::NamedIndex& index : named) indices.push_back(index.index);
  return indices;
}

// All that decides what is in a map, but for some options.
std::string meaning_of(const GridRequest& request, const vjm::Robot& robot,
                       const std::vector<std::string>& but_for, const Run& run) {
  io::Json options = run.options();
  for (const std::string& other : but_for) options.erase(other);
  std::string meaning = this_program() + report::provenance(robot).dump() + options.dump();
  if (!request.map.path.empty()) meaning += io::sha256(io::read_text(request.map.path));
  return meaning;
}

std::vector<vjm::MapPoint> map_points(const GridRequest& request, const vjm::Robot& robot,
                                      const vjm::PoseList& list,
                                      const std::vector<report::NamedIndex>& named, Run& run) {
  const std::vector<vjm::MapIndex> indices = plain(named);
  vjm::MapCheckpoint checkpoint{.file = request.checkpoint, .request = {}};
  if (request.checkpoint.empty() && run.out()) checkpoint.file = run.out()->string() + ".part";
  const bool saves = !checkpoint.file.empty();
  if (saves) {
    io::require_writable(checkpoint.file);  // before hours are spent
    checkpoint.request = io::sha256(meaning_of(
        request, robot, {"checkpoint", "vtu", "links", "draws", "seed", "no-uncertainty"}, run));
  }
  return workspace_map(robot.manipulator, list.poses, indices, run.threads(), run.progress(),
                       saves ? &checkpoint : nullptr, finer_models(robot));
}

// The mean of the first index over the poses with each model of the links; the points of each model
// are a column more.
void compare_maps(const GridRequest& request, const vjm::PoseList& list,
                  std::vector<report::NamedIndex>& indices, std::vector<vjm::MapPoint>& points,
                  io::Json& json, Run& run) {
  const report::NamedIndex first = indices.front();
  const ScratchFolder folder;
  const LinkModels models(request.map.robot_file, request.links, folder.path(), run);
  const auto mapped = [&](const vjm::Robot& robot) {
    return workspace_map(robot.manipulator, list.poses, {first.index}, run.threads(),
                         run.progress(), nullptr, {});
  };
  const auto rows =
      models.compare([&](const vjm::Robot& robot) { return range_of(mapped(robot), 0).mean; });
  for (std::size_t m = 0; m < rows.size(); ++m) {
    const std::vector<vjm::MapPoint> column = mapped(models.robot(m));
    for (std::size_t i = 0; i < points.size(); ++i)
      points[i].values.push_back(column[i].values.front());
    indices.push_back(first);
    indices.back().name = fmt::format("{} ({})", first.name, rows[m].model);
  }
  const report::LinkModelFigure figure{"mean " + first.name, first.unit, first.factor};
  json = report::to_json(figure, rows);
  run.print(report::text(figure, rows) + "\n");
}

// All values of a map, index by index, as numbers whose uncertainties are wanted.
Eigen::VectorXd values_of(const vjm::Robot& robot, const vjm::PoseList& list,
                          const std::vector<vjm::MapIndex>& indices) {
  common::Progress silent;
  const auto points = workspace_map(robot.manipulator, list.poses, indices, 1, silent);
  Eigen::MatrixXd values(points.size(), indices.size());
  for (std::size_t i = 0; i < points.size(); ++i)
    values.row(static_cast<Eigen::Index>(i)) = Eigen::Map<const Eigen::RowVectorXd>(
        points[i].values.data(), static_cast<Eigen::Index>(indices.size()));
  return values.reshaped();
}

// A further column of each index.
void add_columns(const std::string& what, const std::function<double(Eigen::Index)>& number,
                 std::vector<report::NamedIndex>& indices, std::size_t count,
                 std::vector<vjm::MapPoint>& points) {
  for (std::size_t k = 0; k < count; ++k) {
    indices.push_back(indices[k]);
    indices.back().name = what + " of " + indices[k].name;
    for (std::size_t i = 0; i < points.size(); ++i)
      points[i].values.push_back(number(static_cast<Eigen::Index>(k * points.size() + i)));
  }
}

// Beside every value its expanded uncertainty, and the interval that holds 95 % of the draws.
void add_uncertainties(const GridRequest& request, const vjm::Robot& robot,
                       const vjm::PoseList& list, std::vector<report::NamedIndex>& indices,
                       std::vector<vjm::MapPoint>& points, io::Json& json, Run& run) {
  const std::vector<vjm::MapIndex> wanted = plain(indices);
  const auto uncertainty = request.uncertainty.of(
      robot, [&](const vjm::Robot& other) { return std::optional(values_of(other, list, wanted)); },
      run);
  if (!uncertainty) return;
  const auto add = [&](const std::string& what, const std::function<double(Eigen::Index)>& number) {
    add_columns(what, number, indices, wanted.size(), points);
  };
  add("uncertainty", [&](Eigen::Index i) { return uncertainty->first_order.expanded(i); });
  if (uncertainty->draws)
    for (const auto& [what, p] : {std::pair("2.5 %", 0.025), std::pair("97.5 %", 0.975)})
      add(what, [&, p = p](Eigen::Index i) { return uncertainty->draws->quantile(i, p); });
  const auto poses = static_cast<Eigen::Index>(points.size());
  json = report::settings_json(*uncertainty);
  for (std::size_t k = 0; k < wanted.size(); ++k)
    json["budgets"].push_back(
        {{"index", indices[k].name},
         {"budget",
          report::mean_budget_json(*uncertainty, static_cast<Eigen::Index>(k) * poses, poses)}});
  if (const std::string known = report::range_sentence(*uncertainty, 0, poses); !known.empty())
    run.print(report::wrapped(report::capitalised(indices[0].name) + ". " + known) + "\n");
}

// Beside every pose what the first index was as given, and what was chosen.
io::Json add_choice(const Chosen& chosen, const vjm::Robot& robot,
                    std::vector<report::NamedIndex>& indices, std::vector<vjm::MapPoint>& points,
                    Run& run) {
  const report::NamedIndex first = indices.front();
  const auto add = [&](report::NamedIndex column, const std::function<double(std::size_t)>& of) {
    indices.push_back(std::move(column));
    for (std::size_t i = 0; i < points.size(); ++i) points[i].values.push_back(of(i));
  };
  const auto add_values = [&](const std::string& name, const std::string& unit,
                              const std::vector<double>& values) {
    add({.name = name, .index = {}, .unit = unit, .factor = spatial::parse_unit(unit).factor},
        [&](std::size_t i) { return values[i]; });
  };
  report::NamedIndex given = first;
  given.name += " as given";
  add(std::move(given), [&](std::size_t i) { return chosen.given[i].values.front(); });
  if (!chosen.path.turns.empty()) add_values("turn", robot.units.angle, chosen.path.turns);
  for (std::size_t j = 0; j < chosen.joints.size(); ++j)
    add_values(report::joint_column(robot, chosen.joints[j]),
               report::joint_unit(robot, chosen.joints[j]), chosen.path.joints[j]);
  const report::PathChoiceText said{robot,         first,        chosen.given, chosen.path,
                                    chosen.joints, chosen.place, chosen.step};
  run.print(report::wrapped(report::sentence(said)) + "\n");
  return report::to_json(said);
}

// The poses, of a part where one is asked for.
vjm::PoseList read_poses(const GridRequest& request, const vjm::Robot& robot, const Run& run) {
  const io::Part part = part_of("--part", request.part);
  if (!part.is_whole() && !run.out())
    throw UsageError("--out", "a part goes into a file, for join", "Give -o FILE");
  vjm::PoseList list = request.map.read_poses(robot, part);
  remark_on(list, run);
  if (list.poses.empty() && list.whole > 0)
    throw UsageError("--part", fmt::format("there are only {} poses", list.whole),
                     "Divide them into fewer parts");
  return list;
}

// The rows of a part with their numbers in the whole map.
std::string table_of_part(const vjm::PoseList& list, const std::string& meaning,
                          std::string_view csv) {
  const auto next = [&] {
    const std::string_view line = csv.substr(0, csv.find('\n') + 1);
    csv.remove_prefix(line.size());
    return line;
  };
  std::string table = io::title_of_table("map", meaning, list.whole, "poses");
  table += fmt::format("pose,{}", next());
  for (const std::size_t number : list.numbers) {
    table += std::to_string(number);
    table += ',';
    table += next();
  }
  return table;
}

void write_map(const GridRequest& request, const report::Map& result, const Run& run) {
  if (!run.out()) return;
  std::string csv = report::csv(result);
  if (!result.list.numbers.empty())
    csv = table_of_part(result.list, meaning_of(request, result.robot, {"part", "checkpoint"}, run),
                        csv);
  io::write_atomically(*run.out(), csv);
}

io::Json map(const GridRequest& request, Run& run) {
  const vjm::Robot robot = vjm::read_robot(request.map.robot_file);
  vjm::PoseList list = read_poses(request, robot, run);
  std::vector<report::NamedIndex> indices = request.map.read_indices(robot, list);
  std::optional<Chosen> chosen;
  if (request.free.is_asked_for()) chosen = choose(request, robot, indices.front(), list, run);
  std::vector<vjm::MapPoint> points = map_points(request, robot, list, indices, run);
  io::Json link_models, uncertainty;
  add_uncertainties(request, robot, list, indices, points, uncertainty, run);
  if (!request.links.empty()) compare_maps(request, list, indices, points, link_models, run);
  io::Json choice;
  if (chosen) choice = add_choice(*chosen, robot, indices, points, run);
  const report::Map result{robot, list, indices, points};
  write_map(request, result, run);
  if (!request.vtu.empty()) io::write_vtu(request.vtu, report::vtu(result));
  if (run.wants_page()) run.draw(report::picture(result));
  run.print(report::wrapped(report::headline(result)) + "\n" + report::text(result));
  io::Json json = report::to_json(result);
  if (!uncertainty.is_null()) json["uncertainty"] = std::move(uncertainty);
  if (!choice.is_null()) json["choice"] = std::move(choice);
  if (!link_models.is_null()) json["link_models"] = std::move(link_models);
  return json;
}

}  // namespace

void add_map(Program& program) {
  const auto request = std::make_shared<GridRequest>();
  OptionList app = program.add(
      {.name = "map",
       .summary = "Indices of stiffness over a grid of poses or along a path",
       .example = "kinetostat map data/robots/orthoglide.yaml --grid x=-60:60:5,y=-60:60:5,z=0 "
                  "--index weakest-translation --index stiffness=1,1,1",
       .out = "Write one row a pose (CSV); FILE.part lets an interrupted map go on"},
      [request](Run& run) { return map(*request, run); });
  request->map.add_options(app);
  request->uncertainty.add_options(app);
  add_links_option(app, request->links);
  request->free.add_options(app);
  app.add_output("--vtu", request->vtu, "Write the map for ParaView");
  app.add_option("--part", request->part, "Only the i-th of n parts of the poses, for join")
      .type_name("i/n")
      .excludes("--turn")
      .excludes("--joint")
      .excludes("--place")
      .excludes("--links")
      .excludes("--vtu");
  app.add_option("--checkpoint", request->checkpoint,
                 "Where an interrupted map goes on from, when not beside --out")
      .type_name("FILE");
}

}  // namespace kinetostat::apps
