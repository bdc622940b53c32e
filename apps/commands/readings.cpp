// kinetostat readings: how a table of readings is understood, and a campaign file for it.
#include "kinetostat/report/screen/readings.h"

#include <algorithm>
#include <memory>

#include <fmt/format.h>

#include "kinetostat/apps/cli/command.h"
#include "kinetostat/apps/cli/option_values.h"
#include "kinetostat/apps/commands/commands.h"
#include "kinetostat/calibration/campaign/campaign_file.h"
#include "kinetostat/calibration/campaign/readings_overview.h"
#include "kinetostat/common/faults.h"
#include "kinetostat/io/document_kind.h"
#include "kinetostat/io/text_file.h"
#include "kinetostat/report/readings_overview.h"
#include "kinetostat/spatial/units.h"

namespace kinetostat::apps {
namespace {

using calibration::ReadingsOverview;

struct ReadingsOptions {
  std::string file, robot, units, displacement, sheet;
  std::vector<std::string> columns;
};

// "length=mm,force=N".
std::map<std::string, std::string> read_units(const std::string& text) {
  std::map<std::string, std::string> units;
  if (text.empty()) return units;
  for (const std::string& part : split(text)) {
    const std::size_t equals = part.find('=');
    const std::string key = part.substr(0, equals);
    const bool known = key == "length" || key == "force" || key == "angle" || key == "time";
    if (equals == std::string::npos || !known)
      throw UsageError("--units", fmt::format("'{}' is not understood", part),
                       "Write --units length=mm,force=N,angle=deg,time=s");
    try {
      spatial::parse_unit(part.substr(equals + 1));
    } catch (const std::invalid_argument& error) {
      throw UsageError("--units", error.what());
    }
    units[key] = part.substr(equals + 1);
  }
  return units;
}

calibration::ReadingsRequest request_of(const ReadingsOptions& given) {
  calibration::ReadingsRequest request{
      .table = given.file, .units = read_units(given.units), .sheet = given.sheet};
  for (const std::string& text : given.columns) {
    const std::size_t equals = text.rfind('=');
    if (equals == std::string::npos || equals == 0 || equals + 1 == text.size())
      throw UsageError("--column", fmt::format("'{}' is not of the form NAME=MEANING", text),
                       "Write --column \"Gauge 1=dz [um]\"");
    request.columns[text.substr(0, equals)] = text.substr(equals + 1);
  }
  if (!given.displacement.empty())
    request.displacement = given.displacement == "absolute"
                               ? calibration::DisplacementKind::absolute
                               : calibration::DisplacementKind::difference;
  return request;
}

// As a file in this folder names another.
std::string seen_from(const std::filesystem::path& folder, const std::filesystem::path& file) {
  return std::filesystem::absolute(file)
      .lexically_normal()
      .lexically_relative(std::filesystem::absolute(folder).lexically_normal())
      .string();
}

std::string draft(const ReadingsOverview& overview, const ReadingsOptions& request,
                  const std::optional<vjm::Robot>& robot, const std::filesystem::path& out) {
  const std::filesystem::path folder = out.has_parent_path() ? out.parent_path() : ".";
  return calibration::campaign_text(
      overview, overview.table.stem().string(),
      request.robot.empty() ? "" : seen_from(folder, request.robot),
      seen_from(folder, overview.table),
      robot ? robot->units : spatial::UnitSystem{.length = "mm", .angle = "deg"});
}

void refuse(const ReadingsOverview& overview, Run& run) {
  common::Faults faults;
  for (const common::InputError::Details& mistake : overview.mistakes) faults.add(mistake);
  try {
    faults.throw_if_any();
  } catch (const common::InputErrors& errors) {
    run.print(fmt::format("\n{}\n", errors.what()));
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
  return is_campaign(request.file)
             ? calibration::look_at_campaign(request.file, *robot)
             : calibration::look_at_readings(request_of(request), robot ? &*robot : nullptr);
}

std::optional<vjm::Robot> read_robot(const ReadingsOptions& request) {
  if (!request.robot.empty()) return vjm::read_robot(request.robot);
  if (!is_campaign(request.file)) return std::nullopt;
  if (const auto named = calibration::robot_named_in(request.file)) return vjm::read_robot(*named);
  throw common::InputError({.file = request.file,
                            .key = "robot",
                            .what = "the campaign names no robot file",
                            .cure = "Name it on the command line after the campaign"});
}

io::Json show_readings(const ReadingsOptions& request, Run& run) {
  const std::optional<vjm::Robot> robot = read_robot(request);
  const ReadingsOverview overview = look(request, robot);
  run.print(report::readings_text(overview));
  run.print_more("\nEvery column\n" + report::table_text(overview));
  if (!robot) run.print("No robot file is given: columns of joints are not looked for.\n");
  if (!overview.mistakes.empty()) {
    refuse(overview, run);
  } else if (run.out()) {
    if (is_campaign(request.file))
      throw UsageError("--out", "there is a campaign file already",
                       "Give the table itself to have one written");
    io::write_atomically(*run.out(), draft(overview, request, robot, *run.out()));
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
  app.add_option("FILE", request->file, "Table (CSV, .xlsx, .ods), or campaign file").required();
  app.add_option("ROBOT", request->robot, "Robot file, whose joints are looked for in the table");
  app.add_option("--column", request->columns,
                 "Meaning of a column, NAME=MEANING, as 'Gauge 1=-dz [um]'; may be repeated")
      .type_name("COLUMN")
      .hide_default()
      .one_at_a_time();
  app.add_option("--units", request->units,
                 "Units of columns that name none: length=mm,force=N,angle=deg,time=s")
      .type_name("UNITS");
  app.add_option("--displacement", request->displacement,
                 "What displacements are: difference to the unloaded state, or absolute poses")
      .type_name("KIND")
      .one_of({"difference", "absolute"});
  app.add_option("--sheet", request->sheet, "Sheet of a spreadsheet; the first with a table")
      .type_name("NAME");
}

}  // namespace kinetostat::apps
