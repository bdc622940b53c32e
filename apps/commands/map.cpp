// kinetostat map: indices of stiffness over a grid or along a path.
#include "kinetostat/report/manipulators/map.h"

#include <memory>

#include <fmt/format.h>

#include "kinetostat/apps/cli/command.h"
#include "kinetostat/apps/cli/map_request.h"
#include "kinetostat/apps/commands/commands.h"
#include "kinetostat/apps/commands/link_models.h"
#include "kinetostat/io/text_file.h"

namespace kinetostat::apps {
namespace {

struct GridRequest {
  MapRequest map;
  std::string vtu, checkpoint;
  std::vector<std::string> links;
};

// With the beams in two and in four times the segments.
std::vector<vjm::Manipulator> finer_models(const vjm::Robot& robot) {
  std::vector<vjm::Manipulator> finer;
  if (!robot.has_beams) return finer;
  for (const int multiple : {2, 4})
    finer.push_back(vjm::read_robot(robot.file, {.segment_multiple = multiple}).manipulator);
  return finer;
}

std::vector<vjm::MapPoint> map_points(const GridRequest& request, const vjm::Robot& robot,
                                      const vjm::PoseList& list,
                                      const std::vector<report::NamedIndex>& named, Run& run) {
  std::vector<vjm::MapIndex> indices;
  for (const report::NamedIndex& index : named) indices.push_back(index.index);
  vjm::MapCheckpoint checkpoint{.file = request.checkpoint, .request = {}};
  if (request.checkpoint.empty() && run.out()) checkpoint.file = run.out()->string() + ".part";
  const bool saves = !checkpoint.file.empty();
  if (saves) {
    io::require_writable(checkpoint.file);  // before hours are spent
    checkpoint.request = map_identity(robot, list, named);
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

io::Json map(const GridRequest& request, Run& run) {
  const vjm::Robot robot = vjm::read_robot(request.map.robot_file);
  const vjm::PoseList list = request.map.read_poses(robot);
  std::vector<report::NamedIndex> indices = request.map.read_indices(robot, list);
  std::vector<vjm::MapPoint> points = map_points(request, robot, list, indices, run);
  io::Json link_models;
  if (!request.links.empty()) compare_maps(request, list, indices, points, link_models, run);
  const report::Map result{robot, list, indices, points};
  if (run.out()) io::write_atomically(*run.out(), report::csv(result));
  if (!request.vtu.empty()) io::write_vtu(request.vtu, report::vtu(result));
  if (run.wants_page()) run.draw(report::picture(result));
  run.print(report::text(result));
  io::Json json = report::to_json(result);
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
  add_links_option(app, request->links);
  app.add_output("--vtu", request->vtu, "Write the map for ParaView");
  app.add_option("--checkpoint", request->checkpoint,
                 "Where an interrupted map goes on from, when not beside --out")
      .type_name("FILE");
}

}  // namespace kinetostat::apps
