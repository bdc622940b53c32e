// kinetostat map: indices of stiffness over a grid or along a path.
#include "kinetostat/report/manipulators/map.h"

#include <memory>

#include "kinetostat/apps/cli/command.h"
#include "kinetostat/apps/cli/map_request.h"
#include "kinetostat/apps/commands/commands.h"
#include "kinetostat/io/text_file.h"

namespace kinetostat::apps {
namespace {

struct Request {
  MapRequest map;
  std::string vtu, checkpoint;
};

// With the beams in two and in four times the segments.
std::vector<vjm::Manipulator> finer_models(const vjm::Robot& robot) {
  std::vector<vjm::Manipulator> finer;
  if (!robot.has_beams) return finer;
  for (const int multiple : {2, 4})
    finer.push_back(vjm::read_robot(robot.file, {.segment_multiple = multiple}).manipulator);
  return finer;
}

std::vector<vjm::MapPoint> computed(const Request& request, const vjm::Robot& robot,
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

io::Json map(const Request& request, Run& run) {
  const vjm::Robot robot = vjm::read_robot(request.map.robot_file);
  const vjm::PoseList list = request.map.read_poses(robot);
  const std::vector<report::NamedIndex> indices = request.map.read_indices(robot, list);
  const std::vector<vjm::MapPoint> points = computed(request, robot, list, indices, run);
  const report::Map result{robot, list, indices, points};
  if (run.out()) io::write_atomically(*run.out(), report::csv(result));
  if (!request.vtu.empty()) io::write_vtu(request.vtu, report::vtu(result));
  if (run.wants_page()) run.draw(report::picture(result));
  run.print(report::text(result));
  return report::to_json(result);
}

}  // namespace

void add_map(Program& program) {
  const auto request = std::make_shared<Request>();
  OptionList app = program.add(
      {.name = "map",
       .summary = "Indices of stiffness over a grid of poses or along a path",
       .example = "kinetostat map data/robots/orthoglide.yaml --grid x=-60:60:5,y=-60:60:5,z=0 "
                  "--index weakest-translation --index stiffness=1,1,1",
       .out = "Write one row a pose (CSV); FILE.part lets an interrupted map go on"},
      [request](Run& run) { return map(*request, run); });
  request->map.add_options(app);
  app.add_output("--vtu", request->vtu, "Write the map for ParaView");
  app.add_option("--checkpoint", request->checkpoint,
                 "Where an interrupted map goes on from, when not beside --out")
      .type_name("FILE");
}

}  // namespace kinetostat::apps
