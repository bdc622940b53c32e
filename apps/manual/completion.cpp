#include "kinetostat/apps/manual/completion.h"

#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace kinetostat::apps {
namespace {

// "mesh" of "mesh check"; empty for a command of one word.
std::string group_of(const std::string& name) {
  const std::size_t blank = name.find(' ');
  return blank == std::string::npos ? "" : name.substr(0, blank);
}

std::string last_word(const std::string& name) { return name.substr(name.rfind(' ') + 1); }

struct Word {
  std::string word, about;
};

// What may come first on the line: commands of one word, and groups.
std::vector<Word> first_words(const ProgramText& program) {
  std::vector<Word> words;
  for (const CommandText& command : program.commands) {
    const std::string group = group_of(command.name);
    if (group.empty())
      words.push_back({command.name, command.summary});
    else if (words.empty() || words.back().word != group)
      words.push_back({group, fmt::format("The commands that start with '{}'", group)});
  }
  return words;
}

std::vector<std::string> groups(const ProgramText& program) {
  std::vector<std::string> names;
  for (const CommandText& command : program.commands)
    if (const std::string group = group_of(command.name);
        !group.empty() && std::find(names.begin(), names.end(), group) == names.end())
      names.push_back(group);
  return names;
}

std::vector<Word> words_of(const ProgramText& program, const std::string& group) {
  std::vector<Word> words;
  for (const CommandText& command : program.commands)
    if (group_of(command.name) == group)
      words.push_back({last_word(command.name), command.summary});
  return words;
}

std::string joined(const std::vector<Word>& words) {
  std::string text;
  for (const Word& word : words) text += (text.empty() ? "" : " ") + word.word;
  return text;
}

// One line that a shell can show.
std::string about(const OptionText& option) {
  std::string text = option.description.substr(0, option.description.find_first_of("\n;"));
  std::replace(text.begin(), text.end(), '\t', ' ');
  return text;
}

std::string quoted(const std::string& text) {
  std::string result = "'";
  for (const char c : text) result += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return result + "'";
}

enum class Value { none, choice, folder, number, file };

Value kind_of(const OptionText& option) {
  if (option.value.empty()) return Value::none;
  if (!option.choices.empty()) return Value::choice;
  if (option.value == "DIR" || option.value == "FOLDER") return Value::folder;
  return option.value == "N" ? Value::number : Value::file;
}

// --- bash -------------------------------------------------------------------

// "    'study -o'|'study --out')"
std::string bash_case(const CommandText& command, const OptionText& option) {
  std::string text;
  for (const std::string& name : option.names)
    text += fmt::format("{}'{} {}'", text.empty() ? "    " : "|", command.name, name);
  return text + ") ";
}

std::string bash_values(const CommandText& command) {
  std::string text;
  for (const OptionText& option : command.options) {
    if (option.names.empty()) continue;
    switch (kind_of(option)) {
      case Value::choice:
        text += bash_case(command, option) + fmt::format("_kinetostat_reply -W '{}'; return ;;\n",
                                                         fmt::join(option.choices, " "));
        break;
      case Value::folder:
        text += bash_case(command, option) + "_kinetostat_files -d; return ;;\n";
        break;
      case Value::number:
        text += bash_case(command, option) + "return ;;\n";
        break;
      case Value::file:
        text += bash_case(command, option) + "_kinetostat_files -f; return ;;\n";
        break;
      case Value::none:
        break;
    }
  }
  return text;
}

std::string bash_options(const CommandText& command) {
  std::string names;
  for (const OptionText& option : command.options)
    for (const std::string& name : option.names) names += (names.empty() ? "" : " ") + name;
  return fmt::format("    '{}') _kinetostat_reply -W '{}' ;;\n", command.name, names);
}

std::string bash(const ProgramText& program) {
  std::string text =
      "# bash completion for kinetostat: made by 'kinetostat --completion bash'\n"
      "_kinetostat_reply() { mapfile -t COMPREPLY < <(compgen \"$@\" -- \"$word\"); }\n"
      "_kinetostat_files() {\n  _kinetostat_reply \"$@\"\n"
      "  compopt -o filenames 2>/dev/null || true\n}\n"
      "_kinetostat() {\n"
      "  local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD - 1]}\n"
      "  local command=${COMP_WORDS[1]}\n  COMPREPLY=()\n";
  text += fmt::format(
      "  if ((COMP_CWORD == 1)); then\n    _kinetostat_reply -W '{} --help --version'\n"
      "    return\n  fi\n  case $command in\n",
      joined(first_words(program)));
  for (const std::string& group : groups(program))
    text += fmt::format(
        "    {}) ((COMP_CWORD == 2)) && {{ _kinetostat_reply -W '{}'; return; }}\n"
        "      command+=\" ${{COMP_WORDS[2]}}\" ;;\n",
        group, joined(words_of(program, group)));
  text += "  esac\n  case \"$command $before\" in\n";
  for (const CommandText& command : program.commands) text += bash_values(command);
  text +=
      "  esac\n  if [[ $word != -* ]]; then\n    _kinetostat_files -f\n    return\n  fi\n"
      "  case $command in\n";
  for (const CommandText& command : program.commands) text += bash_options(command);
  return text + "  esac\n}\ncomplete -F _kinetostat kinetostat\n";
}

// --- zsh --------------------------------------------------------------------

// Text within the brackets of a specification of _arguments.
std::string for_zsh(const std::string& text) {
  std::string result;
  for (const char c : text) {
    if (c == '[' || c == ']' || c == ':' || c == '\\') result += '\\';
    result += c;
  }
  return result;
}

std::string zsh_value(const OptionText& option) {
  const std::string name = for_zsh(option.value);
  switch (kind_of(option)) {
    case Value::none:
      return "";
    case Value::choice:
      return fmt::format(":{}:({})", name, fmt::join(option.choices, " "));
    case Value::folder:
      return fmt::format(":{}:_files -/", name);
    case Value::number:
      return fmt::format(":{}: ", name);
    case Value::file:
      break;
  }
  return fmt::format(":{}:_files", name);
}

// One specification for each name: the others are no longer offered when one was given.
std::string zsh_option(const OptionText& option) {
  std::string text;
  for (const std::string& name : option.names)
    text += " \\\n        " + quoted(fmt::format("({}){}[{}]{}", fmt::join(option.names, " "), name,
                                                 for_zsh(about(option)), zsh_value(option)));
  return text;
}

std::string zsh_described(const std::vector<Word>& words) {
  std::string text;
  for (const Word& word : words)
    text += " \\\n        " + quoted(word.word + ":" + for_zsh(word.about));
  return text;
}

std::string zsh(const ProgramText& program) {
  std::string text =
      "#compdef kinetostat\n# made by 'kinetostat --completion zsh'\n_kinetostat() {\n"
      "  local command=$words[2]\n  local -a choices\n  if ((CURRENT == 2)); then\n    choices=(" +
      zsh_described(first_words(program)) +
      ")\n    _describe -t commands command choices\n    return\n  fi\n  case $command in\n";
  for (const std::string& group : groups(program))
    text += fmt::format(
        "    ({})\n      choices=({})\n"
        "      ((CURRENT == 3)) && {{ _describe -t commands command choices; return }}\n"
        "      command=\"$command $words[3]\" ;;\n",
        group, zsh_described(words_of(program, group)));
  text += "  esac\n  case $command in\n";
  for (const CommandText& command : program.commands) {
    text += fmt::format("    ('{}')\n      _arguments", command.name);
    for (const OptionText& option : command.options) text += zsh_option(option);
    text += " \\\n        '*:file:_files' ;;\n";
  }
  return text +
         "  esac\n}\nif [[ $funcstack[1] == _kinetostat ]]; then\n  _kinetostat \"$@\"\n"
         "else\n  compdef _kinetostat kinetostat\nfi\n";
}

// --- fish -------------------------------------------------------------------

std::string fish_option(const CommandText& command, const OptionText& option) {
  std::string text = fmt::format("complete -c kinetostat -n '__kinetostat_is {}'", command.name);
  for (const std::string& name : option.names)
    text += name.starts_with("--") ? " -l " + name.substr(2) : " -s " + name.substr(1);
  switch (kind_of(option)) {
    case Value::none:
      break;
    case Value::choice:
      text += fmt::format(" -x -a '{}'", fmt::join(option.choices, " "));
      break;
    case Value::folder:
      text += " -x -a '(__fish_complete_directories)'";
      break;
    case Value::number:
      text += " -x";
      break;
    case Value::file:
      text += " -r -F";
      break;
  }
  std::string words = about(option);
  for (std::size_t at = 0; (at = words.find('\'', at)) != std::string::npos; at += 2)
    words.insert(at, "\\");
  return text + fmt::format(" -d '{}'\n", words);
}

std::string fish_words(const std::string& condition, const std::vector<Word>& words) {
  std::string text;
  for (const Word& word : words) {
    std::string summary = word.about;
    std::erase(summary, '\'');
    text += fmt::format("complete -c kinetostat -n '{}' -f -a {} -d '{}'\n", condition, word.word,
                        summary);
  }
  return text;
}

std::string fish(const ProgramText& program) {
  std::string text =
      "# fish completion for kinetostat: made by 'kinetostat --completion fish'\n"
      "function __kinetostat_is\n  set -l given (commandline -opc)\n"
      "  set -l last (math (count $argv) + 1)\n"
      "  test (count $given) -ge $last; and test \"$given[2..$last]\" = \"$argv\"\nend\n"
      "function __kinetostat_after\n  set -l given (commandline -opc)\n"
      "  test \"$given[2..-1]\" = \"$argv\"\nend\n"
      "function __kinetostat_first\n  test (count (commandline -opc)) -eq 1\nend\n";
  text += fish_words("__kinetostat_first", first_words(program));
  for (const std::string& group : groups(program))
    text += fish_words("__kinetostat_after " + group, words_of(program, group));
  for (const CommandText& command : program.commands)
    for (const OptionText& option : command.options)
      if (!option.names.empty()) text += fish_option(command, option);
  return text;
}

}  // namespace

const std::vector<std::string>& completed_shells() {
  static const std::vector<std::string> shells = {"bash", "zsh", "fish"};
  return shells;
}

std::string completion(const ProgramText& program, const std::string& shell) {
  if (shell == "zsh") return zsh(program);
  return shell == "fish" ? fish(program) : bash(program);
}

}  // namespace kinetostat::apps
