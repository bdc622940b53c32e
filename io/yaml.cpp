#include "kinetostat/io/yaml.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <map>
#include <set>
#include <sstream>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <yaml-cpp/eventhandler.h>

#include "kinetostat/common/error.h"
#include "kinetostat/common/printable.h"
#include "kinetostat/common/spelling.h"
#include "kinetostat/io/file_kind.h"
#include "kinetostat/io/largest_number.h"
#include "kinetostat/io/text_file.h"
#include "kinetostat/spatial/rotation.h"

namespace kinetostat::io {
namespace {

using spatial::Dimension;
using spatial::UnitSystem;
using spatial::Vector3;

std::string hint(const std::string& word, const std::vector<std::string>& candidates) {
  const std::string near = common::nearest_spelling(word, candidates);
  return near.empty() ? fmt::format("Known here: {}", fmt::join(candidates, ", "))
                      : fmt::format("Did you mean '{}'?", near);
}

std::string kind_of(const YAML::Node& node) {
  switch (node.Type()) {
    case YAML::NodeType::Scalar:
      return fmt::format("the value '{}'", node.Scalar());
    case YAML::NodeType::Sequence:
      return fmt::format("a list of {}", node.size());
    case YAML::NodeType::Map:
      return "a map of keys";
    default:
      return "nothing";
  }
}

// A text with its length before it, so that no two sequences of texts look the same.
std::string sized(const std::string& text) { return fmt::format("{}:{} ", text.size(), text); }

// An alias may make a node a part of itself, or of billions of others: whoever walks through it
// would not come to an end. True when `left` more nodes hold all of it.
bool is_small(const YAML::Node& node, int depth, int& left) {
  if (--left < 0 || depth > 100) return false;
  for (const auto& member : node) {
    const bool is_item = node.IsSequence();
    if (is_item
            ? !is_small(member, depth + 1, left)
            : !is_small(member.first, depth + 1, left) || !is_small(member.second, depth + 1, left))
      return false;
  }
  return true;
}

std::string key_text(const YAML::Node& key) { return key.IsScalar() ? key.Scalar() : "?"; }

}  // namespace

YamlNode::YamlNode(const YAML::Node& node, std::shared_ptr<const std::filesystem::path> file,
                   std::string path)
    : node_(node), file_(std::move(file)), path_(std::move(path)) {}

int YamlNode::line() const { return node_.Mark().line + 1; }

YamlNode YamlNode::child(const YAML::Node& node, const std::string& name) const {
  return {node, file_, path_.empty() ? name : path_ + (name.starts_with('[') ? "" : ".") + name};
}

void YamlNode::fail(const std::string& what, const std::string& cure) const {
  throw common::InputError(
      {.file = *file_, .line = line(), .key = path_, .what = what, .cure = cure});
}

// Units and numbers complain with std::invalid_argument; their message gets its place in the file.
template <class Read>
auto YamlNode::decorated(Read read) const {
  try {
    return read();
  } catch (const std::invalid_argument& error) {
    fail(error.what());
  }
}

void YamlNode::allow_only(const std::vector<std::string>& keys) const {
  if (!is_map())
    fail(fmt::format("a map of keys is expected here, not {}", kind_of(node_)),
         fmt::format("Known here: {}", fmt::join(keys, ", ")));
  std::set<std::string> seen;
  for (const auto& [key, place] : key_places()) {
    if (!seen.insert(key).second) place.fail(fmt::format("the key '{}' is given twice", key));
    if (std::find(keys.begin(), keys.end(), key) == keys.end())
      place.fail(fmt::format("the key '{}' is not known here", key), hint(key, keys));
  }
}

bool YamlNode::has(const std::string& key) const {
  return is_map() && static_cast<bool>(node_[key]);
}

std::optional<YamlNode> YamlNode::find(const std::string& key) const {
  if (!has(key)) return std::nullopt;
  return child(node_[key], key);
}

YamlNode YamlNode::at(const std::string& key) const {
  if (!is_map())
    fail(fmt::format("a map with the key '{}' is expected here, not {}", key, kind_of(node_)));
  if (auto found = find(key)) return *found;
  fail(fmt::format("the key '{}' is missing", key));
}

std::pair<std::string, YamlNode> YamlNode::one_of(const std::vector<std::string>& keys) const {
  std::vector<std::string> found;
  for (const std::string& key : keys)
    if (has(key)) found.push_back(key);
  if (found.size() == 1) return {found[0], at(found[0])};
  if (found.size() > 1)
    fail(fmt::format("the keys {} exclude each other", fmt::join(found, " and ")), "Keep one");
  for (const auto& [key, place] : is_map() ? key_places() : decltype(members()){}) {
    const std::string near = common::nearest_spelling(key, keys);
    if (!near.empty())
      place.fail(fmt::format("the key '{}' is not known here", key),
                 fmt::format("Did you mean '{}'?", near));
  }
  fail(fmt::format("one of the keys {} is expected here", fmt::join(keys, ", ")));
}

std::vector<std::pair<std::string, YamlNode>> YamlNode::key_places() const {
  std::vector<std::pair<std::string, YamlNode>> result;
  for (const auto& member : node_) {
    const std::string key = key_text(member.first);
    result.emplace_back(key, child(member.first, key));
  }
  return result;
}

std::vector<std::pair<std::string, YamlNode>> YamlNode::members() const {
  if (!is_map()) fail(fmt::format("a map of keys is expected here, not {}", kind_of(node_)));
  std::vector<std::pair<std::string, YamlNode>> result;
  for (const auto& member : node_) {
    const std::string key = key_text(member.first);
    if (common::has_control_characters(key)) child(member.first, key).refuse_control_characters();
    result.emplace_back(key, child(member.second, key));
  }
  return result;
}

std::vector<YamlNode> YamlNode::items() const {
  if (!is_sequence()) fail(fmt::format("a list is expected here, not {}", kind_of(node_)));
  std::vector<YamlNode> result;
  for (std::size_t i = 0; i < node_.size(); ++i)
    result.push_back(child(node_[i], fmt::format("[{}]", i)));
  return result;
}

std::vector<YamlNode> YamlNode::items(std::size_t size) const {
  std::vector<YamlNode> result = items();
  if (result.size() != size)
    fail(fmt::format("a list of {} is expected here, not of {}", size, result.size()));
  return result;
}

std::string YamlNode::prose() const {
  if (!is_scalar() || node_.Scalar().empty())
    fail(fmt::format("a text is expected here, not {}", kind_of(node_)));
  return node_.Scalar();
}

std::string YamlNode::text() const {
  std::string line = prose();
  if (common::has_control_characters(line)) refuse_control_characters();
  return line;
}

void YamlNode::refuse_control_characters() const {
  fail(fmt::format("'{}' has a line end or another control character in it",
                   common::printable(node_.Scalar())),
       "Write it on one line ('>-' instead of '>' leaves the last line end away)");
}

bool YamlNode::boolean() const {
  const std::string word = choice({"true", "false"});
  return word == "true";
}

double YamlNode::number() const { return quantity(spatial::dimension::none, {}); }

int YamlNode::integer(int lowest, int highest) const {
  const double value = number();
  if (value != std::floor(value) || value < lowest || value > highest)
    fail(fmt::format("'{}' is not a whole number from {} to {}", text(), lowest, highest));
  return static_cast<int>(value);
}

std::string YamlNode::choice(const std::vector<std::string>& words) const {
  std::string word = text();
  if (std::find(words.begin(), words.end(), word) != words.end()) return word;
  const std::string near = common::nearest_spelling(word, words);
  fail(fmt::format("'{}' is not one of {}", word, fmt::join(words, ", ")),
       near.empty() ? "" : fmt::format("Did you mean '{}'?", near));
}

double YamlNode::quantity(const Dimension& dimension, const UnitSystem& units) const {
  const std::string value = text();
  const double si = decorated(
      [&] { return spatial::parse_quantity(value, dimension, units.unit_for(dimension)); });
  require_sensible(si, value);
  return si;
}

void YamlNode::require_sensible(double si, const std::string& value) const {
  if (!std::isfinite(si)) fail(fmt::format("'{}' is not a finite number", value));
  if (std::abs(si) > largest_number) fail(fmt::format("'{}' is too large to compute with", value));
}

double YamlNode::positive(const Dimension& dimension, const UnitSystem& units) const {
  const double si = quantity(dimension, units);
  if (!(si > 0)) fail(fmt::format("'{}' is not positive", text()), "Give a value above zero");
  return si;
}

double YamlNode::quantity_with_unit(const Dimension& dimension) const {
  const std::string value = text();
  const double si = decorated([&] { return spatial::parse_quantity(value, dimension); });
  require_sensible(si, value);
  return si;
}

Vector3 YamlNode::vector3(const Dimension& dimension, const UnitSystem& units) const {
  Vector3 v;
  Eigen::Index i = 0;
  for (const YamlNode& item : items(3)) v[i++] = item.quantity(dimension, units);
  return v;
}

Vector3 YamlNode::direction() const {
  const Vector3 v = vector3(spatial::dimension::none, {});
  if (!(v.norm() > 0)) fail("the direction [0, 0, 0] points nowhere");
  return v.normalized();
}

spatial::Matrix6 YamlNode::matrix6() const {
  spatial::Matrix6 m;
  Eigen::Index i = 0;
  for (const YamlNode& row : items(6)) {
    Eigen::Index j = 0;
    for (const YamlNode& entry : row.items(6)) m(i, j++) = entry.number();
    ++i;
  }
  return m;
}

std::filesystem::path YamlNode::existing_file() const {
  const std::filesystem::path given = text();
  const std::filesystem::path full = given.is_absolute() ? given : file_->parent_path() / given;
  std::error_code error, ignored;
  const std::filesystem::file_status status = std::filesystem::status(full, error);
  if (std::filesystem::is_regular_file(status)) return full.lexically_normal();
  if (status.type() == std::filesystem::file_type::none)
    fail(fmt::format("the file '{}' cannot be read ({})", full.lexically_normal().string(),
                     error.message()),
         "Check the path and that you may read it");
  std::vector<std::string> neighbours;
  for (const auto& entry : std::filesystem::directory_iterator(
           full.parent_path().empty() ? "." : full.parent_path(), ignored))
    neighbours.push_back(entry.path().filename().string());
  const std::string near = common::nearest_spelling(full.filename().string(), neighbours);
  fail(fmt::format("the file '{}' does not exist", full.lexically_normal().string()),
       near.empty() ? "Paths are taken relative to the folder of this file"
                    : fmt::format("Did you mean '{}'?", near));
}

std::string meaning(const YamlNode& node) {
  std::string text;
  if (node.is_map()) {
    std::map<std::string, std::string> members;
    for (const auto& [key, value] : node.members()) members[key] = meaning(value);
    for (const auto& [key, value] : members) text += fmt::format("{}{}", sized(key), value);
    return fmt::format("map {} {}", members.size(), text);
  }
  if (node.is_sequence()) {
    const std::vector<YamlNode> items = node.items();
    for (const YamlNode& item : items) text += meaning(item);
    return fmt::format("list {} {}", items.size(), text);
  }
  if (!node.is_scalar()) return "nothing ";
  std::error_code ignored;
  const std::filesystem::path path = node.file().parent_path() / node.prose();
  if (std::filesystem::is_regular_file(path, ignored)) text = sha256(read_text(path));
  return fmt::format("value {}{}", sized(node.prose()), sized(text));
}

namespace {

constexpr std::size_t largest_yaml = std::size_t{16} << 20;  // [bytes]
constexpr int most_values = 1'000'000;
constexpr int deepest = 100;

common::InputError error_at(const std::filesystem::path& file, const YAML::Mark& mark,
                            const std::string& what, const std::string& cure) {
  return common::InputError(
      {.file = file, .line = mark.line + 1, .column = mark.column + 1, .what = what, .cure = cure});
}

// Counts what a file holds before anything is kept of it. The parser itself has no bounds: a text
// that it cannot place, such as a comma at the start, is one empty document after the other.
class Census : public YAML::EventHandler {
 public:
  explicit Census(const std::filesystem::path& file) : file_(file) {}

  void OnDocumentStart(const YAML::Mark& mark) override {
    if (++documents_ > most_documents)
      throw error_at(file_, mark, "text follows that belongs to no value",
                     "Check indentation, brackets and commas near this place");
  }
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark& mark, YAML::anchor_t) override { count(mark); }
  void OnAlias(const YAML::Mark& mark, YAML::anchor_t) override { count_content(mark); }
  void OnScalar(const YAML::Mark& mark, const std::string&, YAML::anchor_t,
                const std::string&) override {
    count_content(mark);
  }
  void OnSequenceStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t,
                       YAML::EmitterStyle::value) override {
    open(mark);
  }
  void OnSequenceEnd() override { --depth_; }
  void OnMapStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t,
                  YAML::EmitterStyle::value) override {
    open(mark);
  }
  void OnMapEnd() override { --depth_; }

 private:
  static constexpr int most_documents = 10;

  void count(const YAML::Mark& mark) {
    if (++values_ > most_values)
      throw error_at(file_, mark, fmt::format("the file holds more than {} values", most_values),
                     "Readings belong into a CSV file");
  }
  void count_content(const YAML::Mark& mark) {
    count(mark);
    if (documents_ > 1)
      throw error_at(file_, mark, fmt::format("the file holds {} documents", documents_),
                     "Keep one; '---' starts another");
  }
  void open(const YAML::Mark& mark) {
    count_content(mark);
    if (++depth_ > deepest)
      throw error_at(file_, mark, "the file is nested too deeply",
                     "Check brackets and indentation");
  }

  const std::filesystem::path& file_;
  int documents_ = 0, values_ = 0, depth_ = 0;
};

YAML::Node bounded_root(const std::string& text, const std::filesystem::path& file) {
  if (text.size() > largest_yaml)
    throw common::InputError(file, fmt::format("is larger than {} MiB", largest_yaml >> 20),
                             "Readings belong into a CSV file, surfaces into a mesh file");
  Census census(file);
  std::istringstream stream(text);
  YAML::Parser parser(stream);
  while (parser.HandleNextDocument(census)) {
  }
  YAML::Node root = YAML::Load(text);
  if (!root.IsMap())
    throw common::InputError(file,
                             fmt::format("the file holds {}, not a map of keys", kind_of(root)),
                             "A kinetostat file starts with 'kinetostat: 1'");
  if (int left = most_values; !is_small(root, 0, left))
    throw common::InputError(file, "a value holds itself, or more than can be read",
                             "Write it out where an alias (*name) stands for it");
  return root;
}

YAML::Node checked_root(const std::string& text, const std::filesystem::path& file) {
  const bool is_utf16 = text.starts_with("\xff\xfe") || text.starts_with("\xfe\xff");
  if (!is_utf16)
    refuse_other_kinds(file, text, "a YAML file",
                       "Name the YAML file; meshes and tables are named inside it");
  try {
    return bounded_root(text, file);
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception&) {
    if (is_utf16 || !looks_like_table(text)) throw;
    throw common::InputError(
        file, "this looks like a table (CSV), not a YAML file",
        "Name the YAML file; a campaign file names its table with 'readings:'");
  }
}

}  // namespace

YamlNode parse_yaml(const std::string& text, const std::filesystem::path& name) {
  try {
    return {checked_root(text, name), std::make_shared<const std::filesystem::path>(name), ""};
  } catch (const YAML::Exception& error) {
    throw error_at(name, error.mark, "not valid YAML: " + error.msg,
                   "Check indentation, brackets and quotes near this place");
  }
}

// One byte more than is read tells that there is more.
YamlNode read_yaml(const std::filesystem::path& file) {
  return parse_yaml(read_start(file, largest_yaml + 1), file);
}

std::string yaml_scalar(const std::string& text) {
  const auto is_plain = [](unsigned char c) {
    return std::isalnum(c) != 0 || c == '_' || c == '.' || c == '-' || c == '/' || c == ' ';
  };
  const std::string_view words[] = {"true", "false", "null", "yes", "no", "on", "off"};
  if (!text.empty() && std::isalpha(static_cast<unsigned char>(text[0])) != 0 &&
      text.back() != ' ' && std::all_of(text.begin(), text.end(), is_plain) &&
      std::find(std::begin(words), std::end(words), text) == std::end(words))
    return text;
  std::string quoted = "\"";
  for (const char c : common::printable(text)) {
    if (c == '"' || c == '\\') quoted += '\\';
    quoted += c;
  }
  return quoted + "\"";
}

void check_format_version(const YamlNode& top) {
  if (!top.has("kinetostat"))
    top.fail("the key 'kinetostat' is missing",
             "Write 'kinetostat: 1' (the version of the file format) at the top");
  const YamlNode version = top.at("kinetostat");
  if (version.text() != "1")
    version.fail(fmt::format("file format version '{}' is not known", version.text()),
                 "This program reads version 1");
}

UnitSystem read_units(const YamlNode& node) {
  node.allow_only({"length", "force", "angle", "time", "temperature", "mass"});
  UnitSystem units;
  const auto read = [&node](const char* key, const Dimension& dimension, std::string& unit) {
    const auto found = node.find(key);
    if (!found) return;
    unit = found->text();
    try {
      if (spatial::parse_unit(unit).dimension == dimension) return;
    } catch (const std::invalid_argument& error) {
      found->fail(error.what());
    }
    found->fail(fmt::format("'{}' is not a unit of {}", unit, key));
  };
  node.at("length");
  node.at("force");
  read("length", spatial::dimension::length, units.length);
  read("force", spatial::dimension::force, units.force);
  read("angle", spatial::dimension::angle, units.angle);
  read("time", spatial::dimension::time, units.time);
  read("temperature", spatial::dimension::temperature, units.temperature);
  read("mass", spatial::dimension::mass, units.mass);
  return units;
}

namespace {

spatial::Matrix3 read_axes(const YamlNode& node) {
  const bool x = node.has("x"), y = node.has("y"), z = node.has("z");
  if (x + y + z != 2) node.fail("two of the axis directions x, y, z are expected");
  const auto axis = [&node](const char* key) { return node.at(key).direction(); };
  spatial::Matrix3 rotation;
  try {
    if (x && y) {
      rotation = spatial::rotation_from_axes(axis("x"), axis("y"));
    } else if (x) {
      rotation = spatial::rotation_from_axes(axis("x"), axis("z").cross(axis("x")));
    } else {
      rotation = spatial::rotation_from_axes(axis("y").cross(axis("z")), axis("y"));
    }
  } catch (const std::invalid_argument& error) {
    node.fail(error.what());
  }
  return rotation;
}

}  // namespace

spatial::Pose read_pose(const YamlNode& node, const UnitSystem& units) {
  if (node.is_sequence())
    return spatial::Pose::translation(node.vector3(spatial::dimension::length, units));
  node.allow_only({"point", "rpy", "rotation_vector", "x", "y", "z"});
  const bool axes = node.has("x") || node.has("y") || node.has("z");
  if (node.has("rpy") + node.has("rotation_vector") + axes > 1)
    node.fail("the rotation is given in more than one way",
              "Keep one of rpy, rotation_vector, or axes as two of x, y and z");
  Vector3 point = Vector3::Zero();
  if (const auto given = node.find("point"))
    point = given->vector3(spatial::dimension::length, units);
  spatial::Matrix3 rotation = spatial::Matrix3::Identity();
  if (const auto rpy = node.find("rpy"))
    rotation = spatial::rotation_from_rpy(rpy->vector3(spatial::dimension::angle, units));
  if (const auto vector = node.find("rotation_vector"))
    rotation = spatial::exp_rotation(vector->vector3(spatial::dimension::angle, units));
  if (axes) rotation = read_axes(node);
  return {rotation, point};
}

}  // namespace kinetostat::io
