#include "kinetostat/apps/manual/man_pages.h"

#include <algorithm>
#include <cctype>

#include <fmt/format.h>

namespace kinetostat::apps {
namespace {

struct Ending {
  const char *code, *meaning;
};
constexpr Ending endings[] = {
    {"0", "Done."},
    {"1", "A fault of the program."},
    {"2", "The command line is wrong."},
    {"3", "A file is wrong; the message says where, and what would work."},
    {"4", "A computation did not converge, or stopped short."},
    {"5", "The data do not determine what was asked for."},
    {"6", "Not enough memory."},
    {"130, 143", "Stopped by a signal."},
};

// Text as it stands: no character is taken for a macro or an escape.
std::string literal(const std::string& text) {
  std::string result;
  for (const char c : text) {
    const bool starts_line = result.empty() || result.back() == '\n';
    if (starts_line && (c == '.' || c == '\'')) result += "\\&";
    if (starts_line && c == ' ') continue;
    if (c == '\\')
      result += "\\e";
    else if (c == '-')
      result += "\\-";
    else if (c == '\'')
      result += "\\(aq";
    else if (c == '^')
      result += "\\(ha";
    else if (c == '~')
      result += "\\(ti";
    else
      result += c;
  }
  return result;
}

std::string in_capitals(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  return text;
}

// "kinetostat-mesh-check"
std::string page_name(const std::string& command) {
  std::string name = "kinetostat-" + command;
  std::replace(name.begin(), name.end(), ' ', '-');
  return name;
}

std::string head(const ProgramText& program, const std::string& page, const std::string& summary) {
  return fmt::format(
      ".TH {} 1 \"\" \"kinetostat {}\" \"User Commands\"\n.SH NAME\n{} \\- {}\n.SH SYNOPSIS\n",
      literal(in_capitals(page)), program.version, literal(page), literal(summary));
}

// "\fB-o\fR, \fB--out\fR \fIFILE\fR"
std::string term(const OptionText& option) {
  std::string text;
  for (const std::string& name : option.names)
    text += fmt::format("{}\\fB{}\\fR", text.empty() ? "" : ", ", literal(name));
  if (option.value.empty()) return text;
  return text + fmt::format("{}\\fI{}\\fR", text.empty() ? "" : " ", literal(option.value));
}

std::string options(const CommandText& command) {
  std::string text, heading;
  for (const OptionText& option : command.options) {
    if (option.heading != heading) text += fmt::format(".SH \"{}\"\n", in_capitals(option.heading));
    heading = option.heading;
    text += fmt::format(".TP\n{}\n{}\n", term(option), literal(option.description));
  }
  return text;
}

std::string exit_status() {
  std::string text = ".SH \"EXIT STATUS\"\n";
  for (const Ending& ending : endings)
    text += fmt::format(".TP\n.B {}\n{}\n", ending.code, ending.meaning);
  return text;
}

std::string page_of(const ProgramText& program, const CommandText& command) {
  std::string text = head(program, page_name(command.name), command.summary);
  text += fmt::format(".B kinetostat {}\n[\\fIOPTIONS\\fR]", literal(command.name));
  for (const OptionText& option : command.options)
    if (option.names.empty()) text += fmt::format(" \\fI{}\\fR", literal(option.value));
  text += "\n" + options(command);
  text += fmt::format(".SH EXAMPLE\n.nf\n{}\n.fi\n", literal(command.example));
  return text + exit_status() + ".SH \"SEE ALSO\"\n.BR kinetostat (1)\n";
}

std::string main_page(const ProgramText& program) {
  std::string text = head(program, "kinetostat", "stiffness of robots and machine tools") +
                     ".B kinetostat\n\\fICOMMAND\\fR ...\n.br\n.B kinetostat \\-\\-version\n.br\n"
                     ".B kinetostat \\-\\-completion\n\\fISHELL\\fR\n.br\n.B kinetostat "
                     "\\-\\-manual\n\\fIDIR\\fR\n"
                     ".SH DESCRIPTION\n" +
                     literal(program.purpose) + "\n";
  std::string heading;
  for (const CommandText& command : program.commands) {
    if (command.heading != heading) text += fmt::format(".SS {}\n", command.heading);
    heading = command.heading;
    text += fmt::format(".TP\n.BR {} (1)\n{}\n", literal(page_name(command.name)),
                        literal(command.summary));
  }
  return text + exit_status();
}

}  // namespace

std::vector<ManPage> man_pages(const ProgramText& program) {
  std::vector<ManPage> pages = {{"kinetostat.1", main_page(program)}};
  for (const CommandText& command : program.commands)
    pages.push_back({page_name(command.name) + ".1", page_of(program, command)});
  return pages;
}

}  // namespace kinetostat::apps
