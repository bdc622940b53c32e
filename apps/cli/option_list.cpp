#include "kinetostat/apps/cli/option_list.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <set>
#include <string_view>
#include <type_traits>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <fmt/ranges.h>

namespace kinetostat::apps {
namespace {

// Flags the options that name a file to write.
constexpr char output_mark[] = "output";
// Before the values, a line each, in the name of the validator that an option of a few values has.
constexpr std::string_view choices_mark = "one of\n";

bool is_output(CLI::Option& option) {
  try {
    option.get_validator(output_mark);
    return true;
  } catch (const CLI::OptionNotFound&) {
    return false;
  }
}

std::string listed(const std::set<CLI::Option*>& options) {
  std::set<std::string> names;
  for (const CLI::Option* option : options) names.insert(option->get_name());
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

std::vector<std::string> lines_of(std::string_view text) {
  std::vector<std::string> lines;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    lines.emplace_back(text.substr(at, end - at));
    at = end + 1;
  }
  return lines;
}

// The values of Option::one_of(); none where others are possible.
std::vector<std::string> choices_of(CLI::Option& option) {
  try {
    for (int i = 0;; ++i)
      if (const std::string name = option.get_validator(i)->get_name();
          name.starts_with(choices_mark))
        return lines_of(std::string_view(name).substr(choices_mark.size()));
  } catch (const CLI::OptionNotFound&) {  // which is how the last one is found out
    return {};
  }
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
    if (option->get_type_size() > 0 && !value.empty() && value != "[]") add("default: " + value);
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

Option Option::required() {
  option_->required();
  return *this;
}

Option Option::type_name(const std::string& name) {
  option_->type_name(name);
  return *this;
}

Option Option::show_default() {
  option_->capture_default_str();
  return *this;
}

Option Option::hide_default() {
  option_->default_str("");
  return *this;
}

Option Option::between(double least, double most) {
  option_->check(CLI::Range(least, most).description(""));
  return *this;
}

Option Option::positive() {
  option_->check(CLI::PositiveNumber);
  return *this;
}

Option Option::one_of(const std::vector<std::string>& values) {
  option_->check(CLI::IsMember(values).description(""),
                 fmt::format("{}{}", choices_mark, fmt::join(values, "\n")));
  return *this;
}

Option Option::seed() {
  option_->check(
      CLI::Range(std::int64_t{0}, std::numeric_limits<std::int64_t>::max()).description(""));
  return *this;
}

Option Option::size_in_bytes() {
  option_->transform(CLI::AsSizeValue(true));
  return *this;
}

Option Option::delimiter(char separator) {
  option_->delimiter(separator);
  return *this;
}

Option Option::count(int least, int most) {
  option_->expected(least, most);
  return *this;
}

Option Option::one_at_a_time() {
  option_->allow_extra_args(false);
  return *this;
}

Option Option::excludes(const std::string& option) {
  option_->excludes(option);
  return *this;
}

Option Option::excludes(Option other) {
  option_->excludes(other.option_);
  return *this;
}

Option Option::needs(Option other) {
  option_->needs(other.option_);
  return *this;
}

Option Option::group(const std::string& heading) {
  option_->group(heading);
  return *this;
}

namespace {
// CLI11 reads "nan" and "inf" as numbers, and no range refuses the first.
std::string why_not_finite(const std::string& text) {
  double value = 0;
  return CLI::detail::lexical_cast(text, value) && !std::isfinite(value)
             ? fmt::format("'{}' is no finite number", text)
             : std::string();
}
}  // namespace

template <class T>
Option OptionList::add_option(const std::string& name, T& value, const std::string& description) {
  CLI::Option* option = app_->add_option(name, value, description);
  if constexpr (std::is_same_v<T, double> || std::is_same_v<T, std::optional<double>>)
    option->check(CLI::Validator(why_not_finite, ""));
  return Option(option);
}

template Option OptionList::add_option(const std::string&, std::string&, const std::string&);
template Option OptionList::add_option(const std::string&, int&, const std::string&);
template Option OptionList::add_option(const std::string&, std::int64_t&, const std::string&);
template Option OptionList::add_option(const std::string&, std::uint64_t&, const std::string&);
template Option OptionList::add_option(const std::string&, double&, const std::string&);
template Option OptionList::add_option(const std::string&, std::optional<double>&,
                                       const std::string&);
template Option OptionList::add_option(const std::string&, std::vector<std::string>&,
                                       const std::string&);
template Option OptionList::add_option(const std::string&, std::vector<int>&, const std::string&);

Option OptionList::add_flag(const std::string& name, bool& value, const std::string& description) {
  return Option(app_->add_flag(name, value, description));
}

Option OptionList::add_flag(const std::string& name, const std::string& description) {
  return Option(app_->add_flag(name)->description(description));
}

namespace {

CLI::Option* as_output(CLI::Option* option, const std::string& name) {
  const auto is_no_option = [name](const std::string& value) {
    return value.size() > 1 && value.starts_with('-')
               ? fmt::format(
                     "{} names no file: '{}' is an option. Give './{}' if the file is "
                     "called so",
                     name, value, value)
               : std::string();
  };
  return option->type_name("FILE")->check(CLI::Validator(is_no_option, "", output_mark));
}

}  // namespace

Option OptionList::add_output(const std::string& name, std::string& file,
                              const std::string& description) {
  return Option(as_output(app_->add_option(name, file, description), name));
}

Option OptionList::add_outputs(const std::string& name, std::vector<std::string>& files,
                               const std::string& description) {
  return Option(as_output(app_->add_option(name, files, description), name))
      .hide_default()
      .one_at_a_time();
}

std::vector<OptionList::NamedValue> OptionList::in_effect() const {
  std::vector<NamedValue> result;
  for (const CLI::Option* option : std::as_const(*app_).get_options()) {
    if (option->get_group() == common_group || option == app_->get_help_ptr()) continue;
    if (option->get_single_name() == "no-cache" || option->get_single_name() == "share") continue;
    const std::string value = option->count() > 0
                                  ? fmt::format("{}", fmt::join(option->results(), " "))
                                  : option->get_default_str();
    if (value.empty()) continue;
    result.emplace_back(option->get_single_name(), value);
  }
  return result;
}

std::vector<OptionList::NamedValue> OptionList::outputs() const {
  std::vector<NamedValue> files;
  for (CLI::Option* option : app_->get_options({}))
    if (is_output(*option))
      for (const std::string& file : option->results())
        files.emplace_back(option->get_single_name(), file);
  return files;
}

std::vector<std::string> OptionList::positionals() const {
  std::vector<std::string> values;
  for (const CLI::Option* option : std::as_const(*app_).get_options())
    if (option->get_positional())
      values.insert(values.end(), option->results().begin(), option->results().end());
  return values;
}

std::vector<std::string> OptionList::long_names() const {
  std::vector<std::string> names;
  for (const CLI::Option* option : std::as_const(*app_).get_options())
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  return names;
}

std::vector<OptionText> OptionList::described() const {
  const HelpFormatter formatter;
  const auto text_of = [&formatter](CLI::Option& option) {
    OptionText text{.names = {},
                    .value = option.get_positional() ? positional(&option) : type_of(&option),
                    .description = formatter.make_option_desc(&option),
                    .heading = option.get_positional() ? "Arguments" : option.get_group(),
                    .choices = choices_of(option)};
    for (const std::string& name : option.get_snames()) text.names.push_back("-" + name);
    for (const std::string& name : option.get_lnames()) text.names.push_back("--" + name);
    if (option.get_type_size() == 0) text.value.clear();
    if (text.value == "INT" || text.value == "UINT" || text.value == "FLOAT") text.value = "N";
    return text;
  };
  std::vector<OptionText> all;
  for (CLI::Option* option : app_->get_options({})) all.push_back(text_of(*option));
  std::stable_partition(all.begin(), all.end(),
                        [](const OptionText& option) { return option.names.empty(); });
  return all;
}

}  // namespace kinetostat::apps
