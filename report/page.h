// Results as one HTML file that needs nothing else: no network, no server, no other file.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "kinetostat/io/json.h"

namespace kinetostat::report {

/// One result as a page shows it.
struct PageResult {  // NOLINT(bugprone-exception-escape): moves as nlohmann::ordered_json does
  io::Json result;   // as --json writes it: with tool, command and options
  io::Json picture;  // what its charts need beside; may be null
  std::string text;  // the report for people; may be empty
};

/// Where a page may send requests.
enum class PageHost {
  nowhere,  // a file
  studio    // the server that it came from
};

/// The whole page. Its sections are those that the results have something to show for. Results are
/// data, never markup: no text in them is taken for HTML or script. Throws common::InputError when
/// the program was built without pages (no npm, or no Plotly from it).
std::string page(const std::string& title, const std::vector<PageResult>& results,
                 PageHost host = PageHost::nowhere);
/// Throws what page() throws for a program that was built without.
void require_pages();
bool has_pages();

/// Title of a result: "diagnose: load cell on a bench".
std::string title_of(const io::Json& result);

/// The results of a file: one that --json wrote, or all of a page that --html wrote. Throws
/// common::InputError when it is neither.
std::vector<PageResult> read_page_results(const std::filesystem::path& file);

}  // namespace kinetostat::report
