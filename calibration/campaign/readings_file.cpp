#include "kinetostat/calibration/campaign/readings_file.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>
#include <unordered_map>

#include <Eigen/Cholesky>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "kinetostat/calibration/campaign/clock_time.h"
#include "kinetostat/calibration/campaign/readings_columns.h"
#include "kinetostat/common/error.h"
#include "kinetostat/common/spelling.h"
#include "kinetostat/spatial/rotation.h"
#include "kinetostat/vjm/chain/kinematics.h"
#include "kinetostat/vjm/effects/watcher.h"
#include "kinetostat/vjm/manipulator/posture.h"

namespace kinetostat::calibration {
namespace {

using spatial::Dimension;
using spatial::Vector3;
using spatial::Vector6;
namespace dimension = spatial::dimension;

class Reader {
 public:
  Reader(const io::CsvTable& table, const ReadingsContext& context, ReadingsColumns columns,
         const vjm::Manipulator& manipulator, Campaign& campaign, common::Faults& faults)
      : table_(table),
        context_(context),
        columns_(std::move(columns)),
        campaign_(campaign),
        faults_(faults),
        missing_(table.columns().size()),
        manipulator_(manipulator) {}

  void read() {
    read_sessions();
    for (const auto& [name, instrument] : context_.instruments)
      if (instrument.correlation && campaign_.reads_platform())
        correlation_of_[name] = index_of(*instrument.correlation);
    read_times();
    campaign_.readings.reserve(table_.rows());
    for (std::size_t row = 0; row < table_.rows(); ++row) read_row(row);
    check_ids();
    check_time();
    if (!faults_.empty()) return;
    count_copies_once();
    check_noise();
    read_covariates();
    say_how_it_was_read();
  }

 private:
  void fault(std::size_t row, std::size_t column, const std::string& what,
             const std::string& cure) {
    faults_.add(table_.mistake(row, column, what, cure));
  }

  // In SI; not a number after a fault.
  double value(std::size_t row, std::size_t column) {
    try {
      return columns_.factors[column] * table_.number(row, column);
    } catch (const common::InputError& error) {
      faults_.add(error);
      return not_a_number;
    }
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

  // Of a few known words; empty where a word says that there is none.
  std::string word(std::size_t row, const char* name) const {
    const Column& c = columns_.texts.at(name);
    return c && table_.missing(row, *c) ? std::string() : text(row, name);
  }

  std::optional<double> optional_number(std::size_t row, const Column& column) {
    if (!column) return std::nullopt;
    if (!table_.missing(row, *column)) return value(row, *column);
    if (!table_.empty(row, *column)) ++missing_[*column];
    return std::nullopt;
  }

  Vector3 vector3(std::size_t row, const Columns3& columns) {
    Vector3 v = Vector3::Zero();
    for (std::size_t i = 0; i < 3; ++i)
      if (columns[i]) v[static_cast<Eigen::Index>(i)] = value(row, *columns[i]);
    return v;
  }

  // Dates and times of day count from the first; without dates, past midnight they go on.
  void read_times() {
    const Column& column = columns_.texts.at("time");
    std::size_t first = 0;
    while (column && first < table_.rows() && table_.missing(first, *column)) ++first;
    if (!column || first == table_.rows()) return;
    const auto start = read_clock_time(table_.cell(first, *column));
    if (!start && !is_ambiguous_date(table_.cell(first, *column))) return;
    constexpr double day = 86400;
    clock_times_.assign(table_.rows(), std::nullopt);
    double previous = 0, midnights = 0;
    for (std::size_t row = first; row < table_.rows(); ++row) {
      if (table_.missing(row, *column)) continue;
      const auto time = read_clock_time(table_.cell(row, *column));
      if (!time || !start || time->day.has_value() != start->day.has_value()) {
        refuse_time(row, *column);
        continue;
      }
      double seconds = time->seconds - start->seconds + day * midnights;
      if (time->day) seconds += day * static_cast<double>(*time->day - *start->day);
      if (!time->day && seconds < previous - day / 2) ++midnights, seconds += day;
      clock_times_[row] = previous = seconds;
    }
  }

  void refuse_time(std::size_t row, std::size_t column) {
    const std::string_view cell = table_.cell(row, column);
    if (is_ambiguous_date(cell))
      fault(row, column, fmt::format("'{}' may be one day or another", cell),
            "Write dates as 2026-05-03");
    else
      fault(row, column, fmt::format("'{}' is not a time like that of the first row", cell),
            "Write dates and times as 2026-05-03T14:22:05.1, or seconds");
  }

  std::optional<double> read_time(std::size_t row) {
    return clock_times_.empty() ? optional_number(row, columns_.texts.at("time"))
                                : clock_times_[row];
  }

  // "Mean", "Std:": what a spreadsheet computes below its rows.
  static bool names_summary(std::string_view cell) {
    static const std::set<std::string> words = {"mean",       "average",
                                                "std",        "stdev",
                                                "stddev",     "sum",
                                                "total",      "median",
                                                "mittel",     "summe",
                                                "mittelwert", "mittelwerte",
                                                "streuung",   "standardabweichung"};
    std::string word(cell);
    for (char& c : word) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    while (!word.empty() && (word.back() == ':' || word.back() == '.')) word.pop_back();
    return words.count(word) > 0;
  }

  bool refuse_summary(std::size_t row) {
    std::size_t column = 0;
    while (column + 1 < table_.columns().size() && table_.empty(row, column)) ++column;
    const bool is_name = columns_.known.count(column) == 0 || columns_.texts.at("id") == column;
    if (!is_name || !names_summary(table_.cell(row, column))) return false;
    fault(row, column,
          fmt::format("'{}' looks like a summary of other rows, not like a reading",
                      table_.cell(row, column)),
          "Remove the row");
    return true;
  }

  void read_row(std::size_t row) {
    if (refuse_summary(row)) {
      campaign_.readings.emplace_back();
      return;
    }
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
    reading.step = optional_number(row, columns_.texts.at("step"));
    reading.time = read_time(row);
    reading.temperature = optional_number(row, columns_.texts.at("temperature"));
    reading.direction = read_direction(row);
    reading.configuration = read_configuration(row);
    reading.load = read_load(row, reading.configuration);
    reading.role = read_role(row, session);
    reading.instrument = read_instrument(row);
    read_mask(row, reading);
    read_displacement(row, reading);
    campaign_.readings.push_back(std::move(reading));
  }

  std::string read_id(std::size_t row) {
    const Column& c = columns_.texts.at("id");
    if (!c) return std::to_string(row + 1);
    if (table_.empty(row, *c)) fault(row, *c, "the id is empty", "Give each row its own id");
    return std::string(table_.cell(row, *c));
  }

  LoadDirection read_direction(std::size_t row) {
    const std::string direction = word(row, "direction");
    if (direction == "loading") return LoadDirection::loading;
    if (direction == "unloading") return LoadDirection::unloading;
    if (!direction.empty())
      fault(row, *columns_.texts.at("direction"),
            fmt::format("'{}' is not a direction of load", direction),
            "Write loading or unloading, or leave the cell empty");
    return LoadDirection::unstated;
  }

  std::size_t read_configuration(std::size_t row) {
    std::vector<double> values;
    for (const Columns3* columns : {&columns_.position, &columns_.orientation}) {
      const Vector3 v = vector3(row, *columns);
      values.insert(values.end(), v.begin(), v.end());
    }
    for (const JointColumn& c : columns_.joints) values.push_back(value(row, c.column));
    if (std::any_of(values.begin(), values.end(), [](double v) { return std::isnan(v); })) return 0;
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
    const Vector3 point = columns_.point[0] ? vector3(row, columns_.point)
                                            : context_.wrench.point.value_or(Vector3::Zero());
    vjm::Load load{vector3(row, {columns_.wrench[0], columns_.wrench[1], columns_.wrench[2]}),
                   vector3(row, {columns_.wrench[3], columns_.wrench[4], columns_.wrench[5]}),
                   point};
    add_weights(row, load);
    if (!faults_.empty()) return load;  // the posture may be unknown
    add_cylinders(row, configuration, load);
    add_torques(row, configuration, load);
    if (context_.wrench_noise.is_stated()) add_wrench_covariance(load, configuration);
    if (campaign_.control) add_control(load, configuration);
    return in_campaign_axes(std::move(load), configuration);
  }

  // As it is stated, but for the force that is read where a displacement is set.
  void add_control(vjm::Load load, std::size_t configuration) {
    DisplacementControl& control = *campaign_.control;
    const auto axis = static_cast<Eigen::Index>(context_.controlled % 3);
    Vector3& part = context_.controlled < 3 ? load.force : load.moment;
    part[axis] = 0;
    control.beside.push_back(in_campaign_axes(load, configuration));
    if (control.along.size() > configuration) return;
    Vector6 unit = Vector6::Zero();
    unit.segment<3>(context_.controlled < 3 ? 0 : 3) =
        axes_of_wrenches(configuration) * Vector3::Unit(axis);
    control.along.push_back(unit);
  }

  vjm::Load in_campaign_axes(vjm::Load load, std::size_t configuration) {
    const WrenchFrame& frame = context_.wrench;
    const bool as_it_is =
        !frame.on_platform && !frame.origin && frame.axes == spatial::Matrix3::Identity();
    return as_it_is ? load : in_base_axes(std::move(load), configuration);
  }

  void add_weights(std::size_t row, vjm::Load& load) {
    for (std::size_t w = 0; w < context_.weights.size(); ++w) {
      const Column& column = columns_.loads[w];
      const double mass = optional_number(row, column).value_or(0);
      if (mass < 0)
        fault(row, *column, fmt::format("{} is less than no weight", mass),
              "Write how much hangs there, 0 or nothing where nothing does");
      if (!(mass > 0)) continue;
      load.nodes.push_back(context_.weights[w].per_kilogram);
      load.nodes.back().force *= mass;
    }
  }

  void add_cylinders(std::size_t row, std::size_t configuration, vjm::Load& load) {
    for (std::size_t c = 0; c < context_.cylinders.size(); ++c) {
      const Column& column = columns_.loads[context_.weights.size() + c];
      const double force = optional_number(row, column).value_or(0);
      if (force == 0 || std::isnan(force)) continue;
      const Cylinder& cylinder = context_.cylinders[c];
      const auto& rest = at_rest(configuration);
      if (!rest) return;  // out of reach, as will be said
      const vjm::Watched& places = rest->places;
      const double length = (places.frames[cylinder.frames[0]].position() -
                             places.frames[cylinder.frames[1]].position())
                                .norm();
      if (length > 0)
        push_apart(cylinder, places, force, load);
      else
        fault(row, *column, fmt::format("the ends of '{}' are at one point", cylinder.name),
              "Correct 'at' and 'from' in the campaign file");
    }
  }

  void add_torques(std::size_t row, std::size_t configuration, vjm::Load& load) {
    const std::size_t first = context_.weights.size() + context_.cylinders.size();
    for (std::size_t t = 0; t < context_.torques.size(); ++t) {
      const double torque = optional_number(row, columns_.loads[first + t]).value_or(0);
      if (torque == 0 || std::isnan(torque)) continue;
      const auto& rest = at_rest(configuration);
      if (!rest) return;
      load.joints.push_back(context_.torques[t].per_unit);
      load.joints.back().force = torque;
      load.joints.back().direction = direction_of(load.joints.back(), rest->posture);
    }
  }

  spatial::Vector6 direction_of(const vjm::JointForce& joint, const vjm::Posture& posture) const {
    const vjm::Chain& chain = with_watched_->chains()[joint.chain];
    vjm::ChainKinematics kinematics;
    evaluate(chain, posture.coordinates_of(chain, joint.chain), kinematics,
             posture.body(with_watched_->span(joint.chain).from));
    spatial::Vector6 motion = kinematics.jacobian.col(joint.coordinate);
    if (!motion.tail<3>().isZero(0)) motion.head<3>().setZero();
    return motion.normalized();
  }

  // The robot without load, and where everything that is watched of it stands.
  struct Rest {
    vjm::Posture posture;
    vjm::Watched places;
  };

  // Nothing where the configuration is out of reach.
  const std::optional<Rest>& at_rest(std::size_t configuration) {
    if (!with_watched_) with_watched_ = vjm::with_watched(manipulator_, campaign_.watch);
    while (rests_.size() <= configuration) {
      const Configuration& next = campaign_.configurations[rests_.size()];
      const vjm::PostureResult posture =
          next.target ? vjm::posture_at(*with_watched_, *next.target)
                      : vjm::posture_from_joints(*with_watched_, next.joints);
      rests_.emplace_back();
      if (posture.reached)
        rests_.back() = {posture.posture,
                         vjm::watched_at_rest(campaign_.watch, *with_watched_, posture.posture, 0)};
    }
    return rests_[configuration];
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
    load.cell = axes;
    if (frame.origin && !columns_.point[0])
      load.point_on_platform =
          frame.on_platform ? *frame.origin : platform.inverse() * *frame.origin;
    return load;
  }

  Role read_role(std::size_t row, const std::string& session) {
    const std::string role = word(row, "role");
    if (role.empty()) {
      const auto found = context_.roles.find(session);
      return found == context_.roles.end() ? Role::fit : found->second;
    }
    if (std::find(role_names.begin(), role_names.end(), role) != role_names.end())
      return role_named(role);
    fault(row, *columns_.texts.at("role"), fmt::format("'{}' is not a role", role),
          "Write fit, select or confirm, or leave the cell empty");
    return Role::fit;
  }

  std::string read_instrument(std::size_t row) {
    std::string name = word(row, "instrument");
    if (!name.empty() && context_.instruments.count(name) == 0) {
      std::vector<std::string> names;
      for (const auto& [known, instrument] : context_.instruments)
        if (!known.empty()) names.push_back(known);
      const std::string near = common::nearest_spelling(name, names);
      fault(row, *columns_.texts.at("instrument"),
            fmt::format("the instrument '{}' is not described", name),
            near.empty() ? fmt::format("Add '{}' under 'instruments' in the campaign file", name)
                         : fmt::format("Did you mean '{}'?", near));
    }
    return name;
  }

  const Instrument& instrument_of(const Reading& reading) const {
    static const Instrument unknown;
    const auto found = context_.instruments.find(reading.instrument);
    return found == context_.instruments.end() ? unknown : found->second;
  }

  // Of the platform's components among all.
  std::size_t index_of(const spatial::Matrix6& of_platform) {
    Eigen::MatrixXd correlation = Eigen::MatrixXd::Identity(campaign_.size(), campaign_.size());
    correlation.topLeftCorner<6, 6>() = of_platform;
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
    spatial::Matrix6 matrix = spatial::Matrix6::Identity();
    if (result) matrix = campaign_.correlations[*result].topLeftCorner<6, 6>();
    std::optional<std::size_t> last;
    for (const auto& [pair, column] : columns_.correlations)
      if (const auto value = optional_number(row, column)) {
        matrix(pair.first, pair.second) = matrix(pair.second, pair.first) = *value;
        last = column;
      }
    if (!last) return result;
    if (is_correlation(matrix)) return index_of(matrix);
    fault(row, *last,
          fmt::format("with '{}' these correlations are not possible together",
                      table_.cell(row, *last)),
          "Each lies between -1 and 1, and their matrix is positive definite");
    return result;
  }

  void read_mask(std::size_t row, Reading& reading) {
    const std::string mask = word(row, "mask");
    reading.mask_reason = text(row, "mask_reason");
    if (mask.empty() || mask == "0" || mask == "false") return;
    if (mask != "1" && mask != "true")
      return fault(row, *columns_.texts.at("mask"), fmt::format("'{}' is neither 0 nor 1", mask),
                   "Write 1 to leave the reading out, 0 or nothing to use it");
    if (reading.mask_reason.empty())
      fault(row, columns_.texts.at("mask_reason").value_or(*columns_.texts.at("mask")),
            "the reading is masked without a reason", "Say why in the column mask_reason");
    reading.masked = true;
  }

  void read_displacement(std::size_t row, Reading& reading) {
    reading.displacement.setConstant(campaign_.size(), not_a_number);
    reading.sigma = context_.sensor_sigma.tail(campaign_.size());
    if (campaign_.reads_platform()) reading.sigma.head<6>() = instrument_of(reading).sigma;
    reading.correlation = read_correlation(row, reading);
    for (std::size_t i = 0; i < columns_.displacement.size(); ++i) {
      const auto k = static_cast<Eigen::Index>(i);
      if (const auto read = optional_number(row, columns_.displacement[i])) {
        reading.displacement[k] = *read;
      }
      const bool translation = campaign_.is_of_platform(k) && !is_rotation(k);
      if (const auto read = sigma(row, translation ? columns_.any_sigma : Column()))
        reading.sigma[k] = *read;
      if (const auto read = sigma(row, columns_.sigma[i])) reading.sigma[k] = *read;
    }
    if (campaign_.control) take_what_is_set(row, reading);
    if (reading.masked || is_measured(row) || !columns_.has_displacement()) return;
    if (!says_not_measured(row))
      return fault(row, first_displacement(), "the reading has no displacement at all",
                   "Write what was measured, or mask the row and say why");
    reading.masked = true;
    reading.mask_reason = "nothing was measured";
    ++not_measured_;
  }

  // It is no value to fit.
  void take_what_is_set(std::size_t row, Reading& reading) {
    DisplacementControl& control = *campaign_.control;
    double& set = reading.displacement[control.set];
    const Column& column = columns_.displacement[static_cast<std::size_t>(control.set)];
    if (std::isnan(set) && !reading.masked && column)
      fault(row, *column, "the reading does not say where this was set",
            "Write the displacement that was set, or mask the row and say why");
    control.to.push_back(set);
    set = not_a_number;
    reading.sigma[control.set] = not_a_number;
  }

  // Some cell says what was measured, be it well written or not.
  bool is_measured(std::size_t row) const {
    for (std::size_t i = 0; i < columns_.displacement.size(); ++i) {
      const Column& c = columns_.displacement[i];
      const bool is_set =
          campaign_.control && campaign_.control->set == static_cast<Eigen::Index>(i);
      if (c && !is_set && !table_.missing(row, *c)) return true;
    }
    return false;
  }

  // By a word, not by empty cells, which may have been forgotten.
  bool says_not_measured(std::size_t row) const {
    return std::any_of(
        columns_.displacement.begin(), columns_.displacement.end(),
        [&](const Column& c) { return c && table_.missing(row, *c) && !table_.empty(row, *c); });
  }

  std::size_t first_displacement() const {
    return **std::find_if(columns_.displacement.begin(), columns_.displacement.end(),
                          [](const Column& c) { return c.has_value(); });
  }

  std::optional<double> sigma(std::size_t row, const Column& column) {
    const auto value = optional_number(row, column);
    if (value && *value <= 0)
      fault(row, *column, fmt::format("'{}' is not positive", table_.cell(row, *column)),
            "Give the standard deviation of the reading, or leave the cell empty");
    return value;
  }

  void check_ids() {
    std::unordered_map<std::string, int> line_of;
    for (std::size_t row = 0; row < campaign_.readings.size(); ++row) {
      const Reading& reading = campaign_.readings[row];
      const auto [found, fresh] = line_of.emplace(reading.id, reading.line);
      if (!fresh && columns_.texts.at("id"))
        fault(row, *columns_.texts.at("id"),
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
  void check_time() {
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
        fault(i, *columns_.texts.at("time"),
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
      for (std::size_t k = 0; k < campaign_.components.size(); ++k) {
        const Reading& reading = campaign_.readings[row];
        if (!reading.uses(static_cast<Eigen::Index>(k))) continue;
        const bool has = !std::isnan(reading.sigma[static_cast<Eigen::Index>(k)]);
        ++used;
        stated += has;
        if (!has && !without) without = {row, k};
      }
    if (used == 0) {
      const Column& mask = columns_.texts.at("mask");
      return fault(0, mask.value_or(first_displacement()),
                   mask ? "every reading is masked" : "no row has a displacement",
                   "At least one reading must be used");
    }
    if (stated > 0 && stated < used)
      fault(without->first, *columns_.displacement[without->second],
            "this value has no standard deviation, but others have",
            fmt::format("State it under 'noise' in the campaign file or in a column sigma_{}",
                        campaign_.components[without->second].name));
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

  // What is not as the format has it, so that nothing is read in another way than people think.
  void say_how_it_was_read() {
    const auto say = [this](const std::string& sentence) { campaign_.notes.push_back(sentence); };
    std::vector<std::string> missing, commas;
    for (std::size_t c = 0; c < missing_.size(); ++c) {
      if (missing_[c] > 0)
        missing.push_back(fmt::format("'{}' ({})", table_.columns()[c], missing_[c]));
      if (columns_.known.count(c) > 0 && table_.decimal(c) == io::DecimalSign::comma)
        commas.push_back("'" + table_.columns()[c] + "'");
    }
    if (table_.repeated_headers() > 0)
      say(fmt::format("Lines that repeat the names of the columns are passed over ({}).",
                      table_.repeated_headers()));
    if (table_.has_title())
      say(fmt::format("The table starts on line {}: what stands above it is passed over.",
                      table_.header_line()));
    if (!table_.format().other_sheets.empty())
      say(fmt::format("Sheet '{}' is read; tables also stand on: {}.", table_.format().sheet,
                      fmt::join(table_.format().other_sheets, ", ")));
    if (!commas.empty()) say("The numbers have decimal commas.");
    if (!missing.empty())
      say(fmt::format("Cells that say 'not measured' are missing values: {}.",
                      fmt::join(missing, ", ")));
    if (not_measured_ > 0)
      say(fmt::format("{} row{} without any displacement {} left out.", not_measured_,
                      not_measured_ == 1 ? "" : "s", not_measured_ == 1 ? "is" : "are"));
    if (!clock_times_.empty()) say("Times count in seconds from the first one.");
  }

  const io::CsvTable& table_;
  const ReadingsContext& context_;
  ReadingsColumns columns_;
  Campaign& campaign_;
  common::Faults& faults_;

  std::size_t not_measured_ = 0;                    // rows that say so
  std::vector<std::size_t> missing_;                // cells of each column with a word for it
  std::vector<std::optional<double>> clock_times_;  // of the rows [s], where times are of the day
  std::map<std::vector<double>, std::size_t> configuration_of_;
  const vjm::Manipulator& manipulator_;
  std::vector<spatial::Pose> commanded_;               // one a configuration
  std::optional<vjm::Manipulator> with_watched_;       // once it is needed
  std::vector<std::optional<Rest>> rests_;             // one a configuration
  std::map<std::string, std::size_t> correlation_of_;  // of instruments
};

}  // namespace

void read_readings(const io::CsvTable& table, const ReadingsContext& context,
                   const vjm::Manipulator& manipulator, Campaign& campaign, common::Faults faults) {
  ReadingsColumns columns = find_columns(table, context, manipulator, campaign, faults);
  Reader(table, context, std::move(columns), manipulator, campaign, faults).read();
  faults.throw_if_any();
}

}  // namespace kinetostat::calibration
