#include "kinetostat/report/manipulators/path_choice.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include <fmt/format.h>

#include "kinetostat/report/manipulators/pose.h"
#include "kinetostat/report/text/text.h"
#include "kinetostat/vjm/manipulator/joint_place.h"

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

std::string values_text(const std::vector<double>& values, const std::string& unit) {
  const auto [least, most] = std::minmax_element(values.begin(), values.end());
  const double factor = spatial::parse_unit(unit).factor;
  return fmt::format("{} to {} {}", number(*least / factor), number(*most / factor), unit);
}

std::string joints_text(const PathChoiceText& said) {
  std::string text;
  for (std::size_t j = 0; j < said.joints.size(); ++j)
    text += fmt::format("{} {} at {}", j == 0 ? ", with" : " and",
                        joint_column(said.robot, said.joints[j]),
                        values_text(said.choice.joints[j], joint_unit(said.robot, said.joints[j])));
  return text;
}

// A held joint may leave several postures: whether the robot goes over from one to another.
std::string step_text(const PathChoiceText& said) {
  const vjm::JointStep& step = said.step;
  if (step.joint.empty()) return "";
  const double factor = spatial::parse_unit(said.robot.units.angle).factor;
  std::string text =
      fmt::format(" From pose to pose no joint turns by more than {} {} ({}, to pose {})",
                  number(std::abs(step.change) / factor), said.robot.units.angle,
                  joint_column(said.robot, step.joint), step.pose + 1);
  if (std::abs(step.change) > std::numbers::pi / 3)
    text += ": there the robot may go over to another of its postures for the pose";
  return text + ".";
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
    text = fmt::format("Whatever is chosen, some pose of the path is out of reach or has no {}",
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
  if (!said.choice.turns.empty())
    text += ", turned by " + values_text(said.choice.turns, said.robot.units.angle);
  text += joints_text(said);
  if (!coordinates_of(said.place).isZero(0)) text += place_text(said);
  text += ".";
  return text + step_text(said);
}

io::Json to_json(const PathChoiceText& said) {
  const auto or_null = [](double value) {
    return std::isfinite(value) ? io::Json(value) : io::Json(nullptr);
  };
  io::Json json{{"index", said.index.name},
                {"worst_as_given", or_null(worst_given(said))},
                {"worst", or_null(said.choice.worst)}};
  if (!said.choice.turns.empty()) json["turns"] = said.choice.turns;
  for (std::size_t j = 0; j < said.joints.size(); ++j)
    json["joints"].push_back({{"joint", said.joints[j]}, {"values", said.choice.joints[j]}});
  if (!said.step.joint.empty())
    json["largest_turn"] = {
        {"joint", said.step.joint}, {"change", said.step.change}, {"to_pose", said.step.pose + 1}};
  json["base"] = to_json(said.place);
  return json;
}

}  // namespace kinetostat::report
