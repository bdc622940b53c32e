#include "kinetostat/apps/studio/studio_files.h"

#include <algorithm>
#include <optional>

#include <fmt/format.h>

#include "kinetostat/calibration/campaign/column_names.h"
#include "kinetostat/calibration/campaign/readings_overview.h"
#include "kinetostat/common/error.h"
#include "kinetostat/io/base64.h"
#include "kinetostat/io/document_kind.h"
#include "kinetostat/io/text_file.h"
#include "kinetostat/report/readings_overview.h"
#include "kinetostat/spatial/units.h"
#include "kinetostat/vjm/io/robot_file.h"

namespace kinetostat::apps {
namespace {

using calibration::ReadingsOverview;
using io::Json;

constexpr std::size_t longest_name = 100, most_numbers = 100;

bool is_plain(unsigned char c) {
  return c < 128 && (std::isalnum(c) != 0 || c == '-' || c == '_' || c == '.');
}

// What is not plain becomes '_'.
std::string plain_name(std::string name) {
  name = name.substr(name.find_last_of("/\\") + 1);
  std::replace_if(
      name.begin(), name.end(), [](unsigned char c) { return !is_plain(c); }, '_');
  if (name.size() > longest_name - 4) name.erase(0, name.size() - (longest_name - 4));
  if (name.empty() || name.front() == '.') name.insert(0, "file");
  return name;
}

std::string text_at(const Json& request, const char* key) {
  const Json value = request.value(key, Json());
  if (value.is_null()) return {};
  if (!value.is_string()) throw common::InputError(key, "is not a text");
  return value.get<std::string>();
}

std::map<std::string, std::string> texts_at(const Json& request, const char* key) {
  const Json value = request.value(key, Json::object());
  std::map<std::string, std::string> texts;
  if (!value.is_object()) throw common::InputError(key, "is not a set of texts");
  for (const auto& [name, text] : value.items()) {
    if (!text.is_string()) throw common::InputError(key, "is not a set of texts");
    if (!text.get<std::string>().empty()) texts[name] = text.get<std::string>();
  }
  return texts;
}

void require_units(const std::map<std::string, std::string>& units) {
  for (const auto& [name, unit] : units) try {
      spatial::parse_unit(unit);
    } catch (const std::invalid_argument& error) {
      throw common::InputError("units", error.what(), "Write mm, um, N, deg, s");
    }
}

std::optional<vjm::Robot> robot_of(const StudioFiles& files, const Json& request) {
  const std::string name = text_at(request, "robot");
  if (name.empty()) return std::nullopt;
  return vjm::read_robot(files.file(name));
}

ReadingsOverview overview_of(const StudioFiles& files, const Json& request,
                             const std::optional<vjm::Robot>& robot) {
  calibration::ReadingsRequest asked{.table = files.file(text_at(request, "table")),
                                     .columns = texts_at(request, "columns"),
                                     .units = texts_at(request, "units"),
                                     .sheet = text_at(request, "sheet")};
  require_units(asked.units);
  if (const std::string kind = text_at(request, "displacement"); !kind.empty())
    asked.displacement = kind == "absolute" ? calibration::DisplacementKind::absolute
                                            : calibration::DisplacementKind::difference;
  return calibration::look_at_readings(asked, robot ? &*robot : nullptr);
}

Json meanings(const std::optional<vjm::Robot>& robot) {
  Json list = Json::array({"covariate"});
  for (const char* name :
       {"dx",   "dy",        "dz",        "rx",   "ry",          "rz",      "fx",
        "fy",   "fz",        "mx",        "my",   "mz",          "x",       "y",
        "z",    "roll",      "pitch",     "yaw",  "id",          "session", "cycle",
        "step", "direction", "replicate", "time", "temperature", "setting", "mask"})
    list.push_back(name);
  if (robot)
    for (const calibration::Joint& joint : calibration::joints_of(robot->manipulator))
      if (joint.actuated) list.push_back(joint.column());
  return list;
}

}  // namespace

bool is_plain_name(const std::string& name) {
  return !name.empty() && name.size() <= longest_name && name.front() != '.' &&
         std::all_of(name.begin(), name.end(), is_plain);
}

std::filesystem::path StudioFiles::file(const std::string& name) const {
  std::filesystem::path file = folder_ / name;
  std::error_code ignored;
  if (!is_plain_name(name) || std::filesystem::is_symlink(file, ignored))
    throw common::InputError("file", "is not the plain name of a file of the folder",
                             "Drop the file onto the page");
  return file;
}

Json StudioFiles::list() const {
  Json robots = Json::array(), campaigns = Json::array(), tables = Json::array();
  std::vector<std::string> names;
  std::error_code ignored;
  for (const auto& entry : std::filesystem::directory_iterator(folder_, ignored))
    if (entry.is_regular_file(ignored) && !entry.is_symlink(ignored) &&
        is_plain_name(entry.path().filename().string()))
      names.push_back(entry.path().filename().string());
  std::sort(names.begin(), names.end());
  for (const std::string& name : names) {
    const io::DocumentKind kind = io::document_kind(folder_ / name);
    if (kind == io::DocumentKind::robot) robots.push_back(name);
    if (kind == io::DocumentKind::campaign) campaigns.push_back(name);
    if (kind == io::DocumentKind::table) tables.push_back(name);
  }
  return {{"robots", robots}, {"campaigns", campaigns}, {"tables", tables}};
}

std::string StudioFiles::write_new(const std::string& name, const std::string& content) {
  const std::filesystem::path stem = std::filesystem::path(name).stem(),
                              extension = std::filesystem::path(name).extension();
  for (std::size_t k = 1; k <= most_numbers; ++k) {
    std::string numbered =
        k == 1 ? name : fmt::format("{}-{}{}", stem.string(), k, extension.string());
    if (io::write_in_place_of(io::Replace::nothing, folder_ / numbered, content)) return numbered;
    std::error_code ignored;
    if (std::filesystem::is_regular_file(std::filesystem::symlink_status(folder_ / numbered)) &&
        io::read_text(folder_ / numbered) == content)
      return numbered;
  }
  throw common::InputError(name, "is there already, and so are its numbered names");
}

Json StudioFiles::drop(const Json& request) {
  const auto content = io::from_base64(text_at(request, "content"));
  if (!content) throw common::InputError("content", "is not base64");
  const std::string name = write_new(plain_name(text_at(request, "name")), *content);
  return {{"file", name}, {"kind", io::words_for(io::document_kind(folder_ / name))}};
}

Json StudioFiles::look(const Json& request) const {
  const std::optional<vjm::Robot> robot = robot_of(*this, request);
  const ReadingsOverview overview = overview_of(*this, request, robot);
  Json json = report::readings_json(overview);
  for (std::size_t k = 0; k < overview.columns.size(); ++k)
    json["columns"][k]["words"] = overview.columns[k].words;
  json["meanings"] = meanings(robot);
  return json;
}

Json StudioFiles::use(const Json& request) {
  const std::optional<vjm::Robot> robot = robot_of(*this, request);
  if (!robot) throw common::InputError("robot", "is missing", "Drop a robot file, too");
  const ReadingsOverview overview = overview_of(*this, request, robot);
  if (!overview.mistakes.empty())
    throw common::InputError(overview.table, overview.mistakes.front().what,
                             overview.mistakes.front().cure);
  std::string text = calibration::campaign_text(overview, overview.table.stem().string(),
                                                text_at(request, "robot"),
                                                overview.table.filename().string(), robot->units);
  if (const std::string noise = text_at(request, "noise"); !noise.empty()) {
    try {
      spatial::parse_quantity(noise, spatial::dimension::length);
    } catch (const std::invalid_argument& error) {
      throw common::InputError("noise", error.what(), "Write 2 um");
    }
    text += fmt::format("noise: {{translation: {}}}\n", noise);
  }
  return {{"campaign", write_new(overview.table.stem().string() + ".yaml", text)}};
}

}  // namespace kinetostat::apps
