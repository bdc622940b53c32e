// kinetostat new: files to start with, that run as they are.
#include <iterator>
#include <memory>
#include <sstream>

#include <fmt/format.h>

#include "kinetostat/apps/cli/command.h"
#include "kinetostat/apps/cli/shipped_files.h"
#include "kinetostat/apps/commands/commands.h"
#include "kinetostat/common/error.h"
#include "kinetostat/io/text_file.h"
#include "kinetostat/report/screen/wording.h"

namespace kinetostat::apps {
namespace {

using std::filesystem::path;

/// What one `new` command writes, and what can be done with it.
struct Starter {
  std::string word;
  std::string about;
  std::vector<std::pair<std::string, std::string>> files;  // shipped, name in the folder
  std::vector<std::string> next;                           // commands; {} is the folder
};

const std::vector<Starter>& starters() {
  static const std::vector<Starter> all = {
      {"link",
       "A link: its mesh and a commented link file",
       {{"data/starters/link.yaml", "link.yaml"}, {"meshes/tapered_arm.stl", "link.stl"}},
       {"mesh check {}/link.stl --unit mm", "identify {}/link.yaml -o {}/link.link.json"}},
      {"robot",
       "A robot: a commented robot file",
       {{"data/starters/robot.yaml", "robot.yaml"}},
       {"stiffness {}/robot.yaml --joints q1=0,q2=60",
        "deflect {}/robot.yaml --joints q1=0,q2=60 --wrench 0,0,-100"}},
      {"campaign",
       "Measurements: a commented campaign file, its readings and their robot",
       {{"data/starters/campaign.yaml", "campaign.yaml"},
        {"data/starters/readings.csv", "readings.csv"},
        {"data/starters/robot.yaml", "robot.yaml"}},
       {"measure check {}/campaign.yaml", "compare {}/campaign.yaml",
        "diagnose {}/campaign.yaml --html {}/diagnosis.html"}}};
  return all;
}

// A file of the user's is never written over; a robot file that is there already is theirs to use.
void write_files(const Starter& starter, const path& folder, Run& run) {
  for (const auto& [from, name] : starter.files) {
    const path file = folder / name;
    if (!std::filesystem::exists(file)) continue;
    if (starter.word == "campaign" && name == "robot.yaml") continue;
    throw common::InputError(file, "is there already, and is not written over",
                             "Name another folder");
  }
  std::filesystem::create_directories(folder);
  for (const auto& [from, name] : starter.files) {
    const path file = folder / name;
    if (std::filesystem::exists(file)) continue;
    io::write_atomically(file, io::read_text(shipped(from)));
    run.print("Wrote " + file.string() + "\n");
  }
}

std::vector<std::string> words_of(const std::string& command) {
  std::istringstream stream(command);
  return {std::istream_iterator<std::string>(stream), {}};
}

io::Json make(const Starter& starter, const std::string& folder, Run& run) {
  write_files(starter, folder, run);
  run.print("Next:\n");
  io::Json json{{"folder", folder}, {"files", io::Json::array()}, {"next", io::Json::array()}};
  for (const auto& [from, name] : starter.files) json["files"].push_back(name);
  for (const std::string& command : starter.next) {
    std::string line = "kinetostat";
    for (std::string word : words_of(command)) {
      if (const std::size_t at = word.find("{}"); at != std::string::npos)
        word = report::quoted(word.replace(at, 2, folder));
      line += " " + word;
    }
    run.print("  " + line + "\n");
    json["next"].push_back(line);
  }
  return json;
}

}  // namespace

void add_new(Program& program) {
  for (const Starter& starter : starters()) {
    const auto folder = std::make_shared<std::string>();
    OptionList app =
        program.add({.name = "new " + starter.word,
                     .summary = starter.about,
                     .example = fmt::format("kinetostat new {} my_{}", starter.word, starter.word)},
                    [&starter, folder](Run& run) { return make(starter, *folder, run); });
    app.add_option("FOLDER", *folder, "Where the files go; made when it is not there").required();
  }
}

}  // namespace kinetostat::apps
