#include "kinetostat/calibration/campaign/readings_columns.h"

#include <algorithm>
#include <array>
#include <stdexcept>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "kinetostat/calibration/campaign/clock_time.h"
#include "kinetostat/calibration/campaign/column_names.h"
#include "kinetostat/calibration/campaign/joint_column.h"
#include "kinetostat/common/error.h"
#include "kinetostat/common/spelling.h"
#include "kinetostat/io/table/table_layout.h"

namespace kinetostat::calibration {
namespace {

using spatial::Dimension;
namespace dimension = spatial::dimension;

constexpr std::array pose_names = {"x", "y", "z", "roll", "pitch", "yaw"};

bool is_of_pose(const std::string& name) {
  return std::find(pose_names.begin(), pose_names.end(), name) != pose_names.end();
}

class ColumnFinder {
 public:
  ColumnFinder(const io::CsvTable& table, const ReadingsContext& context,
               const vjm::Manipulator& manipulator, Campaign& campaign, common::Faults& faults)
      : table_(table),
        context_(context),
        campaign_(campaign),
        faults_(faults),
        joints_(joints_of(manipulator)) {}

  ReadingsColumns find() {
    name_columns();
    if (campaign_.displacement == DisplacementKind::difference) take_look_alikes("fm");
    if (campaign_.sensors.size() == 1) take_look_alikes("dr");
    find_sensors();
    for (const char* name : {"id", "session", "cycle", "step", "time", "temperature", "setting",
                             "replicate", "direction", "mask", "mask_reason", "role", "instrument"})
      found_.texts[name] = column(name);
    for (std::size_t i = 0; i < 6; ++i)
      found_.wrench[i] = column(std::array{"fx", "fy", "fz", "mx", "my", "mz"}[i]);
    found_.any_sigma = column("sigma");
    for (Eigen::Index i = 0; i < 6; ++i)
      for (Eigen::Index j = i + 1; j < 6; ++j)
        if (const Column c = column("corr_" + correlation_name(i, j)))
          found_.correlations.push_back({{i, j}, *c});
    found_.point = together("px", "py", "pz");
    if (context_.posture == PostureColumns::joints) {
      refuse_poses_without_joint();
    } else {
      found_.position = together("x", "y", "z");
      found_.orientation = together("roll", "pitch", "yaw");
    }
    find_joint_columns();
    if (context_.posture == PostureColumns::unstated) warn_of_drives_named_like_columns();
    find_factors();
    say_what_was_understood();
    look_at_covariates();
    check_columns();
    check_units();
    return std::move(found_);
  }

 private:
  // The columns of all that is read. Where sensors are stated, the platform is read only if a
  // column says so; every sensor has one, or another counts from it.
  void find_sensors() {
    const bool others = campaign_.sensors.size() > 1;
    const auto is_there = [this](const char* name) { return index_of(name).has_value(); };
    if (others && std::none_of(component_names.begin(), component_names.end(), is_there))
      leave_out_platform(campaign_);
    std::vector<bool> read(campaign_.sensors.size());
    for (const Component& component : campaign_.components) {
      found_.displacement.push_back(column(component.name));
      found_.sigma.push_back(column("sigma_" + component.name));
      if (found_.displacement.back()) read[component.sensor] = true;
    }
    for (const LoadColumn& load : load_columns(context_)) {
      found_.loads.push_back(column(load.name));
      if (!found_.loads.back())
        fault_in_header(load.name, fmt::format("the {} '{}' has no column", load.kind, load.name),
                        fmt::format("Add it, say which it is under 'columns' in the campaign file, "
                                    "or remove the {}",
                                    load.kind));
    }
    for (const Sensor& sensor : campaign_.sensors)
      if (sensor.minus) read[*sensor.minus] = true;
    for (const Component& component : campaign_.components)
      if (others && !read[component.sensor]) {
        fault_in_header(
            component.name,
            fmt::format("the sensor '{}' has no column", campaign_.sensors[component.sensor].name),
            "Add it, say which it is under 'columns' in the campaign file, or remove "
            "the sensor");
        read[component.sensor] = true;
      }
  }

  // The dimension of a column of a sensor or weight, "dial_1" or "sigma_dial_1"; nothing for other
  // names.
  std::optional<Dimension> dimension_of_sensor(const std::string& name) const {
    for (const Component& component : campaign_.components)
      if (name == component.name || name == "sigma_" + component.name) return component.dimension;
    for (const LoadColumn& load : load_columns(context_))
      if (name == load.name) return load.dimension;
    return std::nullopt;
  }

  // "Dial 1 [um]" -> "dial_1"; empty where no sensor is called so.
  std::string sensor_called(const std::string& header) const {
    const auto plain = [](std::string name) {
      name = bare_name(name);
      std::erase(name, '_');
      return name;
    };
    const std::string wanted = plain(split_header(header).name);
    for (const Component& component : campaign_.components)
      for (const std::string& name : {component.name, "sigma_" + component.name})
        if (!is_reserved(name) && plain(name) == wanted) return name;
    for (const LoadColumn& load : load_columns(context_))
      if (plain(load.name) == wanted) return load.name;
    return {};
  }

  // What each name means: as the campaign states, as it is written, as it can be understood.
  void name_columns() {
    const std::size_t count = table_.columns().size();
    found_.names.resize(count);
    found_.factors.assign(count, 1);
    found_.dimensions.resize(count);
    read_stated_columns();
    for (std::size_t i = 0; i < count; ++i) {
      const std::string& header = table_.columns()[i];
      if (stated_.count(i) > 0 || is_known_as_written(header)) continue;
      NamedColumn named = understood(header, joints_);
      if (const std::string sensor = sensor_called(header); !sensor.empty())
        named = {.meaning = sensor, .unit = split_header(header).unit, .as_written = false};
      if (named.meaning.empty()) continue;
      const Column other = index_of(named.meaning);
      if (!other) {
        index_of_[named.meaning] = i;
        found_.names[i] = std::move(named);
      } else if (bare_name(split_header(header).name) == bare_name(named.meaning)) {
        fault(i,
              fmt::format("the columns '{}' and '{}' mean the same: {}", header,
                          table_.columns()[*other], named.meaning),
              fmt::format("Remove one, or say 'columns: {{{}: covariate}}' in the campaign file",
                          header));
      }
    }
  }

  bool is_known_as_written(const std::string& header) const {
    return is_reserved(header) || dimension_of_sensor(header) ||
           std::any_of(joints_.begin(), joints_.end(),
                       [&](const Joint& j) { return header == j.name || header == j.alone; });
  }

  void read_stated_columns() {
    for (const auto& [header, stated] : context_.columns) {
      const Column at = column_called(header);
      if (!at) {
        const std::string near = common::nearest_spelling(header, table_.columns());
        campaign_fault(stated, header, fmt::format("the readings have no column '{}'", header),
                       near.empty() ? "Write a name of the header line"
                                    : fmt::format("Did you mean '{}'?", near));
        continue;
      }
      stated_.insert(*at);
      NamedColumn& named = found_.names[*at];
      named = {.meaning = meaning_of(stated, header),
               .unit = stated.unit ? stated.unit : split_header(table_.columns()[*at]).unit,
               .negative = stated.negative,
               .as_written = false};
      if (named.meaning.empty()) continue;
      if (const auto [other, fresh] = index_of_.emplace(named.meaning, *at); !fresh)
        campaign_fault(
            stated, header,
            fmt::format("'{}' is {} already", table_.columns()[other->second], named.meaning),
            "Give each meaning to one column");
    }
  }

  // By its name, or by its name without the unit.
  Column column_called(const std::string& header) const {
    if (const Column found = table_.find(header)) return found;
    for (std::size_t i = 0; i < table_.columns().size(); ++i)
      if (split_header(table_.columns()[i]).name == header) return i;
    return std::nullopt;
  }

  std::string meaning_of(const StatedColumn& stated, const std::string& header) {
    if (stated.meaning.empty() || is_reserved(stated.meaning) ||
        dimension_of_sensor(stated.meaning))
      return stated.meaning;
    std::vector<std::string> words = reserved_names();
    for (const Component& component : campaign_.components) words.push_back(component.name);
    for (const Joint& joint : joints_) {
      if (stated.meaning == joint.name || stated.meaning == joint.alone) return joint.name;
      words.insert(words.end(), {joint.name, joint.alone});
    }
    words.emplace_back("covariate");
    const std::string near = common::nearest_spelling(stated.meaning, words);
    campaign_fault(stated, header,
                   fmt::format("'{}' is neither a quantity nor a joint", stated.meaning),
                   near.empty() ? "Write fx, dz, time, the name of a joint, or covariate"
                                : fmt::format("Did you mean '{}'?", near));
    return {};
  }

  void campaign_fault(const StatedColumn& stated, const std::string& header,
                      const std::string& what, const std::string& cure) {
    faults_.add({.file = campaign_.file,
                 .line = stated.line,
                 .key = "columns." + header,
                 .what = what,
                 .cure = cure});
  }

  // Its index in the table.
  Column index_of(const std::string& name) const {
    if (const auto named = index_of_.find(name); named != index_of_.end()) return named->second;
    const Column found = table_.find(name);
    return found && stated_.count(*found) > 0 ? std::nullopt : found;
  }

  Column column(const std::string& name) {
    const Column found = index_of(name);
    if (found) {
      found_.known.insert(*found);
      if (found_.names[*found].meaning.empty())
        found_.names[*found] = {.meaning = name, .unit = std::nullopt};
    }
    return found;
  }

  void fault(std::size_t column, const std::string& what, const std::string& cure) {
    faults_.add(table_.column_mistake(column, what, cure));
  }

  void fault_in_header(const std::string& column, const std::string& what,
                       const std::string& cure) {
    if (const Column found = index_of(column)) return fault(*found, what, cure);
    faults_.add({.file = table_.file(),
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
    if (missing == 3 || !(columns[0] || columns[1] || columns[2])) return columns;
    fault_in_header(names[missing],
                    fmt::format("the column '{}' is missing: {}, {} and {} go together",
                                names[missing], a, b, c),
                    "Add it, with 0 in every row if need be" + hint_of_drives());
    return {};
  }

  // The drives, without a column, that are named like a given one that `wanted` chooses.
  std::vector<const Joint*> drives_named_like(bool (*wanted)(const std::string&)) const {
    std::vector<const Joint*> result;
    for (const Joint& joint : joints_) {
      const std::string name = bare_name(joint.alone);
      if (joint.actuated && is_reserved(name) && wanted(name) && index_of(name) &&
          !index_of(joint.name))
        result.push_back(&joint);
    }
    return result;
  }

  // For columns of a pose that may be coordinates of drives.
  std::string hint_of_drives() const {
    const std::vector<const Joint*> drives = drives_named_like(is_of_pose);
    if (drives.empty()) return {};
    return fmt::format(
        "; where columns are coordinates of the drives of these names, say 'posture: joints' in "
        "the campaign file, or name them like {}",
        drives[0]->name);
  }

  void refuse_poses_without_joint() {
    for (const char* name : pose_names)
      if (index_of(name) && std::none_of(joints_.begin(), joints_.end(),
                                         [&](const Joint& joint) { return joint.alone == name; }))
        fault_in_header(
            name,
            fmt::format("the campaign says 'posture: joints', and no joint is named '{}'", name),
            "Write 'posture: platform', or name the column otherwise to keep it as a "
            "covariate");
  }

  void warn_of_drives_named_like_columns() {
    std::vector<std::string> columns, whole;
    for (const Joint* joint : drives_named_like(is_of_pose)) {
      columns.push_back(bare_name(joint->alone));
      whole.push_back(joint->name);
    }
    if (!columns.empty())
      warn(fmt::format(
          "Read as the platform's pose: {}; but drives have these names. If the pose is meant, say "
          "'posture: platform' in the campaign file; if coordinates of the drives are, say "
          "'posture: joints', or name the columns {}.",
          fmt::join(columns, ", "), fmt::join(whole, ", ")));
    if (found_.position[0] || !found_.joints.empty()) return;
    for (const Joint* joint :
         drives_named_like([](const std::string& name) { return !is_of_pose(name); }))
      warn(
          fmt::format("The column '{}' is not taken as the coordinate of the drive of this name, "
                      "which would stand in a column '{}'.",
                      bare_name(joint->alone), joint->name));
  }

  void find_joint_columns() {
    std::vector<std::string> missing;
    for (const Joint& joint : joints_) {
      Column found = column(joint.name);
      const bool said = context_.posture == PostureColumns::joints && is_of_pose(joint.alone);
      if (!found && (said || !is_reserved(joint.alone))) found = column(joint.alone);
      if (found) {
        found_.joints.push_back({*found, joint.name, joint.dimension});
        NamedColumn& named = found_.names[*found];
        named.meaning = joint.name;
        campaign_.joint_columns[joint.name] = {
            named.as_written ? table_.columns()[*found] : joint.column(),
            joint.dimension == dimension::angle};
      }
      if (!found && joint.actuated) missing.push_back(said ? joint.alone : joint.column());
    }
    if (!found_.joints.empty() && !missing.empty()) {
      const std::string near = unknown_column_like(missing[0]);
      fault_in_header(
          missing[0],
          fmt::format("the actuated joint '{}' has no column, but others have", missing[0]),
          near.empty()
              ? fmt::format("Add its column, with the coordinate at which it stood in every "
                            "row, or say which it is: 'columns: {{NAME: {}}}'",
                            missing[0])
              : fmt::format("Rename the column '{}' if that is it", near));
    }
    if (!found_.joints.empty() && found_.position[0])
      fault_in_header(
          "x", "the posture is given twice: by x, y, z and by joint coordinates",
          any_of(found_.displacement)
              ? "Keep one; rename the other columns to keep them as covariates"
              : "If the position was measured, say 'columns: {x: dx, y: dy, z: dz}' and "
                "'displacement: absolute'");
    if (found_.orientation[0] && !found_.position[0])
      fault_in_header("x", "roll, pitch, yaw need a position as well", "Add the columns x, y, z");
  }

  // The first column without a meaning whose name may be this one mistyped; empty for none.
  std::string unknown_column_like(const std::string& name) const {
    for (std::size_t i = 0; i < table_.columns().size(); ++i)
      if (found_.known.count(i) == 0 &&
          !common::nearest_spelling(table_.columns()[i], {name}).empty())
        return table_.columns()[i];
    return {};
  }

  // What a number of each column is worth in SI.
  void find_factors() {
    for (const std::size_t i : found_.known) {
      const NamedColumn& named = found_.names[i];
      const Dimension dimension = dimension_of_column(named.meaning);
      found_.dimensions[i] = dimension;
      if (dimension == dimension::none || found_.unknown_units.count(i) > 0) continue;
      double factor = 1;
      if (named.unit)
        factor = own_factor(i, *named.unit, dimension);
      else if (dimension != dimension::temperature)
        factor = spatial::parse_unit(campaign_.units.unit_for(dimension)).factor;
      found_.factors[i] = named.negative ? -factor : factor;
    }
  }

  Dimension dimension_of_column(const std::string& meaning) const {
    for (const Joint& joint : joints_)
      if (joint.name == meaning) return joint.dimension;
    return dimension_of_sensor(meaning).value_or(dimension_of(meaning));
  }

  double own_factor(std::size_t column, const std::string& unit, const Dimension& wanted) {
    constexpr double gravity = 9.80665;  // [m/s^2]
    try {
      const spatial::Unit own = spatial::parse_unit(unit);
      const bool weight =
          (wanted == dimension::force && own.dimension == dimension::mass) ||
          (wanted == dimension::moment && own.dimension == dimension::mass * dimension::length);
      if (weight) {
        campaign_.notes.push_back(
            fmt::format("The column '{}' is in units of mass: the weight of 1 {} is taken, {:.6g} "
                        "{}.",
                        table_.columns()[column], unit, own.factor * gravity,
                        wanted == dimension::force ? "N" : "N m"));
        return own.factor * gravity;
      }
      return spatial::parse_quantity("1 " + unit, wanted);
    } catch (const std::invalid_argument& error) {
      std::string what = error.what();
      if (what.starts_with("'1 ")) what.erase(1, 2);  // the number is ours
      fault(column, what, "Write the unit in which the column was measured");
      return 1;
    }
  }

  void say_what_was_understood() {
    std::vector<std::string> said;
    for (std::size_t i = 0; i < found_.names.size(); ++i) {
      const NamedColumn& named = found_.names[i];
      if (named.as_written || found_.known.count(i) == 0 || found_.unknown_units.count(i) > 0)
        continue;
      said.push_back(fmt::format("'{}' is {}{}", table_.columns()[i], named.negative ? "-" : "",
                                 named.meaning) +
                     (named.unit && dimension_of_column(named.meaning) != dimension::none
                          ? " in " + *named.unit
                          : ""));
    }
    if (!said.empty())
      campaign_.notes.push_back(fmt::format("Columns understood: {}.", fmt::join(said, ", ")));
  }

  // Names that may be a known one mistyped, or look like readings.
  void look_at_covariates() {
    std::vector<std::string> names = reserved_names();
    for (const Component& component : campaign_.components) names.push_back(component.name);
    for (const Joint& joint : joints_) names.insert(names.end(), {joint.name, joint.alone});
    for (std::size_t i = 0; i < table_.columns().size(); ++i) {
      const std::string& name = table_.columns()[i];
      if (found_.known.count(i) > 0 || stated_.count(i) > 0) continue;
      const std::string meant = looks_like(name, joints_);
      const std::string quantity = meant.substr(0, meant.find(' '));
      if (!meant.empty() && !index_of(quantity)) {
        warn(
            fmt::format("The column '{}' is kept as a covariate, not as a reading. If it is {}, "
                        "say 'columns: {{{}: {}}}' in the campaign file.",
                        name, quantity, name, meant));
        continue;
      }
      if (warns_of_joint(name) || warns_of_mass(name)) continue;
      if (!found_.texts.at("time") && holds_clock_times(i))
        campaign_.notes.push_back(fmt::format(
            "The column '{}' holds times and is kept as a covariate; if the readings were taken "
            "then, say 'columns: {{{}: time}}'.",
            name, name));
      const std::string near = common::nearest_spelling(name, names);
      if (!near.empty())
        campaign_.notes.push_back(fmt::format(
            "The column '{}' is kept as a covariate; if '{}' was meant, rename it.", name, near));
    }
  }

  bool warns_of_joint(const std::string& name) {
    const Joint* const joint = joint_like(name, joints_);
    if (joint == nullptr || index_of(joint->name)) return false;
    warn(
        fmt::format("The column '{}' is kept as a covariate, not as a posture. If it is the "
                    "joint {}, say 'columns: {{{}: {} [{}]}}' in the campaign file.",
                    name, joint->column(), name, joint->column(),
                    joint->dimension == dimension::angle ? "deg" : "mm"));
    return true;
  }

  bool warns_of_mass(const std::string& name) {
    if (!is_mass(name)) return false;
    warn(
        fmt::format("The column '{}' is kept as a covariate. If that hangs on the robot, say "
                    "'weights: {{{}: {{on: platform}}}}' in the campaign file.",
                    name, name_for_column(name)));
    return true;
  }

  void warn(std::string sentence) {
    campaign_.notes.push_back(sentence);
    campaign_.warnings.push_back(std::move(sentence));
  }

  // In a table without any load, or displacement: the columns that look like one are taken as such,
  // so that their cells are looked at, and their names are faults.
  void take_look_alikes(std::string_view letters) {
    for (const char letter : letters)
      for (const char axis : {'x', 'y', 'z'})
        if (index_of({letter, axis})) return;
    for (std::size_t i = 0; i < table_.columns().size(); ++i) {
      const std::string& name = table_.columns()[i];
      if (stated_.count(i) > 0 || is_known_as_written(name)) continue;
      const std::string meant = looks_like(name, joints_);
      const std::string quantity = meant.substr(0, meant.find(' '));
      if (meant.empty() || letters.find(meant[0]) == std::string_view::npos || index_of(quantity))
        continue;
      index_of_[quantity] = i;
      found_.names[i] = {.meaning = quantity, .unit = "1", .as_written = false};
      const Dimension dimension = dimension_of(quantity);
      const std::string unit = dimension == dimension::force    ? "N"
                               : dimension == dimension::moment ? "N m"
                               : dimension == dimension::length ? "mm"
                                                                : "deg";
      if (meant != quantity)
        fault(i, fmt::format("'{}' is not known as {}", name, quantity),
              fmt::format("Say 'columns: {{{}: {}}}'", name, meant));
      else
        fault(i, fmt::format("'{}' has no unit", name),
              fmt::format("Write '{} [{}]', or 'columns: {{{}: {} [{}]}}'", name, unit, name, meant,
                          unit));
      found_.unknown_units.insert(i);
    }
  }

  template <class Columns>
  static bool any_of(const Columns& columns) {
    return std::any_of(columns.begin(), columns.end(), [](const Column& c) { return c; });
  }

  void check_columns() {
    if (has_no_names()) {
      faults_.add({.file = table_.file(),
                   .line = table_.header_line(),
                   .what = "numbers stand where the columns should have their names",
                   .cure = "Write a line of names above them, one quantity a column: 'Fz [N]', "
                           "'dz [um]'; a table that lies on its side must be turned"});
      return;
    }
    if (campaign_.control)
      for (const Eigen::Index k : {campaign_.control->set, campaign_.control->force})
        if (!found_.displacement[static_cast<std::size_t>(k)])
          fault_in_header(campaign_.component(k).name,
                          "'displacement_control' needs this column, and it is missing",
                          "Add it, or say which it is under 'columns' in the campaign file");
    if (!any_of(found_.displacement))
      fault_in_header("", "there is no column of displacement",
                      "Name at least one of dx, dy, dz, rx, ry, rz");
    if (!any_of(found_.wrench) && found_.loads.empty() &&
        campaign_.displacement == DisplacementKind::difference)
      fault_in_header("", "there is no column of load, so no difference to the unloaded state",
                      "Name at least one of fx, fy, fz, mx, my, mz" + hint_of_load());
    const bool moments =
        std::any_of(found_.wrench.begin() + 3, found_.wrench.end(),
                    [this](const Column& column) { return column && has_values(*column); });
    const bool point_given = found_.point[0] || context_.wrench.point || context_.wrench.origin;
    if (moments && !point_given)
      fault_in_header(found_.wrench[3]   ? "mx"
                      : found_.wrench[4] ? "my"
                                         : "mz",
                      "moments are given without the point that they are taken about",
                      "Add the columns px, py, pz, or 'wrench_point: reference' or 'wrench_point: "
                      "[x, y, z]' to the campaign file, or name a 'wrench_frame' with its origin");
    if (!moments && !point_given && any_of(found_.wrench))
      campaign_.notes.push_back(
          "No point of application is given: forces act at the platform's reference point.");
    const bool translations =
        campaign_.reads_platform() &&
        (found_.displacement[0] || found_.displacement[1] || found_.displacement[2]);
    if (found_.any_sigma && !translations)
      fault_in_header("sigma", "'sigma' is the deviation of translations, and none is measured",
                      "Write sigma_rx, sigma_ry, sigma_rz");
    if (!found_.position[0] && found_.joints.empty())
      campaign_.notes.push_back(
          "No column states the posture: the robot stands at its home coordinates.");
  }

  // Other than 0, "0.000" and nothing.
  bool has_values(std::size_t column) const {
    for (std::size_t row = 0; row < table_.rows(); ++row)
      if (table_.cell(row, column).find_first_of("123456789") != std::string_view::npos)
        return true;
    return false;
  }

  // Nearly all columns are called by a number.
  bool has_no_names() const {
    const std::vector<std::string>& names = table_.columns();
    const auto numbers = std::count_if(names.begin(), names.end(), [](const std::string& name) {
      return io::looks_like_value(name);
    });
    return numbers > 0 && numbers + 1 >= std::ssize(names);
  }

  // A column in a unit of force that has no axis in its name.
  std::string hint_of_load() const {
    for (std::size_t i = 0; i < table_.columns().size(); ++i) {
      const std::string& header = table_.columns()[i];
      if (found_.known.count(i) > 0 || stated_.count(i) > 0 || !is_force(header)) continue;
      const std::string name = split_header(header).name;
      return fmt::format(
          "; if it is '{}', say 'columns: {{{}: fz}}' in the campaign file, or --column '{}=fz' to "
          "'readings'",
          header, name, name);
    }
    return {};
  }

  void check_units() {
    Column angle;
    const auto look_at = [&](const Column& c) {
      if (c && !angle && !found_.names[*c].unit) angle = c;
    };
    for (std::size_t i = 0; i < found_.displacement.size(); ++i)
      if (campaign_.components[i].dimension == dimension::angle) look_at(found_.displacement[i]);
    for (const Column& c : found_.orientation) look_at(c);
    for (const JointColumn& c : found_.joints)
      if (c.dimension == dimension::angle) look_at(c.column);
    const auto require = [this](const Column& column, bool stated, const char* key,
                                const char* example) {
      if (!column || stated || found_.names[*column].unit) return;
      faults_.add(
          {.file = campaign_.file,
           .line = context_.units_line,
           .key = fmt::format("units.{}", key),
           .what = fmt::format("no unit of {} is stated, but the readings have the column '{}'",
                               key, table_.columns()[*column]),
           .cure = fmt::format("Write '{}: {}' under 'units'", key, example)});
    };
    require(angle, context_.angle_stated, "angle", "deg");
    if (!time_is_of_the_day()) require(found_.texts["time"], context_.time_stated, "time", "s");
  }

  // Clock times have no unit.
  bool time_is_of_the_day() const {
    const Column& time = found_.texts.at("time");
    return time && holds_clock_times(*time);
  }

  bool holds_clock_times(std::size_t column) const {
    for (std::size_t row = 0; row < table_.rows(); ++row)
      if (!table_.missing(row, column))
        return read_clock_time(table_.cell(row, column)).has_value();
    return false;
  }

  const io::CsvTable& table_;
  const ReadingsContext& context_;
  Campaign& campaign_;
  common::Faults& faults_;
  std::vector<Joint> joints_;
  ReadingsColumns found_;
  std::set<std::size_t> stated_;                 // columns that the campaign file names
  std::map<std::string, std::size_t> index_of_;  // columns by meanings that are not their names
};

}  // namespace

std::string joint_column(const vjm::Manipulator& manipulator, const std::string& name) {
  for (const Joint& joint : joints_of(manipulator))
    if (joint.name == name) return joint.column();
  return name;
}

std::string unit_of_column(const NamedColumn& column, const Dimension& dimension,
                           const spatial::UnitSystem& units) {
  if (dimension == dimension::none) return {};
  return column.unit ? *column.unit : units.unit_for(dimension);
}

ReadingsColumns find_columns(const io::CsvTable& table, const ReadingsContext& context,
                             const vjm::Manipulator& manipulator, Campaign& campaign,
                             common::Faults& faults) {
  return ColumnFinder(table, context, manipulator, campaign, faults).find();
}

}  // namespace kinetostat::calibration
