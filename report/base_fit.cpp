#include "kinetostat/report/base_fit.h"

#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "kinetostat/report/text/text.h"

namespace kinetostat::report {
namespace {

using calibration::BaseFit;
using calibration::BoundHit;
using calibration::Campaign;
using calibration::ParameterEstimate;
using io::Json;
using io::numbers;

// Below this weight a reading is named as one that hardly counted.
constexpr double low_weight = 0.5;

std::string shown(const std::string& unit, double si, int digits) {
  return number(si / spatial::parse_unit(unit).factor, digits);
}

std::string hit_text(BoundHit hit) { return hit == BoundHit::lower ? "lower" : "upper"; }

// Instead of an error: at which bound a parameter ends, or that it was kept where it starts.
std::string held_text(const ParameterEstimate& e) {
  return e.parameter.is_held() ? "kept" : hit_text(e.hit) + " bound";
}

// Nominal and fitted value in a unit, with the factor between the two if there is one.
struct Shown {
  double nominal = 1, fitted = 1, error = 0;
  std::string unit = "-";
};

Shown shown_parameter(const Campaign& campaign, const ParameterEstimate& e) {
  if (!e.parameter.is_logarithm())
    return {e.parameter.start, e.value, e.standard_error, e.parameter.unit};
  const double factor = std::exp(e.value);
  Shown shown{1, factor, factor * e.standard_error, "-"};
  if (!e.parameter.stiffness) return shown;
  shown.unit = e.parameter.is_torsional
                   ? fmt::format("{} {}/rad", campaign.units.force, campaign.units.length)
                   : fmt::format("{}/{}", campaign.units.force, campaign.units.length);
  const double nominal = *e.parameter.stiffness / spatial::parse_unit(shown.unit).factor;
  shown.nominal *= nominal;
  shown.fitted *= nominal;
  shown.error *= nominal;
  return shown;
}

std::string parameters_text(const Campaign& campaign, const BaseFit& fit) {
  if (fit.parameters.empty()) return {};
  Table table({"parameter", "nominal", "fitted", "+-", "unit", "factor"});
  for (const ParameterEstimate& e : fit.parameters) {
    const Shown shown = shown_parameter(campaign, e);
    table.add_row({e.parameter.name, number(shown.nominal, 6), number(shown.fitted, 7),
                   e.hit == BoundHit::none ? number(shown.error, 2) : held_text(e), shown.unit,
                   e.parameter.is_logarithm() ? number(std::exp(e.value), 6) : "-"});
  }
  return "\n" + table.text();
}

std::string zeros_text(const Campaign& campaign, const BaseFit& fit) {
  if (fit.zeros.empty()) return {};
  Table table({"zero offset of", "session", "value", "+-", "unit"});
  for (const calibration::Zero& zero : fit.zeros)
    table.add_row({campaign.component(zero.component).name, campaign.sessions[zero.session],
                   shown(campaign.unit_of(zero.component), zero.value, 6),
                   shown(campaign.unit_of(zero.component), zero.standard_error, 2),
                   campaign.unit_of(zero.component)});
  return "\n" + table.text();
}

std::string frames_text(const Campaign& campaign, const BaseFit& fit) {
  if (fit.frames.empty()) return {};
  Table table({"frame of session", "", "value", "+-", "unit"});
  bool any_undetermined = false;
  for (const calibration::FrameEstimate& frame : fit.frames)
    for (Eigen::Index k = 0; k < 6; ++k) {
      const bool turns = calibration::is_rotation(k);
      const std::string& unit = turns ? campaign.units.angle : campaign.units.length;
      if (std::isnan(frame.standard_error[k]))
        any_undetermined |= !std::isnan(frame.value[k]);
      else
        table.add_row({campaign.sessions[frame.session],
                       (turns ? "turn about " : "") + std::string(1, "xyz"[k % 3]),
                       shown(unit, frame.value[k], 6), shown(unit, frame.standard_error[k], 2),
                       unit});
    }
  std::string text = "\n" + table.text();
  if (campaign.displacement == calibration::DisplacementKind::difference)
    text += "  In differences the position of a frame cancels: it is not observable.\n";
  if (any_undetermined)
    text += "  Coordinates of a frame that no reading determines stay as stated.\n";
  return text;
}

std::string target_text(const Campaign& campaign, const BaseFit& fit,
                        const calibration::TargetEstimate& target) {
  const std::string& sensor = campaign.sensors[target.sensor].name;
  Table table({sensor.empty() ? "target" : "target of " + sensor, "value", "+-", "unit"});
  std::vector<std::string> open;
  for (Eigen::Index k = 0; k < 6; ++k) {
    const bool turns = calibration::is_rotation(k);
    const std::string& unit = turns ? campaign.units.angle : campaign.units.length;
    const std::string name = (turns ? "turn about " : "") + std::string(1, "xyz"[k % 3]);
    if (!std::isnan(target.standard_error[k]))
      table.add_row(
          {name, shown(unit, target.value[k], 6), shown(unit, target.standard_error[k], 2), unit});
    else if (!std::isnan(target.value[k]))
      open.push_back(name);
  }
  std::string text = "\n" + table.text();
  if (!open.empty())
    text += fmt::format(
        "  Of the target stays as stated: {}. The readings do not distinguish that from where the "
        "instrument stands{}.\n",
        fmt::join(open, ", "), fit.frames.empty() ? ", or it is not observable" : "");
  return text;
}

std::string targets_text(const Campaign& campaign, const BaseFit& fit) {
  std::string text;
  for (const calibration::TargetEstimate& target : fit.targets)
    text += target_text(campaign, fit, target);
  return text;
}

std::vector<std::string> bound_sentences(const BaseFit& fit) {
  std::vector<std::string> sentences;
  for (const ParameterEstimate& e : fit.parameters)
    if (e.hit != BoundHit::none && !e.parameter.is_held())
      sentences.push_back(fmt::format(
          "The fit of {} ends at its {} bound: the readings would have it beyond what is "
          "possible, so that something else is missing from the model, or the bound is wrong.",
          e.parameter.phrase(), hit_text(e.hit)));
  return sentences;
}

// Readings of which a robust loss has taken most of the influence, by their ids.
std::vector<std::string> doubted(const Campaign& campaign, const BaseFit& fit) {
  std::vector<std::string> ids;
  const std::vector<calibration::Value> values = calibration::values_in_use(campaign);
  for (std::size_t i = 0; i < std::min(values.size(), fit.weights.size()); ++i) {
    const std::string& id = campaign.readings[values[i].reading].id;
    if (fit.weights[i] < low_weight && (ids.empty() || ids.back() != id)) ids.push_back(id);
  }
  return ids;
}

std::string loss_text(const Campaign& campaign, const BaseFit& fit) {
  if (fit.loss == calibration::Loss::squares) return {};
  std::vector<std::string> ids = doubted(campaign, fit);
  const std::size_t count = ids.size();
  if (count > 10) ids.resize(10);
  return fmt::format("  Robust fit ({}): {} readings counted less than half{}{}{}.\n",
                     fit.loss == calibration::Loss::huber ? "Huber" : "Cauchy", count,
                     count > 0 ? ": " : "", fmt::join(ids, ", "), count > 10 ? ", ..." : "");
}

Json to_json(const Campaign& campaign, const calibration::Zero& zero) {
  return {{"component", campaign.component(zero.component).name},
          {"session", campaign.sessions[zero.session]},
          {"value", zero.value},
          {"standard_error", zero.standard_error},
          {"unit", spatial::to_string(campaign.component(zero.component).dimension)}};
}

Json to_json(const Campaign& campaign, const calibration::FrameEstimate& frame) {
  return {{"session", campaign.sessions[frame.session]},
          {"value", numbers(frame.value)},
          {"standard_error", numbers(frame.standard_error)},
          {"units", {"m", "m", "m", "rad", "rad", "rad"}}};
}

Json to_json(const calibration::TargetEstimate& target) {
  return {{"value", numbers(target.value)},
          {"standard_error", numbers(target.standard_error)},
          {"units", {"m", "m", "m", "rad", "rad", "rad"}}};
}

Json covariance_json(const Eigen::MatrixXd& covariance) {
  Json rows = Json::array();
  for (Eigen::Index i = 0; i < covariance.rows(); ++i) {
    Json row = Json::array();
    for (Eigen::Index j = 0; j < covariance.cols(); ++j) row.push_back(covariance(i, j));
    rows.push_back(row);
  }
  return rows;
}

}  // namespace

namespace {

Json factor_json(const ParameterEstimate& e) {
  const double factor = std::exp(e.value);
  Json json{{"stiffness", e.parameter.name},
            {"factor", factor},
            {"log_factor", e.value},
            {"standard_error_of_log_factor", e.standard_error}};
  if (e.parameter.stiffness)
    json.update({{"designed", *e.parameter.stiffness},
                 {"fitted", *e.parameter.stiffness * factor},
                 {"standard_error", *e.parameter.stiffness * factor * e.standard_error},
                 {"unit", e.parameter.is_torsional ? "N m/rad" : "N/m"}});
  return json;
}

}  // namespace

Json to_json(const ParameterEstimate& e) {
  Json json{{"parameter", e.parameter.name}, {"bound", nullptr}};
  if (e.hit != BoundHit::none) json["bound"] = e.parameter.is_held() ? "kept" : hit_text(e.hit);
  if (e.parameter.is_logarithm())
    json.update(factor_json(e));
  else
    json.update({{"designed", e.parameter.start},
                 {"fitted", e.value},
                 {"standard_error", e.standard_error},
                 {"unit", e.parameter.unit}});
  return json;
}

std::string text(const Campaign& campaign, const BaseFit& fit) {
  std::string result = parameters_text(campaign, fit) + zeros_text(campaign, fit) +
                       frames_text(campaign, fit) + targets_text(campaign, fit) +
                       loss_text(campaign, fit);
  for (const std::string& sentence : bound_sentences(fit)) result += "  " + sentence + "\n";
  for (const std::string& sentence : fit.weak) result += "  " + sentence + "\n";
  return result;
}

Json to_json(const Campaign& campaign, const BaseFit& fit) {
  Json json{{"parameters", Json::array()},
            {"zeros", Json::array()},
            {"frames", Json::array()},
            {"covariance", covariance_json(fit.covariance)},
            {"weak_combinations", fit.weak},
            {"bounds_hit", bound_sentences(fit)},
            {"loss", fit.loss == calibration::Loss::squares ? "squares"
                     : fit.loss == calibration::Loss::huber ? "huber"
                                                            : "cauchy"},
            {"readings_of_low_weight", doubted(campaign, fit)},
            {"iterations", fit.iterations}};
  for (const ParameterEstimate& e : fit.parameters) json["parameters"].push_back(to_json(e));
  for (const calibration::Zero& zero : fit.zeros) json["zeros"].push_back(to_json(campaign, zero));
  for (const calibration::FrameEstimate& frame : fit.frames)
    json["frames"].push_back(to_json(campaign, frame));
  for (const calibration::TargetEstimate& target : fit.targets) {
    const std::string& sensor = campaign.sensors[target.sensor].name;
    if (sensor.empty())
      json["target"] = to_json(target);
    else
      json["targets"][sensor] = to_json(target);
  }
  return json;
}

}  // namespace kinetostat::report
