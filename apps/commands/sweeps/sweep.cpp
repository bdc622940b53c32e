// kinetostat sweep: many runs of one command with other values each, as one table. kinetostat join:
// the parts of such a table that several machines have made.
#include <algorithm>
#include <charconv>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <optional>
#include <thread>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "kinetostat/apps/cli/command.h"
#include "kinetostat/apps/cli/option_values.h"
#include "kinetostat/apps/commands/commands.h"
#include "kinetostat/apps/commands/link_models.h"
#include "kinetostat/apps/commands/sweeps/sweep_plan.h"
#include "kinetostat/apps/commands/sweeps/workers.h"
#include "kinetostat/common/child_process.h"
#include "kinetostat/io/csv.h"
#include "kinetostat/io/table_parts.h"
#include "kinetostat/io/text_file.h"
#include "kinetostat/report/screen/wording.h"

namespace kinetostat::apps {
namespace {

namespace fs = std::filesystem;

struct SweepRequest {
  std::string file, part, scheduler;
};

// The columns of the table, then a line for each run.
std::string header_of(const SweepPlan& plan) {
  std::string line = "run";
  for (const std::string& key : plan.keys) line += "," + io::csv_cell(key);
  for (const auto& [name, path] : plan.results) line += "," + io::csv_cell(name);
  return line + ",exit\n";
}

std::string title_of(const SweepPlan& plan) {
  return io::title_of_table("sweep", plan.meaning, plan.runs.size(), "runs");
}

// The JSON among what a program says: its lines from "{" to "}".
io::Json json_in(const std::string& words) {
  const std::size_t begin = words.starts_with("{\n") ? 0 : words.find("\n{\n");
  const std::size_t end = words.rfind("\n}");
  if (begin == std::string::npos || end == std::string::npos || end < begin) return {};
  return io::Json::parse(words.substr(begin, end + 2 - begin), nullptr, false);
}

void replace_word(const std::string& place, const std::string& value,
                  std::vector<std::string>& words) {
  for (std::string& word : words)
    for (std::size_t at = 0; (at = word.find(place, at)) != std::string::npos; at += value.size())
      word.replace(at, place.size(), value);
}

// By its exit code, the last cell.
bool has_failed(const std::string& line) { return !line.ends_with(",0\n"); }

// Whether a line that was kept has so many cells, the last of them an exit code: a disk that was
// full or lost its power leaves others.
bool is_whole(std::string_view line, std::ptrdiff_t cells) {
  bool quoted = false;
  std::ptrdiff_t found = 1;
  for (const char c : line) {
    if (c == '"') quoted = !quoted;
    if (c == ',' && !quoted) ++found;
  }
  const std::string_view exit = line.substr(line.rfind(',') + 1);
  return found == cells && !exit.empty() &&
         exit.find_first_not_of("0123456789") == std::string_view::npos;
}

class Sweep {
 public:
  Sweep(const SweepPlan& plan, const io::Part& part, fs::path kept)
      : plan_(plan), kept_(std::move(kept)) {
    for (std::size_t r = 0; r < plan.runs.size(); ++r)
      if (part.has(r)) wanted_.push_back(r);
    take_up();
  }

  std::size_t known() const { return known_; }

  void run(Run& run) {
    std::vector<std::size_t> open;
    for (const std::size_t r : wanted_)
      if (!lines_.contains(r)) open.push_back(r);
    if (!kept_.empty()) to_keep_.open(kept_, std::ios::app);
    std::vector<Running> running;
    const auto threads = static_cast<std::size_t>(run.threads());
    // The first of many runs goes alone: it shows whether its results fit into a table.
    const bool has_trial = open.size() > threads;
    for (std::size_t next = 0, done = 0; done < open.size();) {
      const std::size_t together = has_trial && done == 0 ? 1 : threads;
      while (running.size() < together && next < open.size() && !is_refused()) {
        running.push_back({open[next], common::ProcessCopy(program_of(open[next]))});
        ++next;
      }
      run.progress().report("runs", static_cast<double>(done) / static_cast<double>(open.size()));
      const std::size_t ended = take_results(running);
      done += ended;
      if (running.empty() && is_refused()) throw refusal();
      if (ended == 0) std::this_thread::sleep_for(std::chrono::microseconds(500));
    }
    if (is_refused()) throw refusal();
  }

  std::string table() const {
    std::string text = title_of(plan_) + header_of(plan_);
    for (const auto& [number, line] : lines_) text += line;
    return text;
  }
  std::size_t failed() const {
    return static_cast<std::size_t>(std::count_if(
        lines_.begin(), lines_.end(), [](const auto& l) { return has_failed(l.second); }));
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
  std::ptrdiff_t cells() const {
    return std::ssize(plan_.keys) + std::ssize(plan_.results) + 2;  // number and exit code
  }
  void take_lines(const std::string& text, std::size_t at) {
    for (std::size_t end; (end = text.find('\n', at)) != std::string::npos; at = end + 1) {
      std::size_t number = 0;
      const auto [rest, bad] = std::from_chars(text.data() + at, text.data() + end, number);
      if (bad == std::errc() && *rest == ',' && is_whole({text.data() + at, end - at}, cells()) &&
          std::binary_search(wanted_.begin(), wanted_.end(), number))
        lines_[number] = text.substr(at, end + 1 - at);
    }
  }

  struct Running {
    std::size_t number;
    common::ProcessCopy copy;
  };

  // How many have ended.
  std::size_t take_results(std::vector<Running>& running) {
    return std::erase_if(running, [this](Running& one) {
      const auto result = one.copy.result();
      if (result) take_result(one.number, *result);
      return result.has_value();
    });
  }

  void take_result(std::size_t r, const common::ChildResult& child) {
    const int code = child.end == common::ChildResult::End::exited ? child.code : 1;
    if (code == bad_usage || code == bad_input) {
      refused_[r] = child.words;
      return;
    }
    const io::Json result = json_in(child.words);
    if (!unfit_) unfit_ = unfit_result(plan_, result);
    if (unfit_) return;
    lines_[r] = line_of(r, code, result);
    if (to_keep_.is_open()) to_keep_ << lines_[r] << std::flush;
  }

  std::vector<std::string> words_of_run(std::size_t r) const {
    std::vector<std::string> words = plan_.command;
    words.insert(words.begin(), "kinetostat");
    for (std::size_t k = 0; k < plan_.keys.size(); ++k) {
      if (plan_.is_word[k]) {
        replace_word("{" + plan_.keys[k] + "}", plan_.runs[r][k], words);
        continue;
      }
      words.emplace_back("--set");
      words.push_back(plan_.keys[k] + "=" + plan_.runs[r][k]);
    }
    for (const char* option : {"--json", "-", "--quiet", "--threads", "1"})
      words.emplace_back(option);
    return words;
  }

  // The command as the program itself would run it.
  std::function<int()> program_of(std::size_t r) const {
    return [words = words_of_run(r)] {
      std::vector<const char*> arguments;
      arguments.reserve(words.size());
      for (const std::string& word : words) arguments.push_back(word.c_str());
      Program program;
      add_all_commands(program);
      return program.run(static_cast<int>(arguments.size()), arguments.data());
    };
  }

  std::string line_of(std::size_t r, int code, const io::Json& result) const {
    std::string line = fmt::format("{}", r);
    for (const std::string& value : plan_.runs[r]) line += "," + io::csv_cell(value);
    for (const auto& [name, path] : plan_.results)
      line += "," + io::csv_cell(result_cell(result, path));
    return line + fmt::format(",{}\n", code);
  }

  bool is_refused() const { return !refused_.empty() || unfit_; }

  // Of the first run that was refused: those before it have ended, whatever the number of threads.
  common::InputError refusal() const {
    if (refused_.empty()) return *unfit_;
    const auto& [r, words] = *refused_.begin();
    return {plan_.file,
            fmt::format("run {}: {}", r, words.substr(0, words.find_last_not_of('\n') + 1)),
            "Correct 'command' or 'vary'"};
  }

  const SweepPlan& plan_;
  fs::path kept_;
  std::vector<std::size_t> wanted_;
  std::map<std::size_t, std::string> lines_;    // by the numbers of the runs
  std::map<std::size_t, std::string> refused_;  // what was said
  std::optional<common::InputError> unfit_;     // a result that no cell of a table can hold
  std::ofstream to_keep_;
  std::size_t known_ = 0;
};

// What a sweep has come to.
struct SweepTable {
  std::string text;
  std::size_t runs = 0, failed = 0;
};

SweepTable made_here(Run& run, const SweepRequest& request, const SweepPlan& plan) {
  fs::path kept;
  if (run.out()) kept = run.out()->string() + ".part";
  Sweep work(plan, part_of("--part", request.part), kept);
  if (work.known() > 0) run.remark(fmt::format("{} runs were done before", work.known()));
  work.run(run);
  SweepTable table{work.table(), work.count(), work.failed()};
  if (run.out()) {
    io::write_atomically(*run.out(), table.text);
    std::error_code ignored;
    fs::remove(kept, ignored);
  }
  return table;
}

SweepTable made_by_workers(Run& run, const SweepRequest& request) {
  if (!run.out())
    throw UsageError("--scheduler", "a table from workers is written to a file", "Add -o FILE");
  const ScratchFolder folder;
  const fs::path joined = folder.path() / "joined.csv";
  run_on_workers(request.scheduler, {"sweep", request.file}, joined, run);
  const io::NumberedTable table = io::read_numbered_table(joined);
  io::write_atomically(*run.out(), table.text());
  return {table.text(), table.lines.size(),
          static_cast<std::size_t>(
              std::count_if(table.lines.begin(), table.lines.end(),
                            [](const auto& line) { return has_failed(line.second); }))};
}

// Names that no run knows are mistakes, most likely.
void say_what_is_empty(Run& run, const SweepPlan& plan, const SweepTable& table) {
  if (table.runs == 0) return;  // as a part may have none
  const io::CsvTable rows(table.text, plan.name);
  for (const auto& [name, path] : plan.results) {
    const auto column = rows.find(name);
    bool is_empty = column.has_value();
    for (std::size_t r = 0; is_empty && r < rows.rows(); ++r)
      is_empty = rows.cell(r, *column).empty();
    if (is_empty)
      run.remark(
          fmt::format("'{}' is empty: no run has the result '{}' (the command with --json - "
                      "shows what there is)",
                      name, path));
  }
}

io::Json sweep(Run& run, const SweepRequest& request) {
  const SweepPlan plan = read_sweep(request.file);
  const SweepTable table =
      request.scheduler.empty() ? made_here(run, request, plan) : made_by_workers(run, request);
  if (run.out())
    run.print(report::wrapped(
        fmt::format("{}: {} runs, written to {}.", plan.name, table.runs, run.out()->string())));
  else
    run.print(table.text);
  say_what_is_empty(run, plan, table);
  if (table.failed > 0)
    run.print(fmt::format("{} runs ended without a full result: see 'exit'.\n", table.failed));
  return {
      {"name", plan.name}, {"runs", table.runs}, {"failed", table.failed}, {"table", table.text}};
}

struct JoinRequest {
  std::vector<std::string> files;
};

// A map has poses only; what else there is keeps its numbers.
io::Json join(Run& run, const JoinRequest& request) {
  const io::JoinedTable all = io::join_tables(request.files);
  const bool is_map = all.title.starts_with("# map ");
  std::string table = is_map ? all.plain_text() : all.text();
  if (run.out()) {
    io::write_atomically(*run.out(), table);
    run.print(fmt::format("{} rows, written to {}.\n", all.lines.size(), run.out()->string()));
  } else {
    run.print(table);
  }
  return {{"rows", all.lines.size()}, {"table", std::move(table)}};
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
  const auto part =
      app.add_option("--part", request->part, "Only the i-th of n parts of the runs, for join")
          .type_name("i/n");
  app.add_option("--scheduler", request->scheduler,
                 "Run on the workers of this Dask scheduler, 'tcp://host:8786', or 'local': of a "
                 "cluster on this machine; with -o")
      .type_name("ADDRESS")
      .excludes(part);
  const auto parts = std::make_shared<JoinRequest>();
  OptionList join_app = program.add(
      {.name = "join",
       .summary = "One table from the parts of a sweep, a map or draws that several machines made",
       .example = "kinetostat join arm.csv -o joined.csv",
       .out = "Write the table (CSV)"},
      [parts](Run& run) { return join(run, *parts); });
  join_app.add_option("FILE", parts->files, "What was written with --part").required();
}

}  // namespace kinetostat::apps
