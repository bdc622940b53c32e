// Synthetic readings of a campaign that is there: its rows, sensors, weights and noise.
#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <fmt/format.h>

#include "kinetostat/calibration/campaign/campaign_file.h"
#include "kinetostat/calibration/campaign/noise_estimate.h"
#include "kinetostat/calibration/campaign/readings_columns.h"
#include "kinetostat/calibration/campaign/readings_file.h"
#include "kinetostat/calibration/campaign/replicates.h"
#include "kinetostat/calibration/regression/simulate.h"
#include "kinetostat/calibration/statistics/normal.h"
#include "kinetostat/common/error.h"
#include "kinetostat/io/csv.h"
#include "kinetostat/io/text_file.h"
#include "kinetostat/io/yaml.h"

namespace kinetostat::calibration {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// A table that may be written again.
struct Grid {
  std::vector<std::string> header;
  std::vector<std::vector<std::string>> rows;

  std::string text() const {
    std::string result;
    const auto add = [&result](const std::vector<std::string>& cells) {
      for (std::size_t c = 0; c < cells.size(); ++c)
        result += (c > 0 ? "," : "") + io::csv_cell(cells[c]);
      result += "\n";
    };
    add(header);
    for (const auto& row : rows) add(row);
    return result;
  }
};

Grid grid_of(const io::CsvTable& table) {
  Grid grid{table.columns(), {}};
  for (std::size_t row = 0; row < table.rows(); ++row) {
    auto& cells = grid.rows.emplace_back();
    for (std::size_t c = 0; c < table.columns().size(); ++c) cells.emplace_back(table.cell(row, c));
  }
  return grid;
}

// The columns that hold readings.
ReadingsColumns columns_of(const io::CsvTable& table, const ReadingsContext& context,
                           const vjm::Robot& robot, Campaign campaign) {
  common::Faults faults;
  ReadingsColumns columns = find_columns(table, context, robot.manipulator, campaign, faults);
  faults.throw_if_any();
  return columns;
}

// The rows of a plan, with the columns of readings that the campaign's own table has.
Grid planned(const std::filesystem::path& plan, const io::CsvTable& own,
             const ReadingsColumns& columns) {
  const io::CsvTable table = io::read_table(plan);
  Grid grid = grid_of(table);
  for (const Column& column : columns.displacement) {
    if (!column) continue;
    const std::string& name = own.columns()[*column];
    if (table.find(name))
      throw common::InputError({.file = plan,
                                .line = table.header_line(),
                                .key = name,
                                .what = "a plan has no readings: they are what is simulated",
                                .cure = "Remove the column"});
    grid.header.push_back(name);
    for (auto& row : grid.rows) row.emplace_back("0");
  }
  return grid;
}

std::string unit_of(const spatial::Dimension& of, const spatial::UnitSystem& units) {
  namespace dimension = spatial::dimension;
  if (of == dimension::length) return units.length;
  if (of == dimension::force) return units.force;
  if (of == dimension::angle) return units.angle;
  if (of == dimension::time) return units.time;
  return of == dimension::mass ? units.mass : units.force + " " + units.length;
}

// Names units in the header where a plan, which is in the units of the robot file, names none.
void name_units(Grid& grid, const std::filesystem::path& plan, ReadingsContext context,
                const vjm::Robot& robot, Campaign campaign) {
  context.angle_stated = context.time_stated = true;
  campaign.units = robot.units;
  const ReadingsColumns columns =
      columns_of(io::CsvTable(grid.text(), plan), context, robot, campaign);
  const auto is_read = [&](std::size_t c) {
    return std::find(columns.displacement.begin(), columns.displacement.end(), Column(c)) !=
           columns.displacement.end();
  };
  for (const std::size_t c : columns.known) {
    const spatial::Dimension& of = columns.dimensions[c];
    if (is_read(c) || columns.names[c].unit || of == spatial::dimension::none ||
        of == spatial::dimension::temperature)
      continue;
    grid.header[c] += fmt::format(" [{}]", unit_of(of, robot.units));
  }
}

// A root of a covariance, also of a singular one.
MatrixXd root_of(const MatrixXd& covariance) {
  const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(covariance);
  return solver.eigenvectors() * solver.eigenvalues().cwiseMax(0).cwiseSqrt().asDiagonal();
}

VectorXd draws(Normal& normal, Index count) {
  VectorXd result(count);
  for (double& value : result) value = normal();
  return result;
}

// The wrenches that the robot feels.
void disturb_wrenches(std::uint64_t seed, Campaign& campaign) {
  Normal normal(seed + 0x9e3779b97f4a7c15);  // other numbers than the instruments'
  for (std::size_t i = 0; i < campaign.wrench_covariance.size(); ++i) {
    const VectorXd error = root_of(campaign.wrench_covariance[i]) * draws(normal, 6);
    campaign.readings[i].load.force += error.head<3>();
    campaign.readings[i].load.moment += error.tail<3>();
  }
}

// What the instruments add, one entry a reading: noise as the campaign states it, and what readings
// share that are counted from one unloaded reading; none where no noise is stated.
std::vector<VectorXd> errors_of(const Campaign& campaign, std::uint64_t seed) {
  std::vector<VectorXd> errors(campaign.readings.size(), VectorXd::Zero(campaign.size()));
  if (!campaign.noise_stated) return errors;
  Normal normal(seed);
  const Noise noise = noise_of(campaign, replicate_groups(campaign));
  for (std::size_t i = 0; i < errors.size(); ++i) {
    MatrixXd correlation = MatrixXd::Identity(campaign.size(), campaign.size());
    if (!noise.correlation.empty() && noise.correlation[i]) correlation = *noise.correlation[i];
    errors[i] =
        noise.sigma[i].asDiagonal() * (root_of(correlation) * draws(normal, campaign.size()));
  }
  for (const Datum& datum : noise.datums) {
    const VectorXd error = datum.sigma.cwiseProduct(draws(normal, campaign.size()));
    for (const std::size_t i : datum.readings) errors[i] += error;
  }
  return errors;
}

// The campaign file without what is written anew: keys at its top level, with what belongs to them.
std::string other_keys(const std::string& text) {
  static const std::set<std::string, std::less<>> replaced = {"origin", "robot", "readings",
                                                              "sheet", "decimal"};
  std::string result;
  bool skip = false;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    const std::string_view line = std::string_view(text).substr(begin, end - begin);
    const bool is_key =
        !line.empty() && line[0] != ' ' && line[0] != '\t' && line[0] != '#' && line[0] != '\r';
    if (is_key) skip = replaced.count(line.substr(0, line.find(':'))) > 0;
    if (!skip) result += std::string(line) + "\n";
    begin = end + 1;
  }
  return result;
}

std::string yaml_text(const std::filesystem::path& like, const std::string& robot_name,
                      std::uint64_t seed) {
  return fmt::format(
      "# Synthetic readings, made by kinetostat simulate with seed {} like those of {}. They come "
      "from the model itself:\n"
      "# that a fit of this model to them succeeds proves nothing about any machine.\n"
      "origin: synthetic, seed {}\nrobot: {}\nreadings: readings.csv\n{}",
      seed, like.filename().string(), seed, io::yaml_scalar(robot_name),
      other_keys(io::read_text(like)));
}

void add_trace(const Campaign& campaign, const std::vector<VectorXd>& plain,
               const std::vector<VectorXd>& with, SimulatedCampaign& result) {
  double over_noise = 0;
  for (Index k = 0; k < campaign.size(); ++k) {
    HiddenTrace trace{.component = campaign.component(k), .unit = campaign.unit_of(k)};
    double squares = 0, count = 0;
    for (std::size_t i = 0; i < plain.size(); ++i) {
      if (!campaign.readings[i].uses(k)) continue;
      const double change = std::abs(with[i][k] - plain[i][k]);
      squares += change * change;
      over_noise += std::pow(change / campaign.readings[i].sigma[k], 2);
      if (++count > 1 && change <= trace.max) continue;
      trace.max = change;
      trace.worst_reading = campaign.readings[i].id;
    }
    if (!(count > 0)) continue;
    trace.rms = std::sqrt(squares / count);
    result.trace.push_back(trace);
  }
  if (campaign.noise_stated) result.detectability = std::sqrt(over_noise);
}

}  // namespace

SimulatedCampaign simulate_like(const vjm::Robot& robot, const std::string& robot_name,
                                const std::filesystem::path& like,
                                const std::optional<std::filesystem::path>& plan,
                                const SimulationOptions& options, common::Progress& progress) {
  Campaign campaign;
  const ReadingsContext context = read_context(like, robot.manipulator, campaign);
  const io::CsvTable own = io::read_table(campaign.readings_file, context.table);
  const ReadingsColumns columns = columns_of(own, context, robot, campaign);
  Grid grid = plan ? planned(*plan, own, columns) : grid_of(own);
  if (plan) name_units(grid, *plan, context, robot, campaign);
  const io::CsvTable table(grid.text(), plan ? *plan : campaign.readings_file,
                           {.missing = context.table.missing});
  campaign.readings_file = table.file();
  const ReadingsColumns into = columns_of(table, context, robot, campaign);
  read_readings(table, context, robot.manipulator, campaign);
  read_known_loads(like, campaign);
  disturb_wrenches(options.seed, campaign);
  const std::vector<VectorXd> readings =
      predicted_readings(robot, options.hidden, campaign, options.threads, progress);
  const std::vector<VectorXd> errors = errors_of(campaign, options.seed);
  for (std::size_t i = 0; i < readings.size(); ++i)
    for (Index k = 0; k < campaign.size(); ++k) {
      const Column& column = into.displacement[static_cast<std::size_t>(k)];
      if (!column || std::isnan(campaign.readings[i].displacement[k])) continue;
      const double value = readings[i][k] + errors[i][k];
      if (std::isfinite(value))
        grid.rows[i][*column] = fmt::format("{}", value / into.factors[*column]);
    }
  SimulatedCampaign result{yaml_text(like, robot_name, options.seed), grid.text(),
                           campaign.warnings};
  if (!options.hidden.empty())
    add_trace(campaign, predicted_readings(robot, {}, campaign, options.threads, progress),
              readings, result);
  return result;
}

}  // namespace kinetostat::calibration
