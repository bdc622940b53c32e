#include "kinetostat/report/page.h"

#include <array>
#include <stdexcept>
#include <string_view>
#include <zlib.h>

#include <fmt/format.h>

#include "kinetostat/common/error.h"
#include "kinetostat/io/base64.h"
#include "kinetostat/io/json_size.h"
#include "kinetostat/io/text_file.h"
#include "kinetostat/report/manipulators/path.h"

// The page that bundle.mjs made, placed there by the assembler; empty when there is none.
extern "C" const char kinetostat_page_begin[];
extern "C" const char kinetostat_page_end[];
asm(R"(
  .section .rodata
  .global kinetostat_page_begin
  .global kinetostat_page_end
kinetostat_page_begin:
  .incbin ")" KINETOSTAT_PAGE R"("
kinetostat_page_end:
  .byte 0
  .previous
)");

namespace kinetostat::report {
namespace {

using io::Json;

constexpr std::string_view results_begin =
    "<script type=\"application/octet-stream\" id=\"results\">";
constexpr std::string_view results_end = "</script>";
constexpr std::size_t most_bytes = std::size_t{128} << 20;  // of inflated results

std::string_view shell() {
  return {kinetostat_page_begin,
          static_cast<std::size_t>(kinetostat_page_end - kinetostat_page_begin)};
}

std::string deflated(const std::string& text) {
  uLongf size = compressBound(text.size());
  std::string bytes(size, '\0');
  if (compress2(reinterpret_cast<Bytef*>(bytes.data()), &size,
                reinterpret_cast<const Bytef*>(text.data()), text.size(), 9) != Z_OK)
    throw std::runtime_error("zlib failed");
  bytes.resize(size);
  return bytes;
}

// Nothing when the bytes are not what deflated() made. Takes memory as the text grows: bytes may
// stand for a thousand times as many. Throws TooLarge beyond `most_bytes`.
struct TooLarge {};
std::optional<std::string> inflated(std::string_view bytes) {
  z_stream stream{};
  if (inflateInit(&stream) != Z_OK) throw std::bad_alloc();
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  stream.avail_in = static_cast<uInt>(bytes.size());
  std::string text;
  std::array<char, 1 << 16> block{};
  int code = Z_OK;
  while (code == Z_OK && text.size() <= most_bytes) {
    stream.next_out = reinterpret_cast<Bytef*>(block.data());
    stream.avail_out = static_cast<uInt>(block.size());
    code = inflate(&stream, Z_NO_FLUSH);
    text.append(block.data(), block.size() - stream.avail_out);
  }
  inflateEnd(&stream);
  if (text.size() > most_bytes) throw TooLarge();
  if (code != Z_STREAM_END) return std::nullopt;
  return text;
}

std::string escaped(std::string_view text) {
  std::string out;
  for (const char c : text) switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      default:
        out += c;
    }
  return out;
}

// The shell with each placeholder replaced, in one pass: replacements are not searched again.
std::string filled(const std::vector<std::pair<std::string_view, std::string>>& values) {
  std::string out;
  std::string_view rest = shell();
  while (true) {
    std::size_t first = std::string_view::npos;
    const std::pair<std::string_view, std::string>* next = nullptr;
    for (const auto& value : values)
      if (const std::size_t at = rest.find(value.first); at < first) first = at, next = &value;
    if (next == nullptr) return out.append(rest);
    out.append(rest.substr(0, first)).append(next->second);
    rest.remove_prefix(first + next->first.size());
  }
}

common::InputError not_a_result(const std::filesystem::path& file) {
  return {file, "is neither a result nor a page of results",
          "Give files that 'kinetostat COMMAND --json FILE' or '--html FILE' wrote"};
}

// A result has its command, one that Python made its inputs, a link the version of its format.
bool is_result(const Json& result) {
  return result.is_object() &&
         (result.contains("command") || result.contains("inputs") || result.contains("kinetostat"));
}

common::InputError too_large(const std::filesystem::path& file) {
  return {file, fmt::format("its results are more than is read back ({} MiB)", most_bytes >> 20),
          "Make a page of fewer results"};
}

Json parsed(const std::filesystem::path& file, const std::string& json) {
  if (io::is_nested_too_deeply(json)) throw not_a_result(file);
  if (io::is_too_large(json)) throw too_large(file);
  return Json::parse(json, nullptr, false);
}

Json results_in_page(const std::filesystem::path& file, std::string_view text) {
  const std::size_t begin = text.find(results_begin);
  if (begin == std::string_view::npos) throw not_a_result(file);
  text.remove_prefix(begin + results_begin.size());
  const auto bytes = io::from_base64(text.substr(0, text.find(results_end)));
  if (!bytes) throw not_a_result(file);
  try {
    const auto json = inflated(*bytes);
    if (!json) throw not_a_result(file);
    Json results = parsed(file, *json);
    if (!results.is_array()) throw not_a_result(file);
    return results;
  } catch (const TooLarge&) {
    throw too_large(file);
  }
}

std::string string_at(const Json& json, const std::vector<const char*>& path) {
  const Json* at = &json;
  for (const char* key : path) {
    if (!at->is_object() || !at->contains(key)) return {};
    at = &(*at)[key];
  }
  return at->is_string() ? at->get<std::string>() : std::string();
}

// What a page shows of a result: not what its picture holds in a shorter form.
Json shown(const PageResult& entry) {
  Json result = entry.result;
  if (result.contains("path")) result["path"] = without_equilibria(std::move(result["path"]));
  if (entry.picture.is_object() && entry.picture.contains("readings") &&
      result.contains("as_designed"))
    result.erase("readings");
  return result;
}

}  // namespace

bool has_pages() { return !shell().empty(); }

void require_pages() {
  if (!has_pages())
    throw common::InputError(
        "--html", "this program was built without pages: npm or Plotly was missing",
        "Run 'scripts/install-packages build', then configure and build again; --json works");
}

std::string page(const std::string& title, const std::vector<PageResult>& results, PageHost host) {
  require_pages();
  Json json = Json::array();
  std::string text;
  for (const PageResult& entry : results) {
    json.push_back({{"result", shown(entry)}, {"picture", entry.picture}, {"text", entry.text}});
    text += "<pre>" + escaped(entry.text) + "</pre>\n";
  }
  const std::string data = json.dump(-1, ' ', false, Json::error_handler_t::replace);
  return filled({{"@TITLE@", escaped(title)},
                 {"@CONNECT@", host == PageHost::studio ? "'self'" : "'none'"},
                 {"@TEXT@", text},
                 {"@RESULTS@", io::base64(deflated(data))}});
}

std::string title_of(const Json& result) {
  const std::string command = string_at(result, {"command"});
  std::string about;
  for (const std::vector<const char*>& path :
       {std::vector<const char*>{"campaign"}, {"campaign", "name"}, {"link"}, {"inputs", "name"}})
    if (about.empty()) about = string_at(result, path);
  if (about.empty()) return command.empty() ? "kinetostat" : "kinetostat " + command;
  return command.empty() ? about : command + ": " + about;
}

std::vector<PageResult> read_page_results(const std::filesystem::path& file) {
  const std::string text = io::read_text(file);
  std::vector<PageResult> results;
  if (text.find(results_begin) == std::string::npos) {
    Json result = parsed(file, text);
    if (!is_result(result)) throw not_a_result(file);
    results.push_back({.result = std::move(result), .picture = {}, .text = {}});
    return results;
  }
  for (Json& entry : results_in_page(file, text)) {
    if (!entry.is_object() || !entry.contains("result") || !entry["result"].is_object())
      throw not_a_result(file);
    results.push_back({.result = entry["result"],
                       .picture = entry.value("picture", Json()),
                       .text = string_at(entry, {"text"})});
  }
  return results;
}

}  // namespace kinetostat::report
