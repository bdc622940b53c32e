#include "kinetostat/calibration/readings_file.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <limits>
#include <numeric>
#include <set>
#include <unordered_map>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "kinetostat/files/error.h"
#include "kinetostat/spatial/rotation.h"
#include "kinetostat/spatial/spelling.h"

namespace kinetostat::calibration {
namespace {

using Column = std::optional<std::size_t>;
using Columns3 = std::array<Column, 3>;
using spatial::Dimension;
using spatial::Vector3;
using spatial::Vector6;
namespace dimension = spatial::dimension;

constexpr double not_measured = std::numeric_limits<double>::quiet_NaN();

const std::vector<std::string>& reserved_names() {
  static const std::vector<std::string> names = {
      "id",        "session",  "cycle",     "step",       "time",     "temperature", "setting",
      "replicate", "x",        "y",         "z",          "roll",     "pitch",       "yaw",
      "fx",        "fy",       "fz",        "mx",         "my",       "mz",          "px",
      "py",        "pz",       "direction", "dx",         "dy",       "dz",          "rx",
      "ry",        "rz",       "sigma",     "sigma_dx",   "sigma_dy", "sigma_dz",    "sigma_rx",
      "sigma_ry",  "sigma_rz", "mask",      "mask_reason"};
  return names;
}

// "Fx [N]" -> "fx": what a column name comes down to when case, unit and blanks are taken off.
std::string bare_name(const std::string& column) {
  std::string bare;
  for (const char c : column.substr(0, column.find_first_of("[(")))
    if (c != ' ') bare += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return bare;
}

struct JointColumn {
  std::size_t column = 0;
  std::string joint;  // "chain.joint"
  Dimension dimension;
};

// A joint whose coordinate a reading may give.
struct Joint {
  std::string name;   // "chain.joint"
  std::string alone;  // "joint" where no other chain has one of that name, else the same
  bool actuated = false;
  Dimension dimension;
};

std::vector<Joint> joints_of(const vjm::Manipulator& manipulator) {
  std::vector<Joint> joints;
  std::map<std::string, int> uses;
  for (const vjm::Chain& chain : manipulator.chains())
    for (const Eigen::Index k : chain.posture_coordinates()) {
      const vjm::Coordinate& joint = chain.coordinates()[static_cast<std::size_t>(k)];
      ++uses[joint.name];
      joints.push_back({chain.name() + "." + joint.name, joint.name,
                        joint.role == vjm::Role::actuated,
                        vjm::is_rotation(joint.motion) ? dimension::angle : dimension::length});
    }
  for (Joint& joint : joints)
    if (uses[joint.alone] > 1) joint.alone = joint.name;
  return joints;
}

class Reader {
 public:
  Reader(const files::CsvTable& table, const ReadingsContext& context,
         const vjm::Manipulator& manipulator, Campaign& campaign)
      : table_(table), context_(context), campaign_(campaign), joints_(joints_of(manipulator)) {}

  void read() {
    find_columns();
    read_sessions();
    campaign_.readings.reserve(table_.rows());
    for (std::size_t row = 0; row < table_.rows(); ++row) read_row(row);
    check_ids();
    check_time();
    check_noise();
    read_covariates();
  }

 private:
  Column column(const std::string& name) {
    const Column found = table_.find(name);
    if (found) known_.insert(*found);
    return found;
  }

  [[noreturn]] void fail_header(const std::string& column, const std::string& what,
                                const std::string& cure) const {
    throw files::InputError({.file = table_.file(),
                             .line = table_.header_line(),
                             .key = column,
                             .what = what,
                             .cure = cure});
  }

  // Three columns that only have a meaning together.
  Columns3 together(const char* a, const char* b, const char* c) {
    const Columns3 columns = {column(a), column(b), column(c)};
    const std::string names[] = {a, b, c};
    const std::size_t missing = static_cast<std::size_t>(
        std::find(columns.begin(), columns.end(), std::nullopt) - columns.begin());
    if (missing < 3 && (columns[0] || columns[1] || columns[2]))
      fail_header(names[missing],
                  fmt::format("the column '{}' is missing: {}, {} and {} go together",
                              names[missing], a, b, c),
                  "Add it, with 0 in every row if need be");
    return columns;
  }

  void find_columns() {
    for (const char* name : {"id", "session", "cycle", "step", "time", "temperature", "setting",
                             "replicate", "direction", "mask", "mask_reason"})
      texts_[name] = column(name);
    for (std::size_t i = 0; i < 6; ++i) {
      displacement_[i] = column(component_names[i]);
      sigma_[i] = column(std::string("sigma_") + component_names[i]);
      wrench_[i] = column(std::array{"fx", "fy", "fz", "mx", "my", "mz"}[i]);
    }
    any_sigma_ = column("sigma");
    point_ = together("px", "py", "pz");
    position_ = together("x", "y", "z");
    orientation_ = together("roll", "pitch", "yaw");
    find_joint_columns();
    check_slips();
    check_columns();
    find_units();
  }

  void find_joint_columns() {
    std::vector<std::string> missing;
    for (const Joint& joint : joints_) {
      Column found = column(joint.name);
      const auto& reserved = reserved_names();
      if (!found && std::find(reserved.begin(), reserved.end(), joint.alone) == reserved.end())
        found = column(joint.alone);
      if (found) joint_columns_.push_back({*found, joint.name, joint.dimension});
      if (!found && joint.actuated) missing.push_back(joint.alone);
    }
    if (!joint_columns_.empty() && !missing.empty())
      fail_header(missing[0],
                  fmt::format("the actuated joint '{}' has no column, but others have", missing[0]),
                  "Add its column, with the coordinate at which it stood in every row");
    if (!joint_columns_.empty() && position_[0])
      fail_header("x", "the posture is given twice: by x, y, z and by joint coordinates",
                  "Keep one; rename the other columns to keep them as covariates");
    if (orientation_[0] && !position_[0])
      fail_header("x", "roll, pitch, yaw need a position as well", "Add the columns x, y, z");
  }

  // "Fx" or "fx [N]" beside "fx" is surely a slip; a near spelling may be one.
  void check_slips() {
    std::vector<std::string> names = reserved_names();
    for (const Joint& joint : joints_) names.insert(names.end(), {joint.name, joint.alone});
    for (std::size_t i = 0; i < table_.columns().size(); ++i) {
      const std::string& name = table_.columns()[i];
      if (known_.count(i) > 0) continue;
      const auto same = std::find_if(names.begin(), names.end(), [&](const std::string& known) {
        return bare_name(name) == bare_name(known);
      });
      if (same != names.end())
        fail_header(name, fmt::format("the column '{}' is not known", name),
                    fmt::format("Write '{}'; units belong in the campaign file", *same));
      const std::string near = spatial::nearest_spelling(name, names);
      if (!near.empty())
        campaign_.notes.push_back(fmt::format(
            "The column '{}' is kept as a covariate; if '{}' was meant, rename it.", name, near));
    }
  }

  void check_columns() {
    const auto any = [](const auto& columns) {
      return std::any_of(columns.begin(), columns.end(), [](const Column& c) { return c; });
    };
    if (!any(displacement_))
      fail_header("", "there is no column of displacement",
                  "Name at least one of dx, dy, dz, rx, ry, rz");
    if (!any(wrench_) && campaign_.displacement == DisplacementKind::difference)
      fail_header("", "there is no column of load, so no difference to the unloaded state",
                  "Name at least one of fx, fy, fz, mx, my, mz");
    const bool moments = wrench_[3] || wrench_[4] || wrench_[5];
    const bool point_given = point_[0] || context_.wrench_point;
    if (moments && !point_given)
      fail_header(wrench_[3]   ? "mx"
                  : wrench_[4] ? "my"
                               : "mz",
                  "moments are given without the point that they are taken about",
                  "Add the columns px, py, pz, or 'wrench_point: reference' or 'wrench_point: "
                  "[x, y, z]' to the campaign file");
    if (!moments && !point_given && any(wrench_))
      campaign_.notes.push_back(
          "No point of application is given: forces act at the platform's reference point.");
    if (any_sigma_ && !displacement_[0] && !displacement_[1] && !displacement_[2])
      fail_header("sigma", "'sigma' is the deviation of translations, and none is measured",
                  "Write sigma_rx, sigma_ry, sigma_rz");
    if (!position_[0] && joint_columns_.empty())
      campaign_.notes.push_back(
          "No column tells the posture: the robot stands at its home coordinates.");
  }

  double factor(const Dimension& dimension) const {
    return spatial::parse_unit(campaign_.units.unit_for(dimension)).factor;
  }

  void find_units() {
    Column angle;
    for (const Column& c : {displacement_[3], displacement_[4], displacement_[5], orientation_[0]})
      if (c && !angle) angle = c;
    for (const JointColumn& c : joint_columns_)
      if (c.dimension == dimension::angle && !angle) angle = c.column;
    const auto require = [this](const Column& column, bool stated, const char* key,
                                const char* example) {
      if (!column || stated) return;
      throw files::InputError(
          {.file = campaign_.file,
           .key = fmt::format("units.{}", key),
           .what = fmt::format("no unit of {} is stated, but the readings have the column '{}'",
                               key, table_.columns()[*column]),
           .cure = fmt::format("Write '{}: {}' under 'units'", key, example)});
    };
    require(angle, context_.angle_stated, "angle", "deg");
    require(texts_["time"], context_.time_stated, "time", "s");
    length_ = factor(dimension::length);
    force_ = factor(dimension::force);
    moment_ = factor(dimension::moment);
    angle_ = factor(dimension::angle);
    time_ = factor(dimension::time);
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
    const Column& c = texts_.at(name);
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
    reading.step = optional_number(row, texts_.at("step"), 1);
    reading.time = optional_number(row, texts_.at("time"), time_);
    reading.temperature = optional_number(row, texts_.at("temperature"), 1);
    reading.direction = read_direction(row);
    reading.configuration = read_configuration(row);
    reading.load = read_load(row);
    read_mask(row, reading);
    read_displacement(row, reading);
    campaign_.readings.push_back(std::move(reading));
  }

  std::string read_id(std::size_t row) const {
    const Column& c = texts_.at("id");
    if (!c) return std::to_string(row + 1);
    if (table_.empty(row, *c)) table_.fail(row, *c, "the id is empty", "Give each row its own id");
    return std::string(table_.cell(row, *c));
  }

  LoadDirection read_direction(std::size_t row) const {
    const std::string word = text(row, "direction");
    if (word.empty()) return LoadDirection::unstated;
    if (word == "loading") return LoadDirection::loading;
    if (word == "unloading") return LoadDirection::unloading;
    table_.fail(row, *texts_.at("direction"), fmt::format("'{}' is not a direction of load", word),
                "Write loading or unloading, or leave the cell empty");
  }

  std::size_t read_configuration(std::size_t row) {
    std::vector<double> values;
    for (const Columns3* columns : {&position_, &orientation_}) {
      const Vector3 v = vector3(row, *columns, columns == &position_ ? length_ : angle_);
      values.insert(values.end(), v.begin(), v.end());
    }
    for (const JointColumn& c : joint_columns_)
      values.push_back(unit(c.dimension) * table_.number(row, c.column));
    const auto [found, fresh] = configuration_of_.emplace(values, campaign_.configurations.size());
    if (fresh) campaign_.configurations.push_back(configuration(values));
    return found->second;
  }

  Configuration configuration(const std::vector<double>& values) const {
    Configuration result;
    const Vector3 position(values[0], values[1], values[2]), rpy(values[3], values[4], values[5]);
    if (position_[0]) result.target = spatial::Pose(spatial::rotation_from_rpy(rpy), position);
    for (std::size_t i = 0; i < joint_columns_.size(); ++i)
      result.joints[joint_columns_[i].joint] = values[6 + i];
    return result;
  }

  vjm::Load read_load(std::size_t row) const {
    const Vector3 point =
        point_[0] ? vector3(row, point_, length_) : context_.wrench_point.value_or(Vector3::Zero());
    return {vector3(row, {wrench_[0], wrench_[1], wrench_[2]}, force_),
            vector3(row, {wrench_[3], wrench_[4], wrench_[5]}, moment_), point};
  }

  void read_mask(std::size_t row, Reading& reading) const {
    const std::string mask = text(row, "mask");
    reading.mask_reason = text(row, "mask_reason");
    if (mask.empty() || mask == "0" || mask == "false") return;
    if (mask != "1" && mask != "true")
      table_.fail(row, *texts_.at("mask"), fmt::format("'{}' is neither 0 nor 1", mask),
                  "Write 1 to leave the reading out, 0 or nothing to use it");
    if (reading.mask_reason.empty())
      table_.fail(row, texts_.at("mask_reason").value_or(*texts_.at("mask")),
                  "the reading is masked without a reason", "Say why in the column mask_reason");
    reading.masked = true;
  }

  void read_displacement(std::size_t row, Reading& reading) const {
    reading.displacement.setConstant(not_measured);
    reading.sigma = context_.noise;
    for (std::size_t i = 0; i < 6; ++i) {
      const auto k = static_cast<Eigen::Index>(i);
      const double unit = displacement_unit(k);
      if (const auto value = optional_number(row, displacement_[i], unit))
        reading.displacement[k] = *value;
      if (const auto value = sigma(row, is_rotation(k) ? Column() : any_sigma_, unit))
        reading.sigma[k] = *value;
      if (const auto value = sigma(row, sigma_[i], unit)) reading.sigma[k] = *value;
    }
    if (!reading.masked && reading.displacement.array().isNaN().all())
      table_.fail(row, first_displacement(), "the reading has no displacement at all",
                  "Write what was measured, or mask the row and say why");
  }

  std::size_t first_displacement() const {
    return **std::find_if(displacement_.begin(), displacement_.end(),
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
            row, *texts_.at("id"),
            fmt::format("the id '{}' is already used on line {}", reading.id, found->second),
            "Give each row its own id");
    }
  }

  // Within a cycle time must not run backwards, in the order of steps, or of rows without steps.
  void check_time() const {
    if (!texts_.at("time")) return;
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
        table_.fail(
            i, *texts_.at("time"),
            fmt::format("time runs backwards in this cycle: '{}' comes after '{}' of line "
                        "{}",
                        table_.cell(i, *texts_.at("time")),
                        table_.cell(*previous, *texts_.at("time")), readings[*previous].line),
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
      throw files::InputError(table_.file(), "every reading is masked",
                              "At least one reading must be used");
    if (stated > 0 && stated < used)
      table_.fail(without->first, *displacement_[without->second],
                  "this value has no standard deviation, but others have",
                  fmt::format("State it under 'noise' in the campaign file or in a column sigma_{}",
                              component_names[without->second]));
    campaign_.noise_stated = stated == used;
  }

  void read_covariates() {
    std::vector<std::string> names;
    for (std::size_t c = 0; c < table_.columns().size(); ++c) {
      if (known_.count(c) > 0) continue;
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

  const files::CsvTable& table_;
  const ReadingsContext& context_;
  Campaign& campaign_;
  std::vector<Joint> joints_;

  std::set<std::size_t> known_;  // columns with a meaning
  std::map<std::string, Column, std::less<>> texts_;
  std::array<Column, 6> displacement_, sigma_, wrench_;
  Column any_sigma_;
  Columns3 point_, position_, orientation_;
  std::vector<JointColumn> joint_columns_;
  double length_ = 1, force_ = 1, moment_ = 1, angle_ = 1, time_ = 1;
  std::map<std::vector<double>, std::size_t> configuration_of_;
};

}  // namespace

void read_readings(const files::CsvTable& table, const ReadingsContext& context,
                   const vjm::Manipulator& manipulator, Campaign& campaign) {
  Reader(table, context, manipulator, campaign).read();
}

}  // namespace kinetostat::calibration
