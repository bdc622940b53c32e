// kinetostat report: several results on one page.
#include "kinetostat/apps/cli/command.h"
#include "kinetostat/apps/commands/commands.h"
#include "kinetostat/io/text_file.h"
#include "kinetostat/report/page.h"

namespace kinetostat::apps {
namespace {

struct ReportRequest {
  std::vector<std::string> files;
  std::string title = "kinetostat";
};

io::Json report_of(const ReportRequest& request, Run& run) {
  if (!run.out()) throw UsageError("--out", "the page has no name", "Give -o PAGE.html");
  std::vector<report::PageResult> results;
  io::Json json{{"results", io::Json::array()}};
  for (const std::string& file : request.files) {
    for (report::PageResult& result : report::read_page_results(file)) {
      json["results"].push_back({{"file", file}, {"title", report::title_of(result.result)}});
      run.print(file + ": " + report::title_of(result.result) + "\n");
      results.push_back(std::move(result));
    }
  }
  io::write_atomically(*run.out(), report::page(request.title, results));
  run.print("Page: " + run.out()->string() + "\n");
  return json;
}

}  // namespace

void add_report(Program& program) {
  const auto request = std::make_shared<ReportRequest>();
  OptionList app =
      program.add({.name = "report",
                   .summary = "Several results on one page",
                   .example = "kinetostat report data/links/foot.link.json -o links.html",
                   .out = "Write the page"},
                  [request](Run& run) { return report_of(*request, run); });
  app.add_option("RESULTS", request->files, "What --json or --html of other commands wrote")
      .required();
  app.add_option("--title", request->title, "Heading of the page").show_default();
}

}  // namespace kinetostat::apps
