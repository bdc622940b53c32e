#include "kinetostat/report/screen/bars.h"

#include <algorithm>

#include <fmt/format.h>

#include "kinetostat/report/screen/wording.h"
#include "kinetostat/report/waterfall.h"

namespace kinetostat::report {
namespace {

using calibration::WaterfallStage;

constexpr char floor_name[] = "noise floor";

std::vector<WaterfallStage> shown_of(const std::vector<WaterfallStage>& stages) {
  std::vector<WaterfallStage> shown;
  for (const WaterfallStage& stage : stages)
    if (stage.name != calibration::as_adopted) shown.push_back(stage);
  return shown;
}

}  // namespace

std::string falling_error(const std::vector<WaterfallStage>& stages,
                          std::vector<std::pair<std::string, std::string>> names) {
  const std::vector<WaterfallStage> shown = shown_of(stages);
  if (shown.empty()) return {};
  std::vector<std::string> labels;
  std::size_t width = 0;
  double largest = 0;
  for (const WaterfallStage& stage : shown) {
    std::string label = stage.name == floor_name ? "noise" : stage_in_words(stage.name);
    const auto named = std::find_if(names.begin(), names.end(),
                                    [&](const auto& name) { return stage.name == name.first; });
    if (named != names.end()) {
      label = named->second;
      names.erase(named);  // the next of this name is another one
    }
    width = std::max(width, label.size());
    largest = std::max(largest, stage.whitened);
    labels.push_back(label);
  }
  width = std::min<std::size_t>(width, 40);
  const std::size_t longest = 70 - width;
  std::string text;
  for (std::size_t k = 0; k < shown.size(); ++k) {
    const WaterfallStage& s = shown[k];
    if (labels[k].size() > width) labels[k] = labels[k].substr(0, width - 3) + "...";
    text += fmt::format(
        "  {:<{}}  {:<{}}  {:>5}{}\n", labels[k], width, bar(s.whitened / largest, longest),
        longest, times(s.whitened),
        s.name == floor_name ? "" : fmt::format("  ({} to {})", times(s.lower), times(s.upper)));
  }
  return text;
}

std::string fall_in_words(const std::vector<WaterfallStage>& stages) {
  std::string text;
  for (const WaterfallStage& stage : shown_of(stages))
    if (stage.name != floor_name) text += (text.empty() ? "" : " -> ") + times(stage.whitened);
  return text;
}

}  // namespace kinetostat::report
