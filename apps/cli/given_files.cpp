#include "kinetostat/apps/cli/given_files.h"

#include <algorithm>
#include <array>
#include <optional>
#include <string_view>

#include <fmt/format.h>

#include "kinetostat/io/document_kind.h"

namespace kinetostat::apps {
namespace {

using io::DocumentKind;
using Kinds = std::vector<DocumentKind>;

// What the positional arguments of a command are, in their order; the last stands for those after
// it.
struct Wanted {
  const char* command;
  std::vector<Kinds> places;
  bool takes_robot_alone = false;  // where a campaign may stand in its place
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
      {"study", {robot_or_campaign, campaign}, true},
      {"adopt", {robot, {DocumentKind::diagnosis}}},
      {"identify", {{DocumentKind::link}}},
      {"beam", {{DocumentKind::link}}},
      {"modes", {{DocumentKind::link, DocumentKind::robot}}},
      {"mesh check", {{DocumentKind::mesh}}},
      {"import", {{DocumentKind::description}}},
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

}  // namespace

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
