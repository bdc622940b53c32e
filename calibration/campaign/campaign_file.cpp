#include "kinetostat/calibration/campaign/campaign_file.h"

#include <algorithm>
#include <cctype>
#include <cmath>

#include <fmt/format.h>

#include "kinetostat/calibration/campaign/clock_time.h"
#include "kinetostat/calibration/campaign/readings_file.h"
#include "kinetostat/calibration/campaign/sensor_file.h"
#include "kinetostat/common/error.h"
#include "kinetostat/common/faults.h"
#include "kinetostat/common/spelling.h"
#include "kinetostat/io/text_file.h"
#include "kinetostat/io/yaml.h"

namespace kinetostat::calibration {
namespace {

using io::YamlNode;
using spatial::Dimension;
namespace dimension = spatial::dimension;

// A text as a quoted YAML scalar where it holds what ends a plain one in braces: "fx [N]".
std::string quoted(std::string_view part) {
  const std::size_t first = part.find_first_not_of(" \t\r\n");
  if (first == std::string_view::npos) return std::string(part);
  const std::size_t last = part.find_last_not_of(" \t\r\n");
  const std::string_view core = part.substr(first, last + 1 - first);
  if (core.front() == '"' || core.front() == '\'' ||
      core.find_first_of("[]") == std::string_view::npos)
    return std::string(part);
  return fmt::format("{}\"{}\"{}", part.substr(0, first), core, part.substr(last + 1));
}

// `columns: {Fx [N]: fx, Kraft X: fx [N]}` as people write it is no YAML: names with a bracket
// want quotes within braces. Lines stay where they are.
std::string with_quoted_columns(std::string text) {
  const std::size_t key = text.starts_with("columns:") ? 0 : text.find("\ncolumns:");
  if (key == std::string::npos) return text;
  const std::size_t open = text.find_first_not_of(" \t\n", text.find(':', key) + 1);
  if (open == std::string::npos || text[open] != '{') return text;
  std::string result = text.substr(0, open + 1);
  std::size_t begin = open + 1, at = begin;
  char quote = 0;
  int depth = 0;
  for (; at < text.size(); ++at) {
    const char c = text[at];
    if (quote != 0) {
      if (c == quote) quote = 0;
      continue;
    }
    const std::size_t core = text.find_first_not_of(" \t\r\n", begin);
    if ((c == '"' || c == '\'') && at == core) quote = c;
    if (c == '[' || c == '(') ++depth;
    if (c == ']' || c == ')') --depth;
    const bool colon = c == ':' && at + 1 < text.size() && std::isspace(text[at + 1]) != 0;
    if (depth > 0 || !(colon || c == ',' || c == '}')) continue;
    result += quoted(std::string_view(text).substr(begin, at - begin)) + c;
    begin = at + 1;
    if (c == '}') break;
  }
  return result + text.substr(std::min(begin, text.size()));
}

// One byte more than parse_yaml() takes tells that there is more.
constexpr std::size_t most_read = (std::size_t{16} << 20) + 1;

YamlNode read_top(const std::filesystem::path& file) {
  YamlNode top = io::parse_yaml(with_quoted_columns(io::read_start(file, most_read)), file);
  io::check_format_version(top);
  top.allow_only({"kinetostat",    "campaign",     "origin",
                  "robot",         "posture",      "units",
                  "displacement",  "zero",         "datum_noise",
                  "session_frame", "frames",       "displacement_frame",
                  "target_point",  "wrench_frame", "wrench_point",
                  "wrench_noise",  "known_loads",  "noise",
                  "instruments",   "instrument",   "roles",
                  "columns",       "missing",      "decimal",
                  "sheet",         "readings",     "sensors",
                  "weights",       "target_pose",  "cylinders",
                  "torques",       "history",      "displacement_control",
                  "repeatability", "date",         "operator",
                  "serial"});
  return top;
}

double read_deviation(const YamlNode& node, const Dimension& dimension) {
  const double value = node.quantity_with_unit(dimension);
  if (!(value > 0))
    node.fail("'" + node.text() + "' is not positive",
              "Give the standard deviation of one reading, or remove the key when it is not known");
  return value;
}

// One standard deviation for all three axes, or a list of three.
void read_deviations(const YamlNode& node, const Dimension& dimension,
                     Eigen::Ref<spatial::Vector3> noise) {
  if (node.is_scalar()) {
    noise.setConstant(read_deviation(node, dimension));
    return;
  }
  Eigen::Index i = 0;
  for (const YamlNode& item : node.items(3)) noise[i++] = read_deviation(item, dimension);
}

// `correlation: {dx_dz: 0.3}` between components.
spatial::Matrix6 read_correlation(const YamlNode& node) {
  spatial::Matrix6 matrix = spatial::Matrix6::Identity();
  std::vector<std::string> names;
  for (Eigen::Index i = 0; i < 6; ++i)
    for (Eigen::Index j = i + 1; j < 6; ++j) names.push_back(correlation_name(i, j));
  node.allow_only(names);
  for (Eigen::Index i = 0; i < 6; ++i)
    for (Eigen::Index j = i + 1; j < 6; ++j)
      if (const auto given = node.find(correlation_name(i, j)))
        matrix(i, j) = matrix(j, i) = given->number();
  if (!is_correlation(matrix))
    node.fail("these correlations are not possible together",
              "Each lies between -1 and 1, and their matrix is positive definite");
  return matrix;
}

Instrument read_instrument(const YamlNode& node) {
  node.allow_only({"translation", "rotation", "correlation"});
  Instrument instrument;
  if (const auto given = node.find("translation"))
    read_deviations(*given, dimension::length, instrument.sigma.head<3>());
  if (const auto given = node.find("rotation"))
    read_deviations(*given, dimension::angle, instrument.sigma.tail<3>());
  if (const auto given = node.find("correlation"))
    instrument.correlation = read_correlation(*given);
  return instrument;
}

std::map<std::string, Instrument> read_instruments(const YamlNode& top) {
  std::map<std::string, Instrument> instruments;
  if (const auto given = top.find("instruments"))
    for (const auto& [name, node] : given->members())
      instruments.emplace(name, read_instrument(node));
  if (const auto given = top.find("noise")) instruments[""] = read_instrument(*given);
  // Where none is described, it is only a name.
  if (const auto given = top.find("instrument"); given && top.has("instruments")) {
    if (top.has("noise"))
      given->fail("'noise' and 'instrument' both say how exact the readings are", "Keep one");
    std::vector<std::string> names;
    names.reserve(instruments.size());
    for (const auto& [name, instrument] : instruments) names.push_back(name);
    instruments[""] = instruments.at(given->choice(names));
  }
  return instruments;
}

std::string read_line(const YamlNode& top, const char* key) {
  const auto given = top.find(key);
  if (!given) return {};
  std::string text = given->text();
  if (text.find_first_not_of(" \t\r\n") == std::string::npos)
    given->fail("nothing is stated", "Write it behind the key, or remove the key");
  if (text.find_first_of("\r\n") != std::string::npos)
    given->fail("this has several lines", "Write it in one line");
  return text;
}

std::string read_date(const YamlNode& top) {
  std::string text = read_line(top, "date");
  if (text.empty() || iso_date(text) == text.substr(0, 10)) return text;
  const std::string meant = iso_date(text);
  top.at("date").fail(fmt::format("'{}' is not a date of ISO 8601", text),
                      meant.empty()
                          ? "Write year, month and day, 2026-03-01, or with a time 2026-03-01T14:22"
                          : fmt::format("Write {}", meant));
}

Occasion read_occasion(const YamlNode& top) {
  return {.date = read_date(top),
          .measured_by = read_line(top, "operator"),
          .measured_with = read_line(top, "instrument"),
          .serial = read_line(top, "serial")};
}

// A frame that the campaign file names: where it stands, on what.
struct NamedFrame {
  bool on_platform = false;
  spatial::Pose pose;
};

std::map<std::string, NamedFrame> read_frames(const YamlNode& top,
                                              const spatial::UnitSystem& units) {
  std::map<std::string, NamedFrame> frames = {{"base", {}}, {"platform", {true, {}}}};
  if (const auto given = top.find("frames"))
    for (const auto& [name, node] : given->members()) {
      if (frames.count(name) > 0)
        node.fail(fmt::format("the frame '{}' needs no description", name), "Choose another name");
      node.allow_only({"on", "pose"});
      frames[name] = {node.at("on").choice({"base", "platform"}) == "platform",
                      io::read_pose(node.at("pose"), units)};
    }
  return frames;
}

std::optional<NamedFrame> read_frame(const YamlNode& top, const std::string& key,
                                     const std::map<std::string, NamedFrame>& frames) {
  const auto given = top.find(key);
  if (!given) return std::nullopt;
  std::vector<std::string> names;
  names.reserve(frames.size());
  for (const auto& [name, frame] : frames) names.push_back(name);
  return frames.at(given->choice(names));
}

Observation read_observation(const YamlNode& top, const std::map<std::string, NamedFrame>& frames,
                             const Campaign& campaign) {
  Observation observation;
  if (const auto frame = read_frame(top, "displacement_frame", frames)) {
    const YamlNode node = top.at("displacement_frame");
    if (frame->on_platform && campaign.displacement == DisplacementKind::absolute)
      node.fail("absolute poses cannot be given in a frame that moves with the platform",
                "Name a frame on the base, or measure differences");
    if (frame->on_platform && frame->pose.rotation() != spatial::Matrix3::Identity())
      node.fail("differences can be given in the platform's own axes, not in turned ones",
                "Write 'displacement_frame: platform', or turn the readings");
    observation.platform_axes = frame->on_platform;
    if (!frame->on_platform) observation.frame = frame->pose;
  }
  if (const auto target = top.find("target_point"))
    observation.target = target->vector3(dimension::length, campaign.units);
  return observation;
}

// What the wrenches of the readings are given in.
WrenchFrame read_wrench_frame(const YamlNode& top, const std::map<std::string, NamedFrame>& frames,
                              const spatial::UnitSystem& units) {
  WrenchFrame result;
  if (const auto frame = read_frame(top, "wrench_frame", frames)) {
    result.on_platform = frame->on_platform;
    result.axes = frame->pose.rotation();
    const std::string name = top.at("wrench_frame").text();
    if (name != "base" && name != "platform") result.origin = frame->pose.position();
  }
  const auto point = top.find("wrench_point");
  if (!point) return result;
  result.origin.reset();
  result.point = spatial::Vector3(spatial::Vector3::Zero());
  if (point->is_scalar())
    point->choice({"reference"});
  else
    result.point = point->vector3(dimension::length, units);
  return result;
}

// `wrench_noise: {force: 2 N, moment: 0.1 N m, share: 0.5 %}`.
WrenchNoise read_wrench_noise(const YamlNode& top) {
  WrenchNoise noise;
  const auto given = top.find("wrench_noise");
  if (!given) return noise;
  given->allow_only({"force", "moment", "share"});
  if (const auto force = given->find("force"))
    noise.force = read_deviation(*force, dimension::force);
  if (const auto moment = given->find("moment"))
    noise.moment = read_deviation(*moment, dimension::moment);
  if (const auto share = given->find("share")) {
    noise.share = read_deviation(*share, dimension::none);
    if (noise.share > 0.5)
      share->fail(fmt::format("'{}' is more than half of what the load cell reads", share->text()),
                  "Give the standard deviation as a share of the reading: 0.5 %");
  }
  if (!noise.is_stated())
    given->fail("nothing is stated",
                "Give the standard deviation of a component: 'force: 2 N', 'moment: 0.1 N m', or "
                "'share: 0.5 %' of what it reads");
  return noise;
}

// `{translation: 5 um, rotation: 10 urad}`, errors that readings share; 0 um: exact.
void read_shared_noise(const YamlNode& given, Campaign& campaign) {
  given.allow_only({"translation", "rotation"});
  const auto read = [&](const char* key, const Dimension& dimension, Eigen::Index first) {
    const auto node = given.find(key);
    if (!node) return;
    const double value = node->quantity_with_unit(dimension);
    if (!(value >= 0))
      node->fail("'" + node->text() + "' is negative",
                 "Give the standard deviation, 0 where it is exact");
    campaign.datum_noise.segment<3>(first).setConstant(value);
  };
  read("translation", dimension::length, 0);
  read("rotation", dimension::angle, 3);
}

// Where the drives of a robot stop each time.
void read_repeatability(const YamlNode& top, Campaign& campaign) {
  const auto given = top.find("repeatability");
  if (!given) return;
  if (campaign.displacement != DisplacementKind::absolute)
    given->fail("differences count from a reading where the drives stopped, which cancels",
                "Remove the key: it is for 'displacement: absolute'");
  if (!given->is_map())
    given->fail("how exactly the drives stop is stated for translations and rotations",
                "Write 'repeatability: {translation: 20 um, rotation: 50 urad}'");
  read_shared_noise(*given, campaign);
}

// `0` alone: all of them are exact.
void read_datum_noise(const YamlNode& top, Campaign& campaign) {
  const auto given = top.find("datum_noise");
  if (!given) return;
  if (is_all_exact(*given)) {
    campaign.datum_noise.setZero();
    return;
  }
  if (!given->is_map())
    given->fail("the noise of the unloaded readings is stated for translations and rotations",
                "Write 'datum_noise: {translation: 5 um, rotation: 10 urad}', or 0 where all of "
                "them are exact");
  read_shared_noise(*given, campaign);
  const bool is_read =
      campaign.displacement == DisplacementKind::difference && campaign.zero == ZeroReading::known;
  if (!is_read && (campaign.datum_noise.array() > 0).any())
    given->fail("no unloaded reading is there whose noise it could be",
                campaign.displacement == DisplacementKind::absolute
                    ? "State 'repeatability' where the drives of a robot stop a little elsewhere "
                      "each time"
                    : "Remove the key: it is for 'displacement: difference' with 'zero: known'");
}

// Noise of the wrench adds to that of the displacement, which must then be known by itself.
void check_wrench_noise(const YamlNode& top, const Campaign& campaign) {
  if (campaign.wrench_covariance.empty() || campaign.noise_stated) return;
  top.at("wrench_noise")
      .fail("the noise of the wrenches adds to that of the displacements, which is not stated",
            "State 'noise: {translation: ...}' as well, or remove 'wrench_noise': the scatter of "
            "repeated readings holds both");
}

void check_datum_noise(const YamlNode& top, const Campaign& campaign) {
  if (campaign.noise_stated || !(campaign.datum_noise.array() > 0).any()) return;
  const bool of_poses = campaign.displacement == DisplacementKind::absolute;
  top.at(of_poses ? "repeatability" : "datum_noise")
      .fail(of_poses
                ? "how exactly the drives stop is stated, and the noise of a reading is not"
                : "the noise of the unloaded readings is stated, and that of the others is not",
            "State 'noise: {translation: ...}' as well, or remove the key");
}

std::map<std::string, Role> read_roles(const YamlNode& top) {
  std::map<std::string, Role> roles;
  if (const auto given = top.find("roles"))
    for (const auto& [session, node] : given->members())
      roles[session] = role_named(node.choice({role_names.begin(), role_names.end()}));
  return roles;
}

// `columns: {Kraft X: fx [N], Gauge 2: -dz, Remark: covariate}`.
std::map<std::string, StatedColumn> read_columns(const YamlNode& top) {
  std::map<std::string, StatedColumn> columns;
  const auto given = top.find("columns");
  if (!given) return columns;
  for (const auto& [header, node] : given->members()) {
    StatedColumn& column = columns[header] = read_stated_column(node.text());
    column.line = node.line();
    if (column.meaning.empty() && node.text() != "covariate" && node.text() != "ignore")
      node.fail("'" + node.text() + "' has no name", "Write what the column means: 'fx [N]'");
  }
  return columns;
}

// `missing: n.m.` or `missing: [-999, n.m.]`; `decimal: comma`; `sheet: Messung`.
io::TableFormat read_table_format(const YamlNode& top) {
  io::TableFormat format;
  if (const auto missing = top.find("missing")) {
    if (missing->is_scalar())
      format.missing.push_back(missing->text());
    else
      for (const YamlNode& word : missing->items()) format.missing.push_back(word.text());
  }
  if (const auto decimal = top.find("decimal"))
    format.decimal = decimal->choice({"point", "comma"}) == "comma" ? io::DecimalSign::comma
                                                                    : io::DecimalSign::point;
  if (const auto sheet = top.find("sheet")) format.sheet = sheet->text();
  return format;
}

PostureColumns read_posture(const YamlNode& top) {
  const auto given = top.find("posture");
  if (!given) return PostureColumns::unstated;
  return given->choice({"platform", "joints"}) == "joints" ? PostureColumns::joints
                                                           : PostureColumns::platform;
}

// A session that no reading belongs to is a slip.
void require_session(const YamlNode& node, const std::string& session, const Campaign& campaign) {
  if (std::binary_search(campaign.sessions.begin(), campaign.sessions.end(), session)) return;
  const std::string near = common::nearest_spelling(session, campaign.sessions);
  node.fail(fmt::format("no reading belongs to a session '{}'", session),
            near.empty() ? "Write a name of the column 'session'"
                         : fmt::format("Did you mean '{}'?", near));
}

void check_roles(const YamlNode& top, const std::map<std::string, Role>& roles,
                 const Campaign& campaign) {
  for (const auto& [session, role] : roles)
    require_session(top.at("roles").at(session), session, campaign);
  if (!has_role(campaign, Role::fit))
    throw common::InputError(
        {.file = campaign.file,
         .line = top.has("roles") ? top.at("roles").line() : 0,
         .key = "roles",
         .what = "no reading is left to fit by: all are masked, to select or to confirm",
         .cure = "Give at least one session or pose the role 'fit'"});
}

// Sessions whose loads were weights: exact, and no load cell has a part in them.
void read_known_loads(const YamlNode& top, Campaign& campaign) {
  const auto given = top.find("known_loads");
  if (!given) return;
  for (const YamlNode& node : given->items()) {
    const std::string session = node.text();
    require_session(node, session, campaign);
    for (std::size_t i = 0; i < campaign.readings.size(); ++i) {
      Reading& reading = campaign.readings[i];
      if (campaign.sessions[reading.session] != session) continue;
      reading.known_load = true;
      if (!campaign.wrench_covariance.empty()) campaign.wrench_covariance[i].setZero();
    }
  }
}

}  // namespace

std::optional<std::filesystem::path> robot_named_in(const std::filesystem::path& campaign) {
  const YamlNode top = read_top(campaign);
  const auto robot = top.find("robot");
  if (!robot) return std::nullopt;
  return robot->existing_file();
}

namespace {

ReadingsContext read_stated(const YamlNode& top, const vjm::Manipulator& manipulator,
                            Campaign& campaign) {
  const YamlNode units = top.at("units");
  campaign.file = top.file();
  campaign.name = top.at("campaign").text();
  campaign.occasion = read_occasion(top);
  if (const auto robot = top.find("robot")) campaign.robot = robot->text();
  campaign.units = io::read_units(units);
  if (top.at("displacement").choice({"difference", "absolute"}) == "absolute")
    campaign.displacement = DisplacementKind::absolute;
  if (const auto zero = top.find("zero"); zero && zero->choice({"known", "estimate"}) == "estimate")
    campaign.zero = ZeroReading::estimated;
  read_datum_noise(top, campaign);
  read_repeatability(top, campaign);
  if (const auto frame = top.find("session_frame");
      frame && frame->choice({"known", "estimate"}) == "estimate")
    campaign.session_frame = SessionFrame::estimated;
  if (const auto history = top.find("history"))
    campaign.history_continues = history->choice({"starts", "continues"}) == "continues";
  if (const auto target = top.find("target_pose");
      target && target->choice({"known", "estimate"}) == "estimate")
    campaign.target_pose = TargetPose::estimated;
  campaign.readings_file = top.at("readings").existing_file();
  const auto frames = read_frames(top, campaign.units);
  campaign.observation = read_observation(top, frames, campaign);
  Eigen::VectorXd sensor_sigma = read_sensors(top, manipulator, campaign);
  const std::size_t controlled = read_control(top, campaign, sensor_sigma);
  return {.sensor_sigma = sensor_sigma,
          .weights = read_weights(top, manipulator, campaign),
          .cylinders = read_cylinders(top, manipulator, campaign),
          .torques = read_torques(top, manipulator, campaign),
          .instruments = read_instruments(top),
          .wrench = read_wrench_frame(top, frames, campaign.units),
          .wrench_noise = read_wrench_noise(top),
          .controlled = controlled,
          .roles = read_roles(top),
          .posture = read_posture(top),
          .columns = read_columns(top),
          .table = read_table_format(top),
          .units_line = units.line(),
          .angle_stated = units.has("angle"),
          .time_stated = units.has("time")};
}

}  // namespace

ReadingsContext read_context(const std::filesystem::path& file, const vjm::Manipulator& manipulator,
                             Campaign& campaign) {
  return read_stated(read_top(file), manipulator, campaign);
}

void read_known_loads(const std::filesystem::path& file, Campaign& campaign) {
  read_known_loads(read_top(file), campaign);
}

Campaign read_campaign(const std::filesystem::path& file, const vjm::Manipulator& manipulator) {
  const YamlNode top = read_top(file);
  Campaign campaign;
  const ReadingsContext context = read_stated(top, manipulator, campaign);
  common::Faults faults;
  const io::CsvTable table = io::read_table(campaign.readings_file, context.table, &faults);
  read_readings(table, context, manipulator, campaign, std::move(faults));
  if (campaign.target_pose == TargetPose::estimated && !campaign.reads_platform())
    top.at("target_pose")
        .fail(
            "no reading is of the platform, so that no target on it is seen",
            "Remove the key; a sensor says where it looks by its 'at', or 'target_pose: estimate'");
  check_roles(top, context.roles, campaign);
  check_wrench_noise(top, campaign);
  check_datum_noise(top, campaign);
  read_known_loads(top, campaign);
  return campaign;
}

}  // namespace kinetostat::calibration
