#include "kinetostat/report/comparison.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "kinetostat/calibration/campaign/datum.h"
#include "kinetostat/calibration/campaign/pure_error.h"
#include "kinetostat/calibration/regression/datum_noise.h"
#include "kinetostat/calibration/sensors/weight.h"
#include "kinetostat/io/csv.h"
#include "kinetostat/io/text_file.h"
#include "kinetostat/report/base_fit.h"
#include "kinetostat/report/campaign_check.h"
#include "kinetostat/report/text/text.h"

namespace kinetostat::report {
namespace {

using calibration::Adequacy;
using calibration::Assessment;
using calibration::Campaign;
using calibration::ChiSquareTest;
using calibration::Comparison;
using calibration::LackOfFitTest;
using calibration::NoiseSource;
using calibration::Reading;
using calibration::ResidualStatistics;
using io::Json;
using io::numbers;

// A model as it is called in sentences.
struct Named {
  std::string name;
  const Assessment* assessment;
};

std::vector<Named> models(const Comparison& comparison) {
  std::vector<Named> result = {{"The nominal model", &comparison.nominal}};
  if (comparison.fitted) result.push_back({"The fitted model", &*comparison.fitted});
  return result;
}

const std::string& name_of(const Campaign& campaign, Eigen::Index component) {
  return campaign.component(component).name;
}

double in_units(const Campaign& campaign, Eigen::Index component, double si) {
  return si / spatial::parse_unit(campaign.unit_of(component)).factor;
}

std::string quantity(const Campaign& campaign, Eigen::Index component, double si) {
  return number(in_units(campaign, component, si), 4) + " " + campaign.unit_of(component);
}

std::string probability(double p) {
  return p < 1e-300 ? "p < 1e-300" : fmt::format("p = {}", number(p, 2));
}

// The mean of a residual whose constant is fitted is rounding; it is shown as 0.
double shown_bias(const ResidualStatistics& s) {
  return std::abs(s.bias) < 1e-9 * s.max ? 0 : s.bias;
}

struct Finding {
  double severity;  // 1 where a test is just failed
  std::string sentence;
};

Finding finding(const std::string& model, const LackOfFitTest& test) {
  return {
      test.f / test.critical,
      fmt::format(
          "{} {}: lack-of-fit F = {} against {} ({} %, {} and {} degrees of freedom, "
          "{}).",
          model,
          test.p_value < test.level ? "fails" : "is consistent with the scatter of the replicates",
          number(test.f, 4), number(test.critical, 4), number(100 * test.level, 3),
          test.degrees_of_freedom_lack, test.degrees_of_freedom_pure, probability(test.p_value))};
}

// The key that says that unloaded readings are exact, where half of a reading's variance is taken
// for them whatever the readings show; else empty.
std::string exact_datum(const Campaign& campaign) {
  if (campaign.readings.size() <= calibration::most_for_datums ||
      campaign.displacement == calibration::DisplacementKind::absolute)
    return {};
  std::vector<Eigen::VectorXd> sigma;
  for (const Reading& reading : campaign.readings) sigma.push_back(reading.sigma);
  if (calibration::datums_of(campaign, sigma).empty()) return {};
  bool translation = false, rotation = false;
  for (const Reading& reading : campaign.readings)
    for (const Eigen::Index k : calibration::components_in_use(reading))
      if (std::isnan(campaign.datum_noise[k]))
        (campaign.component(k).dimension == spatial::dimension::angle ? rotation : translation) =
            true;
  if (!translation && !rotation) return {};
  return fmt::format("datum_noise: {{{}{}{}}}", translation ? "translation: 0 um" : "",
                     translation && rotation ? ", " : "", rotation ? "rotation: 0 urad" : "");
}

Finding finding(const Campaign& campaign, const std::string& model, const Assessment& assessment) {
  const ChiSquareTest& test = *assessment.chi_square;
  std::string sentence = fmt::format(
      "{} {}: its error is {} times the stated noise (chi-square {} against {}, {} %, "
      "{} degrees of freedom, {}).",
      model, test.p_value < test.level ? "fails" : "is consistent with the stated noise",
      number(assessment.error_over_noise(), 3), number(test.statistic, 4), number(test.critical, 4),
      number(100 * test.level, 3), test.degrees_of_freedom, probability(test.p_value));
  if (test.lower_p_value < test.level / 2) {
    sentence += " That is less than the stated noise allows: it seems overstated.";
    if (const std::string exact = exact_datum(campaign); !exact.empty())
      sentence += fmt::format(
          " Half of one reading's variance is taken for each unloaded reading: where these are "
          "exact, or means of many, state '{}' in the campaign file, or what they have.",
          exact);
  }
  return {test.statistic / test.critical, sentence};
}

// A unit or sign error explains whatever else is found.
void add_unit_error(const Comparison& comparison, std::vector<Finding>& findings) {
  if (!comparison.unit_error.empty())
    findings.push_back({std::numeric_limits<double>::infinity(), comparison.unit_error});
}

// Only a disagreement is worth a sentence; it comes first, because it undermines the chi-square.
void add_noise_check(const Comparison& comparison, std::vector<Finding>& findings) {
  if (!comparison.noise_check) return;
  const ChiSquareTest& test = *comparison.noise_check;
  if (2 * std::min(test.p_value, test.lower_p_value) >= test.level) return;
  findings.push_back(
      {std::numeric_limits<double>::infinity(),
       fmt::format("Repeated readings scatter {} times the stated noise (chi-square {} on {} "
                   "degrees of freedom): correct the stated noise before the chi-square tests "
                   "below are believed.",
                   number(std::sqrt(test.reduced()), 3), number(test.statistic, 4),
                   test.degrees_of_freedom)});
}

std::string axis_sentence(const Campaign& campaign, const std::string& model,
                          const ResidualStatistics& s) {
  return fmt::format(
      "{} leaves {} % of its squared error in {}: rms {}, largest {} at reading "
      "'{}', bias {}.",
      model, number(100 * s.share, 3), name_of(campaign, s.component),
      quantity(campaign, s.component, s.rms), quantity(campaign, s.component, s.max),
      campaign.readings[s.worst_reading].id, quantity(campaign, s.component, shown_bias(s)));
}

void add_axes(const Campaign& campaign, const Named& model, std::vector<Finding>& findings) {
  if (model.assessment->is_exact) {
    findings.push_back({-20, fmt::format("{} leaves no error beyond rounding.", model.name)});
    return;
  }
  for (const ResidualStatistics& s : model.assessment->by_component)
    if (s.share > 1e-3) findings.push_back({s.share - 10, axis_sentence(campaign, model.name, s)});
}

// Below this level a dependence is a finding.
constexpr double level = calibration::significance_level;

std::string test_text(const calibration::PatternTest& test) {
  return fmt::format("F = {} on {} and {} degrees of freedom, {} after Holm's correction",
                     number(test.f, 4), test.degrees_of_freedom, test.degrees_of_freedom_within,
                     probability(test.holm_p_value));
}

std::string pattern_sentence(const Campaign& campaign, const std::string& model,
                             const calibration::Pattern& pattern) {
  const bool by_bias =
      pattern.bias && (!pattern.size || pattern.bias->holm_p_value <= pattern.size->holm_p_value);
  const auto worst = std::max_element(
      pattern.groups.begin(), pattern.groups.end(), [](const auto& a, const auto& b) {
        return a.share - a.share_of_values < b.share - b.share_of_values;
      });
  std::string text = fmt::format(
      "{}: the {} of its error depends on {}. {} % of the squared error is at {} ({} % of the "
      "values)",
      model, by_bias ? "mean" : "size", pattern.factor, number(100 * worst->share, 3), worst->label,
      number(100 * worst->share_of_values, 3));
  if (worst->component)
    text += fmt::format(", {} % of it in {}", number(100 * worst->component_share, 3),
                        name_of(campaign, *worst->component));
  if (by_bias && pattern.along_load) {
    text += ", mean along the load";
    for (std::size_t g = 0; g < std::min<std::size_t>(pattern.groups.size(), 4); ++g)
      text += fmt::format("{} {} at {}", g == 0 ? "" : ",", number(pattern.groups[g].mean, 3),
                          pattern.groups[g].label);
    text += " (whitened)";
  }
  return text + fmt::format("; {}.", test_text(by_bias ? *pattern.bias : *pattern.size));
}

std::string loop_test_text(const calibration::LoopTest& test) {
  if (test.degrees_of_freedom_noise > 0)
    return fmt::format("F = {} on {} and {} degrees of freedom, {} after Holm's correction",
                       number(test.statistic / static_cast<double>(test.degrees_of_freedom), 4),
                       test.degrees_of_freedom, test.degrees_of_freedom_noise,
                       probability(test.holm_p_value));
  return fmt::format("chi-square {} on {} degrees of freedom, {} after Holm's correction",
                     number(test.statistic, 4), test.degrees_of_freedom,
                     probability(test.holm_p_value));
}

std::string area_sentence(const Campaign&, const std::string& model,
                          const calibration::Patterns& patterns) {
  const auto worst = std::max_element(
      patterns.loops.each.begin(), patterns.loops.each.end(), [](const auto& a, const auto& b) {
        return std::abs(a.measured - a.predicted) < std::abs(b.measured - b.predicted);
      });
  return fmt::format(
      "{} loses {} J in load cycle '{}', where {} J were measured with a noise of {} J ({} closed "
      "cycles; {}).",
      model, number(worst->predicted, 3), worst->cycle, number(worst->measured, 3),
      number(worst->noise.value_or(0), 2), patterns.loops.each.size(),
      loop_test_text(*patterns.loops.area));
}

std::string return_sentence(const Campaign& campaign, const std::string& model,
                            const calibration::Patterns& patterns) {
  const calibration::Loop* worst = nullptr;
  Eigen::Index component = 0;
  double largest = -1;
  for (const calibration::Loop& loop : patterns.loops.each)
    for (Eigen::Index k = 0; loop.return_to_zero && k < campaign.size(); ++k)
      if (const double size = std::abs((*loop.return_to_zero)[k]); size > largest)
        largest = size, worst = &loop, component = k;
  return fmt::format(
      "{} does not return to zero as the readings do: in load cycle '{}' they come back {} of {} "
      "off ({}).",
      model, worst->cycle, quantity(campaign, component, (*worst->return_to_zero)[component]),
      name_of(campaign, component), loop_test_text(*patterns.loops.return_to_zero));
}

// Between -6 and -5: below the tests of adequacy, above plain statistics, the surest first.
double significance(double p_value, double statistic) {
  const double digits = p_value > 1e-300 ? -std::log10(p_value) : 300 + std::log10(statistic);
  return -5 - 1 / (1 + std::max(0.0, digits));
}

double severity_of(const calibration::Pattern& pattern) {
  double severity = -6;
  for (const auto* test : {&pattern.bias, &pattern.size})
    if (*test) severity = std::max(severity, significance((*test)->holm_p_value, (*test)->f));
  return severity;
}

// Significant dependences, between the tests of adequacy and the plain statistics.
Finding reversal_finding(const Named& model, const calibration::Reversal& r) {
  return {significance(r.test.holm_p_value, r.test.f),
          fmt::format("{} leaves an error of which {} % {} over {} pairs of readings; {}.",
                      model.name, number(100 * std::max(r.odd_share, 1 - r.odd_share), 3),
                      r.odd_share > 0.5 ? "changes sign with the load (odd)"
                                        : "stays when the load is reversed (even)",
                      r.pairs, test_text(r.test))};
}

void add_patterns(const Campaign& campaign, const Named& model, std::vector<Finding>& findings) {
  const calibration::Patterns& patterns = model.assessment->patterns;
  for (const calibration::Pattern& pattern : patterns.factors)
    if (pattern.holm_p_value() < level)
      findings.push_back({severity_of(pattern), pattern_sentence(campaign, model.name, pattern)});
  if (patterns.reversal && patterns.reversal->test.holm_p_value < level)
    findings.push_back(reversal_finding(model, *patterns.reversal));
  for (const auto& [test, sentence] : {std::pair(patterns.loops.area, &area_sentence),
                                       std::pair(patterns.loops.return_to_zero, &return_sentence)})
    if (test && test->holm_p_value < level)
      findings.push_back({significance(test->holm_p_value, test->statistic),
                          sentence(campaign, model.name, patterns)});
}

std::string_view noise_text(NoiseSource source) {
  switch (source) {
    case NoiseSource::stated:
      return "stated";
    case NoiseSource::replicates:
      return "replicates";
    default:
      return "unknown";
  }
}

std::string_view adequacy_text(Adequacy adequacy) {
  switch (adequacy) {
    case Adequacy::adequate:
      return "adequate";
    case Adequacy::inadequate:
      return "inadequate";
    case Adequacy::inconclusive:
      return "inconclusive";
    default:
      return "not_evaluated";
  }
}

std::string session_name(const Campaign& campaign, const ResidualStatistics& s) {
  return s.session ? campaign.sessions[*s.session] : "all";
}

std::vector<std::string> statistics_row(const Campaign& campaign, const ResidualStatistics& s) {
  const auto show = [&](double si) { return number(in_units(campaign, s.component, si), 4); };
  return {name_of(campaign, s.component),
          std::to_string(s.count),
          show(s.rms),
          show(s.max),
          campaign.readings[s.worst_reading].id,
          show(shown_bias(s)),
          campaign.unit_of(s.component)};
}

std::string statistics_text(const Campaign& campaign, const Assessment& assessment) {
  const bool sessions = !assessment.by_session.empty();
  std::vector<std::string> header = {"", "values", "rms", "max", "at reading", "bias", "unit"};
  if (sessions) header.insert(header.begin() + 1, "session");
  Table table(header);
  std::vector<ResidualStatistics> rows = assessment.by_component;
  rows.insert(rows.end(), assessment.by_session.begin(), assessment.by_session.end());
  for (const ResidualStatistics& s : rows) {
    std::vector<std::string> row = statistics_row(campaign, s);
    if (sessions) row.insert(row.begin() + 1, session_name(campaign, s));
    table.add_row(row);
  }
  return table.text();
}

// Whose word the standard errors are.
std::string error_text(const Assessment& assessment) {
  if (assessment.fit.estimated == 0) return {};
  if (assessment.adequacy == Adequacy::inadequate)
    return "  The model fails, so these standard errors are too small to be believed.\n";
  if (assessment.fit.error_source == NoiseSource::unknown)
    return "  The standard errors come from the residual: they take the model to be right.\n";
  return {};
}

// Root mean square of the errors in units of their noise, of a model as it stands.
std::string error_over_noise_text(const Assessment& assessment) {
  if (assessment.fit.error_source == NoiseSource::unknown || assessment.fit.values == 0) return {};
  return fmt::format("  Error {} times the noise (rms of {} values).\n",
                     number(assessment.error_over_noise(), 4), assessment.fit.values);
}

std::string deviation_text(const Campaign& campaign, const Assessment& assessment) {
  if (!assessment.residual_deviation) return {};
  return fmt::format(
      "  Residual standard deviation {} on {} degrees of freedom.\n",
      quantity(campaign, assessment.by_component[0].component, *assessment.residual_deviation),
      assessment.fit.degrees_of_freedom());
}

// As it is stated; nothing where it is not.
Json direction_json(calibration::LoadDirection direction) {
  if (direction == calibration::LoadDirection::unstated) return {};
  return direction == calibration::LoadDirection::loading ? "loading" : "unloading";
}

std::string role_name(calibration::Role role) {
  return calibration::role_names[static_cast<std::size_t>(role)];
}

std::string held_out_text(const Campaign& campaign, const calibration::HeldOutReadings& held_out) {
  std::string text = fmt::format("  Kept out of the fit, to {}: {} values",
                                 role_name(held_out.role), held_out.values);
  if (!held_out.failure.empty()) return text + "; " + held_out.failure + "\n";
  for (const ResidualStatistics& s : held_out.by_component)
    text +=
        fmt::format(", {} rms {} max {}", name_of(campaign, s.component),
                    quantity(campaign, s.component, s.rms), quantity(campaign, s.component, s.max));
  if (held_out.chi_square)
    text += fmt::format("; {} times the noise ({})",
                        number(std::sqrt(held_out.chi_square->reduced()), 3),
                        probability(held_out.chi_square->p_value));
  return text + ".\n";
}

std::string held_out_text(const Campaign& campaign, const Assessment& assessment) {
  std::string text;
  for (const calibration::HeldOutReadings& held_out : assessment.held_out)
    text += held_out_text(campaign, held_out);
  return text;
}

std::string assessment_text(const Campaign& campaign, const std::string& title,
                            const Assessment& assessment) {
  return fmt::format("\n{}\n{}\n", title, std::string(title.size(), '-')) +
         statistics_text(campaign, assessment) + error_over_noise_text(assessment) +
         deviation_text(campaign, assessment) + held_out_text(campaign, assessment) +
         report::text(campaign, assessment.fit) + error_text(assessment);
}

Json to_json(const ChiSquareTest& test) {
  return {{"chi_square", test.statistic},       {"degrees_of_freedom", test.degrees_of_freedom},
          {"reduced", test.reduced()},          {"level", test.level},
          {"critical", test.critical},          {"p_value", test.p_value},
          {"lower_p_value", test.lower_p_value}};
}

Json to_json(const LackOfFitTest& test) {
  return {{"f", test.f},
          {"degrees_of_freedom", {test.degrees_of_freedom_lack, test.degrees_of_freedom_pure}},
          {"level", test.level},
          {"critical", test.critical},
          {"p_value", test.p_value}};
}

Json to_json(const Campaign& campaign, const ResidualStatistics& s) {
  Json json{{"component", name_of(campaign, s.component)}};
  if (s.session) json["session"] = campaign.sessions[*s.session];
  json["unit"] = spatial::to_string(campaign.component(s.component).dimension);
  json["values"] = s.count;
  json["rms"] = s.rms;
  json["max"] = s.max;
  json["worst_reading"] = campaign.readings[s.worst_reading].id;
  json["bias"] = s.bias;
  json["share"] = s.share;
  return json;
}

Json to_json(const calibration::PatternTest& test) {
  return {{"f", test.f},
          {"degrees_of_freedom", {test.degrees_of_freedom, test.degrees_of_freedom_within}},
          {"p_value", test.p_value},
          {"holm_p_value", test.holm_p_value}};
}

Json to_json(const Campaign& campaign, const calibration::Pattern& pattern) {
  Json json{{"factor", pattern.factor},  {"along_load", pattern.along_load},
            {"trend", pattern.is_trend}, {"mean", nullptr},
            {"size", nullptr},           {"groups", Json::array()}};
  if (pattern.bias) json["mean"] = to_json(*pattern.bias);
  if (pattern.size) json["size"] = to_json(*pattern.size);
  for (const calibration::PatternGroup& g : pattern.groups) {
    json["groups"].push_back({{"label", g.label},
                              {"values", g.values},
                              {"share", g.share},
                              {"share_of_values", g.share_of_values},
                              {"whitened_mean", g.mean}});
    if (g.component)
      json["groups"].back().update(
          {{"component", name_of(campaign, *g.component)}, {"component_share", g.component_share}});
  }
  return json;
}

Json to_json(const calibration::Loop& loop) {
  Json json{{"session", loop.session},        {"cycle", loop.cycle},
            {"measured_area", loop.measured}, {"predicted_area", loop.predicted},
            {"noise_of_area", nullptr},       {"unit", "J"},
            {"return_to_zero", nullptr}};
  if (loop.noise) json["noise_of_area"] = *loop.noise;
  if (loop.return_to_zero) json["return_to_zero"] = numbers(*loop.return_to_zero);
  return json;
}

Json to_json(const calibration::LoopTest& test) {
  Json json{{"statistic", test.statistic},
            {"degrees_of_freedom", test.degrees_of_freedom},
            {"degrees_of_freedom_of_noise", nullptr},
            {"p_value", test.p_value},
            {"holm_p_value", test.holm_p_value}};
  if (test.degrees_of_freedom_noise > 0)
    json["degrees_of_freedom_of_noise"] = test.degrees_of_freedom_noise;
  return json;
}

Json to_json(const Campaign& campaign, const calibration::Patterns& patterns) {
  Json json{{"factors", Json::array()},
            {"reversal", nullptr},
            {"loops", Json::array()},
            {"loop_area", nullptr},
            {"return_to_zero", nullptr}};
  for (const calibration::Pattern& p : patterns.factors)
    json["factors"].push_back(to_json(campaign, p));
  for (const calibration::Loop& loop : patterns.loops.each) json["loops"].push_back(to_json(loop));
  if (patterns.reversal)
    json["reversal"] = {{"pairs", patterns.reversal->pairs},
                        {"odd_share", patterns.reversal->odd_share},
                        {"test", to_json(patterns.reversal->test)}};
  if (patterns.loops.area) json["loop_area"] = to_json(*patterns.loops.area);
  if (patterns.loops.return_to_zero)
    json["return_to_zero"] = to_json(*patterns.loops.return_to_zero);
  return json;
}

Json to_json(const Campaign& campaign, const calibration::HeldOutReadings& held_out) {
  Json json{{"role", role_name(held_out.role)},
            {"values", held_out.values},
            {"estimated", held_out.estimated},
            {"whitened_sum_of_squares", held_out.squared_error},
            {"by_component", Json::array()},
            {"chi_square", nullptr},
            {"failure", nullptr}};
  for (const auto& s : held_out.by_component) json["by_component"].push_back(to_json(campaign, s));
  if (held_out.chi_square) json["chi_square"] = to_json(*held_out.chi_square);
  if (!held_out.failure.empty()) json["failure"] = held_out.failure;
  return json;
}

Json to_json(const Campaign& campaign, const Assessment& assessment) {
  const calibration::BaseFit& fit = assessment.fit;
  Json json{{"adequacy", adequacy_text(assessment.adequacy)},
            {"values", fit.values},
            {"estimated", fit.estimated},
            {"degrees_of_freedom", fit.degrees_of_freedom()},
            {"whitened_sum_of_squares", fit.squared_error},
            {"error_over_noise", nullptr},
            {"residual_standard_deviation", nullptr},
            {"chi_square", nullptr},
            {"lack_of_fit", nullptr}};
  if (fit.error_source != NoiseSource::unknown && fit.values > 0)
    json["error_over_noise"] = assessment.error_over_noise();
  if (assessment.residual_deviation)
    json["residual_standard_deviation"] = *assessment.residual_deviation;
  if (assessment.chi_square) json["chi_square"] = to_json(*assessment.chi_square);
  if (assessment.lack_of_fit) json["lack_of_fit"] = to_json(*assessment.lack_of_fit);
  json.update(report::to_json(campaign, assessment.fit));
  json["standard_errors_from"] =
      fit.error_source == NoiseSource::unknown ? "residual" : noise_text(fit.error_source);
  for (const char* key : {"by_component", "by_session"}) json[key] = Json::array();
  for (const auto& s : assessment.by_component)
    json["by_component"].push_back(to_json(campaign, s));
  for (const auto& s : assessment.by_session) json["by_session"].push_back(to_json(campaign, s));
  json["held_out"] = Json::array();
  for (const auto& held_out : assessment.held_out)
    json["held_out"].push_back(to_json(campaign, held_out));
  json["patterns"] = to_json(campaign, assessment.patterns);
  return json;
}

// Of what was measured; NaN elsewhere.
Eigen::VectorXd sigma_of(const calibration::Reading& reading, Eigen::VectorXd sigma) {
  for (Eigen::Index k = 0; k < sigma.size(); ++k)
    if (std::isnan(reading.displacement[k])) sigma[k] = std::numeric_limits<double>::quiet_NaN();
  return sigma;
}

Json readings_json(const Campaign& campaign, const Comparison& comparison) {
  Json list = Json::array();
  const bool known = comparison.noise.source != NoiseSource::unknown;
  for (std::size_t i = 0; i < campaign.readings.size(); ++i) {
    const calibration::Reading& reading = campaign.readings[i];
    Json json{{"id", reading.id},
              {"line", reading.line},
              {"session", campaign.sessions[reading.session]},
              {"cycle", reading.cycle},
              {"direction", direction_json(reading.direction)},
              {"configuration", reading.configuration},
              {"load",
               {{"force", io::to_json(reading.load.force)},
                {"moment", io::to_json(reading.load.moment)}}},
              {"role", role_name(reading.role)},
              {"masked", reading.masked},
              {"measured", numbers(reading.displacement)},
              {"sigma", known ? numbers(sigma_of(reading, comparison.noise.sigma[i])) : Json()},
              {"predicted", numbers(comparison.nominal.fit.predicted[i])},
              {"residual", numbers(comparison.nominal.residual[i])}};
    if (!reading.load.nodes.empty())
      json["load"]["weights"] = io::to_json(calibration::force_at_nodes(reading.load));
    if (!reading.load.joints.empty()) {
      const spatial::Vector6 joints = calibration::load_in_joints(reading.load);
      json["load"]["in_joints"] = {{"force", io::to_json(spatial::Vector3(joints.head<3>()))},
                                   {"moment", io::to_json(spatial::Vector3(joints.tail<3>()))}};
    }
    if (reading.masked) json["mask_reason"] = reading.mask_reason;
    if (!reading.instrument.empty()) json["instrument"] = reading.instrument;
    json["whitened"] = numbers(comparison.nominal.whitened[i]);
    if (comparison.fitted) {
      json["refitted_predicted"] = numbers(comparison.fitted->fit.predicted[i]);
      json["refitted_residual"] = numbers(comparison.fitted->residual[i]);
      json["refitted_whitened"] = numbers(comparison.fitted->whitened[i]);
    }
    list.push_back(json);
  }
  return list;
}

Json file_json(const std::filesystem::path& file) {
  return {{"file", file.string()}, {"sha256", io::sha256(io::read_text(file))}};
}

std::size_t masked(const Campaign& campaign) {
  return static_cast<std::size_t>(std::count_if(campaign.readings.begin(), campaign.readings.end(),
                                                [](const auto& r) { return r.masked; }));
}

std::string summary(const Campaign& campaign, const Comparison& comparison) {
  std::string text = fmt::format(
      "Campaign '{}': {} readings in use, {} masked, {} values of {} states; noise {}.\n",
      campaign.name, campaign.readings.size() - masked(campaign), masked(campaign),
      comparison.nominal.fit.values, comparison.groups,
      comparison.noise.source == NoiseSource::replicates ? "from replicates"
                                                         : noise_text(comparison.noise.source));
  for (const std::string& note : campaign.notes) text += "  " + note + "\n";
  for (const std::string& note : comparison.notes) text += "  " + note + "\n";
  if (!comparison.refit_failure.empty()) text += "  Not fitted: " + comparison.refit_failure + "\n";
  return text;
}

std::vector<Eigen::Index> measured_components(const Comparison& comparison) {
  std::vector<Eigen::Index> result;
  for (const auto& s : comparison.nominal.by_component) result.push_back(s.component);
  return result;
}

std::string cell(double value) { return std::isnan(value) ? "" : fmt::format(",{}", value); }

std::string cell(const Campaign& campaign, Eigen::Index component, double si) {
  return std::isnan(si) ? "," : cell(in_units(campaign, component, si));
}

}  // namespace

std::vector<std::string> findings(const Campaign& campaign, const Comparison& comparison) {
  std::vector<Finding> all;
  add_unit_error(comparison, all);
  add_noise_check(comparison, all);
  for (const Named& model : models(comparison)) {
    if (const auto& test = model.assessment->lack_of_fit) all.push_back(finding(model.name, *test));
    if (model.assessment->chi_square)
      all.push_back(finding(campaign, model.name, *model.assessment));
  }
  add_patterns(campaign, models(comparison).back(), all);
  add_axes(campaign, models(comparison).back(), all);
  std::stable_sort(all.begin(), all.end(),
                   [](const Finding& a, const Finding& b) { return a.severity > b.severity; });
  std::vector<std::string> sentences;
  sentences.reserve(all.size());
  for (const Finding& finding : all) sentences.push_back(finding.sentence);
  return sentences;
}

std::string text(const Campaign& campaign, const Comparison& comparison) {
  std::string text = summary(campaign, comparison) + "\nFindings, worst first\n";
  for (const std::string& sentence : findings(campaign, comparison))
    text += "  - " + sentence + "\n";
  text += fmt::format("  Adequacy: {}.\n", adequacy_text(comparison.adequacy()));
  text += assessment_text(campaign, "Nominal", comparison.nominal);
  if (comparison.fitted) text += assessment_text(campaign, "Fitted", *comparison.fitted);
  return text;
}

Json to_json(const Campaign& campaign, const Comparison& comparison) {
  Json about = occasion_json(campaign);
  about.update({{"campaign", file_json(campaign.file)},
                {"readings", file_json(campaign.readings_file)},
                {"in_use", campaign.readings.size() - masked(campaign)},
                {"masked", masked(campaign)},
                {"notes", campaign.notes}});
  Json json{{"campaign", about},
            {"noise", noise_text(comparison.noise.source)},
            {"states", comparison.groups},
            {"pure_error", nullptr},
            {"noise_check", nullptr},
            {"notes", comparison.notes},
            {"adequacy", adequacy_text(comparison.adequacy())},
            {"findings", findings(campaign, comparison)},
            {"as_designed", to_json(campaign, comparison.nominal)},
            {"refitted", nullptr},
            {"refit_failure", nullptr},
            {"unit_error", nullptr}};
  if (!comparison.refit_failure.empty()) json["refit_failure"] = comparison.refit_failure;
  if (!comparison.unit_error.empty()) json["unit_error"] = comparison.unit_error;
  if (comparison.replicates)
    json["pure_error"] = {{"whitened_sum_of_squares", comparison.replicates->sum},
                          {"degrees_of_freedom", comparison.replicates->degrees_of_freedom}};
  if (comparison.noise_check) json["noise_check"] = to_json(*comparison.noise_check);
  if (comparison.fitted) json["refitted"] = to_json(campaign, *comparison.fitted);
  json["components"] = Json::array();
  for (const calibration::Component& component : campaign.components)
    json["components"].push_back(component.name);
  json["readings"] = readings_json(campaign, comparison);
  return json;
}

std::string residual_table(const Campaign& campaign, const Comparison& comparison) {
  std::string text =
      io::csv_comment(fmt::format("{}, translations in {}, rotations in {}", campaign.name,
                                  campaign.units.length, campaign.units.angle)) +
      "id,session,masked,mask_reason";
  const std::vector<Eigen::Index> components = measured_components(comparison);
  const std::vector<Named> all = models(comparison);
  for (const Eigen::Index k : components) {
    text += "," + name_of(campaign, k);
    for (const char* model : {"designed", "refitted"})
      if (model == std::string("designed") || comparison.fitted)
        text += fmt::format(",predicted_{0}_{1},residual_{0}_{1},whitened_{0}_{1}",
                            name_of(campaign, k), model);
  }
  text += "\n";
  for (std::size_t i = 0; i < campaign.readings.size(); ++i) {
    const calibration::Reading& reading = campaign.readings[i];
    text += fmt::format("{},{},{},{}", io::csv_cell(reading.id),
                        io::csv_cell(campaign.sessions[reading.session]), reading.masked ? 1 : 0,
                        io::csv_cell(reading.mask_reason));
    for (const Eigen::Index k : components) {
      text += cell(campaign, k, reading.displacement[k]);
      for (const Named& model : all)
        text +=
            cell(campaign, k, model.assessment->fit.predicted[i][k]) +
            cell(campaign, k, model.assessment->residual[i][k]) +
            (std::isnan(model.assessment->whitened[i][k]) ? ","
                                                          : cell(model.assessment->whitened[i][k]));
    }
    text += "\n";
  }
  return text;
}

}  // namespace kinetostat::report
