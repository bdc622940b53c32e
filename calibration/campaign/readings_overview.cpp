#include "kinetostat/calibration/campaign/readings_overview.h"

#include <algorithm>
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "kinetostat/calibration/campaign/campaign_file.h"
#include "kinetostat/calibration/campaign/clock_time.h"
#include "kinetostat/calibration/campaign/readings_columns.h"
#include "kinetostat/calibration/campaign/readings_file.h"
#include "kinetostat/common/error.h"
#include "kinetostat/io/yaml.h"
#include "kinetostat/vjm/chain/chain_builder.h"

namespace kinetostat::calibration {
namespace {

using spatial::Dimension;
namespace dimension = spatial::dimension;

// A robot of which no joint is known.
vjm::Manipulator nobody() { return {"robot", {vjm::ChainBuilder("robot").build()}}; }

std::string words_for(const std::string& meaning, const std::vector<Joint>& joints) {
  for (const Joint& joint : joints)
    if (joint.name == meaning) return fmt::format("joint {}", joint.column());
  static const std::map<std::string, std::string> of_axes = {{"f", "force along "},
                                                             {"m", "moment about "},
                                                             {"p", "point of application, "},
                                                             {"d", "displacement along "},
                                                             {"r", "rotation about "}};
  if (meaning.size() == 2 && std::string_view("xyz").find(meaning[1]) != std::string_view::npos)
    if (const auto found = of_axes.find(meaning.substr(0, 1)); found != of_axes.end())
      return fmt::format("{}, {}{}", meaning, found->second, meaning[1]);
  if (meaning.size() == 1) return fmt::format("{}, posture of the platform", meaning);
  if (meaning == "roll" || meaning == "pitch" || meaning == "yaw")
    return meaning + ", posture of the platform";
  if (meaning.starts_with("sigma")) return meaning + ", standard deviation";
  if (meaning.starts_with("corr")) return meaning + ", correlation";
  if (meaning.empty()) return "covariate";
  return is_reserved(meaning) ? meaning : meaning + ", a sensor";
}

// Which of `units:` such a column needs.
std::string unit_key(const Dimension& d) {
  if (d == dimension::length) return "length";
  if (d == dimension::force || d == dimension::moment) return "force";
  if (d == dimension::angle) return "angle";
  return d == dimension::time ? "time" : "";
}

void look_at_cells(const io::CsvTable& table, std::size_t c, ColumnOverview& column) {
  std::set<std::string> words;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    if (table.missing(row, c)) {
      ++column.missing;
      continue;
    }
    ++column.values;
    try {
      const double value = table.number(row, c);
      if (!column.range) column.range = {value, value};
      (*column.range)[0] = std::min((*column.range)[0], value);
      (*column.range)[1] = std::max((*column.range)[1], value);
    } catch (const common::InputError&) {
      const std::string text(table.cell(row, c));
      if (words.empty()) column.first = text;
      column.last = text;
      words.insert(text);
    }
  }
  column.different = words.size();
}

bool is_clock(const ColumnOverview& column) {
  return !column.first.empty() && read_clock_time(column.first).has_value();
}

std::vector<ColumnOverview> look_at_columns(const io::CsvTable& table,
                                            const ReadingsColumns& columns,
                                            const spatial::UnitSystem& units,
                                            const std::vector<Joint>& joints) {
  std::vector<ColumnOverview> result;
  for (std::size_t c = 0; c < table.columns().size(); ++c) {
    ColumnOverview& column = result.emplace_back();
    const NamedColumn& named = columns.names[c];
    const bool used = columns.known.count(c) > 0;
    column.header = table.columns()[c];
    column.meaning = used ? named.meaning : "";
    column.words = words_for(column.meaning, joints);
    column.negative = used && named.negative;
    look_at_cells(table, c, column);
    const Dimension d = columns.dimensions[c];
    if (columns.unknown_units.count(c) > 0)
      column.unit = "?";
    else if (used && d != dimension::none && !(column.meaning == "time" && is_clock(column)))
      column.unit =
          d == dimension::temperature && !named.unit ? "degC" : unit_of_column(named, d, units);
    if (!used) column.meant = looks_like(column.header, joints);
  }
  return result;
}

// Guesses that are only made where they are shown and written down.
void guess_columns(const io::CsvTable& table, const std::vector<Joint>& joints,
                   ReadingsOverview& overview) {
  std::map<std::string, std::string> header_of;
  bool any_joint = false;
  for (const std::string& header : table.columns()) {
    const NamedColumn named = understood(header, joints);
    header_of.emplace(named.meaning, header);
    any_joint = any_joint || std::any_of(joints.begin(), joints.end(), [&](const Joint& joint) {
                  return named.meaning == joint.name;
                });
  }
  const auto has = [&](const char* name) { return header_of.count(name) > 0; };
  const bool measured = has("dx") || has("dy") || has("dz") || has("rx") || has("ry") || has("rz");
  if (any_joint && !measured && has("x") && has("y") && has("z") && overview.stated.empty())
    for (const char* axis : {"x", "y", "z"}) {
      overview.stated[header_of[axis]] = std::string("d") + axis;
      overview.displacement = DisplacementKind::absolute;
    }
  if (has("time")) return;
  for (std::size_t c = 0; c < table.columns().size(); ++c) {
    const std::string name = bare_name(table.columns()[c]);
    const bool may_be = name == "zeit" || name == "timestamp" || name == "datum" ||
                        name == "date" || name == "datetime" || name == "uhrzeit" ||
                        name == "datum/uhrzeit" || name == "date/time" || name == "clock";
    std::size_t row = 0;
    while (row + 1 < table.rows() && table.missing(row, c)) ++row;
    if (!may_be || overview.stated.count(table.columns()[c]) > 0) continue;
    if (!read_clock_time(table.cell(row, c))) continue;
    overview.stated[table.columns()[c]] = "time";
    return;
  }
}

// Columns that have no unit, and none is given for them.
void check_units(const io::CsvTable& table, const ReadingsColumns& columns,
                 ReadingsOverview& overview) {
  static const std::map<std::string, std::string> examples = {
      {"length", "mm"}, {"force", "N"}, {"angle", "deg"}, {"time", "s"}};
  for (std::size_t c = 0; c < table.columns().size(); ++c) {
    const ColumnOverview& column = overview.columns[c];
    const Dimension d = columns.dimensions[c];
    const std::string key = unit_key(d);
    if (key.empty() || columns.names[c].unit || (column.meaning == "time" && is_clock(column)))
      continue;
    if (overview.units.count(key) > 0) continue;
    const std::string unit = d == dimension::moment ? "N m" : examples.at(key);
    overview.mistakes.push_back(
        table.column_mistake(c, fmt::format("'{}' has no unit", column.header),
                             fmt::format("Write '{} [{}]', or give --units {}={}", column.header,
                                         unit, key, examples.at(key))));
    overview.columns[c].unit = "?";
  }
}

void add(const common::Faults& faults, ReadingsOverview& overview) {
  for (const common::InputError::Details& mistake : faults.mistakes())
    overview.mistakes.push_back(mistake);
}

// Reads all of it as a comparison would, for its mistakes and notes.
void try_to_read(const io::CsvTable& table, const ReadingsContext& context,
                 const vjm::Manipulator& manipulator, Campaign campaign,
                 const common::Faults& before, ReadingsOverview& overview) {
  try {
    read_readings(table, context, manipulator, campaign, before);
  } catch (const common::InputError& error) {
    common::Faults faults;
    faults.add(error);
    add(faults, overview);
  }
  overview.notes = campaign.notes;
}

std::string unit_or(const std::map<std::string, std::string>& units, const char* key,
                    const std::string& otherwise) {
  const auto found = units.find(key);
  return found == units.end() ? otherwise : found->second;
}

}  // namespace

ReadingsOverview look_at_readings(const ReadingsRequest& request, const vjm::Robot* robot) {
  const vjm::Manipulator manipulator = robot != nullptr ? robot->manipulator : nobody();
  const std::vector<Joint> joints = joints_of(manipulator);
  common::Faults faults;
  const io::CsvTable table = io::read_table(request.table, {.sheet = request.sheet}, &faults);
  ReadingsOverview overview{.table = request.table,
                            .rows = table.rows(),
                            .header_line = static_cast<std::size_t>(table.header_line()),
                            .stated = request.columns,
                            .units = request.units};
  if (!table.format().other_sheets.empty() || !request.sheet.empty())
    overview.sheet = table.format().sheet;
  guess_columns(table, joints, overview);
  if (request.displacement) overview.displacement = *request.displacement;

  Campaign campaign;
  campaign.file = campaign.readings_file = request.table;
  campaign.displacement = overview.displacement;
  campaign.units = {.length = unit_or(request.units, "length", "mm"),
                    .force = unit_or(request.units, "force", "N"),
                    .angle = unit_or(request.units, "angle", "deg"),
                    .time = unit_or(request.units, "time", "s")};
  ReadingsContext context{.angle_stated = true, .time_stated = true};
  for (const auto& [header, meaning] : overview.stated)
    context.columns[header] = read_stated_column(meaning);
  Campaign looked_at = campaign;
  common::Faults of_columns;  // found again when all is read
  const ReadingsColumns columns = find_columns(table, context, manipulator, looked_at, of_columns);
  overview.needs_wrench_point =
      (columns.wrench[3] || columns.wrench[4] || columns.wrench[5]) && !columns.point[0];
  if (overview.needs_wrench_point)
    context.wrench.point = spatial::Vector3(spatial::Vector3::Zero());
  overview.columns = look_at_columns(table, columns, campaign.units, joints);
  check_units(table, columns, overview);
  try_to_read(table, context, manipulator, campaign, faults, overview);
  return overview;
}

ReadingsOverview look_at_campaign(const std::filesystem::path& file, const vjm::Robot& robot) {
  Campaign campaign;
  const ReadingsContext context = read_context(file, robot.manipulator, campaign);
  common::Faults faults;
  const io::CsvTable table = io::read_table(campaign.readings_file, context.table, &faults);
  ReadingsOverview overview{.table = campaign.readings_file,
                            .rows = table.rows(),
                            .header_line = static_cast<std::size_t>(table.header_line()),
                            .displacement = campaign.displacement};
  Campaign looked_at = campaign;
  common::Faults of_columns;
  const ReadingsColumns columns =
      find_columns(table, context, robot.manipulator, looked_at, of_columns);
  overview.columns = look_at_columns(table, columns, campaign.units, joints_of(robot.manipulator));
  try_to_read(table, context, robot.manipulator, campaign, faults, overview);
  return overview;
}

std::string campaign_text(const ReadingsOverview& overview, const std::string& name,
                          const std::string& robot, const std::string& readings,
                          const spatial::UnitSystem& units) {
  const auto unit = [&](const char* key, const std::string& otherwise) {
    return io::yaml_scalar(unit_or(overview.units, key, otherwise));
  };
  const bool absolute = overview.displacement == DisplacementKind::absolute;
  std::string text = fmt::format(
      "kinetostat: 1\ncampaign: {}\n{}units: {{length: {}, force: {}, angle: {}, time: {}}}  # "
      "where "
      "a column names none\ndisplacement: {}\n",
      io::yaml_scalar(name), robot.empty() ? "" : "robot: " + io::yaml_scalar(robot) + "\n",
      unit("length", units.length), unit("force", units.force), unit("angle", units.angle),
      unit("time", units.time),
      absolute ? "absolute  # poses in the base frame" : "difference  # from the unloaded state");
  if (overview.needs_wrench_point)
    text += "wrench_point: reference  # moments are about the reference point\n";
  std::vector<std::string> stated;
  for (const auto& [header, meaning] : overview.stated)
    stated.push_back(fmt::format("{}: {}", io::yaml_scalar(header), io::yaml_scalar(meaning)));
  if (!stated.empty()) text += fmt::format("columns: {{{}}}\n", fmt::join(stated, ", "));
  if (!overview.sheet.empty()) text += fmt::format("sheet: {}\n", io::yaml_scalar(overview.sheet));
  return text + fmt::format("readings: {}\n", io::yaml_scalar(readings));
}

}  // namespace kinetostat::calibration
