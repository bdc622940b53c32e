#include "kinetostat/apps/commands/studies/table_request.h"

#include <map>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "kinetostat/apps/cli/option_values.h"
#include "kinetostat/common/faults.h"
#include "kinetostat/io/text_file.h"
#include "kinetostat/io/yaml.h"
#include "kinetostat/report/screen/wording.h"
#include "kinetostat/spatial/units.h"

namespace kinetostat::apps {
namespace {

using calibration::ReadingsOverview;

// "length=mm,force=N".
std::map<std::string, std::string> units_of_columns(const std::string& text) {
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

std::string line_of_noise(const std::string& noise) {
  if (noise.empty()) return {};
  try {
    spatial::parse_quantity(noise, spatial::dimension::length);
  } catch (const std::invalid_argument& error) {
    throw UsageError("--noise", error.what(), "Write --noise 3um");
  }
  return fmt::format("noise: {{translation: {}}}\n", io::yaml_scalar(noise));
}

// As a file in this folder names another.
std::string seen_from(const std::filesystem::path& folder, const std::filesystem::path& file) {
  return std::filesystem::absolute(file)
      .lexically_normal()
      .lexically_relative(std::filesystem::absolute(folder).lexically_normal())
      .string();
}

// The first line of a file that was made: the digest of all that follows, as long as nobody edits
// it.
std::string line_of_origin(const std::string& draft) {
  return fmt::format("# Made by 'kinetostat study' ({}); edited, it counts as it is.\n",
                     io::sha256(draft).substr(0, 16));
}

// Whether a file may be replaced by `draft`; edited, it may not.
bool is_replaceable(const std::filesystem::path& file, const std::string& draft) {
  std::error_code ignored;
  if (!std::filesystem::exists(file, ignored)) return true;
  const std::string text = io::read_text(file);
  const std::string first = text.substr(0, text.find('\n') + 1), rest = text.substr(first.size());
  if (first == line_of_origin(rest)) return true;
  if (first == line_of_origin(draft)) return false;
  throw common::InputError(
      file, "is there already, edited or from elsewhere, and would be made otherwise now",
      fmt::format("Study it itself, 'kinetostat study {} -o {}', or remove it",
                  report::quoted(file.string()), report::quoted(file.parent_path().string())));
}

void require_usable(const ReadingsOverview& overview) {
  common::Faults faults;
  for (const common::InputError::Details& mistake : overview.mistakes) faults.add(mistake);
  faults.throw_if_any();
}

// What only people know, with the words to add.
void say_what_is_not_used(const ReadingsOverview& overview, const std::filesystem::path& file,
                          const Run& run) {
  for (const calibration::ColumnOverview& column : overview.columns)
    if (!column.meant.empty())
      run.warn(fmt::format("'{}' is not used; if it is a reading, add --column \"{}={}\"",
                           column.header, column.header, column.meant));
  if (overview.sensors_only) return;
  for (const calibration::ProposedSensor& sensor : overview.sensors)
    run.warn(fmt::format(
        "'{0}' is not used; if it reads the platform, add --column \"{1}=dx\" (or -dx, "
        "dy, ...); if a {2} elsewhere, remove the '#' before 'sensors:' in {3}",
        fmt::join(sensor.columns, "', '"), sensor.columns.front(), sensor.kind, file.string()));
}

[[noreturn]] void ask_what_carries(const ReadingsOverview& overview,
                                   const std::filesystem::path& file) {
  std::vector<std::string> names;
  for (const calibration::ProposedSensor& sensor : overview.sensors) names.push_back(sensor.name);
  throw common::InputError(
      {.file = file,
       .key = "sensors",
       .what = fmt::format("the table does not say what carries {}", report::listed(names)),
       .cure = "Write it in this file instead of WHERE, then give the same command again"});
}

}  // namespace

void TableRequest::add_options(OptionList& app) {
  app.add_option("--column", columns,
                 "Meaning of a column, NAME=MEANING, as 'Gauge 1=-dz [um]'; may be repeated")
      .type_name("COLUMN")
      .hide_default()
      .one_at_a_time();
  app.add_option("--units", units,
                 "Units of columns that name none: length=mm,force=N,angle=deg,time=s")
      .type_name("UNITS");
  app.add_option("--displacement", displacement,
                 "What displacements are: difference to the unloaded state, or absolute poses")
      .type_name("KIND")
      .one_of({"difference", "absolute"});
  app.add_option("--noise", noise,
                 "Standard deviation of one displacement, as 3um; else from repeated readings")
      .type_name("LENGTH");
  app.add_option("--sheet", sheet, "Sheet of a spreadsheet; the first with a table")
      .type_name("NAME");
}

bool TableRequest::says_something() const {
  return !columns.empty() || !units.empty() || !displacement.empty() || !sheet.empty() ||
         !noise.empty();
}

calibration::ReadingsOverview TableRequest::look(const vjm::Robot* robot) const {
  calibration::ReadingsRequest request{
      .table = file, .units = units_of_columns(units), .sheet = sheet};
  for (const std::string& text : columns) {
    const std::size_t equals = text.rfind('=');
    if (equals == std::string::npos || equals == 0 || equals + 1 == text.size())
      throw UsageError("--column", fmt::format("'{}' is not of the form NAME=MEANING", text),
                       "Write --column \"Gauge 1=dz [um]\"");
    request.columns[text.substr(0, equals)] = text.substr(equals + 1);
  }
  if (!displacement.empty())
    request.displacement = displacement == "absolute" ? calibration::DisplacementKind::absolute
                                                      : calibration::DisplacementKind::difference;
  return calibration::look_at_readings(request, robot);
}

std::string drafted_campaign(const TableRequest& request, const ReadingsOverview& overview,
                             const vjm::Robot* robot, const std::filesystem::path& out) {
  const std::filesystem::path folder = out.has_parent_path() ? out.parent_path() : ".";
  return calibration::campaign_text(overview, overview.table.stem().string(),
                                    robot != nullptr ? seen_from(folder, robot->file) : "",
                                    seen_from(folder, overview.table),
                                    robot != nullptr
                                        ? robot->units
                                        : spatial::UnitSystem{.length = "mm", .angle = "deg"}) +
         line_of_noise(request.noise);
}

std::filesystem::path keep_drafted_campaign(const TableRequest& request,
                                            const ReadingsOverview& overview,
                                            const vjm::Robot& robot,
                                            const std::filesystem::path& folder, const Run& run) {
  require_usable(overview);
  std::filesystem::path file = folder / drafted_campaign_name;
  say_what_is_not_used(overview, file, run);
  const std::string draft = drafted_campaign(request, overview, &robot, file);
  if (!is_replaceable(file, draft)) {
    run.remark(fmt::format("{} was edited: it counts as it is", file.string()));
    return file;
  }
  io::write_atomically(file, line_of_origin(draft) + draft);
  if (overview.sensors_only && !overview.sensors.empty()) ask_what_carries(overview, file);
  return file;
}

}  // namespace kinetostat::apps
