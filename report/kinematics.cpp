#include "kinetostat/report/kinematics.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "kinetostat/report/base_fit.h"
#include "kinetostat/report/text/text.h"

namespace kinetostat::report {
namespace {

using calibration::CalibratedGeometry;
using calibration::Campaign;
using calibration::GeometricParameter;
using calibration::KinematicCalibration;
using calibration::KinematicStage;
using calibration::LeftOut;
using calibration::LeftOutGeometry;
using calibration::ObservabilityIndices;
using calibration::PoseError;
using io::Json;

Json known(double x) { return std::isfinite(x) ? Json(x) : Json(); }

Json to_json(const Campaign& campaign, const PoseError& e) {
  return {{"values", e.values},
          {"over_noise", known(e.whitened)},
          {"translation_rms", known(e.translation)},
          {"translation_max", known(e.worst_translation)},
          {"rotation_rms", known(e.rotation)},
          {"rotation_max", known(e.worst_rotation)},
          {"distance_rms", known(e.distance)},
          {"distance_max", known(e.worst_distance)},
          {"worst_reading", campaign.readings.at(e.worst_reading).id}};
}

Json to_json(const Campaign& campaign, const KinematicStage& stage) {
  return {{"name", stage.name},
          {"parameters", stage.fitted},
          {"fitted", to_json(campaign, stage.at_fitted)},
          {"held_out", stage.held_out ? to_json(campaign, *stage.held_out) : Json()}};
}

Json to_json(const GeometricParameter& what) {
  static constexpr std::array names = {"x", "y", "z", "rx", "ry", "rz"};
  const bool is_ratio = what.group == calibration::GeometryGroup::drive;
  return {{"group", calibration::to_string(what.group)},
          {"at", what.at},
          {"component", is_ratio ? "ratio" : names[static_cast<std::size_t>(what.component)]},
          {"what", what.phrase()},
          {"unit", what.unit()}};
}

Json to_json(const CalibratedGeometry& g) {
  Json json = to_json(g.what);
  json.update({{"before", g.before},
               {"value", g.value},
               {"standard_error", g.deviation},
               {"significant", g.is_significant()}});
  return json;
}

Json to_json(const LeftOutGeometry& out) {
  Json json = to_json(out.what);
  json.update({{"reason", in_words(out.why)}, {"like", out.like}});
  return json;
}

Json to_json(const ObservabilityIndices& o) {
  if (o.unknowns == 0) return nullptr;
  return {{"equations", o.equations},
          {"unknowns", o.unknowns},
          {"condition_number", known(o.condition())},
          {"in_words", conditioning_in_words(o.condition())},
          {"O1", o.o1},
          {"O2", o.o2},
          {"O3", o.o3},
          {"O4", o.o4},
          {"O5", o.o5}};
}

std::string stage_cell(const SmallUnits& units, const PoseError& e, double PoseError::*length,
                       double PoseError::*angle) {
  if (std::isfinite(e.*length)) return number(units.length_in(e.*length), 3);
  return std::isfinite(e.*angle) ? number(units.angle_in(e.*angle), 3) : "-";
}

std::string stages_text(const SmallUnits& units, const KinematicCalibration& c) {
  Table table({"error", "parameters", "rms", "largest", "held out: rms", "largest", "times noise"});
  for (const KinematicStage& s : c.stages) {
    const auto cell = [&](const std::optional<PoseError>& e, auto length, auto angle) {
      return e ? stage_cell(units, *e, length, angle) : "-";
    };
    const PoseError& judged = s.held_out ? *s.held_out : s.at_fitted;
    table.add_row(
        {s.name, std::to_string(s.fitted),
         cell(s.at_fitted, &PoseError::translation, &PoseError::rotation),
         cell(s.at_fitted, &PoseError::worst_translation, &PoseError::worst_rotation),
         cell(s.held_out, &PoseError::translation, &PoseError::rotation),
         cell(s.held_out, &PoseError::worst_translation, &PoseError::worst_rotation),
         c.noise_source == calibration::NoiseSource::unknown ? "-" : number(judged.whitened, 3)});
  }
  return table.text();
}

std::string geometry_text(const SmallUnits& units, const KinematicCalibration& c) {
  if (c.geometry.empty()) return {};
  Table table({"parameter", "place", "before", "value", "+-", "unit", "significant"});
  for (const CalibratedGeometry& g : c.geometry)
    table.add_row({g.what.phrase().substr(4), g.what.at, number(units.in(g.what, g.before), 4),
                   number(units.in(g.what, g.value), 4), number(units.in(g.what, g.deviation), 2),
                   units.of(g.what), g.is_significant() ? "yes" : "no"});
  return "\n" + table.text();
}

std::string others_text(const KinematicCalibration& c) {
  if (c.others.empty()) return {};
  Table table({"beside it", "fitted", "+-", "unit"});
  for (const calibration::ParameterEstimate& e : c.others) {
    const bool is_factor = e.parameter.is_logarithm();
    const double value = is_factor ? std::exp(e.value) : e.value;
    table.add_row({e.parameter.name, number(value, 4),
                   number(is_factor ? value * e.standard_error : e.standard_error, 2),
                   is_factor ? "times nominal" : e.parameter.unit});
  }
  return "\n" + table.text();
}

std::string left_out_text(const KinematicCalibration& c) {
  std::string text;
  for (const LeftOut why : {LeftOut::confounded, LeftOut::unseen, LeftOut::too_many,
                            LeftOut::unneeded, LeftOut::redundant}) {
    if (c.count(why) == 0) continue;
    text += fmt::format("\nLeft at their values, {}:\n", in_words(why));
    for (const LeftOutGeometry& out : c.left_out)
      if (out.why == why)
        text += fmt::format("  {}{}{}\n", out.what.phrase(), out.like.empty() ? "" : ": like ",
                            fmt::join(out.like, " and "));
  }
  for (const std::string& sentence : c.others_kept) text += sentence + "\n";
  return text;
}

std::string correlations_text(const KinematicCalibration& c) {
  constexpr double strong = 0.9;
  const auto name = [&](Eigen::Index k) {
    const auto i = static_cast<std::size_t>(k);
    return i < c.geometry.size() ? c.geometry[i].what.phrase()
                                 : c.others[i - c.geometry.size()].parameter.phrase();
  };
  std::string text;
  for (Eigen::Index i = 0; i < c.correlation.rows(); ++i)
    for (Eigen::Index j = i + 1; j < c.correlation.cols(); ++j)
      if (std::abs(c.correlation(i, j)) > strong)
        text += fmt::format("  {:+.3f}  {}, {}\n", c.correlation(i, j), name(i), name(j));
  return text.empty() ? "" : "\nCorrelations above 0.9:\n" + text;
}

std::string observability_text(const KinematicCalibration& c) {
  const ObservabilityIndices& o = c.observability;
  if (o.unknowns == 0) return {};
  return fmt::format(
      "\n{} equations for {} unknowns: {}, condition number {}. Observability indices, columns in "
      "units of\nthe noise and of a tolerance ({} m, {} rad): O1 {}, O2 {}, O3 {}, O4 {}, O5 {}.\n",
      o.equations, o.unknowns, conditioning_in_words(o.condition()), number(o.condition(), 3),
      number(c.tolerance.length, 3), number(c.tolerance.angle, 3), number(o.o1, 3), number(o.o2, 3),
      number(o.o3, 3), number(o.o4, 3), number(o.o5, 3));
}

}  // namespace

SmallUnits::SmallUnits(const spatial::UnitSystem& units)
    : length(units.length == "m" ? "mm" : units.length),
      angle(units.angle == "rad" ? "mrad" : units.angle) {}

double SmallUnits::length_in(double metres) const {
  return metres / spatial::parse_unit(length).factor;
}

double SmallUnits::angle_in(double radians) const {
  return radians / spatial::parse_unit(angle).factor;
}

std::string conditioning_in_words(double condition) {
  if (condition < 100) return "well conditioned";
  return condition < 1000 ? "fairly conditioned" : "poorly conditioned";
}

std::string in_words(LeftOut why) {
  switch (why) {
    case LeftOut::redundant:
      return "redundant by the kinematics";
    case LeftOut::confounded:
      return "not distinguishable in these poses";
    case LeftOut::unseen:
      return "not seen by these readings";
    case LeftOut::unneeded:
      return "no better at poses that were held out";
    case LeftOut::too_many:
      break;
  }
  return "too many for so few readings";
}

std::string text(const Campaign& campaign, const KinematicCalibration& c) {
  const SmallUnits units(campaign.units);
  std::string result = stages_text(units, c) + geometry_text(units, c) + others_text(c) +
                       left_out_text(c) + correlations_text(c) + observability_text(c);
  for (const std::string& sentence : c.weak) result += sentence + "\n";
  return result;
}

Json to_json(const Campaign& campaign, const KinematicCalibration& c) {
  Json stages = Json::array(), geometry = Json::array(), others = Json::array(),
       left_out = Json::array();
  for (const KinematicStage& stage : c.stages) stages.push_back(to_json(campaign, stage));
  for (const CalibratedGeometry& g : c.geometry) geometry.push_back(to_json(g));
  for (const calibration::ParameterEstimate& e : c.others) others.push_back(to_json(e));
  for (const LeftOutGeometry& out : c.left_out) left_out.push_back(to_json(out));
  return {
      {"campaign_name", campaign.name},
      {"readings_used", c.readings},
      {"poses", c.poses},
      {"values", c.values},
      {"noise", c.noise_source == calibration::NoiseSource::stated       ? "stated"
                : c.noise_source == calibration::NoiseSource::replicates ? "replicates"
                                                                         : "unknown"},
      {"stages", stages},
      {"taken", c.after().name},
      {"judged_on_held_out_poses", c.is_judged},
      {"geometry", geometry},
      {"fitted_beside", others},
      {"kept_beside", c.others_kept},
      {"left_out", left_out},
      {"correlation", io::rows(c.correlation)},
      {"weak_combinations", c.weak},
      {"observability", to_json(c.observability)},
      {"tolerance", {{"length", c.tolerance.length}, {"angle", c.tolerance.angle}}},
      {"reach", c.reach},
      {"residual_over_noise", c.residual_ratio},
      {"confirmed_before", c.confirmed_before ? to_json(campaign, *c.confirmed_before) : Json()},
      {"confirmed", c.confirmed ? to_json(campaign, *c.confirmed) : Json()}};
}

}  // namespace kinetostat::report
