#include "kinetostat/report/screen/link_models.h"

#include <cmath>

#include <fmt/format.h>

#include "kinetostat/report/screen/wording.h"
#include "kinetostat/report/text/text.h"

namespace kinetostat::report {
namespace {

double difference(double value, double reference) { return value / reference - 1; }

std::string signed_percent(double share) {
  return fmt::format("{}{} %", share < 0 ? "" : "+", figure(100 * share, 2));
}

// The link that causes most of a difference.
std::pair<std::string, double> cause_of(const LinkModelRow& row, double reference) {
  std::pair<std::string, double> cause;
  for (const auto& [link, value] : row.by_link)
    if (const double by = difference(value, reference); std::abs(by) >= std::abs(cause.second))
      cause = {link, by};
  return cause;
}

}  // namespace

LinkModelFigure stiffness_figure(const spatial::UnitSystem& units) {
  return {"softest stiffness", units.force + "/" + units.length,
          spatial::parse_unit(units.force).factor / spatial::parse_unit(units.length).factor};
}

std::string in_short(const std::vector<LinkModelRow>& rows) {
  const double reference = rows.back().value;
  std::vector<std::string> words;
  for (std::size_t i = 0; i + 1 < rows.size(); ++i)
    words.push_back(
        fmt::format("{} {}", rows[i].model, signed_percent(difference(rows[i].value, reference))));
  return fmt::format("{} against {}; most of it by link {}", listed(words), rows.back().model,
                     cause_of(rows.front(), reference).first);
}

std::string text(const LinkModelFigure& shown, const std::vector<LinkModelRow>& rows) {
  const double reference = rows.back().value;
  Table table({"links", fmt::format("{} [{}]", shown.name, shown.unit),
               "against " + rows.back().model, "most of it by"});
  for (const LinkModelRow& row : rows) {
    const auto [link, by] = cause_of(row, reference);
    const bool is_last = row.by_link.empty();
    table.add_row({row.model, figure(row.value / shown.factor, 4),
                   is_last ? "" : signed_percent(difference(row.value, reference)),
                   is_last ? "" : fmt::format("link {} ({})", link, signed_percent(by))});
  }
  return table.text();
}

io::Json to_json(const LinkModelFigure& shown, const std::vector<LinkModelRow>& rows) {
  const double reference = rows.back().value;
  io::Json list = io::Json::array();
  for (const LinkModelRow& row : rows) {
    io::Json json{{"model", row.model}, {"value", row.value}};
    json["difference"] = difference(row.value, reference);
    json["by_link"] = io::Json::object();
    for (const auto& [link, value] : row.by_link)
      json["by_link"][link] = difference(value, reference);
    list.push_back(std::move(json));
  }
  return {{"figure", shown.name}, {"unit", shown.unit}, {"factor", shown.factor}, {"rows", list}};
}

}  // namespace kinetostat::report
