#include "kinetostat/report/manipulators/path_choice.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "kinetostat/report/manipulators/pose.h"
#include "kinetostat/report/text/text.h"

namespace kinetostat::report {
namespace {

// Of the poses as given; NaN where one has no value.
double worst_given(const PathChoiceText& said) {
  const bool more = vjm::is_more_better(said.index.index.kind);
  double worst = std::numeric_limits<double>::quiet_NaN();
  for (const vjm::MapPoint& point : said.given) {
    const double value = point.values.front();
    if (std::isnan(value)) return value;
    if (std::isnan(worst) || (more ? value < worst : value > worst)) worst = value;
  }
  return worst;
}

std::string with_unit(double value, const NamedIndex& index) {
  const std::string text = number(value / index.factor);
  return index.unit.empty() ? text : text + " " + index.unit;
}

std::string turns_text(const PathChoiceText& said) {
  const auto [least, most] =
      std::minmax_element(said.choice.turns.begin(), said.choice.turns.end());
  const double unit = spatial::parse_unit(said.robot.units.angle).factor;
  return fmt::format(", turned by {} to {} {}", number(*least / unit), number(*most / unit),
                     said.robot.units.angle);
}

std::string place_text(const PathChoiceText& said) {
  const spatial::Vector6 c = coordinates_of(said.place);
  const double length = spatial::parse_unit(said.robot.units.length).factor,
               angle = spatial::parse_unit(said.robot.units.angle).factor;
  std::string text =
      fmt::format(", with the base at ({}, {}, {}) {}", number(c[0] / length),
                  number(c[1] / length), number(c[2] / length), said.robot.units.length);
  if (c[5] != 0)
    text += fmt::format(" turned by {} {}", number(c[5] / angle), said.robot.units.angle);
  return text;
}

}  // namespace

std::string sentence(const PathChoiceText& said) {
  const double given = worst_given(said), chosen = said.choice.worst;
  const bool more = vjm::is_more_better(said.index.index.kind);
  const double gain = more ? chosen / given : given / chosen;
  std::string text;
  if (std::isnan(chosen))
    text = fmt::format(
        "However it is turned and placed, some pose of the path is out of reach or "
        "has no {}",
        said.index.name);
  else if (std::isnan(given))
    text = fmt::format("All poses of the path are reached, the worst with {} of {}",
                       said.index.name, with_unit(chosen, said.index));
  else if (gain < 1.0005)
    text = fmt::format("Nothing makes the worst pose of the path better: {} is {} there",
                       said.index.name, with_unit(chosen, said.index));
  else
    text = fmt::format("At the worst pose of the path {} is {} times as {}: {} -> {}",
                       said.index.name, number(gain), more ? "large" : "small",
                       with_unit(given, said.index), with_unit(chosen, said.index));
  if (!said.choice.turns.empty()) text += turns_text(said);
  if (!coordinates_of(said.place).isZero(0)) text += place_text(said);
  return text + ".";
}

io::Json to_json(const PathChoiceText& said) {
  const auto or_null = [](double value) {
    return std::isfinite(value) ? io::Json(value) : io::Json(nullptr);
  };
  io::Json json{{"index", said.index.name},
                {"worst_as_given", or_null(worst_given(said))},
                {"worst", or_null(said.choice.worst)}};
  if (!said.choice.turns.empty()) json["turns"] = said.choice.turns;
  json["base"] = to_json(said.place);
  return json;
}

}  // namespace kinetostat::report
