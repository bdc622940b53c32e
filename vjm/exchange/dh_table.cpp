#include "kinetostat/vjm/exchange/dh_table.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <fmt/format.h>

#include "kinetostat/common/error.h"
#include "kinetostat/common/spelling.h"
#include "kinetostat/io/csv.h"
#include "kinetostat/io/largest_number.h"
#include "kinetostat/io/yaml.h"
#include "kinetostat/spatial/rotation.h"

namespace kinetostat::vjm::dh_table {
namespace {

using io::YamlNode;
using spatial::Pose;
using spatial::UnitSystem;
using spatial::Vector3;
namespace dimension = spatial::dimension;

struct Row {
  std::string name;
  int line = 0;
  bool slides = false;
  double theta = 0, d = 0, a = 0, alpha = 0;
  std::optional<double> lower = {}, upper = {}, effort = {}, stiffness = {};
};

Pose about(const Vector3& axis, double angle, double along) {
  return {spatial::exp_rotation(angle * axis), along * axis};
}

RobotDescription description(const std::filesystem::path& file, const std::string& name,
                             DhConvention convention, const std::vector<Row>& rows) {
  RobotDescription robot{.file = file, .format = "table of Denavit and Hartenberg", .name = name};
  robot.links.push_back({.name = "base"});
  Pose before;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const Row& row = rows[i];
    const Pose turned = about(Vector3::UnitZ(), row.theta, row.d),
               shifted = about(Vector3::UnitX(), row.alpha, row.a);
    const bool is_modified = convention == DhConvention::modified;
    DescribedJoint joint{.name = row.name,
                         .line = row.line,
                         .type = row.slides ? JointType::prismatic : JointType::continuous,
                         .parent = robot.links.back().name,
                         .child = fmt::format("link_{}", i + 1),
                         .origin = is_modified ? before * shifted : before,
                         .axis = Vector3::UnitZ(),
                         .effort = row.effort,
                         .stiffness = row.stiffness};
    if (row.lower && row.upper) {
      joint.limits = {*row.lower, *row.upper};
      if (!row.slides) joint.type = JointType::revolute;
    }
    before = is_modified ? turned : turned * shifted;
    robot.links.push_back({.name = joint.child, .line = row.line});
    robot.joints.push_back(std::move(joint));
  }
  robot.links.push_back({.name = "tool"});
  robot.joints.push_back({.name = "tool",
                          .parent = fmt::format("link_{}", rows.size()),
                          .child = "tool",
                          .origin = before});
  check_names(robot);
  return robot;
}

Row read_row(const YamlNode& node, std::size_t number, const UnitSystem& units) {
  node.allow_only({"name", "type", "theta", "d", "a", "alpha", "range", "effort", "stiffness"});
  const auto read = [&](const char* key, const spatial::Dimension& of) {
    const auto given = node.find(key);
    return given ? given->quantity(of, units) : 0.0;
  };
  const auto name = node.find("name"), type = node.find("type");
  Row row{.name = name ? name->text() : fmt::format("q{}", number),
          .line = node.line(),
          .slides = type && type->choice({"revolute", "prismatic"}) == "prismatic",
          .theta = read("theta", dimension::angle),
          .d = read("d", dimension::length),
          .a = read("a", dimension::length),
          .alpha = read("alpha", dimension::angle)};
  if (const auto range = node.find("range")) {
    const std::vector<YamlNode> ends = range->items(2);
    const spatial::Dimension of = row.slides ? dimension::length : dimension::angle;
    row.lower = ends[0].quantity(of, units);
    row.upper = ends[1].quantity(of, units);
    if (!(*row.lower < *row.upper)) range->fail("needs the least value first");
  }
  if (const auto effort = node.find("effort"))
    row.effort = effort->positive(row.slides ? dimension::force : dimension::moment, units);
  if (const auto k = node.find("stiffness"))
    row.stiffness = k->positive(
        row.slides ? dimension::linear_stiffness : dimension::torsional_stiffness, units);
  return row;
}

RobotDescription read_yaml_table(const std::filesystem::path& file) {
  const YamlNode top = io::read_yaml(file);
  if (!top.has("dh"))
    throw common::InputError(
        file, "there is no key 'dh': this is no table of Denavit and Hartenberg's parameters",
        "Write 'dh: standard' or 'dh: modified', and 'joints:' with theta, d, "
        "a and alpha of each");
  top.allow_only({"kinetostat", "name", "units", "dh", "joints"});
  io::check_format_version(top);
  const UnitSystem units = io::read_units(top.at("units"));
  const bool is_modified = top.at("dh").choice({"standard", "modified"}) == "modified";
  std::vector<Row> rows;
  for (const YamlNode& item : top.at("joints").items())
    rows.push_back(read_row(item, rows.size() + 1, units));
  if (rows.empty()) top.at("joints").fail("there are no joints");
  const auto name = top.find("name");
  return description(file, name ? name->text() : file.stem().string(),
                     is_modified ? DhConvention::modified : DhConvention::standard, rows);
}

// The columns of a table, whose names may have their unit: "a [mm]".
class Columns {
 public:
  explicit Columns(const io::CsvTable& table) : table_(table) {
    static const std::vector<std::string> known = {"name",   "type",      "theta",     "d",
                                                   "a",      "alpha",     "lower",     "upper",
                                                   "effort", "stiffness", "convention"};
    for (std::size_t c = 0; c < table.columns().size(); ++c) {
      std::string name = table.columns()[c], unit;
      if (const std::size_t at = name.find('['); at != std::string::npos) {
        unit = name.substr(at + 1, name.find(']') - at - 1);
        name = name.substr(0, name.find_last_not_of(' ', at - 1) + 1);
      }
      if (std::find(known.begin(), known.end(), name) == known.end()) {
        const std::string near = common::nearest_spelling(name, known);
        table.fail_column(c, fmt::format("the column '{}' is not known", name),
                          near.empty()
                              ? "Columns are name, type, theta, d, a, alpha, lower, upper, "
                                "effort, stiffness and convention"
                              : fmt::format("Did you mean '{}'?", near));
      }
      columns_.push_back({name, unit});
    }
  }

  std::optional<std::size_t> find(const std::string& name) const {
    for (std::size_t c = 0; c < columns_.size(); ++c)
      if (columns_[c].first == name) return c;
    return std::nullopt;
  }
  std::string text(std::size_t row, const std::string& name, const std::string& otherwise) const {
    const auto c = find(name);
    return c && !table_.missing(row, *c) ? std::string(table_.cell(row, *c)) : otherwise;
  }
  // In SI; the unit is the column's or the cell's own. Of none in an empty cell alone: the words
  // for "not measured" are no parameters.
  std::optional<double> quantity(std::size_t row, const std::string& name,
                                 const spatial::Dimension& of) const {
    const auto c = find(name);
    if (!c || table_.empty(row, *c)) return std::nullopt;
    try {
      const double value = spatial::parse_quantity(table_.cell(row, *c), of, columns_[*c].second);
      if (std::abs(value) <= io::largest_number) return value;
    } catch (const std::invalid_argument& error) {
      table_.fail(row, *c, error.what(), "Write the unit into the name of the column: 'a [mm]'");
    }
    table_.fail(row, *c, "is no finite number");
  }
  std::optional<double> positive(std::size_t row, const std::string& name,
                                 const spatial::Dimension& of) const {
    const std::optional<double> value = quantity(row, name, of);
    if (value && !(*value > 0))
      table_.fail(row, *find(name), "is not positive",
                  "Give a value above zero, or leave it empty");
    return value;
  }
  std::string word(std::size_t row, const std::string& name, const std::vector<std::string>& words,
                   const std::string& otherwise) const {
    std::string value = text(row, name, otherwise);
    if (std::find(words.begin(), words.end(), value) == words.end())
      table_.fail(row, *find(name), fmt::format("'{}' is not {} or {}", value, words[0], words[1]));
    return value;
  }

 private:
  const io::CsvTable& table_;
  std::vector<std::pair<std::string, std::string>> columns_;  // names and units
};

Row read_row(const io::CsvTable& table, const Columns& columns, std::size_t i) {
  Row row{.name = columns.text(i, "name", fmt::format("q{}", i + 1)), .line = table.line(i)};
  row.slides = columns.word(i, "type", {"revolute", "prismatic"}, "revolute") == "prismatic";
  row.theta = columns.quantity(i, "theta", dimension::angle).value_or(0);
  row.d = columns.quantity(i, "d", dimension::length).value_or(0);
  row.a = columns.quantity(i, "a", dimension::length).value_or(0);
  row.alpha = columns.quantity(i, "alpha", dimension::angle).value_or(0);
  const spatial::Dimension of = row.slides ? dimension::length : dimension::angle;
  row.lower = columns.quantity(i, "lower", of);
  row.upper = columns.quantity(i, "upper", of);
  if (row.lower.has_value() != row.upper.has_value())
    table.fail(i, *columns.find(row.lower ? "lower" : "upper"),
               fmt::format("a range has both ends, and '{}' is empty or not there",
                           row.lower ? "upper" : "lower"));
  if (row.lower && row.upper && !(*row.lower < *row.upper))
    table.fail(i, *columns.find("lower"), "is not below 'upper'");
  row.effort = columns.positive(i, "effort", row.slides ? dimension::force : dimension::moment);
  row.stiffness = columns.positive(
      i, "stiffness", row.slides ? dimension::linear_stiffness : dimension::torsional_stiffness);
  return row;
}

RobotDescription read_csv_table(const std::filesystem::path& file) {
  const io::CsvTable table = io::read_csv(file);
  const Columns columns(table);
  if (!columns.find("convention"))
    throw common::InputError(file, "the table does not say which convention it has",
                             "Add a column 'convention' with standard or modified in every row");
  std::vector<Row> rows;
  std::string convention;
  for (std::size_t i = 0; i < table.rows(); ++i) {
    rows.push_back(read_row(table, columns, i));
    const std::string own = columns.word(i, "convention", {"standard", "modified"}, "");
    if (!convention.empty() && own != convention)
      table.fail(i, *columns.find("convention"), "the rows have different conventions");
    convention = own;
  }
  return description(file, file.stem().string(),
                     convention == "modified" ? DhConvention::modified : DhConvention::standard,
                     rows);
}

}  // namespace
}  // namespace kinetostat::vjm::dh_table

namespace kinetostat::vjm {

RobotDescription read_dh_table(const std::filesystem::path& file) {
  const std::string extension = file.extension().string();
  return extension == ".yaml" || extension == ".yml" ? dh_table::read_yaml_table(file)
                                                     : dh_table::read_csv_table(file);
}

}  // namespace kinetostat::vjm
