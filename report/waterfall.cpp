#include "kinetostat/report/waterfall.h"

#include <algorithm>
#include <cmath>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "kinetostat/report/comparison.h"
#include "kinetostat/report/text/text.h"
#include "kinetostat/spatial/units.h"

namespace kinetostat::report {
namespace {

using calibration::WaterfallStage;
using io::Json;

std::string in_unit(double si, const std::string& unit) {
  return std::isnan(si) ? "-" : number(si / spatial::parse_unit(unit).factor, 4);
}

bool is_confirmed(const std::vector<WaterfallStage>& stages) {
  return std::any_of(stages.begin(), stages.end(),
                     [](const WaterfallStage& s) { return !std::isnan(s.confirmed); });
}

// How the error of one stage compares with that of another, above the noise in which both end.
std::string fall_text(const WaterfallStage& from, const WaterfallStage& to) {
  const double change = 100 * (1 - to.whitened / from.whitened);
  std::string text = fmt::format("The held-out error {} from {} to {} times the noise ({} %)",
                                 change > 0 ? "falls" : "RISES", number(from.whitened, 4),
                                 number(to.whitened, 4), number(std::abs(change), 3));
  const double excess = std::pow(from.whitened, 2) - 1;
  if (excess > 0.04)
    text += fmt::format("; of the part above the noise {} % are gone",
                        number(100 * (1 - (std::pow(to.whitened, 2) - 1) / excess), 3));
  return text + ".\n";
}

// The last stage of one of the models.
const WaterfallStage* last_of(const std::vector<WaterfallStage>& stages, const std::string& name) {
  const WaterfallStage* found = nullptr;
  for (const WaterfallStage& stage : stages)
    if (stage.name.starts_with(name)) found = &stage;
  return found;
}

}  // namespace

std::string stage_in_words(std::string name) {
  for (const auto& [in_json, word] :
       {std::pair<std::string_view, std::string_view>{"as designed", "nominal"},
        {"refitted", "fitted"}})
    if (name.ends_with(in_json))
      return name.replace(name.size() - in_json.size(), in_json.size(), word);
  return name;
}

std::string waterfall_text(const calibration::Campaign& campaign,
                           const std::vector<WaterfallStage>& stages, const std::string& held_out) {
  if (stages.empty()) return "";
  const bool confirmed = is_confirmed(stages);
  std::vector<std::string> head{"",
                                fmt::format("rms {}", campaign.units.length),
                                fmt::format("rms {}", campaign.units.angle),
                                "times the noise",
                                "95 % from",
                                "to"};
  if (confirmed) head.emplace_back("kept to confirm");
  Table table(head);
  for (const WaterfallStage& s : stages) {
    std::vector<std::string> row{stage_in_words(s.name),
                                 in_unit(s.translation, campaign.units.length),
                                 in_unit(s.rotation, campaign.units.angle),
                                 number(s.whitened, 4),
                                 number(s.lower, 4),
                                 number(s.upper, 4)};
    if (confirmed) row.push_back(std::isnan(s.confirmed) ? "-" : number(s.confirmed, 4));
    table.add_row(row);
  }
  const bool is_adopted = std::any_of(stages.begin(), stages.end(), [](const auto& stage) {
    return stage.name == calibration::as_adopted;
  });
  return fmt::format("\nError on {} left out of the fit{}\n{}", held_out,
                     is_adopted ? fmt::format(", {} on all readings whether set aside or not",
                                              calibration::as_adopted)
                                : "",
                     table.text());
}

Json to_json(const WaterfallStage& s) {
  const auto optional = [](double x) { return std::isnan(x) ? Json() : Json(x); };
  return {{"name", s.name},
          {"whitened", s.whitened},
          {"lower", s.lower},
          {"upper", s.upper},
          {"translation", optional(s.translation)},
          {"rotation", optional(s.rotation)},
          {"confirmed", optional(s.confirmed)},
          {"before", optional(s.before)}};
}

Json to_json(const std::vector<WaterfallStage>& stages) {
  Json list = Json::array();
  for (const WaterfallStage& stage : stages) list.push_back(to_json(stage));
  return list;
}

std::string text(const calibration::Campaign& campaign, const calibration::BeforeAfter& both) {
  std::string text = waterfall_text(campaign, both.stages, both.held_out);
  const WaterfallStage *from = last_of(both.stages, "before"), *to = last_of(both.stages, "after");
  if (from != nullptr && to != nullptr) text += fall_text(*from, *to);
  if (both.stages.empty())
    text += "\nThe noise is known from nothing but the residual, so errors are not compared.\n";
  return "\nBEFORE\n" + report::text(campaign, both.before) + "\nAFTER\n" +
         report::text(campaign, both.after) + text;
}

Json to_json(const calibration::Campaign& campaign, const calibration::BeforeAfter& both) {
  return {{"waterfall", to_json(both.stages)},
          {"held_out", both.held_out},
          {"before", to_json(campaign, both.before)},
          {"after", to_json(campaign, both.after)}};
}

}  // namespace kinetostat::report
