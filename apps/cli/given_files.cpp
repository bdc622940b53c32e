#include "kinetostat/apps/cli/given_files.h"

#include <algorithm>
#include <array>
#include <optional>
#include <string_view>

#include <fmt/format.h>

#include "kinetostat/io/document_kind.h"
#include "kinetostat/io/text_file.h"
#include "kinetostat/io/yaml.h"
#include "kinetostat/io/yaml_change.h"

namespace kinetostat::apps {
namespace {

using io::DocumentKind;
using Kinds = std::vector<DocumentKind>;

// What the positional arguments of a command are, in their order; the last stands for those after
// it.
struct Wanted {
  const char* command;
  std::vector<Kinds> places;
  bool takes_robot_alone = false;  // where a campaign may stand in its place; after a table, too
};

const Kinds robot = {DocumentKind::robot};
// The robot file may be left out where the campaign names it.
const Kinds robot_or_campaign = {DocumentKind::robot, DocumentKind::campaign};
const Kinds campaign = {DocumentKind::campaign};

const std::vector<Wanted>& all_wanted() {
  static const std::vector<Wanted> all = {
      {"export", {robot}},
      {"stiffness", {robot}},
      {"deflect", {robot}},
      {"trace", {robot}},
      {"assemble", {robot}},
      {"map", {robot}},
      {"compensate", {robot}},
      {"simulate", {robot}},
      {"revert", {robot}},
      {"effect list", {robot}},
      {"measure check", {robot_or_campaign, campaign}},
      {"compare", {robot_or_campaign, campaign}},
      {"calibrate", {robot_or_campaign, campaign}},
      {"diagnose", {robot_or_campaign, campaign}},
      {"plan", {robot_or_campaign, campaign}},
      {"study",
       {{DocumentKind::robot, DocumentKind::campaign, DocumentKind::table},
        {DocumentKind::campaign, DocumentKind::table}},
       true},
      {"adopt", {robot, {DocumentKind::diagnosis}}},
      {"identify", {{DocumentKind::link}}},
      {"beam", {{DocumentKind::link}}},
      {"modes", {{DocumentKind::link, DocumentKind::robot}}},
      {"mesh check", {{DocumentKind::mesh}}},
      {"import", {{DocumentKind::description, DocumentKind::table}}},
      {"readings", {{DocumentKind::table, DocumentKind::campaign}, robot}},
  };
  return all;
}

// The command for a file of this kind.
std::string command_for(DocumentKind kind, const std::string& file) {
  switch (kind) {
    case DocumentKind::mesh:
      return fmt::format(
          "'kinetostat mesh check {} --unit mm' looks at it; 'kinetostat identify' "
          "finds its stiffness from a link file that names it",
          file);
    case DocumentKind::description:
      return fmt::format("'kinetostat import {} -o robot.yaml' makes a robot file of it", file);
    case DocumentKind::table:
      return fmt::format(
          "'kinetostat readings {} -o campaign.yaml' shows how it is understood and "
          "writes a campaign file",
          file);
    case DocumentKind::robot:
      return fmt::format(
          "'kinetostat stiffness {}' takes it; 'kinetostat compare {} "
          "campaign.yaml' compares it with readings",
          file, file);
    case DocumentKind::campaign:
      return fmt::format(
          "'kinetostat compare {}' takes it, with the robot file before it where it "
          "names none",
          file);
    case DocumentKind::link:
      return fmt::format("'kinetostat identify {}' takes it", file);
    case DocumentKind::link_result:
      return fmt::format(
          "A robot file names it under 'links'; 'kinetostat report {} -o page.html' "
          "shows it",
          file);
    case DocumentKind::diagnosis:
      return fmt::format(
          "'kinetostat adopt robot.yaml {} -o calibrated.yaml' puts what it found "
          "into a robot file",
          file);
    case DocumentKind::result:
      return fmt::format("'kinetostat report {} -o page.html' shows it", file);
    case DocumentKind::unknown:
      break;
  }
  return {};
}

std::string words_for(const Kinds& kinds) {
  std::string words;
  for (const DocumentKind kind : kinds)
    words += fmt::format("{}{}", words.empty() ? "" : " or ", io::words_for(kind));
  return words;
}

using File = std::pair<std::filesystem::path, std::string>;  // and its text

bool is_written_by_people(DocumentKind kind) {
  return kind == DocumentKind::robot || kind == DocumentKind::campaign ||
         kind == DocumentKind::link;
}

// The files that may be changed, with the robot file that a campaign names.
std::vector<File> readable(const std::vector<std::string>& files) {
  std::vector<File> result;
  for (const std::string& file : files) {
    const DocumentKind kind = io::document_kind(file);
    if (!is_written_by_people(kind)) continue;
    result.emplace_back(file, io::read_text(file));
    if (kind != DocumentKind::campaign) continue;
    const io::YamlNode top = io::parse_yaml(result.back().second, file);
    const auto its_robot = top.find("robot");
    if (!its_robot || !its_robot->is_scalar()) continue;
    const std::filesystem::path named = its_robot->existing_file();
    result.emplace_back(named, io::read_text(named));
  }
  return result;
}

}  // namespace

bool takes_set(const std::string& command) {
  for (const Wanted& wanted : all_wanted())
    for (const Kinds& place : wanted.places)
      if (command == wanted.command &&
          std::any_of(place.begin(), place.end(), is_written_by_people))
        return true;
  return false;
}

std::vector<File> changed_files(const std::vector<std::string>& files,
                                const std::vector<Setting>& settings) {
  std::vector<File> all;
  if (settings.empty()) return all;
  all = readable(files);
  if (all.empty())
    throw common::InputError(files.empty() ? "" : files[0],
                             "no value can be set in it: it is no robot, link or campaign file");
  for (const auto& [key, value] : settings) {
    auto file = std::find_if(all.begin(), all.end(), [&key = key](const File& f) {
      return io::has_first_key(f.second, key);
    });
    if (file == all.end()) file = all.begin();
    file->second = io::with_value(file->second, file->first, key, value);
  }
  return all;
}

void refuse_misplaced_files(const std::string& command, const std::vector<std::string>& files) {
  const auto found = std::find_if(all_wanted().begin(), all_wanted().end(),
                                  [&](const Wanted& w) { return command == w.command; });
  if (found == all_wanted().end()) return;
  std::vector<DocumentKind> kinds;
  kinds.reserve(files.size());
  for (const std::string& file : files) kinds.push_back(io::document_kind(file));
  if (kinds == Kinds{DocumentKind::campaign, DocumentKind::robot} && found->places.size() > 1)
    throw MisplacedFile(files[0], "this is a campaign file, and the robot file comes first",
                        fmt::format("Write 'kinetostat {} {} {}'", command, files[1], files[0]));
  // A table that does not look like one is read as what stands before the robot file.
  if (found->takes_robot_alone && kinds.size() == 2 && kinds[1] == DocumentKind::robot &&
      (kinds[0] == DocumentKind::table || kinds[0] == DocumentKind::unknown))
    return;
  for (std::size_t i = 0; i < files.size(); ++i) {
    const Kinds& wanted = found->places[std::min(i, found->places.size() - 1)];
    if (kinds[i] == DocumentKind::unknown ||
        std::find(wanted.begin(), wanted.end(), kinds[i]) != wanted.end())
      continue;
    throw MisplacedFile(
        files[i], fmt::format("this is {}, not {}", io::words_for(kinds[i]), words_for(wanted)),
        command_for(kinds[i], files[i]));
  }
  if (kinds == robot && found->places[0] == robot_or_campaign && !found->takes_robot_alone)
    throw MisplacedFile(
        files[0], "this is a robot file, and no campaign file comes after it",
        fmt::format("Write 'kinetostat {} {} campaign.yaml'; 'kinetostat readings TABLE -o "
                    "campaign.yaml' makes one from a table",
                    command, files[0]));
}

}  // namespace kinetostat::apps
