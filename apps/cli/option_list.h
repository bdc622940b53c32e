// The options of one command. CLI11 behind it is parsed by one unit only: its headers cost each
// unit that includes them more than all of its own code.
#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "kinetostat/apps/manual/program_text.h"

namespace CLI {
class App;
class FormatterBase;
class Option;
}  // namespace CLI

namespace kinetostat::apps {

/// One option, as a handle: copies name the same option. Its value goes into the variable that it
/// was added with.
class Option {
 public:
  explicit Option(CLI::Option* option) : option_(option) {}

  Option required();
  /// What stands for the value in the help: "FILE".
  Option type_name(const std::string& name);
  /// The help shows the value that the variable has now.
  Option show_default();
  /// The help shows no default.
  Option hide_default();
  /// Values are refused below `least` and above `most`.
  Option between(double least, double most);
  Option positive();
  /// Values other than these are refused. The description names them.
  Option one_of(const std::vector<std::string>& values);
  /// A whole number from 0 on: unsigned conversion alone would take -1 for a large one.
  Option seed();
  /// "2 GB", "512 MB", in powers of 1000; bytes without a unit.
  Option size_in_bytes();
  /// Several values in one, separated by this.
  Option delimiter(char separator);
  /// How many values.
  Option count(int least, int most);
  /// One value each time that the option is given.
  Option one_at_a_time();
  Option excludes(const std::string& option);
  Option excludes(Option other);
  Option needs(Option other);
  /// Heading under which the help lists it.
  Option group(const std::string& heading);

 private:
  CLI::Option* option_;
};

/// The options of one command, as a handle. Names are "--long", "-s,--long", or without dashes for
/// a positional.
class OptionList {
 public:
  explicit OptionList(CLI::App& app) : app_(&app) {}

  /// T: std::string, bool, int, unsigned, std::int64_t, std::size_t, double, std::optional of one
  /// of these, or std::vector of std::string, int, double.
  template <class T>
  Option add_option(const std::string& name, T& value, const std::string& description);
  Option add_flag(const std::string& name, bool& value, const std::string& description);
  /// A flag that says what is done anyway.
  Option add_flag(const std::string& name, const std::string& description);
  /// An option that names a file to write, --json among them. Before anything is computed it is
  /// known that the file can be written and that no other option names it; while the command runs,
  /// it cannot be read (io::Outputs).
  Option add_output(const std::string& name, std::string& file, const std::string& description);
  /// The same, which may be given several times.
  Option add_outputs(const std::string& name, std::vector<std::string>& files,
                     const std::string& description);

  /// A name without dashes and its value.
  using NamedValue = std::pair<std::string, std::string>;
  /// The options that decide the result, with defaults filled in. The common ones (threads, files,
  /// quiet) and
  /// --no-cache and --share change no figure, so they are left out: the same input gives the same
  /// bytes on any machine.
  std::vector<NamedValue> in_effect() const;
  /// The files that were given to options of add_output().
  std::vector<NamedValue> outputs() const;
  /// What stands on the command line without the name of an option, in the order of the help.
  std::vector<std::string> positionals() const;
  /// "--json", ...
  std::vector<std::string> long_names() const;
  /// All of them, as in the help: first what stands without a name, then heading by heading.
  std::vector<OptionText> described() const;

  /// Heading of the options that every command has.
  static constexpr char common_group[] = "Options of every command";

 private:
  CLI::App* app_;
};

/// How the help of a command shows its options: "--draws N   Simulated campaigns (default: 500)",
/// what stands for the value beside the name, and what else is to be known, which others it needs
/// or excludes, in its description.
std::shared_ptr<CLI::FormatterBase> help_formatter();

}  // namespace kinetostat::apps
