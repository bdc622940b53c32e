#include "kinetostat/calibration/campaign/readings_overview.h"

#include <algorithm>
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "kinetostat/calibration/campaign/campaign_file.h"
#include "kinetostat/calibration/campaign/clock_time.h"
#include "kinetostat/calibration/campaign/readings_columns.h"
#include "kinetostat/calibration/campaign/readings_file.h"
#include "kinetostat/calibration/sensors/sensor_guess.h"
#include "kinetostat/calibration/sensors/sensor_places.h"
#include "kinetostat/common/error.h"
#include "kinetostat/io/yaml.h"
#include "kinetostat/vjm/chain/chain_builder.h"

namespace kinetostat::calibration {
namespace {

using spatial::Dimension;
namespace dimension = spatial::dimension;

// A robot of which no joint is known.
vjm::Manipulator nobody() { return {"robot", {vjm::ChainBuilder("robot").build()}}; }

std::string words_for(const std::string& meaning, const std::vector<Joint>& joints,
                      const std::vector<std::string>& weights) {
  for (const std::string& header : weights)
    if (name_for_column(header) == meaning) return meaning + ", a weight";
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
                                            const std::vector<Joint>& joints,
                                            const std::vector<std::string>& weights = {}) {
  std::vector<ColumnOverview> result;
  for (std::size_t c = 0; c < table.columns().size(); ++c) {
    ColumnOverview& column = result.emplace_back();
    const NamedColumn& named = columns.names[c];
    const bool used = columns.known.count(c) > 0;
    column.header = table.columns()[c];
    column.meaning = used ? named.meaning : "";
    column.words = words_for(column.meaning, joints, weights);
    column.negative = used && named.negative;
    look_at_cells(table, c, column);
    const Dimension d = columns.dimensions[c];
    if (columns.unknown_units.count(c) > 0)
      column.unit = "?";
    else if (used && d != dimension::none && !(column.meaning == "time" && is_clock(column)))
      column.unit =
          d == dimension::temperature && !named.unit ? "degC" : unit_of_column(named, d, units);
    if (used) continue;
    column.meant = looks_like(column.header, joints);
    if (const Joint* joint = joint_like(column.header, joints); joint && column.meant.empty())
      column.meant = fmt::format("{} [{}]", joint->column(),
                                 joint->dimension == dimension::angle ? "deg" : "mm");
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

// What somebody has said that a column is, with its unit or without; null where nobody has.
const std::string* stated_of(const std::string& header, const ReadingsOverview& overview) {
  for (const std::string& name : {header, split_header(header).name})
    if (const auto stated = overview.stated.find(name); stated != overview.stated.end())
      return &stated->second;
  return nullptr;
}

// What the columns are understood as.
std::set<std::string> meanings(const io::CsvTable& table, const std::vector<Joint>& joints,
                               const ReadingsOverview& overview) {
  std::set<std::string> result;
  for (const std::string& header : table.columns()) {
    const std::string* stated = stated_of(header, overview);
    result.insert(stated == nullptr ? understood(header, joints).meaning
                                    : read_stated_column(*stated).meaning);
  }
  return result;
}

// To one that is there, as a further axis of a level, or as a new one.
void add_sensor(const std::string& header, const SensorGuess& guess, ReadingsOverview& overview) {
  const auto same =
      std::find_if(overview.sensors.begin(), overview.sensors.end(), [&](const ProposedSensor& s) {
        return s.name == guess.name && s.kind == "tilt" && guess.kind == "tilt" &&
               guess.axis != 0 && s.axes.find(guess.axis) == std::string::npos;
      });
  const bool more = same != overview.sensors.end();
  ProposedSensor& sensor = more ? *same : overview.sensors.emplace_back();
  if (!more) sensor = {.name = guess.name, .kind = guess.kind, .joint = guess.joint};
  sensor.columns.push_back(header);
  if (guess.axis != 0) sensor.axes += guess.axis;
}

// Sensors that further columns look like. One that shows a joint is one only where another column
// says where that joint stands.
void propose_sensors(const io::CsvTable& table, const std::vector<Joint>& joints,
                     ReadingsOverview& overview) {
  const std::set<std::string> known = meanings(table, joints, overview);
  std::vector<std::string> names;
  names.reserve(joints.size());
  for (const Joint& joint : joints) names.push_back(joint.alone);
  overview.sensors_only =
      std::none_of(component_names.begin(), component_names.end(),
                   [&](const char* component) { return known.count(component) > 0; });
  for (const std::string& header : table.columns()) {
    if (stated_of(header, overview) != nullptr || !understood(header, joints).meaning.empty())
      continue;
    const auto guess = sensor_guess(split_header(header).name, names);
    if (!guess || is_reserved(guess->name)) continue;
    const bool stands = std::any_of(joints.begin(), joints.end(), [&](const Joint& j) {
      return j.alone == guess->joint && known.count(j.name) > 0;
    });
    if (guess->kind != "joint" || stands) add_sensor(header, *guess, overview);
  }
}

// The column that a campaign file would have for it.
std::string column_of(const ProposedSensor& sensor, std::size_t k) {
  return sensor.columns.size() == 1 ? sensor.name
                                    : fmt::format("{}.r{}", sensor.name, sensor.axes[k]);
}

// Adds them to what is read, as far as columns and units go: what carries them nobody has said.
void take_as_read(const std::vector<Joint>& joints, ReadingsOverview& overview,
                  Campaign& campaign) {
  for (const ProposedSensor& sensor : overview.sensors) {
    const bool turns = std::any_of(joints.begin(), joints.end(), [&](const Joint& j) {
      return j.alone == sensor.joint && j.dimension == dimension::angle;
    });
    const Dimension of = sensor.kind == "tilt"     ? dimension::angle
                         : sensor.kind == "torque" ? (turns ? dimension::moment : dimension::force)
                         : sensor.kind == "joint" && turns ? dimension::angle
                                                           : dimension::length;
    for (std::size_t k = 0; k < sensor.columns.size(); ++k) {
      campaign.components.push_back(
          {column_of(sensor, k), of, campaign.sensors.size(), static_cast<Eigen::Index>(k)});
      if (split_header(sensor.columns[k]).name != column_of(sensor, k))
        overview.stated[sensor.columns[k]] = column_of(sensor, k);
    }
    campaign.sensors.push_back({.name = sensor.name, .by_instrument = false});
  }
  campaign.datum_noise.setConstant(campaign.size(), not_a_number);
}

// Masses that no name says anything else of: loads, where nothing else is one.
void propose_weights(const io::CsvTable& table, const std::vector<Joint>& joints,
                     ReadingsOverview& overview, ReadingsContext& context) {
  const std::set<std::string> known = meanings(table, joints, overview);
  for (const char* component : {"fx", "fy", "fz", "mx", "my", "mz"})
    overview.has_wrench = overview.has_wrench || known.count(component) > 0;
  for (const std::string& header : table.columns())
    if (stated_of(header, overview) == nullptr && understood(header, joints).meaning.empty() &&
        is_mass(header))
      overview.weights.push_back(header);
  if (overview.has_wrench) return;
  for (const std::string& header : overview.weights)
    context.weights.push_back({.name = name_for_column(header), .per_kilogram = {}});
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

std::string lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(c < 128 ? std::tolower(c) : c); });
  return text;
}

using Words = std::vector<std::string>;
const Words of_date = {"date", "datum", "date of test", "test date", "messdatum"},
            of_operator = {"operator",     "measured by", "tested by", "bediener",
                           "gemessen von", "pr\u00fcfer", "pruefer",   "op\u00e9rateur"},
            of_instrument = {"instrument", "measuring instrument", "tracker", "messger\u00e4t",
                             "messmittel"},
            of_machine = {"machine serial",         "robot serial", "serial number of machine",
                          "serial number of robot", "machine s/n",  "robot s/n"},
            of_something = {"serial", "serial number", "serial no",  "serial no.",
                            "s/n",    "seriennummer",  "serien-nr.", "serien-nr"};

// What stands behind one of these words and a colon, or in the next cell; empty where nothing does.
std::string stated_above(const std::vector<std::vector<std::string>>& lines, const Words& words) {
  const auto is_word = [&](std::string_view text) {
    const std::size_t last = text.find_last_not_of(" :");
    return last != text.npos &&
           std::count(words.begin(), words.end(), lower(std::string(text.substr(0, last + 1)))) > 0;
  };
  for (const std::vector<std::string>& cells : lines)
    for (std::size_t k = 0; k < cells.size(); ++k) {
      const std::string cell = cells[k].substr(cells[k].starts_with('#') ? 1 : 0);
      const std::size_t start = cell.find_first_not_of(' '), colon = cell.find(':');
      if (start == cell.npos) continue;
      const std::size_t value =
          colon == cell.npos ? cell.npos : cell.find_first_not_of(' ', colon + 1);
      if (value != cell.npos && is_word(cell.substr(start, colon - start)))
        return cell.substr(value);
      if (k + 1 < cells.size() && is_word(cell.substr(start))) return cells[k + 1];
    }
  return {};
}

// A serial number without a machine beside it may be that of the instrument, where one is named.
Occasion occasion_above(const io::CsvTable& table) {
  const std::vector<std::vector<std::string>> lines = table.title();
  Occasion occasion{.date = iso_date(stated_above(lines, of_date)),
                    .measured_by = stated_above(lines, of_operator),
                    .measured_with = stated_above(lines, of_instrument),
                    .serial = stated_above(lines, of_machine)};
  if (occasion.serial.empty() && occasion.measured_with.empty())
    occasion.serial = stated_above(lines, of_something);
  return occasion;
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
                            .units = request.units,
                            .occasion = occasion_above(table)};
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
  propose_sensors(table, joints, overview);
  if (robot != nullptr)
    for (const SensorPlace& place : sensor_places(robot->manipulator))
      if (std::count(place.name.begin(), place.name.end(), '.') < 2)  // no masses of links
        overview.places.push_back(place.name);
  if (overview.sensors_only) take_as_read(joints, overview, campaign);
  ReadingsContext context{.sensor_sigma = Eigen::VectorXd::Constant(campaign.size(), not_a_number),
                          .angle_stated = true,
                          .time_stated = true};
  for (const auto& [header, meaning] : overview.stated)
    context.columns[header] = read_stated_column(meaning);
  propose_weights(table, joints, overview, context);
  Campaign looked_at = campaign;
  common::Faults of_columns;  // found again when all is read
  const ReadingsColumns columns = find_columns(table, context, manipulator, looked_at, of_columns);
  overview.needs_wrench_point =
      (columns.wrench[3] || columns.wrench[4] || columns.wrench[5]) && !columns.point[0];
  if (overview.needs_wrench_point)
    context.wrench.point = spatial::Vector3(spatial::Vector3::Zero());
  overview.columns =
      look_at_columns(table, columns, campaign.units, joints,
                      context.weights.empty() ? std::vector<std::string>() : overview.weights);
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

namespace {

std::string sensor_text(const ProposedSensor& sensor) {
  std::string text = fmt::format("{}: {{kind: {}", io::yaml_scalar(sensor.name), sensor.kind);
  if (!sensor.joint.empty()) return text + fmt::format(", joint: {}}}", sensor.joint);
  text += ", on: WHERE";
  if (sensor.kind == "gauge") {
    const char axis = sensor.axes.empty() ? 'z' : sensor.axes[0];
    text += fmt::format(", direction: [{}, {}, {}]}}  # the direction in which it counts up",
                        axis == 'x' ? 1 : 0, axis == 'y' ? 1 : 0, axis == 'z' ? 1 : 0);
  } else if (sensor.kind == "distance") {
    text += ", from: {on: base, at: [0, 0, 0]}}  # the other end";
  } else {
    std::vector<std::string> axes;
    for (const char axis : sensor.axes.empty() ? std::string("x") : sensor.axes)
      axes.emplace_back(1, axis);
    text += fmt::format(", axes: [{}]}}  # its own axes, as it is mounted", fmt::join(axes, ", "));
  }
  return text;
}

std::string weights_text(const ReadingsOverview& overview) {
  if (overview.weights.empty()) return {};
  std::vector<std::string> weights;
  for (const std::string& header : overview.weights)
    weights.push_back(
        fmt::format("{}: {{on: platform}}", io::yaml_scalar(name_for_column(header))));
  return fmt::format("{}weights: {{{}}}  # masses that hang there\n",
                     overview.has_wrench ? "# " : "", fmt::join(weights, ", "));
}

std::string sensors_text(const ReadingsOverview& overview) {
  if (overview.sensors.empty()) return {};
  const std::string lead = overview.sensors_only ? "" : "# ";
  std::string text =
      "# Columns that look like sensors elsewhere than at the platform: write "
      "instead of WHERE what carries each";
  if (!overview.places.empty()) {
    const std::size_t most = std::min<std::size_t>(overview.places.size(), 6);
    text += fmt::format(
        "\n# ({}{})",
        fmt::join(std::vector(overview.places.begin(),
                              overview.places.begin() + static_cast<std::ptrdiff_t>(most)),
                  ", "),
        most < overview.places.size() ? ", ..." : "");
  }
  text += fmt::format(", and 'noise: 2 um' where it is known.{}\n{}sensors:\n",
                      lead.empty() ? "" : " Then remove the '#'.", lead);
  std::vector<std::string> stated;
  for (const ProposedSensor& sensor : overview.sensors) {
    text += fmt::format("{}  {}\n", lead, sensor_text(sensor));
    for (std::size_t k = 0; k < sensor.columns.size(); ++k)
      if (split_header(sensor.columns[k]).name != column_of(sensor, k))
        stated.push_back(fmt::format("{}: {}", io::yaml_scalar(sensor.columns[k]),
                                     io::yaml_scalar(column_of(sensor, k))));
  }
  if (!overview.sensors_only && !stated.empty())
    text += fmt::format("# columns: {{{}}}\n", fmt::join(stated, ", "));
  return text;
}

}  // namespace

std::string campaign_text(const ReadingsOverview& overview, const std::string& name,
                          const std::string& robot, const std::string& readings,
                          const spatial::UnitSystem& units) {
  const auto unit = [&](const char* key, const std::string& otherwise) {
    return io::yaml_scalar(unit_or(overview.units, key, otherwise));
  };
  const bool absolute = overview.displacement == DisplacementKind::absolute;
  std::string occasion;
  for (const auto& [key, value] : overview.occasion.stated())
    occasion += fmt::format("{}: {}\n", key, io::yaml_scalar(value));
  std::string text = fmt::format(
      "kinetostat: 1\ncampaign: {}\n{}{}units: {{length: {}, force: {}, angle: {}, time: {}}}  # "
      "where "
      "a column names none\ndisplacement: {}\n",
      io::yaml_scalar(name), occasion,
      robot.empty() ? "" : "robot: " + io::yaml_scalar(robot) + "\n", unit("length", units.length),
      unit("force", units.force), unit("angle", units.angle), unit("time", units.time),
      absolute ? "absolute  # poses in the base frame" : "difference  # from the unloaded state");
  if (absolute) text += "# session_frame: estimate  # where the instrument stands elsewhere\n";
  if (overview.needs_wrench_point)
    text += "wrench_point: reference  # moments are about the reference point\n";
  std::vector<std::string> stated;
  for (const auto& [header, meaning] : overview.stated)
    stated.push_back(fmt::format("{}: {}", io::yaml_scalar(header), io::yaml_scalar(meaning)));
  if (!stated.empty()) text += fmt::format("columns: {{{}}}\n", fmt::join(stated, ", "));
  if (!overview.sheet.empty()) text += fmt::format("sheet: {}\n", io::yaml_scalar(overview.sheet));
  return text + weights_text(overview) + sensors_text(overview) +
         fmt::format("readings: {}\n", io::yaml_scalar(readings));
}

}  // namespace kinetostat::calibration
