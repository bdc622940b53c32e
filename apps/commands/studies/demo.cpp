// kinetostat demo: stories, each a study of shipped robots and readings.
#include <iterator>
#include <memory>
#include <vector>

#include <fmt/format.h>

#include "kinetostat/apps/cli/command.h"
#include "kinetostat/apps/cli/shipped_files.h"
#include "kinetostat/apps/commands/commands.h"
#include "kinetostat/apps/commands/studies/study.h"
#include "kinetostat/common/spelling.h"
#include "kinetostat/io/document_kind.h"
#include "kinetostat/report/screen/wording.h"

namespace kinetostat::apps {
namespace {

struct Story {
  const char *name, *about;
  const char* source;              // whose readings, under which licence, and what is known of them
  std::vector<const char*> files;  // robots and campaigns, each studied
};

const std::vector<Story>& stories() {
  static const std::vector<Story> all = {
      {"arm",
       "A six-axis arm with backlash in a joint and a soft base (simulated)",
       "Simulated by a program that shares no code with kinetostat (tests/twin). Hidden in it: "
       "0.00327 deg of play to either side at joint q3, and a base that turns by 0.090 urad/(N "
       "m); every stiffness is off by 12 %.",
       {"data/measurements/arm_backlash_soft_base/campaign.yaml"}},
      {"cycloidal",
       "Cycloidal drives on a bench, as built against preloaded (real readings)",
       "Real readings: Jelmer V., Anti-Backlash Cycloidal Actuator, CC BY-SA 4.0; shortened, see "
       "data/measurements/cycloidal_drives/README.md.",
       {"data/measurements/cycloidal_drives/as_built.yaml",
        "data/measurements/cycloidal_drives/split_discs.yaml"}},
      {"ur10",
       "A UR10 before a laser tracker: its kinematics come first (real readings)",
       "Real readings: github.com/christianlandgraf/ipa-robot-accuracy, series D, MIT; see "
       "data/measurements/ur10_tracker/README.md.",
       {"data/measurements/ur10_tracker/campaign.yaml"}},
      {"orthoglide",
       "An Orthoglide, from the meshes of its links to play in a drive (simulated)",
       "Links drawn for kinetostat (meshes/). Readings simulated by tests/twin; hidden in them: "
       "1.68 "
       "um of play at the x drive.",
       {"data/robots/orthoglide_fea.yaml",
        "data/measurements/orthoglide_clearance/campaign.yaml"}}};
  return all;
}

struct DemoRequest {
  std::string story = stories().front().name;
  bool list = false;
};

std::vector<std::string> names() {
  std::vector<std::string> list;
  for (const Story& story : stories()) list.emplace_back(story.name);
  return list;
}

const Story& story_named(const std::string& name) {
  for (const Story& story : stories())
    if (story.name == name) return story;
  const std::string near = common::nearest_spelling(name, names());
  throw UsageError("STORY", fmt::format("there is no story '{}'", name),
                   near.empty() ? "Use " + report::listed(names(), "or")
                                : fmt::format("Did you mean '{}'?", near));
}

io::Json list_stories(Run& run) {
  io::Json list = io::Json::array();
  for (const Story& story : stories()) {
    run.print(fmt::format("  {:<12}{}\n", story.name, story.about));
    list.push_back({{"story", story.name},
                    {"about", story.about},
                    {"source", story.source},
                    {"files", story.files}});
  }
  return {{"stories", list}};
}

// Each file in a folder of its own where there are several.
io::Json tell(const Story& story, const std::filesystem::path& folder, Run& run) {
  io::Json studies = io::Json::array();
  for (const std::filesystem::path name : story.files) {
    const std::filesystem::path file = shipped(name);
    std::filesystem::path out = folder / story.name;
    if (story.files.size() > 1) {
      if (!studies.empty()) run.print("\n");
      const bool is_one_of_many = name.stem() != "campaign";
      out /= is_one_of_many ? name.stem() : name.parent_path().filename();
    }
    const bool is_robot = io::document_kind(file) == io::DocumentKind::robot;
    io::Json study = is_robot ? study_design(file, out, run)
                              : study_readings({.files = {file.string()}}, out, {}, run);
    io::Json shown{{"command", "study"}};
    shown.update(study);
    run.add_to_page({.result = std::move(shown), .picture = run.picture(), .text = {}});
    studies.push_back({{"file", name.string()}, {"study", std::move(study)}});
  }
  run.print("\n" + report::wrapped(story.source));
  run.draw({});
  return {{"headline", story.about},
          {"story", story.name},
          {"source", story.source},
          {"studies", studies}};
}

io::Json demo(const DemoRequest& request, Run& run) {
  if (request.list) return list_stories(run);
  return tell(story_named(request.story), run.out().value_or("kinetostat-demo"), run);
}

}  // namespace

void add_demo(Program& program) {
  const auto request = std::make_shared<DemoRequest>();
  std::string what = "Write the study there, kinetostat-demo unless given";
  OptionList app = program.add(
      {.name = "demo",
       .summary = "A shipped story: from readings to the effects that a model lacks, and a page",
       .example = "kinetostat demo",
       .out = what,
       .out_is_folder = true},
      [request](Run& run) { return demo(*request, run); });
  app.add_option("STORY", request->story, "Which story: " + report::listed(names(), "or"))
      .show_default();
  app.add_flag("--list", request->list, "Say what the stories are about");
}

}  // namespace kinetostat::apps
