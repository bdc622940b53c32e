// Common parts of all commands of the program: options, output, progress, exit codes.
//
// A command is one file with one function, `void add_<command>(Program&)`, which names the command,
// adds its options and gives the action. Everything else happens here.
#pragma once

#include <cstdio>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "kinetostat/apps/cli/option_list.h"
#include "kinetostat/common/error.h"
#include "kinetostat/common/faults.h"
#include "kinetostat/common/progress.h"
#include "kinetostat/io/json.h"
#include "kinetostat/report/page.h"

namespace kinetostat::apps {

/// How the program ends. Cancellation ends it with 128 + the signal's number, as shells expect.
enum ExitCode : int {
  done = 0,
  failure = 1,  // a fault of the program itself
  bad_usage = 2,
  bad_input = 3,
  no_convergence = 4,
  not_identifiable = 5,
  out_of_memory = 6,
};

/// An option whose value is not understood, when only the command itself knows. Reads "--at: '1,2'
/// has 2 values, not 3 or 6. Separate them with commas." Ends the program with exit code 2.
class UsageError : public std::runtime_error {
 public:
  UsageError(const std::string& option, const std::string& what, const std::string& cure = {});
};

/// One screen of it, or all.
std::string words_of(const common::InputErrors& errors, bool verbose);

/// Where text goes. Tests put their own streams here.
struct Streams {
  std::FILE* out = stdout;
  std::FILE* err = stderr;
};

/// The options that every command has.
struct CommonOptions {
  std::string json;  // a file, or "-" for standard output; empty when not asked for
  std::string html;  // a file; empty when not asked for
  std::string out;   // a file; empty when not asked for
  int threads = 1;
  bool quiet = false, verbose = false;
};

/// One run of one command, as its action sees it.
class Run {
 public:
  Run(const CommonOptions& options, io::Json command_options, common::Progress& progress,
      std::function<void(std::string_view)> write_now,
      std::function<void(std::string_view)> say_aside)
      : options_(options),
        command_options_(std::move(command_options)),
        progress_(progress),
        write_now_(std::move(write_now)),
        say_aside_(std::move(say_aside)) {}

  /// Adds to the report for people, which goes to standard output. The text brings its own line
  /// ends.
  void print(std::string_view text) {
    report_ += text;
    screen_ += text;
  }
  /// Adds what standard output has with --verbose only; the file of --out and the page have it
  /// always.
  void print_more(std::string_view text) {
    report_ += text;
    if (options_.verbose) screen_ += text;
  }

  bool is_verbose() const { return options_.verbose; }

  /// Goes to standard output at once, for commands that stay.
  void say_now(const std::string& text) const { write_now_(text); }
  /// Sentences about the run itself, not about its result, which stays the same bytes: they go to
  /// standard error at once. Remarks are left out with --quiet.
  void warn(const std::string& sentence) const { say_aside_("warning: " + sentence); }
  void remark(const std::string& sentence) const {
    if (!options_.quiet) say_aside_(sentence);
  }
  /// Whether the result goes into a page; then its pictures are wanted.
  bool wants_page() const { return !options_.html.empty(); }
  /// Whether the result itself is written, as JSON or on a page; else only the report is.
  bool wants_result() const { return wants_page() || !options_.json.empty(); }
  /// Data that charts of the result need and the result itself does not hold.
  void draw(io::Json picture) { picture_ = std::move(picture); }
  /// Further results that belong on the same page, each with its own tool, command and options.
  void add_to_page(report::PageResult result) { page_.push_back(std::move(result)); }

  /// The result is only part of what was asked for: it is delivered, then the reason is said and
  /// the program ends with exit code 4.
  void stop_short(std::string reason) { shortfall_ = std::move(reason); }
  /// The data do not determine a part of what was asked: the rest is delivered, then the reason is
  /// printed and the program ends with exit code 5.
  void leave_unidentified(std::string reason) { unidentified_ = std::move(reason); }
  /// The result says that the input is unsound: it is delivered, then the program ends with exit
  /// code 3 and this error.
  void refuse(common::InputError error) { refusal_ = std::move(error); }

  common::Progress& progress() { return progress_; }
  /// The options of the command itself, defaults filled in, by their names.
  const io::Json& options() const { return command_options_; }
  int threads() const { return options_.threads; }
  /// The file of --out, for commands whose product is not the report itself.
  std::optional<std::filesystem::path> out() const;

  const std::string& report() const { return report_; }
  const std::string& screen() const { return screen_; }  // the part of it for standard output
  const io::Json& picture() const { return picture_; }
  const std::vector<report::PageResult>& page() const { return page_; }
  const std::string& shortfall() const { return shortfall_; }
  const std::string& unidentified() const { return unidentified_; }
  const std::optional<common::InputError>& refusal() const { return refusal_; }

 private:
  const CommonOptions& options_;
  io::Json command_options_;
  common::Progress& progress_;
  std::function<void(std::string_view)> write_now_, say_aside_;
  std::string report_, screen_;
  io::Json picture_;
  std::vector<report::PageResult> page_;
  std::string shortfall_, unidentified_;
  std::optional<common::InputError> refusal_;
};

/// Name and purpose of a command.
struct CommandInfo {
  std::string name;     // "stiffness", or "mesh check" for a command in a group
  std::string summary;  // one line, no full stop
  std::string example;  // a whole command line that works in the source folder
  /// Content of --out when it is not the report as text; the action then writes it to run.out().
  std::string out = {};
  bool out_is_folder = false;       // --out, instead of a file
  bool runs_until_stopped = false;  // the first Ctrl-C is its proper end
};

/// Computes, prints the report for people through the run, and returns the result for programs.
/// Throws UsageError, common::InputError, NoConvergence, NotIdentifiable or Cancelled for what
/// users can repair.
using Action = std::function<io::Json(Run&)>;

class Program {
 public:
  explicit Program(Streams streams = {});
  ~Program();
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;

  /// The returned handle takes the options of this command. Options that name files must not check
  /// that they exist: a missing file is bad input, not bad usage.
  OptionList add(const CommandInfo& info, Action action);

  /// All that it can be asked.
  ProgramText described() const;

  /// Parses, runs, reports. Never throws. Call it once.
  int run(int argc, const char* const* argv);

 private:
  struct Command {
    CommandInfo info;
    CLI::App* app;
    Action action;

    OptionList options() const { return OptionList(*app); }
  };

  int parse_and_run(int argc, const char* const* argv);
  CLI::App& group_of(const std::string& name);
  void add_common_options(const Command& command);
  std::string help();
  std::vector<std::pair<std::string_view, const Command*>> in_order() const;
  std::string help_footer() const;
  const Command* chosen() const;
  void answer();
  int usage_error(const std::string& what, const std::vector<std::string>& arguments);
  std::string hint(const std::vector<std::string>& arguments) const;
  void run_action(const Command& command);
  void write_page(const Command& command, const Run& run, const io::Json& result);
  void deliver(const Command& command, const Run& run, const io::Json& result);
  void write(std::string_view text);
  void write_screen(const std::string& text);
  void say(std::string_view text) const;

  Streams streams_;
  CommonOptions options_;
  std::string shell_, manual_folder_;
  std::vector<std::string> changes_;  // --set
  std::vector<std::unique_ptr<Command>> commands_;
  std::unique_ptr<CLI::App> app_;
};

}  // namespace kinetostat::apps
