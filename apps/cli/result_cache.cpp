#include "kinetostat/apps/cli/result_cache.h"

#include <algorithm>

#include <fmt/format.h>

#include "kinetostat/apps/cli/version.h"
#include "kinetostat/common/child_process.h"
#include "kinetostat/fea/mesh/surface_import.h"
#include "kinetostat/io/text_file.h"
#include "kinetostat/report/links/link_result.h"

namespace kinetostat::apps {
namespace {

// Options that change no figure.
constexpr const char* outputs[] = {"link", "vtu", "deck", "msh", "csv", "matlab"};

std::string options_that_decide(const Run& run) {
  io::Json options = run.options();
  for (const char* name : outputs) options.erase(name);
  return options.dump();
}

bool is_step(const fea::LinkSpec& spec) { return fea::unit_of_format(spec.mesh_file) == "mm"; }

// The helper that reads the meshes, where one does.
std::string reader_of(const fea::LinkSpec& spec) {
  if (!is_step(spec) && std::none_of(spec.bodies.begin(), spec.bodies.end(), is_step)) return "";
  const std::filesystem::path helper = common::find_helper("kinetostat-step");
  return helper.empty() ? "" : " " + io::sha256(io::read_text(helper));
}

}  // namespace

ResultCache::ResultCache(const io::Cache& cache, const Run& run, const fea::LinkSpec& spec)
    : cache_(cache),
      key_(cache.enabled() ? fmt::format("identify {}{} {} {} {}", this_program(), reader_of(spec),
                                         run.threads(), options_that_decide(run), spec.meaning)
                           : ""),
      link_sha256_(spec.sha256) {}

std::optional<ResultCache::Entry> ResultCache::find() const {
  const std::optional<std::string> text = cache_.find(key_);
  if (!text) return std::nullopt;
  io::Json json = io::Json::parse(*text, nullptr, false);
  if (!json.is_object() || !json["screen"].is_string() || !json["report"].is_string() ||
      !json["result"].is_object())
    return std::nullopt;  // sealed by hand
  // Another file may say the same in other words.
  return Entry{json["screen"].get<std::string>(), json["report"].get<std::string>(),
               report::with_link_file(std::move(json["result"]), link_sha256_)};
}

void ResultCache::keep(const Entry& entry) const {
  cache_.keep(key_,
              io::to_text(io::Json{
                  {"screen", entry.screen}, {"report", entry.report}, {"result", entry.result}}));
}

}  // namespace kinetostat::apps
