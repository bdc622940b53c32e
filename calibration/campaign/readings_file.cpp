#include "kinetostat/calibration/campaign/readings_file.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <set>
#include <unordered_map>

#include <Eigen/Cholesky>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "kinetostat/calibration/campaign/readings_columns.h"
#include "kinetostat/common/error.h"
#include "kinetostat/common/spelling.h"
#include "kinetostat/spatial/rotation.h"
#include "kinetostat/vjm/manipulator/posture.h"

namespace kinetostat::calibration {
namespace {

using spatial::Dimension;
using spatial::Vector3;
using spatial::Vector6;
namespace dimension = spatial::dimension;

constexpr double not_measured = std::numeric_limits<double>::quiet_NaN();

class Reader {
 public:
  Reader(const io::CsvTable& table, const ReadingsContext& context, ReadingsColumns columns,
         const vjm::Manipulator& manipulator, Campaign& campaign)
      : table_(table),
        context_(context),
        columns_(std::move(columns)),
        campaign_(campaign),
        manipulator_(manipulator) {
    length_ = factor(dimension::length);
    force_ = factor(dimension::force);
    moment_ = factor(dimension::moment);
    angle_ = factor(dimension::angle);
    time_ = factor(dimension::time);
  }

  void read() {
    read_sessions();
    for (const auto& [name, instrument] : context_.instruments)
      if (instrument.correlation) correlation_of_[name] = index_of(*instrument.correlation);
    campaign_.readings.reserve(table_.rows());
    for (std::size_t row = 0; row < table_.rows(); ++row) read_row(row);
    check_ids();
    count_copies_once();
    check_time();
    check_noise();
    read_covariates();
  }

 private:
  double factor(const Dimension& dimension) const {
    return spatial::parse_unit(campaign_.units.unit_for(dimension)).factor;
  }

  double unit(const Dimension& dimension) const {
    return dimension == dimension::angle ? angle_ : length_;
  }
  double displacement_unit(Eigen::Index component) const {
    return is_rotation(component) ? angle_ : length_;
  }

  void read_sessions() {
    std::set<std::string> names;
    for (std::size_t row = 0; row < table_.rows(); ++row) names.insert(text(row, "session"));
    campaign_.sessions.assign(names.begin(), names.end());
  }

  std::string text(std::size_t row, const char* name) const {
    const Column& c = columns_.texts.at(name);
    return c ? std::string(table_.cell(row, *c)) : std::string();
  }

  std::optional<double> optional_number(std::size_t row, const Column& column, double unit) const {
    if (!column || table_.empty(row, *column)) return std::nullopt;
    return unit * table_.number(row, *column);
  }

  Vector3 vector3(std::size_t row, const Columns3& columns, double unit) const {
    Vector3 v = Vector3::Zero();
    for (std::size_t i = 0; i < 3; ++i)
      if (columns[i]) v[static_cast<Eigen::Index>(i)] = unit * table_.number(row, *columns[i]);
    return v;
  }

  void read_row(std::size_t row) {
    Reading reading;
    reading.line = table_.line(row);
    reading.id = read_id(row);
    const std::string session = text(row, "session");
    reading.session = static_cast<std::size_t>(
        std::lower_bound(campaign_.sessions.begin(), campaign_.sessions.end(), session) -
        campaign_.sessions.begin());
    reading.cycle = text(row, "cycle");
    reading.setting = text(row, "setting");
    reading.replicate = text(row, "replicate");
    reading.step = optional_number(row, columns_.texts.at("step"), 1);
    reading.time = optional_number(row, columns_.texts.at("time"), time_);
    reading.temperature = optional_number(row, columns_.texts.at("temperature"), 1);
    reading.direction = read_direction(row);
    reading.configuration = read_configuration(row);
    reading.load = read_load(row, reading.configuration);
    reading.role = read_role(row, session);
    reading.instrument = read_instrument(row);
    read_mask(row, reading);
    read_displacement(row, reading);
    campaign_.readings.push_back(std::move(reading));
  }

  std::string read_id(std::size_t row) const {
    const Column& c = columns_.texts.at("id");
    if (!c) return std::to_string(row + 1);
    if (table_.empty(row, *c)) table_.fail(row, *c, "the id is empty", "Give each row its own id");
    return std::string(table_.cell(row, *c));
  }

  LoadDirection read_direction(std::size_t row) const {
    const std::string word = text(row, "direction");
    if (word.empty()) return LoadDirection::unstated;
    if (word == "loading") return LoadDirection::loading;
    if (word == "unloading") return LoadDirection::unloading;
    table_.fail(row, *columns_.texts.at("direction"),
                fmt::format("'{}' is not a direction of load", word),
                "Write loading or unloading, or leave the cell empty");
  }

  std::size_t read_configuration(std::size_t row) {
    std::vector<double> values;
    for (const Columns3* columns : {&columns_.position, &columns_.orientation}) {
      const Vector3 v = vector3(row, *columns, columns == &columns_.position ? length_ : angle_);
      values.insert(values.end(), v.begin(), v.end());
    }
    for (const JointColumn& c : columns_.joints)
      values.push_back(unit(c.dimension) * table_.number(row, c.column));
    const auto [found, fresh] = configuration_of_.emplace(values, campaign_.configurations.size());
    if (fresh) campaign_.configurations.push_back(configuration(values));
    return found->second;
  }

  Configuration configuration(const std::vector<double>& values) const {
    Configuration result;
    const Vector3 position(values[0], values[1], values[2]), rpy(values[3], values[4], values[5]);
    if (columns_.position[0])
      result.target = spatial::Pose(spatial::rotation_from_rpy(rpy), position);
    for (std::size_t i = 0; i < columns_.joints.size(); ++i)
      result.joints[columns_.joints[i].joint] = values[6 + i];
    return result;
  }

  vjm::Load read_load(std::size_t row, std::size_t configuration) {
    const Vector3 point = columns_.point[0] ? vector3(row, columns_.point, length_)
                                            : context_.wrench.point.value_or(Vector3::Zero());
    const vjm::Load load{
        vector3(row, {columns_.wrench[0], columns_.wrench[1], columns_.wrench[2]}, force_),
        vector3(row, {columns_.wrench[3], columns_.wrench[4], columns_.wrench[5]}, moment_), point};
    if (context_.wrench_noise.is_stated()) add_wrench_covariance(load, configuration);
    const WrenchFrame& frame = context_.wrench;
    const bool as_it_is =
        !frame.on_platform && !frame.origin && frame.axes == spatial::Matrix3::Identity();
    return as_it_is ? load : in_base_axes(load, configuration);
  }

  // Of a wrench as it is stated, turned into base axes.
  void add_wrench_covariance(const vjm::Load& stated, std::size_t configuration) {
    const WrenchNoise& noise = context_.wrench_noise;
    const spatial::Matrix3 axes = axes_of_wrenches(configuration);
    spatial::Matrix6 covariance = spatial::Matrix6::Zero();
    for (const bool moment : {false, true}) {
      const Vector3 reads = noise.share * (moment ? stated.moment : stated.force);
      const double floor = moment ? noise.moment : noise.force;
      const Vector3 variance = reads.cwiseAbs2().array() + floor * floor;
      covariance.block<3, 3>(moment ? 3 : 0, moment ? 3 : 0) =
          axes * variance.asDiagonal() * axes.transpose();
    }
    campaign_.wrench_covariance.push_back(covariance);
  }

  spatial::Matrix3 axes_of_wrenches(std::size_t configuration) {
    const WrenchFrame& frame = context_.wrench;
    return frame.on_platform ? commanded(configuration).rotation() * frame.axes : frame.axes;
  }

  // Where the platform stands without load, as commanded; its base frame where that is not known.
  const spatial::Pose& commanded(std::size_t configuration) {
    while (commanded_.size() <= configuration) {
      const Configuration& next = campaign_.configurations[commanded_.size()];
      if (next.target) {
        commanded_.push_back(*next.target);
        continue;
      }
      const vjm::PostureResult posture = vjm::posture_from_joints(manipulator_, next.joints);
      commanded_.push_back(posture.reached ? posture.posture.platform : spatial::Pose());
    }
    return commanded_[configuration];
  }

  vjm::Load in_base_axes(vjm::Load load, std::size_t configuration) {
    const WrenchFrame& frame = context_.wrench;
    const spatial::Pose& platform = commanded(configuration);
    const spatial::Matrix3 axes = axes_of_wrenches(configuration);
    load.force = axes * load.force;
    load.moment = axes * load.moment;
    if (frame.origin && !columns_.point[0])
      load.point_on_platform =
          frame.on_platform ? *frame.origin : platform.inverse() * *frame.origin;
    return load;
  }

  Role read_role(std::size_t row, const std::string& session) const {
    const std::string word = text(row, "role");
    if (word.empty()) {
      const auto found = context_.roles.find(session);
      return found == context_.roles.end() ? Role::fit : found->second;
    }
    if (std::find(role_names.begin(), role_names.end(), word) == role_names.end())
      table_.fail(row, *columns_.texts.at("role"), fmt::format("'{}' is not a role", word),
                  "Write fit, select or confirm, or leave the cell empty");
    return role_named(word);
  }

  std::string read_instrument(std::size_t row) const {
    const std::string name = text(row, "instrument");
    if (!name.empty() && context_.instruments.count(name) == 0) {
      std::vector<std::string> names;
      for (const auto& [known, instrument] : context_.instruments)
        if (!known.empty()) names.push_back(known);
      const std::string near = common::nearest_spelling(name, names);
      table_.fail(row, *columns_.texts.at("instrument"),
                  fmt::format("the instrument '{}' is not described", name),
                  near.empty()
                      ? fmt::format("Add '{}' under 'instruments' in the campaign file", name)
                      : fmt::format("Did you mean '{}'?", near));
    }
    return name;
  }

  const Instrument& instrument_of(const Reading& reading) const {
    static const Instrument unknown;
    const auto found = context_.instruments.find(reading.instrument);
    return found == context_.instruments.end() ? unknown : found->second;
  }

  std::size_t index_of(const spatial::Matrix6& correlation) {
    auto& known = campaign_.correlations;
    const auto found = std::find(known.begin(), known.end(), correlation);
    if (found != known.end()) return static_cast<std::size_t>(found - known.begin());
    known.push_back(correlation);
    return known.size() - 1;
  }

  // Columns of the row over what the instrument says.
  std::optional<std::size_t> read_correlation(std::size_t row, const Reading& reading) {
    std::optional<std::size_t> result;
    if (const auto found = correlation_of_.find(reading.instrument); found != correlation_of_.end())
      result = found->second;
    spatial::Matrix6 matrix =
        result ? campaign_.correlations[*result] : spatial::Matrix6(spatial::Matrix6::Identity());
    std::optional<std::size_t> last;
    for (const auto& [pair, column] : columns_.correlations)
      if (const auto value = optional_number(row, column, 1)) {
        matrix(pair.first, pair.second) = matrix(pair.second, pair.first) = *value;
        last = column;
      }
    if (!last) return result;
    if (!is_correlation(matrix))
      table_.fail(row, *last,
                  fmt::format("with '{}' these correlations are not possible together",
                              table_.cell(row, *last)),
                  "Each lies between -1 and 1, and their matrix is positive definite");
    return index_of(matrix);
  }

  void read_mask(std::size_t row, Reading& reading) const {
    const std::string mask = text(row, "mask");
    reading.mask_reason = text(row, "mask_reason");
    if (mask.empty() || mask == "0" || mask == "false") return;
    if (mask != "1" && mask != "true")
      table_.fail(row, *columns_.texts.at("mask"), fmt::format("'{}' is neither 0 nor 1", mask),
                  "Write 1 to leave the reading out, 0 or nothing to use it");
    if (reading.mask_reason.empty())
      table_.fail(row, columns_.texts.at("mask_reason").value_or(*columns_.texts.at("mask")),
                  "the reading is masked without a reason", "Say why in the column mask_reason");
    reading.masked = true;
  }

  void read_displacement(std::size_t row, Reading& reading) {
    reading.displacement.setConstant(not_measured);
    reading.sigma = instrument_of(reading).sigma;
    reading.correlation = read_correlation(row, reading);
    for (std::size_t i = 0; i < 6; ++i) {
      const auto k = static_cast<Eigen::Index>(i);
      const double unit = displacement_unit(k);
      if (const auto value = optional_number(row, columns_.displacement[i], unit))
        reading.displacement[k] = *value;
      if (const auto value = sigma(row, is_rotation(k) ? Column() : columns_.any_sigma, unit))
        reading.sigma[k] = *value;
      if (const auto value = sigma(row, columns_.sigma[i], unit)) reading.sigma[k] = *value;
    }
    if (!reading.masked && reading.displacement.array().isNaN().all())
      table_.fail(row, first_displacement(), "the reading has no displacement at all",
                  "Write what was measured, or mask the row and say why");
  }

  std::size_t first_displacement() const {
    return **std::find_if(columns_.displacement.begin(), columns_.displacement.end(),
                          [](const Column& c) { return c.has_value(); });
  }

  std::optional<double> sigma(std::size_t row, const Column& column, double unit) const {
    const auto value = optional_number(row, column, unit);
    if (value && !(*value > 0))
      table_.fail(row, *column, fmt::format("'{}' is not positive", table_.cell(row, *column)),
                  "Give the standard deviation of the reading, or leave the cell empty");
    return value;
  }

  void check_ids() const {
    std::unordered_map<std::string, int> line_of;
    for (std::size_t row = 0; row < campaign_.readings.size(); ++row) {
      const Reading& reading = campaign_.readings[row];
      const auto [found, fresh] = line_of.emplace(reading.id, reading.line);
      if (!fresh)
        table_.fail(
            row, *columns_.texts.at("id"),
            fmt::format("the id '{}' is already used on line {}", reading.id, found->second),
            "Give each row its own id");
    }
  }

  // A table that was pasted twice would look twice as certain. Rows that are the same but for the
  // id are one reading where they say when it was taken, or where every row is there more than
  // once.
  void count_copies_once() {
    std::unordered_map<std::string, std::vector<std::size_t>> rows_of;
    for (std::size_t row = 0; row < table_.rows(); ++row) rows_of[all_but_id(row)].push_back(row);
    const bool all_twice = std::all_of(rows_of.begin(), rows_of.end(),
                                       [](const auto& same) { return same.second.size() > 1; });
    std::size_t copies = 0;
    for (const auto& [text, rows] : rows_of) {
      if (rows.size() < 2 || !(all_twice || says_when(campaign_.readings[rows[0]]))) continue;
      for (std::size_t k = 1; k < rows.size(); ++k) {
        Reading& copy = campaign_.readings[rows[k]];
        if (copy.masked) continue;
        copy.masked = true;
        copy.mask_reason = fmt::format("the same row as on line {}", table_.line(rows[0]));
        ++copies;
      }
    }
    if (copies > 0)
      campaign_.warnings.push_back(
          fmt::format("{} of {} rows of {} are copies of other rows: each reading is counted once",
                      copies, table_.rows(), campaign_.readings_file.filename().string()));
  }

  static bool says_when(const Reading& reading) {
    return reading.time || (reading.step && !reading.cycle.empty());
  }

  std::string all_but_id(std::size_t row) const {
    std::string text;
    for (std::size_t column = 0; column < table_.columns().size(); ++column)
      if (columns_.texts.at("id") != column) text += fmt::format("{}\n", table_.cell(row, column));
    return text;
  }

  // Within a cycle time must not run backwards, in the order of steps, or of rows without steps.
  void check_time() const {
    if (!columns_.texts.at("time")) return;
    const std::vector<Reading>& readings = campaign_.readings;
    std::vector<std::size_t> order(readings.size());
    std::iota(order.begin(), order.end(), 0);
    const auto key = [&readings](std::size_t i) {
      const Reading& r = readings[i];
      return std::tuple(r.session, std::string_view(r.cycle), r.step.value_or(0.0));
    };
    std::stable_sort(order.begin(), order.end(),
                     [&key](std::size_t a, std::size_t b) { return key(a) < key(b); });
    std::optional<std::size_t> previous;
    for (const std::size_t i : order) {
      if (!readings[i].time) continue;
      if (previous && readings[*previous].session == readings[i].session &&
          readings[*previous].cycle == readings[i].cycle &&
          *readings[i].time < *readings[*previous].time)
        table_.fail(i, *columns_.texts.at("time"),
                    fmt::format("time runs backwards in this cycle: '{}' comes after '{}' of line "
                                "{}",
                                table_.cell(i, *columns_.texts.at("time")),
                                table_.cell(*previous, *columns_.texts.at("time")),
                                readings[*previous].line),
                    "Order the rows by time, or number the steps and cycles");
      previous = i;
    }
  }

  void check_noise() {
    std::size_t stated = 0, used = 0;
    std::optional<std::pair<std::size_t, std::size_t>> without;
    for (std::size_t row = 0; row < campaign_.readings.size(); ++row)
      for (std::size_t k = 0; k < 6; ++k) {
        const Reading& reading = campaign_.readings[row];
        if (!reading.uses(static_cast<Eigen::Index>(k))) continue;
        const bool has = !std::isnan(reading.sigma[static_cast<Eigen::Index>(k)]);
        ++used;
        stated += has;
        if (!has && !without) without = {row, k};
      }
    if (used == 0)
      table_.fail(0, *columns_.texts.at("mask"), "every reading is masked",
                  "At least one reading must be used");
    if (stated > 0 && stated < used)
      table_.fail(without->first, *columns_.displacement[without->second],
                  "this value has no standard deviation, but others have",
                  fmt::format("State it under 'noise' in the campaign file or in a column sigma_{}",
                              component_names[without->second]));
    campaign_.noise_stated = stated == used;
  }

  void read_covariates() {
    std::vector<std::string> names;
    for (std::size_t c = 0; c < table_.columns().size(); ++c) {
      if (columns_.known.count(c) > 0) continue;
      Covariate& covariate = campaign_.covariates.emplace_back();
      covariate.name = table_.columns()[c];
      names.push_back("'" + covariate.name + "'");
      for (std::size_t row = 0; row < table_.rows(); ++row)
        covariate.values.emplace_back(table_.cell(row, c));
    }
    if (!names.empty())
      campaign_.notes.push_back(
          fmt::format("Columns kept as covariates: {}.", fmt::join(names, ", ")));
  }

  const io::CsvTable& table_;
  const ReadingsContext& context_;
  ReadingsColumns columns_;
  Campaign& campaign_;

  double length_ = 1, force_ = 1, moment_ = 1, angle_ = 1, time_ = 1;
  std::map<std::vector<double>, std::size_t> configuration_of_;
  const vjm::Manipulator& manipulator_;
  std::vector<spatial::Pose> commanded_;               // one a configuration
  std::map<std::string, std::size_t> correlation_of_;  // of instruments
};

}  // namespace

void read_readings(const io::CsvTable& table, const ReadingsContext& context,
                   const vjm::Manipulator& manipulator, Campaign& campaign) {
  Reader(table, context, find_columns(table, context, manipulator, campaign), manipulator, campaign)
      .read();
}

}  // namespace kinetostat::calibration
