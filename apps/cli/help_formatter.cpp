#include "kinetostat/apps/cli/help_formatter.h"

#include <algorithm>
#include <set>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <fmt/ranges.h>

namespace kinetostat::apps {
namespace {

std::string listed(const std::set<CLI::Option*>& options) {
  std::vector<std::string> names;
  for (const CLI::Option* option : options) names.push_back(option->get_name());
  std::sort(names.begin(), names.end());
  return fmt::format("{}", fmt::join(names, " or "));
}

// What stands for the value, without what its validators say.
std::string type_of(const CLI::Option* option) {
  const std::string type = option->get_type_name();
  return type.substr(0, type.find(':'));
}

// "ROBOT", "[ROBOT] CAMPAIGN"; in brackets what may be left out.
std::string positional(const CLI::Option* option) {
  const std::string type = type_of(option);
  const std::string name = type == "TEXT" ? option->get_name(true) : type;
  return option->get_required() || name.starts_with('[') ? name : "[" + name + "]";
}

class HelpFormatter : public CLI::Formatter {
 public:
  HelpFormatter() {
    for (const char* number : {"INT", "UINT", "FLOAT"}) label(number, "N");
  }

  std::string make_option_name(const CLI::Option* option, bool is_positional) const override {
    return is_positional ? positional(option) : Formatter::make_option_name(option, false);
  }

  std::string make_option_opts(const CLI::Option* option) const override {
    if (option->get_positional() || option->get_type_size() == 0) return "";
    return " " + get_label(type_of(option));
  }

  std::string make_option_desc(const CLI::Option* option) const override {
    std::string text = option->get_description();
    const auto add = [&text](const std::string& what) { text += fmt::format(" ({})", what); };
    if (option->get_required() && !option->get_positional()) add("required");
    const std::string value = option->get_default_str();
    const bool is_known =
        value.empty() || value == "[]" || text.find("default:") != std::string::npos;
    if (option->get_type_size() > 0 && !is_known) add("default: " + value);
    if (!option->get_needs().empty()) add("with " + listed(option->get_needs()));
    if (!option->get_excludes().empty()) add("not with " + listed(option->get_excludes()));
    return text;
  }

  std::string make_option_usage(const CLI::Option* option) const override {
    return positional(option);
  }

  std::string make_group(std::string group, bool is_positional,
                         std::vector<const CLI::Option*> options) const override {
    // CLI11 sets two blank lines between groups.
    const bool is_first = is_positional || group == "Options";
    const std::string text =
        Formatter::make_group(std::move(group), is_positional, std::move(options));
    return is_first ? text : text.substr(1);
  }
};

}  // namespace

std::shared_ptr<CLI::FormatterBase> help_formatter() { return std::make_shared<HelpFormatter>(); }

}  // namespace kinetostat::apps
