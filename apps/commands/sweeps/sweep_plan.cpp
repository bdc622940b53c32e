#include "kinetostat/apps/commands/sweeps/sweep_plan.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <functional>
#include <glob.h>
#include <numeric>
#include <random>
#include <set>
#include <sstream>

#include <boost/random/sobol.hpp>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "kinetostat/io/text_file.h"
#include "kinetostat/io/yaml.h"

namespace kinetostat::apps {
namespace {

using io::YamlNode;

constexpr int most_runs = 1'000'000;

// One key: either a list of values, or a range.
struct Varied {
  std::string key;
  bool is_word = false;  // of the command, else a key for --set
  std::vector<std::string> values = {};
  double from = 0, to = 0;
  bool logarithmic = false;
  std::string unit = {};

  // The value at u in [0, 1], of a list for u below 1.
  std::string at(double u) const {
    if (!values.empty())
      return values[std::min(values.size() - 1,
                             static_cast<std::size_t>(u * static_cast<double>(values.size())))];
    const double x = logarithmic ? from * std::pow(to / from, u) : from + u * (to - from);
    return unit.empty() ? fmt::format("{}", x) : fmt::format("{} {}", x, unit);
  }
};

std::string scalar_text(const YamlNode& node) {
  if (!node.is_scalar()) node.fail("one value is expected", "Write numbers or texts of one line");
  return node.text();
}

// The files that a pattern of the shell stands for, in the order of their names.
std::vector<std::string> files_of(const YamlNode& node) {
  glob_t found = {};
  const int failed = ::glob(node.text().c_str(), 0, nullptr, &found);
  std::vector<std::string> files(found.gl_pathv, found.gl_pathv + found.gl_pathc);
  ::globfree(&found);
  if (failed != 0 || files.empty())
    node.fail("there is no such file", "Write a pattern such as runs/*/campaign.yaml");
  return files;
}

// Its steps, 0 for a list.
std::pair<Varied, int> read_varied(const YamlNode& node) {
  node.allow_only({"set", "word", "values", "files", "from", "to", "steps", "scale", "unit"});
  const auto [what, name] = node.one_of({"set", "word"});
  Varied varied{.key = name.text(), .is_word = what == "word"};
  const auto [kind, first] = node.one_of({"values", "files", "from"});
  if (kind == "files") {
    varied.values = files_of(first);
    return {varied, 0};
  }
  if (kind == "values") {
    for (const YamlNode& item : first.items()) varied.values.push_back(scalar_text(item));
    if (varied.values.empty()) first.fail("the list is empty");
    return {varied, 0};
  }
  varied.from = first.number();
  varied.to = node.at("to").number();
  if (const auto unit = node.find("unit")) varied.unit = unit->text();
  if (const auto scale = node.find("scale"))
    varied.logarithmic = scale->choice({"linear", "log"}) == "log";
  if (varied.logarithmic && !(varied.from > 0 && varied.to > 0))
    first.fail("a range on a log scale lies above zero");
  const auto steps = node.find("steps");
  return {varied, steps ? steps->integer(2, most_runs) : 0};
}

// Every value with every other, the last key the fastest.
std::vector<std::vector<std::string>> grid(const YamlNode& vary, const std::vector<Varied>& all,
                                           const std::vector<int>& steps) {
  std::vector<std::vector<std::string>> runs(1);
  for (std::size_t k = 0; k < all.size(); ++k) {
    std::vector<std::string> values = all[k].values;
    if (values.empty() && steps[k] == 0)
      vary.fail(fmt::format("'{}' has no steps", all[k].key),
                "Add 'steps: 5', or 'sample: {method: sobol, count: 64}'");
    for (int i = 0; i < steps[k]; ++i) values.push_back(all[k].at(i / (steps[k] - 1.0)));
    if (runs.size() * values.size() > most_runs)
      vary.fail(fmt::format("the grid has more than {} runs", most_runs));
    std::vector<std::vector<std::string>> more;
    for (const auto& run : runs)
      for (const std::string& value : values) {
        more.push_back(run);
        more.back().push_back(value);
      }
    runs = std::move(more);
  }
  return runs;
}

// Points of the unit cube, the same on any machine.
std::function<double()> numbers_of(const std::string& method, std::size_t dimensions,
                                   unsigned seed) {
  if (method == "random")
    return [engine = std::mt19937_64(seed)]() mutable {
      return static_cast<double>(engine() >> 11) * 0x1p-53;
    };
  // Without its first point, a corner, which Boost leaves out, and as many more as the seed says.
  boost::random::sobol engine(dimensions);
  engine.discard(dimensions * seed);
  return [engine]() mutable { return static_cast<double>(engine() >> 11) * 0x1p-53; };
}

std::vector<std::vector<std::string>> sampled(const YamlNode& sample,
                                              const std::vector<Varied>& all) {
  const int count = sample.at("count").integer(1, most_runs);
  const auto seed = sample.find("seed");
  const auto number = numbers_of(sample.at("method").text(), all.size(),
                                 seed ? static_cast<unsigned>(seed->integer(0, most_runs)) : 0);
  std::vector<std::vector<std::string>> runs(static_cast<std::size_t>(count));
  for (auto& run : runs)
    for (const Varied& varied : all) run.push_back(varied.at(number()));
  return runs;
}

// Words as a shell takes them, quotes and all else left as they are but for single and double ones.
std::vector<std::string> words_of(const YamlNode& node) {
  std::vector<std::string> words;
  std::string word;
  char quote = 0;
  bool open = false;
  for (const char c : node.text() + " ") {
    if (quote != 0) {
      if (c == quote)
        quote = 0;
      else
        word += c;
    } else if (c == '"' || c == '\'') {
      quote = c;
      open = true;
    } else if (c != ' ') {
      word += c;
      open = true;
    } else if (open) {
      words.push_back(std::move(word));
      word.clear();
      open = false;
    }
  }
  if (quote != 0) node.fail("a quote is not closed");
  if (!words.empty() && words[0] == "kinetostat") words.erase(words.begin());
  if (words.empty()) node.fail("there is no command", "Write one: 'stiffness arm.yaml'");
  for (std::size_t w = 0; w < words.size(); ++w) {
    const std::string& option = words[w];
    const std::string file = option + (w + 1 < words.size() ? words[w + 1] : "");
    const bool is_output =
        (option.starts_with("-o") && !option.starts_with("--")) || option.starts_with("--out");
    if ((is_output && file.find('{') == std::string::npos) || option.starts_with("--json") ||
        option.starts_with("--html"))
      node.fail(fmt::format("'{}' names a file, which every run would write", option),
                "Leave it out: what is under 'results' goes into the table. Or name a file of each "
                "run, -o {campaign}.json, where a 'word: campaign' varies");
  }
  return words;
}

// Words that vary stand in the command; what files they name decides the results.
void take_words(const YamlNode& vary, const std::vector<Varied>& all, SweepPlan& plan) {
  for (const Varied& varied : all) {
    plan.is_word.push_back(varied.is_word);
    if (!varied.is_word) continue;
    const std::string place = "{" + varied.key + "}";
    const auto has = [&](const std::string& word) { return word.find(place) != std::string::npos; };
    if (std::none_of(plan.command.begin(), plan.command.end(), has))
      vary.fail(fmt::format("the command has no word {}", place),
                fmt::format("Write 'command: diagnose {}'", place));
    for (const std::string& value : varied.values)
      if (std::error_code error; std::filesystem::is_regular_file(value, error))
        plan.meaning += io::sha256(io::read_text(value));
  }
}

// Of the columns of the table each has its own name.
void take_results(const YamlNode& results, SweepPlan& plan) {
  std::set<std::string> taken(plan.keys.begin(), plan.keys.end());
  taken.insert({"run", "exit"});
  for (const auto& [name, path] : results.members()) {
    if (!taken.insert(name).second)
      path.fail(fmt::format("the table has a column '{}' already", name),
                "Give the result another name");
    plan.results.emplace_back(name, path.text());
    plan.result_lines.push_back(path.line());
  }
}

// What varies is set by each run, over what the command says.
void refuse_set_of_varied(const YamlNode& command, const SweepPlan& plan) {
  for (std::size_t w = 0; w < plan.command.size(); ++w) {
    std::string set = plan.command[w];
    if (set == "--set" && w + 1 < plan.command.size()) set += "=" + plan.command[w + 1];
    for (const std::string& key : plan.keys)
      if (set.starts_with("--set=" + key + "="))
        command.fail(fmt::format("it sets '{}', which varies", key),
                     "Leave that out here, or under 'vary'");
  }
}

const io::Json* result_at(const io::Json& result, const std::string& path) {
  const io::Json* at = &result;
  std::istringstream parts(path);
  for (std::string part; std::getline(parts, part, '.');) {
    if (at->is_object() && at->contains(part)) {
      at = &(*at)[part];
      continue;
    }
    std::size_t number = 0;
    const auto [end, error] = std::from_chars(part.data(), part.data() + part.size(), number);
    if (!at->is_array() || error != std::errc() || end != part.data() + part.size() ||
        number >= at->size())
      return nullptr;
    at = &(*at)[number];
  }
  return at;
}

// ": it has a.x, a.y", the first few; empty for what is empty.
std::string first_parts(const io::Json& at, const std::string& path) {
  if (at.empty()) return {};
  std::vector<std::string> paths;
  for (const auto& [key, part] : at.items()) paths.push_back(fmt::format("{}.{}", path, key));
  constexpr std::size_t most = 4;
  const char* const more = paths.size() > most ? ", ..." : "";
  paths.resize(std::min(paths.size(), most));
  return fmt::format(": it has {}{}", fmt::join(paths, ", "), more);
}

}  // namespace

SweepPlan read_sweep(const std::filesystem::path& file) {
  const YamlNode top = io::read_yaml(file);
  top.allow_only({"kinetostat", "sweep", "command", "vary", "sample", "results"});
  io::check_format_version(top);
  SweepPlan plan{.file = file,
                 .name = top.at("sweep").text(),
                 .command = words_of(top.at("command")),
                 .meaning = io::meaning(top)};
  for (const std::string& word : plan.command)
    if (std::error_code error; std::filesystem::is_regular_file(word, error))
      plan.meaning += io::sha256(io::read_text(word));
  std::vector<Varied> all;
  std::vector<int> steps;
  for (const YamlNode& item : top.at("vary").items()) {
    auto [varied, count] = read_varied(item);
    if (std::find(plan.keys.begin(), plan.keys.end(), varied.key) != plan.keys.end())
      item.fail(fmt::format("'{}' varies already", varied.key), "Give each key once");
    if (varied.key == "run" || varied.key == "exit")
      item.fail(fmt::format("the table has a column '{}' already", varied.key),
                "Choose another word for what varies");
    plan.keys.push_back(varied.key);
    all.push_back(std::move(varied));
    steps.push_back(count);
  }
  if (all.empty()) top.at("vary").fail("nothing is varied");
  take_words(top.at("vary"), all, plan);
  take_results(top.at("results"), plan);
  refuse_set_of_varied(top.at("command"), plan);
  const auto sample = top.find("sample");
  if (sample) sample->allow_only({"method", "count", "seed"});
  const bool is_grid =
      !sample || sample->at("method").choice({"grid", "random", "sobol"}) == "grid";
  plan.runs = is_grid ? grid(top.at("vary"), all, steps) : sampled(*sample, all);
  return plan;
}

std::string result_cell(const io::Json& result, const std::string& path) {
  const io::Json* const at = result_at(result, path);
  if (at == nullptr) return {};
  if (at->is_number_float()) return fmt::format("{}", at->get<double>());
  if (at->is_string()) return at->get<std::string>();
  return at->is_primitive() && !at->is_null() ? at->dump() : std::string();
}

std::optional<common::InputError> unfit_result(const SweepPlan& plan, const io::Json& result) {
  for (std::size_t r = 0; r < plan.results.size(); ++r) {
    const auto& [name, path] = plan.results[r];
    const io::Json* const at = result_at(result, path);
    if (at != nullptr && at->is_structured())
      return common::InputError(
          {.file = plan.file,
           .line = plan.result_lines[r],
           .key = "results." + name,
           .what = fmt::format("'{}' is no single value, which a cell of the "
                               "table can hold{}",
                               path, first_parts(*at, path)),
           .cure = "Name one value of the command's JSON (--json - shows it)"});
  }
  return std::nullopt;
}

}  // namespace kinetostat::apps
