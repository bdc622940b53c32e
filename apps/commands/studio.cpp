// kinetostat studio: the page of a comparison on this machine, where effects are switched on and
// fitted.
#include <chrono>
#include <memory>

#include <fmt/format.h>

#include "kinetostat/apps/cli/campaign_request.h"
#include "kinetostat/apps/cli/command.h"
#include "kinetostat/apps/commands/commands.h"
#include "kinetostat/apps/studio/studio_server.h"
#include "kinetostat/apps/studio/studio_session.h"
#include "kinetostat/calibration/campaign/campaign_file.h"

namespace kinetostat::apps {
namespace {

struct StudioRequest {
  CampaignRequest campaign;
  std::string folder;
  int port = 0;
  double time_limit = 60;
};

// Stops a fit with the program, and after a time.
class TimeLimit : public common::Progress {
 public:
  TimeLimit(const common::Progress& program, double seconds)
      : program_(program),
        end_(std::chrono::steady_clock::now() +
             std::chrono::milliseconds(static_cast<long>(1000 * seconds))) {}
  bool cancelled() const override {
    return program_.cancelled() || std::chrono::steady_clock::now() > end_;
  }

 private:
  const common::Progress& program_;
  std::chrono::steady_clock::time_point end_;
};

io::Json studio(const StudioRequest& request, Run& run) {
  report::require_pages();
  vjm::Robot robot = request.campaign.read_robot();
  calibration::Campaign campaign = request.campaign.read_campaign(robot, run);
  const std::filesystem::path folder =
      request.folder.empty() ? robot.file.parent_path() : std::filesystem::path(request.folder);
  StudioSession session(std::move(robot), std::move(campaign), folder, run.threads(),
                        run.progress());
  StudioRooms rooms;
  rooms.page = report::page(session.title(), {session.opening()}, report::PageHost::studio);
  rooms.actions["fit"] = [&](const io::Json& asked) {
    TimeLimit limit(run.progress(), request.time_limit);
    return session.fit(asked, limit);
  };
  rooms.actions["save"] = [&](const io::Json& asked) { return session.save(asked); };
  serve_studio(rooms, {.port = request.port,
                       .opened =
                           [&run](const std::string& address) {
                             run.say_now("Open " + address + "\nCtrl-C ends the session.\n");
                           },
                       .stopped = [&run] { return run.progress().cancelled(); }});
  run.print("The session has ended.\n");
  return io::Json::object();
}

}  // namespace

void add_studio(Program& program) {
  const auto request = std::make_shared<StudioRequest>();
  OptionList app = program.add(
      {.name = "studio",
       .summary = "Switch effects on and off in a browser on this machine, and see the error fall",
       .example = "kinetostat studio data/robots/bench.yaml "
                  "data/measurements/nist_load_cell/campaign.yaml",
       .out = {},
       .runs_until_stopped = true},
      [request](Run& run) { return studio(*request, run); });
  request->campaign.add_options(app);
  app.add_option("--folder", request->folder,
                 "Where robot files are saved (default: beside the robot file)")
      .type_name("DIR");
  app.add_option("--port", request->port, "Port to listen on (default: any that is free)")
      .between(0, 65535);
  app.add_option("--fit-time", request->time_limit, "Seconds that one fit may take")
      .type_name("S")
      .positive()
      .show_default();
}

}  // namespace kinetostat::apps
