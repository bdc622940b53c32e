#include "kinetostat/apps/cli/command.h"

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <sstream>
#include <system_error>
#include <thread>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "kinetostat/apps/cli/cancellation.h"
#include "kinetostat/apps/cli/given_files.h"
#include "kinetostat/apps/cli/progress_bar.h"
#include "kinetostat/apps/cli/version.h"
#include "kinetostat/apps/manual/completion.h"
#include "kinetostat/apps/manual/man_pages.h"
#include "kinetostat/common/error.h"
#include "kinetostat/common/faults.h"
#include "kinetostat/common/out_of_memory.h"
#include "kinetostat/common/printable.h"
#include "kinetostat/common/spelling.h"
#include "kinetostat/io/document_kind.h"
#include "kinetostat/io/text_file.h"

namespace kinetostat::apps {
namespace {

constexpr int most_threads = 1024;
constexpr char no_memory[] =
    "kinetostat: there is not enough memory for this computation. Close other programs, ask for "
    "less (a coarser mesh, fewer poses, --threads 1), or raise the limit (ulimit -v).\n";

int processor_count() {
  return std::clamp(static_cast<int>(std::thread::hardware_concurrency()), 1, most_threads);
}

std::string echo(const CommandInfo& info, const OptionList& options) {
  const auto values = options.in_effect();
  std::size_t width = 0;
  for (const auto& [name, value] : values) width = std::max(width, name.size());
  std::string text = fmt::format("kinetostat {}\n", info.name);
  for (const auto& [name, value] : values)
    text += fmt::format("  {:<{}}  {}\n", name, width, common::printable(value));
  return text + "\n";
}

io::Json options_json(const OptionList& options) {
  io::Json json = io::Json::object();
  for (const auto& [name, value] : options.in_effect()) json[name] = value;
  return json;
}

io::Json provenance(const CommandInfo& info, const OptionList& options) {
  io::Json json;
  json["tool"] = fmt::format("kinetostat {}", version());
  json["command"] = info.name;
  json["options"] = options_json(options);
  return json;
}

std::string fault(const std::exception& error) {
  return fmt::format(
      "this is a fault of the program, please report it with the files that caused it: {}",
      error.what());
}

constexpr std::size_t help_columns = 80;

// Help in lines of at most 80 columns. What is too long goes on below its description, or (an
// example, after `deep` blanks) as a shell takes it.
std::string folded(const std::string& help) {
  std::istringstream lines(help);
  std::string result, line;
  while (std::getline(lines, line)) {
    const std::size_t text = line.find_first_not_of(' ');
    const bool is_command =
        text != std::string::npos && line.substr(text).starts_with("kinetostat ");
    std::size_t indent = text == std::string::npos ? 0 : text;
    if (is_command)
      indent += 4;
    else if (const std::size_t gap = line.find("  ", indent); gap != std::string::npos)
      indent = std::min<std::size_t>(line.find_first_not_of(' ', gap), 30);
    const std::size_t most = help_columns - (is_command ? 2 : 0);
    while (line.size() > help_columns) {
      const std::size_t at = line.rfind(' ', most);
      if (at == std::string::npos || at <= indent) break;
      result += line.substr(0, at) + (is_command ? " \\\n" : "\n");
      line = std::string(indent, ' ') + line.substr(at + 1);
    }
    result += line + "\n";
  }
  return result;
}

// Commands by what they are about, in the order of the help; the first word of a name decides.
struct Group {
  std::string_view title;
  std::vector<std::string_view> words;
};
const std::vector<Group>& groups() {
  static const std::vector<Group> all = {
      {"Links", {"mesh", "identify", "beam", "modes"}},
      {"Robots",
       {"import", "export", "stiffness", "deflect", "trace", "assemble", "map", "compensate"}},
      {"Measurements",
       {"study", "readings", "measure", "compare", "calibrate", "diagnose", "adopt", "revert",
        "plan", "simulate", "effect", "studio"}},
      {"Files and pages", {"new", "report", "sweep", "join", "fleet", "demo"}}};
  return all;
}

std::string took(double seconds) {
  return seconds < 60 ? fmt::format("{:.1f} s", seconds) : clock_text(seconds) + " min";
}

// The headline bold, the next step in colour. On a terminal only, and not where NO_COLOR is set.
bool shows_colours(std::FILE* stream) {
  const char* terminal = std::getenv("TERM");
  return ::isatty(::fileno(stream)) == 1 && std::getenv("NO_COLOR") == nullptr &&
         terminal != nullptr && std::string_view(terminal) != "dumb";
}

// Its first sentence: lines up to the first that ends with a full stop or a blank one.
std::size_t end_of_headline(const std::string& text) {
  for (std::size_t at = 0, end; (end = text.find('\n', at)) != std::string::npos; at = end + 1)
    if (end == at || text[end - 1] == '.' || end > 400) return end;
  return 0;
}

// The files that this run writes, but for standard output. Throws UsageError when two are one.
std::vector<std::filesystem::path> outputs_of(const OptionList& options) {
  std::vector<std::filesystem::path> files;
  std::vector<std::string> named_by;
  const auto same = [](const std::filesystem::path& a, const std::filesystem::path& b) {
    namespace fs = std::filesystem;
    return fs::weakly_canonical(fs::absolute(a)) == fs::weakly_canonical(fs::absolute(b));
  };
  for (const auto& [name, file] : options.outputs()) {
    if (file == "-" && name == "json") continue;
    if (file == "-")
      throw UsageError("--" + name, "'-' is standard output, which takes --json only",
                       "Name a file");
    for (std::size_t i = 0; i < files.size(); ++i)
      if (same(files[i], file))
        throw UsageError("--" + name, fmt::format("'{}' is named by --{} too", file, named_by[i]),
                         "Name two different files");
    files.emplace_back(file);
    named_by.push_back(name);
  }
  return files;
}

// KEY=VALUE of --set.
std::vector<Setting> settings_of(const std::vector<std::string>& texts) {
  std::vector<Setting> settings;
  for (const std::string& text : texts) {
    const std::size_t sign = text.find('=');
    if (sign == std::string::npos || sign == 0)
      throw UsageError("--set", fmt::format("'{}' is not KEY=VALUE", text),
                       "Write --set links.upper.beam.length='300 mm'");
    settings.emplace_back(text.substr(0, sign), text.substr(sign + 1));
  }
  return settings;
}

std::string page_sentence(const char* sort) {
  return fmt::format("\nBy its keys this is a {} file, described in docs/reference/{}-file.md.",
                     sort, sort);
}

// The page of the reference that describes a file with a mistake in it, by what the file says that
// it is; empty where none does.
std::string page_about(const common::InputError& error) {
  const std::filesystem::path& file = error.details().file;
  const std::string extension = file.extension().string();
  const bool text = extension == ".csv" || extension == ".tsv" || extension == ".txt";
  if (!text && extension != ".yaml" && extension != ".yml") return {};
  switch (io::document_kind(file)) {
    case io::DocumentKind::link:
      return page_sentence("link");
    case io::DocumentKind::campaign:
      return page_sentence("campaign");
    case io::DocumentKind::robot:
      return page_sentence("robot");
    case io::DocumentKind::table:
      break;
    default:
      return {};
  }
  // Readings have loads or displacements; tables of poses have neither, and a page for each use.
  const std::string start = io::read_start(file, 4096);
  for (const char* name : {"dx", "dy", "dz", "fx", "fy", "fz"})
    if (start.find(name) != std::string::npos)
      return "\nIts columns are described in docs/reference/campaign-file.md.";
  return {};
}

// An option that is given has a value: that of a variable of the shell may be missing.
void require_values(const CLI::App& app) {
  for (const CLI::Option* option : app.get_options())
    for (const std::string& value : option->results())
      if (value.empty())
        throw UsageError(option->get_name(), "the value is empty", "Give one, or leave it out");
}

}  // namespace

std::string words_of(const common::InputErrors& errors, bool verbose) {
  if (verbose) return errors.all();
  return std::string(errors.what()) + (errors.is_cut() ? ", with --verbose" : "");
}

UsageError::UsageError(const std::string& option, const std::string& what, const std::string& cure)
    : std::runtime_error(common::InputError(option, what, cure).what()) {}

std::optional<std::filesystem::path> Run::out() const {
  if (options_.out.empty()) return std::nullopt;
  return options_.out;
}

Program::Program(Streams streams)
    : streams_(streams),
      app_(std::make_unique<CLI::App>(
          "Stiffness of robots and machine tools, from the CAD mesh of a link to measurements.",
          "kinetostat")) {
  app_->formatter(help_formatter());
  app_->set_help_flag("-h,--help", "Print this help and exit");
  app_->add_flag("--version")->description("Print the version, what is linked and its licences");
  Option(app_->add_option("--completion", shell_, "Print what completes the line in this shell"))
      .one_of(completed_shells());
  app_->add_option("--manual", manual_folder_, "Write the man pages there");
  app_->option_defaults()->always_capture_default();
}

Program::~Program() = default;

OptionList Program::add(const CommandInfo& info, Action action) {
  const std::string name = info.name.substr(info.name.rfind(' ') + 1);
  CLI::App* app = group_of(info.name).add_subcommand(name, info.summary);
  app->set_help_flag("-h,--help", "Print this help and exit");
  app->footer(fmt::format("Example:\n  {}", info.example));
  commands_.push_back(std::make_unique<Command>(Command{info, app, std::move(action)}));
  return OptionList(*app);
}

// The app that holds a command: "mesh" for "mesh check", the program itself for "stiffness".
CLI::App& Program::group_of(const std::string& name) {
  const std::size_t blank = name.rfind(' ');
  if (blank == std::string::npos) return *app_;
  const std::string group = name.substr(0, blank);
  for (CLI::App* known : app_->get_subcommands({}))
    if (known->get_name() == group) return *known;
  CLI::App* app =
      app_->add_subcommand(group, fmt::format("The commands that start with '{}'", group));
  app->require_subcommand(1);
  return *app;
}

void Program::add_common_options(const Command& command) {
  OptionList options = command.options();
  const auto add = [&options](const char* name, std::string& file, const std::string& what) {
    options.add_output(name, file, what).group(OptionList::common_group);
  };
  add("--json", options_.json, "Write the result as JSON; '-' is standard output");
  add("--html", options_.html,
      "Write the result as a page to look at, one file that needs no other");
  const char* out = "-o,--out";
  const std::string& what = command.info.out;
  if (command.info.out_is_folder)
    options.add_option(out, options_.out, what).type_name("DIR").group(OptionList::common_group);
  else
    add(out, options_.out, what.empty() ? "Write the report to a file as well" : what);
  if (takes_set(command.info.name))
    options
        .add_option(
            "--set", changes_,
            "Another value in the robot, link or campaign file for this run, by its keys: "
            "links.upper.beam.length='300 mm', chain_types.arm.q1.stiffness=2e5; any number "
            "of times")
        .type_name("KEY=VALUE")
        .hide_default()
        .one_at_a_time();
  options.add_option("--threads", options_.threads, "Threads to use; all processors unless given")
      .group(OptionList::common_group)
      .type_name("N")
      .hide_default()
      .between(1, most_threads);
  options
      .add_flag("-v,--verbose", options_.verbose,
                "Print everything: options in effect, all tables and tests")
      .group(OptionList::common_group);
  options.add_flag("-q,--quiet", options_.quiet, "No progress and no remarks")
      .group(OptionList::common_group);
}

// Each with the heading that it stands under.
std::vector<std::pair<std::string_view, const Program::Command*>> Program::in_order() const {
  std::vector<std::pair<std::string_view, const Command*>> ordered;
  const auto add = [&](std::string_view title, std::string_view word) {
    for (const auto& command : commands_) {
      const std::string& name = command->info.name;
      const bool is_asked =
          word.empty() || name == word || name.starts_with(std::string(word) + " ");
      const bool is_new = std::none_of(ordered.begin(), ordered.end(), [&](const auto& known) {
        return known.second == command.get();
      });
      if (is_asked && is_new) ordered.emplace_back(title, command.get());
    }
  };
  for (const Group& group : groups())
    for (const std::string_view word : group.words) add(group.title, word);
  add("Others", "");
  return ordered;
}

std::string Program::help_footer() const {
  std::string text;
  std::string_view heading;
  for (const auto& [title, command] : in_order()) {
    if (title != heading) text += fmt::format("{}{}\n", text.empty() ? "" : "\n", title);
    heading = title;
    text += fmt::format("  {:<14}  {}\n", command->info.name, command->info.summary);
  }
  return text +
         "\n'kinetostat COMMAND --help' describes one command, with an example;\n"
         "'kinetostat --version' says what is linked, and its licences;\n"
         "'kinetostat --completion bash' (zsh, fish) completes the line in a shell;\n"
         "'kinetostat --manual DIR' writes the man pages.";
}

ProgramText Program::described() const {
  ProgramText text{.version = version(), .purpose = app_->get_description(), .commands = {}};
  for (const auto& [title, command] : in_order())
    text.commands.push_back({.name = command->info.name,
                             .summary = command->info.summary,
                             .heading = std::string(title),
                             .example = command->info.example,
                             .options = command->options().described()});
  return text;
}

std::string Program::help() {
  if (chosen() != nullptr || !app_->get_subcommands().empty()) return folded(app_->help());
  return folded(fmt::format("{}\n\nUsage: kinetostat COMMAND ...\n\n{}\n", app_->get_description(),
                            help_footer()));
}

const Program::Command* Program::chosen() const {
  for (const auto& command : commands_)
    if (command->app->parsed()) return command.get();
  return nullptr;
}

int Program::run(int argc, const char* const* argv) {
  const auto complain = [this](ExitCode code, const std::string& what) {
    say(fmt::format("kinetostat: {}\n", what));
    return code;
  };
  const auto run_out = [this] {
    std::fputs(no_memory, streams_.err);  // which takes none itself
    return out_of_memory;
  };
  try {
    return parse_and_run(argc, argv);
  } catch (const common::Cancelled&) {
    say("kinetostat: stopped; no result was written.\n");
    return 128 + cancelling_signal();
  } catch (const UsageError& error) {
    return complain(bad_usage, error.what());
  } catch (const MisplacedFile& error) {
    return complain(bad_input, error.what());
  } catch (const common::InputErrors& errors) {
    return complain(bad_input, words_of(errors, options_.verbose) + page_about(errors));
  } catch (const common::InputError& error) {
    return complain(bad_input, error.what() + page_about(error));
  } catch (const common::NoConvergence& error) {
    return complain(no_convergence, error.what());
  } catch (const common::NotIdentifiable& error) {
    return complain(not_identifiable, error.what());
  } catch (const std::filesystem::filesystem_error& error) {
    return complain(bad_input, common::InputError(error.path1(), error.code().message(),
                                                  "Check the path and that you may use it")
                                   .what());
  } catch (const common::OutOfMemory& error) {
    return complain(out_of_memory, error.what());
  } catch (const std::bad_alloc&) {
    return run_out();
  } catch (const std::system_error& error) {
    // Neither threads nor processes can be started: there is no memory for their stacks.
    if (error.code() == std::errc::not_enough_memory ||
        error.code() == std::errc::resource_unavailable_try_again)
      return run_out();
    return complain(failure, fault(error));
  } catch (const std::exception& error) {
    return complain(failure, fault(error));
  }
}

int Program::parse_and_run(int argc, const char* const* argv) {
  options_.threads = processor_count();
  // Last, so that the help of a command starts with its own options.
  for (const auto& command : commands_) add_common_options(*command);
  try {
    app_->parse(argc, argv);
  } catch (const CLI::CallForHelp&) {
    write(help());
    return done;
  } catch (const CLI::ParseError& error) {
    return usage_error(error.what(), {argv + std::min(argc, 1), argv + argc});
  }
  if (const Command* command = chosen()) {
    require_values(*command->app);
    run_action(*command);
  } else {
    answer();
  }
  return done;
}

// Without a command: what the program says of itself.
void Program::answer() {
  if (!manual_folder_.empty()) {
    for (const ManPage& page : man_pages(described()))
      io::write_atomically(std::filesystem::path(manual_folder_) / page.file, page.text);
  } else if (!shell_.empty()) {
    write(completion(described(), shell_));
  } else {
    write((*app_)["--version"]->count() > 0 ? version_report() : help());
  }
}

int Program::usage_error(const std::string& what, const std::vector<std::string>& arguments) {
  const Command* command = chosen();
  const std::string name = command == nullptr ? "" : " " + command->info.name;
  say(fmt::format("kinetostat{}: {}.{}\nSee 'kinetostat{} --help'.\n", name, what, hint(arguments),
                  name));
  return bad_usage;
}

// "Did you mean" for the first argument that looks like a mistyped command or option.
std::string Program::hint(const std::vector<std::string>& arguments) const {
  const Command* command = chosen();
  std::vector<std::string> known;
  if (command == nullptr) {
    known = {"--help", "--version"};
    for (const CLI::App* app : app_->get_subcommands({})) known.push_back(app->get_name());
  } else {
    known = command->options().long_names();
  }
  for (const std::string& argument : arguments) {
    const std::string word = argument.substr(0, argument.find('='));
    if (command != nullptr && !word.starts_with("--")) continue;
    if (std::find(known.begin(), known.end(), word) != known.end()) continue;
    const std::string near = common::nearest_spelling(word, known);
    if (!near.empty()) return fmt::format(" Did you mean '{}'?", near);
  }
  return {};
}

void Program::run_action(const Command& command) {
  const auto start = std::chrono::steady_clock::now();
  refuse_misplaced_files(command.info.name, command.options().positionals());
  const io::Outputs outputs(outputs_of(command.options()));
  const io::ReadAs changed(changed_files(command.options().positionals(), settings_of(changes_)));
  if (command.info.out_is_folder && !options_.out.empty())
    io::require_writable(std::filesystem::path(options_.out) / "file");
  if (!options_.html.empty()) report::require_pages();
  const bool text = options_.json != "-";
  if (text && options_.verbose) write(echo(command.info, command.options()));
  ProgressBar progress(streams_.err, options_.quiet ? ProgressBar::Style::none
                                                    : ProgressBar::style_for(streams_.err));
  Run run(
      options_, options_json(command.options()), progress,
      [this](std::string_view said) { write(said); },
      [this, &progress](std::string_view said) {
        progress.wipe();
        say(fmt::format("kinetostat: {}\n", said));
      });
  const io::Json result = command.action(run);
  progress.wipe();
  // What an action gives although it was stopped is worth having.
  if (progress.cancelled() && run.shortfall().empty() && !command.info.runs_until_stopped)
    throw common::Cancelled();
  deliver(command, run, result);
  const std::chrono::duration<double> time = std::chrono::steady_clock::now() - start;
  if (!options_.quiet && time.count() >= 1)
    say(fmt::format("kinetostat: {}\n", took(time.count())));
  if (run.refusal()) throw *run.refusal();
  if (!run.shortfall().empty()) throw common::NoConvergence(run.shortfall());
  if (!run.unidentified().empty()) throw common::NotIdentifiable(run.unidentified());
}

void Program::write_page(const Command& command, const Run& run, const io::Json& result) {
  io::Json json = provenance(command.info, command.options());
  json.update(result);
  std::vector<report::PageResult> results = run.page();
  results.insert(results.begin(), {json, run.picture(), run.report()});
  io::write_atomically(options_.html, report::page(report::title_of(json), results));
}

void Program::deliver(const Command& command, const Run& run, const io::Json& result) {
  if (run.out() && command.info.out.empty()) io::write_atomically(*run.out(), run.report());
  if (!options_.html.empty()) write_page(command, run, result);
  if (!options_.json.empty()) {
    io::Json json = provenance(command.info, command.options());
    json.update(result);
    if (options_.json == "-") {
      write(io::to_text(json));
      return;
    }
    io::write_json(options_.json, json);
  }
  write_screen(run.screen());
}

void Program::write_screen(const std::string& text) {
  if (!shows_colours(streams_.out)) return write(text);
  const std::size_t headline = end_of_headline(text), next = text.rfind("\nNext: ");
  std::fputs("\x1b[1m", streams_.out);
  write(std::string_view(text).substr(0, headline));
  std::fputs("\x1b[0m", streams_.out);
  write(std::string_view(text).substr(headline,
                                      next == std::string::npos ? next : next + 1 - headline));
  if (next == std::string::npos) return;
  std::fputs("\x1b[36m", streams_.out);
  write(std::string_view(text).substr(next + 1));
  std::fputs("\x1b[0m", streams_.out);
}

// What others wrote into files must not command the terminal. A full disk or a closed pipe behind
// standard output must not pass for success.
void Program::write(std::string_view text) {
  const std::string shown = common::printable(text, "\n\t");
  std::fwrite(shown.data(), 1, shown.size(), streams_.out);
  if (std::fflush(streams_.out) != 0 || std::ferror(streams_.out) != 0)
    throw common::InputError("standard output", "cannot be written to",
                             "Check that the disk behind it is not full");
}

// Nothing can be reported when standard error is full or closed.
void Program::say(std::string_view text) const {
  std::fputs(common::printable(text, "\n\t").c_str(), streams_.err);
  std::fflush(streams_.err);
}

}  // namespace kinetostat::apps
