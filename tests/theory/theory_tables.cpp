// theory_tables FOLDER [--write]: every page of docs/theory holds between
//   <!-- table NAME -->  and  <!-- end -->
// what is computed today. Without --write a difference is printed and ends with exit code 1.
#include <algorithm>
#include <filesystem>
#include <functional>
#include <map>
#include <stdexcept>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "kinetostat/io/text_file.h"

#include "tables.h"

namespace kinetostat::theory {

std::string markdown(const std::vector<std::string>& heading,
                     const std::vector<std::vector<std::string>>& rows) {
  std::string text = fmt::format("| {} |\n|", fmt::join(heading, " | "));
  for (std::size_t i = 0; i < heading.size(); ++i) text += "---|";
  text += "\n";
  for (const auto& row : rows) text += fmt::format("| {} |\n", fmt::join(row, " | "));
  return text;
}

vjm::Robot shipped(const std::string& name) {
  return vjm::read_robot(std::string(KINETOSTAT_SOURCE_DIR) + "/data/robots/" + name);
}

namespace {

const std::map<std::string, std::function<std::string()>>& tables() {
  static const std::map<std::string, std::function<std::string()>> all = {
      {"decision_rules", decision_rules},
      {"jamris_table_1_and_3", jamris_table_1_and_3},
      {"jamris_table_2", jamris_table_2},
      {"nonperf_table_1", nonperf_table_1},
      {"nonperf_table_2", nonperf_table_2},
      {"mmt11_table_2_unloaded", mmt11_table_2_unloaded},
      {"iros11_platforms", iros11_platforms},
      {"mmt11_urrs", mmt11_urrs},
      {"straight_column", straight_column},
      {"mmt11_table_2_critical", mmt11_table_2_critical},
      {"iterations_at_a_pose", iterations_at_a_pose},
      {"iterations_under_a_load", iterations_under_a_load},
  };
  return all;
}

// The page with its tables computed afresh.
std::string renewed(const std::string& page, const std::filesystem::path& file) {
  static const std::string begin = "<!-- table ", close = " -->\n", end = "<!-- end -->";
  std::string result;
  std::size_t done = 0;
  for (std::size_t at = page.find(begin); at != std::string::npos; at = page.find(begin, done)) {
    const std::size_t name_at = at + begin.size(), name_end = page.find(close, name_at);
    const std::size_t stop = page.find(end, name_at);
    if (name_end == std::string::npos || stop == std::string::npos)
      throw std::runtime_error(fmt::format("{}: a table is not closed", file.string()));
    const std::string name = page.substr(name_at, name_end - name_at);
    if (!tables().contains(name))
      throw std::runtime_error(fmt::format("{}: no table '{}'", file.string(), name));
    result += page.substr(done, name_end + close.size() - done) + tables().at(name)();
    done = stop;
  }
  return result + page.substr(done);
}

bool check(const std::filesystem::path& file, bool write) {
  const std::string page = io::read_text(file);
  const std::string fresh = renewed(page, file);
  if (fresh == page) return true;
  if (write) {
    io::write_atomically(file, fresh);
    return true;
  }
  const auto [a, b] = std::mismatch(page.begin(), page.end(), fresh.begin(), fresh.end());
  const auto line = [](const std::string& text, auto place) {
    const auto first = std::find(std::make_reverse_iterator(place), text.rend(), '\n').base();
    return std::string(first, std::find(place, text.end(), '\n'));
  };
  fmt::print("{}\n  page: {}\n  now:  {}\n", file.string(), line(page, a), line(fresh, b));
  return false;
}

}  // namespace
}  // namespace kinetostat::theory

int main(int argc, char** argv) {
  if (argc < 2) {
    fmt::print(stderr, "usage: theory_tables FOLDER [--write]\n");
    return 2;
  }
  const bool write = argc > 2 && std::string(argv[2]) == "--write";
  std::vector<std::filesystem::path> pages;
  for (const auto& entry : std::filesystem::directory_iterator(argv[1]))
    if (entry.path().extension() == ".md") pages.push_back(entry.path());
  std::sort(pages.begin(), pages.end());
  bool good = !pages.empty();
  for (const auto& page : pages) good &= kinetostat::theory::check(page, write);
  return good ? 0 : 1;
}
