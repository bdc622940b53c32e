// kinetostat readings: how a table of readings is understood, and a campaign file for it.
#include "kinetostat/report/screen/readings.h"

#include <memory>

#include <fmt/format.h>

#include "kinetostat/apps/cli/command.h"
#include "kinetostat/apps/commands/commands.h"
#include "kinetostat/apps/commands/studies/table_request.h"
#include "kinetostat/calibration/campaign/campaign_file.h"
#include "kinetostat/calibration/campaign/readings_overview.h"
#include "kinetostat/common/faults.h"
#include "kinetostat/io/document_kind.h"
#include "kinetostat/io/text_file.h"
#include "kinetostat/report/readings_overview.h"

namespace kinetostat::apps {
namespace {

using calibration::ReadingsOverview;

struct ReadingsOptions {
  TableRequest table;
  std::string robot;
};

void refuse(const ReadingsOverview& overview, Run& run) {
  common::Faults faults;
  for (const common::InputError::Details& mistake : overview.mistakes) faults.add(mistake);
  try {
    faults.throw_if_any();
  } catch (const common::InputErrors& errors) {
    run.print(words_of(errors, run.is_verbose()) + "\n");
    run.refuse({overview.table, "it cannot be compared with a model yet",
                "Repair what is listed in the report"});
  } catch (const common::InputError& error) {
    run.refuse(error);
  }
}

bool is_campaign(const std::string& file) {
  return io::document_kind(file) == io::DocumentKind::campaign;
}

ReadingsOverview look(const ReadingsOptions& request, const std::optional<vjm::Robot>& robot) {
  return is_campaign(request.table.file) ? calibration::look_at_campaign(request.table.file, *robot)
                                         : request.table.look(robot ? &*robot : nullptr);
}

std::optional<vjm::Robot> read_robot(const ReadingsOptions& request) {
  if (!request.robot.empty()) return vjm::read_robot(request.robot);
  if (!is_campaign(request.table.file)) return std::nullopt;
  if (const auto named = calibration::robot_named_in(request.table.file))
    return vjm::read_robot(*named);
  throw common::InputError({.file = request.table.file,
                            .key = "robot",
                            .what = "the campaign names no robot file",
                            .cure = "Name it on the command line after the campaign"});
}

io::Json show_readings(const ReadingsOptions& request, Run& run) {
  const std::optional<vjm::Robot> robot = read_robot(request);
  const ReadingsOverview overview = look(request, robot);
  // What is to be repaired comes first, and fills a screen.
  const bool is_whole = overview.mistakes.empty();
  if (!is_whole) refuse(overview, run);
  const std::string columns = report::readings_text(overview);
  is_whole ? run.print(columns) : run.print_more("\n" + columns);
  run.print_more("\nEvery column\n" + report::table_text(overview));
  if (!robot && is_whole)
    run.print("No robot file is given: columns of joints are not looked for.\n");
  if (is_whole && run.out()) {
    if (is_campaign(request.table.file))
      throw UsageError("--out", "there is a campaign file already",
                       "Give the table itself to have one written");
    io::write_atomically(*run.out(), drafted_campaign(request.table, overview,
                                                      robot ? &*robot : nullptr, *run.out()));
    const bool open = overview.sensors_only && !overview.sensors.empty();
    run.print(fmt::format("\nNext: {}kinetostat compare {}{}\n",
                          open ? "say in the file what carries each sensor, then " : "",
                          request.robot.empty() ? "ROBOT " : "", run.out()->string()));
  }
  return report::readings_json(overview);
}

}  // namespace

void add_readings(Program& program) {
  const auto request = std::make_shared<ReadingsOptions>();
  OptionList app = program.add(
      {.name = "readings",
       .summary = "Show how a table of readings is understood, and write a campaign file for it",
       .example = "kinetostat readings data/measurements/nist_load_cell/readings.csv "
                  "data/robots/bench.yaml --units length=mm,force=N",
       .out = "Write the campaign file"},
      [request](Run& run) { return show_readings(*request, run); });
  app.add_option("FILE", request->table.file, "Table (CSV, .xlsx, .ods), or campaign file")
      .required();
  app.add_option("ROBOT", request->robot, "Robot file, whose joints are looked for in the table");
  request->table.add_options(app);
}

}  // namespace kinetostat::apps
