// kinetostat map: indices of stiffness over a grid or along a path.
#include "kinetostat/report/manipulators/map.h"

#include <functional>
#include <memory>
#include <utility>

#include <fmt/format.h>

#include "kinetostat/apps/cli/command.h"
#include "kinetostat/apps/cli/map_request.h"
#include "kinetostat/apps/commands/commands.h"
#include "kinetostat/apps/commands/link_models.h"
#include "kinetostat/io/text_file.h"
#include "kinetostat/report/manipulators/uncertainty.h"
#include "kinetostat/report/screen/uncertainty.h"
#include "kinetostat/report/screen/wording.h"

namespace kinetostat::apps {
namespace {

struct GridRequest {
  MapRequest map;
  UncertaintyRequest uncertainty;
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

std::vector<vjm::MapIndex> plain(const std::vector<report::NamedIndex>& named) {
  std::vector<vjm::MapIndex> indices;
  for (const report::NamedIndex& index : named) indices.push_back(index.index);
  return indices;
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
  run.print(report::wrapped(report::capitalised(indices[0].name) + ". " +
                            report::range_sentence(*uncertainty, 0, poses)) +
            "\n");
}

io::Json map(const GridRequest& request, Run& run) {
  const vjm::Robot robot = vjm::read_robot(request.map.robot_file);
  const vjm::PoseList list = request.map.read_poses(robot);
  std::vector<report::NamedIndex> indices = request.map.read_indices(robot, list);
  std::vector<vjm::MapPoint> points = map_points(request, robot, list, indices, run);
  io::Json link_models, uncertainty;
  add_uncertainties(request, robot, list, indices, points, uncertainty, run);
  if (!request.links.empty()) compare_maps(request, list, indices, points, link_models, run);
  const report::Map result{robot, list, indices, points};
  if (run.out()) io::write_atomically(*run.out(), report::csv(result));
  if (!request.vtu.empty()) io::write_vtu(request.vtu, report::vtu(result));
  if (run.wants_page()) run.draw(report::picture(result));
  run.print(report::text(result));
  io::Json json = report::to_json(result);
  if (!uncertainty.is_null()) json["uncertainty"] = std::move(uncertainty);
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
  app.add_output("--vtu", request->vtu, "Write the map for ParaView");
  app.add_option("--checkpoint", request->checkpoint,
                 "Where an interrupted map goes on from, when not beside --out")
      .type_name("FILE");
}

}  // namespace kinetostat::apps
