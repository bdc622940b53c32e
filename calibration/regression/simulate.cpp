#include "kinetostat/calibration/regression/simulate.h"

#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "kinetostat/calibration/campaign/readings_file.h"
#include "kinetostat/calibration/regression/predict.h"
#include "kinetostat/calibration/statistics/normal.h"
#include "kinetostat/common/error.h"
#include "kinetostat/io/csv.h"
#include "kinetostat/io/yaml.h"

namespace kinetostat::calibration {
namespace {

void refuse_displacements(const io::CsvTable& plan) {
  for (const char* name : component_names)
    if (plan.find(name))
      throw common::InputError({.file = plan.file(),
                                .line = plan.header_line(),
                                .key = name,
                                .what = "a plan has no displacements: they are what is simulated",
                                .cure = "Remove the columns dx dy dz rx ry rz"});
  for (std::size_t row = 0; row < plan.rows(); ++row)
    for (std::size_t c = 0; c < plan.columns().size(); ++c)
      if (plan.cell(row, c).find('\n') != std::string_view::npos)
        plan.fail(row, c, "a cell of a plan runs over several lines", "Write it on one line");
}

// The rows of the plan with further cells; comments and line numbers stay as they are.
template <class Cells>
std::string extended(const std::string& text, const io::CsvTable& plan, const std::string& header,
                     const Cells& cells) {
  std::string result;
  std::size_t begin = 0, row = 0;
  for (int line = 1; begin < text.size(); ++line) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    std::string content = text.substr(begin, end - begin);
    if (!content.empty() && content.back() == '\r') content.pop_back();
    if (line == plan.header_line()) content += header;
    if (row < plan.rows() && line == plan.line(row)) content += cells(row++);
    result += content + "\n";
    begin = end + 1;
  }
  return result;
}

// As in the header: where it has no comma, another separator is in use.
char separator_of(const std::string& text, const io::CsvTable& plan) {
  std::size_t begin = 0;
  for (int line = 1; line < plan.header_line(); ++line) begin = text.find('\n', begin) + 1;
  const std::string header = text.substr(begin, text.find('\n', begin) - begin);
  if (header.find(',') != std::string::npos) return ',';
  if (header.find(';') != std::string::npos) return ';';
  return header.find('\t') != std::string::npos ? '\t' : ',';
}

Campaign planned(const vjm::Robot& robot, const std::filesystem::path& file,
                 const std::string& table, DisplacementKind displacement) {
  Campaign campaign;
  campaign.file = campaign.readings_file = file;
  campaign.units = robot.units;
  campaign.displacement = displacement;
  ReadingsContext context{.angle_stated = true, .time_stated = true};
  context.wrench.point = spatial::Vector3(spatial::Vector3::Zero());
  read_readings(io::CsvTable(table, file), context, robot.manipulator, campaign);
  return campaign;
}

std::string noise_text(const SimulationOptions& options) {
  std::string parts;
  if (options.translation_noise > 0)
    parts += fmt::format("translation: {} m", options.translation_noise);
  if (options.rotation_noise > 0)
    parts += fmt::format("{}rotation: {} rad", parts.empty() ? "" : ", ", options.rotation_noise);
  return parts.empty() ? "" : "noise: {" + parts + "}\n";
}

// The unloaded state is the model's own.
std::string datum_noise_text(const SimulationOptions& options) {
  return options.displacement == DisplacementKind::difference
             ? "datum_noise: {translation: 0 m, rotation: 0 rad}\n"
             : "";
}

std::string wrench_noise_text(const SimulationOptions& options) {
  std::string parts;
  const auto add = [&parts](const char* key, double value, const char* unit) {
    if (value > 0) parts += fmt::format("{}{}: {}{}", parts.empty() ? "" : ", ", key, value, unit);
  };
  add("force", options.force_noise, " N");
  add("moment", options.moment_noise, " N m");
  add("share", options.wrench_share, "");
  return parts.empty() ? "" : "wrench_noise: {" + parts + "}\n";
}

// The wrenches that the robot feels.
void disturb_wrenches(const SimulationOptions& options, Campaign& campaign) {
  if (!(options.force_noise > 0 || options.moment_noise > 0 || options.wrench_share > 0)) return;
  Normal normal(options.seed + 0x9e3779b97f4a7c15);  // other numbers than the instrument's
  for (Reading& reading : campaign.readings)
    for (auto [component, floor] : {std::pair(&reading.load.force, options.force_noise),
                                    std::pair(&reading.load.moment, options.moment_noise)})
      for (double& value : *component)
        value += normal() * std::hypot(floor, options.wrench_share * value);
}

std::string yaml_text(const vjm::Robot& robot, const std::string& robot_name,
                      const SimulationOptions& options) {
  return fmt::format(
      "# Synthetic readings, made by kinetostat simulate with seed {}. They come from the model "
      "itself: that a fit of\n"
      "# this model to them succeeds proves nothing about any machine.\n"
      "kinetostat: 1\n"
      "campaign: {}\n"
      "origin: synthetic, seed {}\n"
      "robot: {}\n"
      "units: {{length: {}, force: {}, angle: {}, time: {}}}\n"
      "displacement: {}\n"
      "wrench_point: reference\n{}{}{}"
      "readings: readings.csv\n",
      options.seed, io::yaml_scalar("synthetic readings of " + robot.name), options.seed,
      io::yaml_scalar(robot_name), robot.units.length, robot.units.force, robot.units.angle,
      robot.units.time,
      options.displacement == DisplacementKind::absolute ? "absolute" : "difference",
      noise_text(options), datum_noise_text(options), wrench_noise_text(options));
}

void add_trace(const Campaign& campaign, const SimulationOptions& options,
               const std::vector<Eigen::VectorXd>& plain, const std::vector<Eigen::VectorXd>& with,
               SimulatedCampaign& result) {
  double over_noise = 0;
  bool has_noise = true;
  for (Eigen::Index k = 0; k < 6; ++k) {
    if (!options.components[static_cast<std::size_t>(k)]) continue;
    HiddenTrace trace{.component = campaign.component(k), .unit = campaign.unit_of(k)};
    double squares = 0;
    for (std::size_t i = 0; i < plain.size(); ++i) {
      const double change = with[i][k] - plain[i][k];
      squares += change * change;
      if (std::abs(change) <= trace.max && i > 0) continue;
      trace.max = std::abs(change);
      trace.worst_reading = campaign.readings[i].id;
    }
    trace.rms = std::sqrt(squares / static_cast<double>(plain.size()));
    const double noise = is_rotation(k) ? options.rotation_noise : options.translation_noise;
    has_noise = has_noise && noise > 0;
    over_noise += squares / (noise * noise);
    result.trace.push_back(trace);
  }
  if (has_noise) result.detectability = std::sqrt(over_noise);
}

}  // namespace

std::vector<Eigen::VectorXd> predicted_readings(const vjm::Robot& robot,
                                                const std::vector<vjm::Effect>& more,
                                                const Campaign& campaign, int threads,
                                                common::Progress& progress) {
  std::vector<vjm::Effect> effects = robot.effects;
  effects.insert(effects.end(), more.begin(), more.end());
  Predictions predictions = Predictor(robot.without_effects(), effects, campaign, threads, progress)
                                .predict({}, Eigen::VectorXd(), false, progress);
  if (predictions.failure)
    throw common::NoConvergence(fmt::format(
        "{}:{}: the model has no equilibrium: {}. Check the load and its unit.",
        campaign.readings_file.string(), campaign.readings[predictions.failure->reading].line,
        predictions.failure->reason));
  return std::move(predictions.displacement);
}

SimulatedCampaign simulate(const vjm::Robot& robot, const std::string& robot_name,
                           const std::filesystem::path& plan, const SimulationOptions& options,
                           common::Progress& progress) {
  io::TableFormat format;
  const std::string text = io::table_text(plan, format);
  const io::CsvTable table(text, plan, format);
  refuse_displacements(table);
  const std::string separator(1, separator_of(text, table));
  std::string header, zeros;
  for (std::size_t k = 0; k < 6; ++k)
    if (options.components[k]) header += separator + component_names[k], zeros += separator + "0";
  Campaign campaign =
      planned(robot, plan, extended(text, table, header, [&](std::size_t) { return zeros; }),
              options.displacement);
  disturb_wrenches(options, campaign);
  const auto predicted = [&](const std::vector<vjm::Effect>& hidden) {
    return predicted_readings(robot, hidden, campaign, options.threads, progress);
  };
  const std::vector<Eigen::VectorXd> readings = predicted(options.hidden);
  Normal normal(options.seed);
  const double length = spatial::parse_unit(robot.units.length).factor;
  const double angle = spatial::parse_unit(robot.units.angle).factor;
  const auto cells = [&](std::size_t row) {
    std::string result;
    for (Eigen::Index k = 0; k < 6; ++k) {
      // Drawn whether it is written or not: the components chosen do not change the others' noise.
      const double noise =
          normal() * (is_rotation(k) ? options.rotation_noise : options.translation_noise);
      if (options.components[static_cast<std::size_t>(k)])
        result += separator +
                  fmt::format("{}", (readings[row][k] + noise) / (is_rotation(k) ? angle : length));
    }
    return result;
  };
  SimulatedCampaign result{yaml_text(robot, robot_name, options),
                           extended(text, table, header, cells), campaign.warnings};
  if (!options.hidden.empty()) add_trace(campaign, options, predicted({}), readings, result);
  return result;
}

}  // namespace kinetostat::calibration
