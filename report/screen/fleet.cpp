#include "kinetostat/report/screen/fleet.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include <fmt/format.h>

#include "kinetostat/report/screen/wording.h"
#include "kinetostat/report/text/text.h"
#include "kinetostat/vjm/manipulator/manipulator.h"

namespace kinetostat::report {
namespace {

using io::Json;

std::string name_of_factor(const std::string& stiffness) {
  return "stiffness of " + stiffness + ", factor";
}

void add_effect(const calibration::RecordedEffect& effect, std::vector<FleetValue>& values) {
  for (std::size_t p = 0; p < effect.values.size() && p < effect.parameters.size(); ++p) {
    const double deviation = p < effect.deviations.size()
                                 ? effect.deviations[p]
                                 : std::numeric_limits<double>::quiet_NaN();
    // What design fixes has none, and is no quantity.
    if (std::isnan(effect.values[p]) || (p > 0 && std::isnan(deviation))) continue;
    values.push_back({.name = fmt::format("{} of {}", effect.parameters[p].name, effect.name()),
                      .unit = effect.parameters[p].unit,
                      .value = effect.values[p],
                      .deviation = deviation});
  }
}

void add_estimate(const calibration::RecordedEstimate& one, std::vector<FleetValue>& values) {
  if (one.is_kept) return;
  if (!one.stiffness.empty() && !std::isnan(one.factor))
    values.push_back({.name = name_of_factor(one.stiffness),
                      .unit = "",
                      .value = one.factor,
                      .deviation = one.factor * one.standard_error_of_log_factor});
  if (!one.effect.empty() && !std::isnan(one.fitted))
    values.push_back({.name = fmt::format("{} of {} at {}", one.value_of, one.effect, one.at),
                      .unit = one.unit,
                      .value = one.fitted,
                      .deviation = one.standard_error});
}

std::string called(const FleetMember& member) {
  if (member.date.empty()) return member.serial;
  return member.serial.empty() ? member.date : fmt::format("{} of {}", member.serial, member.date);
}

FleetSeries& series_of(const FleetValue& value, std::vector<FleetSeries>& all) {
  for (FleetSeries& series : all)
    if (series.name == value.name && series.unit == value.unit) return series;
  all.push_back({.name = value.name,
                 .unit = value.unit,
                 .members = {},
                 .values = {},
                 .deviations = {},
                 .chart = {}});
  return all.back();
}

// The unit in which a quantity reads best, and how many of the stated one it is.
struct ReadableUnit {
  std::string name;
  double factor = 1;

  std::string operator()(double value) const { return number(value / factor); }
  std::string with_name(double value) const {
    return name.empty() ? (*this)(value) : (*this)(value) + " " + name;
  }
};

ReadableUnit readable_unit(const FleetSeries& series) {
  double largest = 0;
  for (const double value : series.values) largest = std::max(largest, std::abs(value));
  if (series.unit != "m" && series.unit != "rad") return {unit_in_words(series.unit)};
  if (largest >= 1 || largest == 0) return {series.unit};
  if (largest >= 1e-3) return {"m" + series.unit, 1e-3};
  if (largest >= 1e-6 || series.unit == "rad") return {"u" + series.unit, 1e-6};
  return {"nm", 1e-9};
}

bool has_limits(const FleetSeries& series) { return series.values.size() >= least_of_series; }

// "A-07 of 2026-05-02: gap of clearance at q3 is 0.4 mrad, above its limit 0.2"
std::string sentence(const Fleet& fleet, const FleetSeries& series, std::size_t i) {
  const double value = series.values[i];
  const bool above = value > series.chart.upper;
  const ReadableUnit unit = readable_unit(series);
  return fmt::format("{}: {} is {}, {} its limit {}", called(fleet.members[series.members[i]]),
                     series.name, unit.with_name(value), above ? "above" : "below",
                     unit(above ? series.chart.upper : series.chart.lower));
}

Json number_or_null(double x) { return std::isfinite(x) ? Json(x) : Json(); }

Json json_of(const Fleet& fleet, const FleetSeries& series) {
  Json values = Json::array(), outside = Json::array();
  for (std::size_t i = 0; i < series.values.size(); ++i)
    values.push_back({{"member", series.members[i]},
                      {"value", series.values[i]},
                      {"deviation", number_or_null(series.deviations[i])}});
  for (const std::size_t i : series.chart.outside)
    outside.push_back({{"member", series.members[i]}, {"sentence", sentence(fleet, series, i)}});
  Json json{{"name", series.name}, {"unit", series.unit}, {"values", values}};
  if (has_limits(series))
    json["limits"] = {{"mean", series.chart.mean},
                      {"lower", series.chart.lower},
                      {"upper", series.chart.upper},
                      {"mean_moving_range", series.chart.mean_moving_range}};
  json["outside"] = outside;
  return json;
}

}  // namespace

std::vector<FleetValue> fleet_values(const calibration::DiagnosisRecord& diagnosis) {
  std::vector<FleetValue> values;
  for (const calibration::RecordedFinding& finding : diagnosis.found)
    add_effect(finding.effect, values);
  for (const auto& one :
       diagnosis.found.empty() ? diagnosis.fitted_without : diagnosis.fitted_beside)
    add_estimate(one, values);
  return values;
}

std::vector<FleetValue> fleet_values(const vjm::Robot& robot) {
  std::vector<FleetValue> values;
  for (const vjm::Effect& effect : robot.effects)
    for (Eigen::Index p = 0; p < effect.values.size(); ++p) {
      const vjm::EffectParameter& kind = effect.kind->parameters[static_cast<std::size_t>(p)];
      const bool angular = turns(effect, robot.without_effects());
      // What design fixes is no quantity.
      if (!(angular ? kind.usual_angular : kind.usual_linear).empty()) continue;
      values.push_back({.name = effect.name_of(p),
                        .unit = to_string(angular ? kind.angular : kind.linear),
                        .value = effect.values[p],
                        .deviation = effect.deviations.size() > p
                                         ? effect.deviations[p]
                                         : std::numeric_limits<double>::quiet_NaN()});
    }
  for (const vjm::FittedStiffness& one : robot.fitted)
    values.push_back({.name = name_of_factor(one.name),
                      .unit = "",
                      .value = one.factor,
                      .deviation = one.deviation});
  return values;
}

Fleet make_fleet(std::string name, std::vector<FleetMember> members, std::size_t baseline) {
  std::stable_sort(members.begin(), members.end(), [](const auto& a, const auto& b) {
    return std::tie(a.date, a.serial) < std::tie(b.date, b.serial);
  });
  Fleet fleet{
      .name = std::move(name), .members = std::move(members), .series = {}, .baseline = baseline};
  for (std::size_t m = 0; m < fleet.members.size(); ++m)
    for (const FleetValue& value : fleet.members[m].values) {
      FleetSeries& series = series_of(value, fleet.series);
      series.members.push_back(m);
      series.values.push_back(value.value);
      series.deviations.push_back(value.deviation);
    }
  for (FleetSeries& series : fleet.series)
    if (has_limits(series)) series.chart = calibration::individuals_chart(series.values, baseline);
  return fleet;
}

std::string headline(const Fleet& fleet) {
  std::vector<std::string> who;
  for (const FleetSeries& series : fleet.series)
    for (const std::size_t i : series.chart.outside) {
      const std::string one = called(fleet.members[series.members[i]]);
      if (std::find(who.begin(), who.end(), one) == who.end()) who.push_back(one);
    }
  const std::string all = fmt::format("{}, {} in all", fleet.name, fleet.members.size());
  if (std::none_of(fleet.series.begin(), fleet.series.end(), has_limits))
    return fmt::format("{}: no quantity has the {} values that limits need.", all, least_of_series);
  if (who.empty()) return fmt::format("{}: every value lies within its control limits.", all);
  constexpr std::size_t most = 5;
  const std::size_t more = who.size() > most ? who.size() - most : 0;
  who.resize(who.size() - more);
  if (more > 0) who.push_back(fmt::format("{} others", more));
  return fmt::format("{}: outside the control limits {} {}.", all,
                     who.size() == 1 && more == 0 ? "is" : "are", listed(who));
}

std::string text(const Fleet& fleet) {
  std::string said;
  for (const FleetSeries& series : fleet.series)
    for (const std::size_t i : series.chart.outside)
      said += wrapped(sentence(fleet, series, i) + ".", 2, 4);
  Table table({"quantity", "unit", "values", "mean", "lower limit", "upper limit", "outside"});
  for (const FleetSeries& series : fleet.series) {
    const bool limits = has_limits(series);
    const ReadableUnit unit = readable_unit(series);
    const auto cell = [&](double x) { return limits ? unit(x) : std::string("-"); };
    table.add_row({series.name, unit.name, fmt::format("{}", series.values.size()),
                   cell(series.chart.mean), cell(series.chart.lower), cell(series.chart.upper),
                   limits ? fmt::format("{}", series.chart.outside.size()) : "-"});
  }
  said += (said.empty() ? "" : "\n") + table.text();
  const std::string of =
      fleet.baseline > 0 ? fmt::format(" of the first {} values", fleet.baseline) : std::string();
  return said + wrapped(fmt::format("Limits: mean +- 2.66 times the mean moving range{}, "
                                    "in the order of date and serial number (individuals chart).",
                                    of),
                        2, 2);
}

Json to_json(const Fleet& fleet) {
  Json members = Json::array(), series = Json::array();
  for (const FleetMember& one : fleet.members)
    members.push_back({{"serial", one.serial}, {"date", one.date}, {"file", one.file}});
  for (const FleetSeries& one : fleet.series) series.push_back(json_of(fleet, one));
  return {{"fleet", fleet.name},
          {"baseline", fleet.baseline},
          {"members", members},
          {"series", series}};
}

}  // namespace kinetostat::report
