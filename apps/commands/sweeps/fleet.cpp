// kinetostat fleet: many robots, or one robot over years, against control limits.
#include "kinetostat/report/screen/fleet.h"

#include <algorithm>
#include <cctype>
#include <chrono>
#include <memory>

#include <fmt/format.h>

#include "kinetostat/apps/cli/command.h"
#include "kinetostat/apps/commands/commands.h"
#include "kinetostat/io/text_file.h"
#include "kinetostat/io/yaml.h"
#include "kinetostat/report/diagnosis_file.h"
#include "kinetostat/report/screen/wording.h"

namespace kinetostat::apps {
namespace {

namespace fs = std::filesystem;
using report::FleetMember;

struct FleetRequest {
  std::vector<std::string> files;
  std::size_t baseline = 0;
};

struct MemberList {
  std::string name = "robots";
  std::vector<FleetMember> members;
};

bool is_json(const fs::path& file) { return file.extension() == ".json"; }

// "2026-05-02", as any order of texts puts it.
bool is_date(const std::string& text) {
  constexpr const char* form = "0000-00-00";
  if (text.size() != 10) return false;
  for (std::size_t i = 0; i < text.size(); ++i)
    if (form[i] == '0' ? std::isdigit(static_cast<unsigned char>(text[i])) == 0
                       : text[i] != form[i])
      return false;
  const auto number = [&text](std::size_t at, std::size_t count) {
    return std::stoi(text.substr(at, count));
  };
  return std::chrono::year_month_day(std::chrono::year(number(0, 4)),
                                     std::chrono::month(static_cast<unsigned>(number(5, 2))),
                                     std::chrono::day(static_cast<unsigned>(number(8, 2))))
      .ok();
}

std::string text_in(const io::Json& json, const char* key) {
  return json.is_object() && json.contains(key) && json[key].is_string()
             ? json[key].get<std::string>()
             : std::string();
}

// What the diagnosis of a campaign says of its robot, where nobody else does.
void take_campaign(const io::Json& json, FleetMember& member) {
  for (const io::Json& part : {json, json.value("campaign", io::Json())}) {
    if (member.serial.empty()) member.serial = text_in(part, "serial");
    if (member.date.empty()) member.date = text_in(part, "date");
  }
}

void read_member(const fs::path& file, FleetMember& member) {
  member.file = file.string();
  if (is_json(file)) {
    const io::Json json = io::read_json(file);
    member.values = report::fleet_values(report::diagnosis_record(json, file));
    take_campaign(json, member);
  } else {
    member.values = report::fleet_values(vjm::read_robot(file));
  }
  if (member.serial.empty()) member.serial = file.stem().string();
}

FleetMember listed_member(const io::YamlNode& item, const fs::path& folder) {
  item.allow_only({"serial", "date", "file"});
  FleetMember member;
  if (const auto serial = item.find("serial")) member.serial = serial->text();
  if (const auto date = item.find("date")) {
    member.date = date->text();
    if (!is_date(member.date)) date->fail("this is no date", "Write year, month, day: 2026-05-02");
  }
  const io::YamlNode file = item.at("file");
  read_member(folder / file.text(), member);
  return member;
}

MemberList read_list(const fs::path& file) {
  const io::YamlNode top = io::read_yaml(file);
  top.allow_only({"kinetostat", "fleet", "robots"});
  io::check_format_version(top);
  MemberList list{.name = top.at("fleet").text(), .members = {}};
  for (const io::YamlNode& item : top.at("robots").items())
    list.members.push_back(listed_member(item, file.parent_path()));
  if (list.members.empty())
    top.at("robots").fail("the list is empty",
                          "Write a line '- {serial: A1, date: 2026-05-02, "
                          "file: a1.json}' for each robot");
  return list;
}

bool is_list(const fs::path& file) { return !is_json(file) && io::read_yaml(file).has("fleet"); }

MemberList read_fleet(const std::vector<std::string>& files) {
  if (files.size() == 1 && is_list(files.front())) return read_list(files.front());
  MemberList list;
  for (const std::string& file : files) {
    list.members.emplace_back();
    read_member(file, list.members.back());
  }
  return list;
}

io::Json fleet(const FleetRequest& request, Run& run) {
  if (request.baseline == 1 || request.baseline == 2)
    throw UsageError("--baseline", "one or two values say too little of how others spread",
                     "Give 3 or more");
  MemberList list = read_fleet(request.files);
  if (request.baseline > list.members.size())
    throw UsageError("--baseline", fmt::format("there are {} values", list.members.size()),
                     "Give at most so many");
  const report::Fleet found =
      report::make_fleet(std::move(list.name), std::move(list.members), request.baseline);
  run.print(report::wrapped(headline(found)) + "\n" + text(found));
  io::Json json{{"headline", headline(found)}};
  json.update(to_json(found));
  return json;
}

}  // namespace

void add_fleet(Program& program) {
  const auto request = std::make_shared<FleetRequest>();
  OptionList app =
      program.add({.name = "fleet",
                   .summary = "Many robots, or one over years: values outside their control limits",
                   .example = "kinetostat fleet data/fleet/fleet.yaml --html fleet.html"},
                  [request](Run& run) { return fleet(*request, run); });
  app.add_option("FILES", request->files,
                 "What 'diagnose -o' or 'adopt -o' wrote of each; or one list: fleet, robots with "
                 "serial, date and file")
      .required();
  app.add_option("--baseline", request->baseline,
                 "Limits from the first N values, when all was well; from all unless given")
      .type_name("N");
}

}  // namespace kinetostat::apps
