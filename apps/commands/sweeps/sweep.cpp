// kinetostat sweep: many runs of one command with other values each, as one table. kinetostat join:
// the parts of such a table that several machines have made.
#include <algorithm>
#include <charconv>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <mutex>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "kinetostat/apps/cli/command.h"
#include "kinetostat/apps/commands/commands.h"
#include "kinetostat/apps/commands/sweeps/sweep_plan.h"
#include "kinetostat/common/child_process.h"
#include "kinetostat/common/parallel.h"
#include "kinetostat/io/csv.h"
#include "kinetostat/io/text_file.h"
#include "kinetostat/report/screen/wording.h"

namespace kinetostat::apps {
namespace {

namespace fs = std::filesystem;

struct SweepRequest {
  std::string file, part;
  int number = 1, parts = 1;  // of --part
};

// "2/8"
void read_part(SweepRequest& request) {
  if (request.part.empty()) return;
  const char* const end = request.part.data() + request.part.size();
  const auto [slash, first] = std::from_chars(request.part.data(), end, request.number);
  bool good = first == std::errc() && slash != end && *slash == '/';
  if (good) {
    const auto [rest, second] = std::from_chars(slash + 1, end, request.parts);
    good = second == std::errc() && rest == end;
  }
  if (!good || request.number < 1 || request.number > request.parts)
    throw UsageError("--part", fmt::format("'{}' is not i/n", request.part),
                     "Write --part 2/8 for the second of eight parts");
}

// The columns of the table, then a line for each run.
std::string header_of(const SweepPlan& plan) {
  std::string line = "run";
  for (const std::string& key : plan.keys) line += "," + io::csv_cell(key);
  for (const auto& [name, path] : plan.results) line += "," + io::csv_cell(name);
  return line + ",exit\n";
}

// What a table is of, so that parts of another are not taken for its own.
std::string title_of(const SweepPlan& plan) {
  return io::csv_comment(
      fmt::format("sweep {} of {} runs", io::sha256(plan.meaning).substr(0, 16), plan.runs.size()));
}

// The JSON among what a program says: its lines from "{" to "}".
io::Json json_in(const std::string& words) {
  const std::size_t begin = words.starts_with("{\n") ? 0 : words.find("\n{\n");
  const std::size_t end = words.rfind("\n}");
  if (begin == std::string::npos || end == std::string::npos || end < begin) return {};
  return io::Json::parse(words.substr(begin, end + 2 - begin), nullptr, false);
}

class Sweep {
 public:
  Sweep(const SweepPlan& plan, const SweepRequest& request, fs::path kept)
      : plan_(plan), kept_(std::move(kept)) {
    for (std::size_t r = 0; r < plan.runs.size(); ++r)
      if (r % static_cast<std::size_t>(request.parts) ==
          static_cast<std::size_t>(request.number - 1))
        wanted_.push_back(r);
    take_up();
  }

  std::size_t known() const { return known_; }

  void run(Run& run) {
    std::vector<std::size_t> open;
    for (const std::size_t r : wanted_)
      if (!lines_.contains(r)) open.push_back(r);
    std::ofstream kept;
    if (!kept_.empty()) kept.open(kept_, std::ios::app);
    std::mutex mutex;
    common::parallel_for(open.size(), run.threads(), "runs", run.progress(), [&](std::size_t i) {
      const std::string line = line_of(open[i], run.progress());
      const std::lock_guard lock(mutex);
      lines_[open[i]] = line;
      if (kept.is_open()) kept << line << std::flush;
    });
  }

  std::string table() const {
    std::string text = title_of(plan_) + header_of(plan_);
    for (const auto& [number, line] : lines_) text += line;
    return text;
  }
  std::size_t failed() const {
    return static_cast<std::size_t>(std::count_if(
        lines_.begin(), lines_.end(), [](const auto& l) { return !l.second.ends_with(",0\n"); }));
  }
  std::size_t count() const { return lines_.size(); }

 private:
  // What an earlier run that was stopped has done of the same sweep; a line that was cut short is
  // left out of what is kept.
  void take_up() {
    if (kept_.empty()) return;
    const std::string title = title_of(plan_);
    std::error_code error;
    if (fs::exists(kept_, error))
      if (const std::string text = io::read_text(kept_); text.starts_with(title))
        take_lines(text, title.size());
    known_ = lines_.size();
    std::string whole = title;
    for (const auto& [number, line] : lines_) whole += line;
    io::write_atomically(kept_, whole);
  }
  void take_lines(const std::string& text, std::size_t at) {
    for (std::size_t end; (end = text.find('\n', at)) != std::string::npos; at = end + 1) {
      std::size_t number = 0;
      const auto [rest, bad] = std::from_chars(text.data() + at, text.data() + end, number);
      if (bad == std::errc() && std::binary_search(wanted_.begin(), wanted_.end(), number))
        lines_[number] = text.substr(at, end + 1 - at);
    }
  }

  std::string line_of(std::size_t r, common::Progress& progress) const {
    common::ChildCall call{.program = fs::read_symlink("/proc/self/exe"),
                           .arguments = plan_.command,
                           .input = {},
                           .time_limit = 1e9};
    for (std::size_t k = 0; k < plan_.keys.size(); ++k) {
      call.arguments.emplace_back("--set");
      call.arguments.push_back(plan_.keys[k] + "=" + plan_.runs[r][k]);
    }
    for (const char* option : {"--json", "-", "--quiet", "--threads", "1"})
      call.arguments.emplace_back(option);
    const common::ChildResult child = run_child(call, "runs", progress);
    const int code = child.end == common::ChildResult::End::exited ? child.code : 1;
    if (code == bad_usage || code == bad_input) refuse(child.words, r);
    const io::Json result = json_in(child.words);
    std::string line = fmt::format("{}", r);
    for (const std::string& value : plan_.runs[r]) line += "," + io::csv_cell(value);
    for (const auto& [name, path] : plan_.results)
      line += "," + io::csv_cell(result_cell(result, path));
    return line + fmt::format(",{}\n", code);
  }

  [[noreturn]] void refuse(const std::string& words, std::size_t r) const {
    throw common::InputError(
        plan_.file, fmt::format("run {}: {}", r, words.substr(0, words.find_last_not_of('\n') + 1)),
        "Correct 'command' or 'vary'");
  }

  const SweepPlan& plan_;
  fs::path kept_;
  std::vector<std::size_t> wanted_;
  std::map<std::size_t, std::string> lines_;  // by the numbers of the runs
  std::size_t known_ = 0;
};

io::Json sweep(Run& run, SweepRequest request) {
  read_part(request);
  const SweepPlan plan = read_sweep(request.file);
  fs::path kept;
  if (run.out()) kept = run.out()->string() + ".part";
  Sweep work(plan, request, kept);
  if (work.known() > 0) run.remark(fmt::format("{} runs were done before", work.known()));
  work.run(run);
  const std::string table = work.table();
  if (run.out()) {
    io::write_atomically(*run.out(), table);
    std::error_code ignored;
    fs::remove(kept, ignored);
    run.print(report::wrapped(
        fmt::format("{}: {} runs, written to {}.", plan.name, work.count(), run.out()->string())));
  } else {
    run.print(table);
  }
  if (work.failed() > 0)
    run.print(fmt::format("{} runs ended without a full result: see 'exit'.\n", work.failed()));
  return {{"name", plan.name}, {"runs", work.count()}, {"failed", work.failed()}, {"table", table}};
}

struct JoinRequest {
  std::vector<std::string> files;
};

// A part of a table: title, header, lines by their numbers.
struct Part {
  std::string title, header;
  std::map<std::size_t, std::string> lines;
};

Part read_part_of_table(const fs::path& file) {
  const std::string text = io::read_text(file);
  Part part;
  std::size_t at = 0;
  const auto next = [&] {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    std::string line = text.substr(at, end - at) + "\n";
    at = end + 1;
    return line;
  };
  part.title = next();
  part.header = next();
  if (!part.title.starts_with("# sweep ") || !part.header.starts_with("run,"))
    throw common::InputError(file, "this is no table that 'kinetostat sweep' has written",
                             "Name files of sweep --part i/n -o FILE");
  while (at < text.size()) {
    const std::string line = next();
    std::size_t number = 0;
    (void)std::from_chars(line.data(), line.data() + line.size(), number);
    part.lines[number] = line;
  }
  return part;
}

// "# sweep HASH of N runs"
std::size_t runs_in(const std::string& title) {
  const std::size_t at = title.rfind(" of ");
  std::size_t number = 0;
  if (at != std::string::npos)
    (void)std::from_chars(title.data() + at + 4, title.data() + title.size(), number);
  return number;
}

io::Json join(Run& run, const JoinRequest& request) {
  Part all = read_part_of_table(request.files.front());
  for (const std::string& file : request.files) {
    Part part = read_part_of_table(file);
    if (part.title != all.title || part.header != all.header)
      throw common::InputError(file, "this is a part of another sweep",
                               fmt::format("Join only what {} belongs to", request.files.front()));
    all.lines.merge(part.lines);
  }
  const std::size_t wanted = runs_in(all.title);
  for (std::size_t r = 0; r < wanted; ++r)
    if (!all.lines.contains(r))
      throw common::InputError(request.files.front(),
                               fmt::format("run {} of {} is in none of the files", r, wanted),
                               "Name all parts: those of --part 1/n to n/n");
  std::string table = all.title + all.header;
  for (const auto& [number, line] : all.lines) table += line;
  if (run.out()) {
    io::write_atomically(*run.out(), table);
    run.print(fmt::format("{} runs, written to {}.\n", wanted, run.out()->string()));
  } else {
    run.print(table);
  }
  return {{"runs", wanted}, {"table", table}};
}

}  // namespace

void add_sweep(Program& program) {
  const auto request = std::make_shared<SweepRequest>();
  OptionList app =
      program.add({.name = "sweep",
                   .summary = "Many runs of a command with other values each, as one table",
                   .example = "kinetostat sweep data/sweeps/arm.yaml -o arm.csv",
                   .out = "Write the table (CSV); an interrupted run goes on from FILE.part"},
                  [request](Run& run) { return sweep(run, *request); });
  app.add_option("FILE", request->file, "Sweep file").required();
  app.add_option("--part", request->part, "Only the i-th of n parts of the runs, for join")
      .type_name("i/n");
  const auto parts = std::make_shared<JoinRequest>();
  OptionList join_app =
      program.add({.name = "join",
                   .summary = "The table of a sweep from the parts that several machines made",
                   .example = "kinetostat join arm.csv -o joined.csv",
                   .out = "Write the table (CSV)"},
                  [parts](Run& run) { return join(run, *parts); });
  join_app.add_option("FILE", parts->files, "Tables of sweep --part").required();
}

}  // namespace kinetostat::apps
