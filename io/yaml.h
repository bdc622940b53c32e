// YAML files that people write, read with the place of every value at hand for error messages.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <yaml-cpp/yaml.h>

#include "kinetostat/spatial/linear_algebra.h"
#include "kinetostat/spatial/pose.h"
#include "kinetostat/spatial/units.h"

namespace kinetostat::io {

/// One value of a YAML file with its file, line and path of keys ("links.leg.beam.length").
/// Every accessor throws InputError naming them when the value is not what is asked for.
class YamlNode {
 public:
  YamlNode(const YAML::Node& node, std::shared_ptr<const std::filesystem::path> file,
           std::string path);

  const std::filesystem::path& file() const { return *file_; }
  const std::string& path() const { return path_; }
  int line() const;

  bool is_map() const { return node_.IsMap(); }
  bool is_sequence() const { return node_.IsSequence(); }
  bool is_scalar() const { return node_.IsScalar(); }

  /// Refuses every key that is not in the list, with the nearest known key as a hint, and keys that
  /// are given twice. Requires a map.
  void allow_only(const std::vector<std::string>& keys) const;
  bool has(const std::string& key) const;
  /// The value of a key that must be there.
  YamlNode at(const std::string& key) const;
  std::optional<YamlNode> find(const std::string& key) const;
  /// The one key among `keys` that is there; none or several is an error. For "one of these kinds".
  std::pair<std::string, YamlNode> one_of(const std::vector<std::string>& keys) const;

  /// The members of a map, in the order of the file; keys are texts of one line.
  std::vector<std::pair<std::string, YamlNode>> members() const;
  /// The items of a sequence.
  std::vector<YamlNode> items() const;
  /// The items of a sequence of exactly `size`.
  std::vector<YamlNode> items(std::size_t size) const;

  /// One line without control characters: names go into tables, and into decks and scripts for
  /// other programs.
  std::string text() const;
  /// A text of any number of lines.
  std::string prose() const;
  bool boolean() const;
  /// A finite plain number.
  double number() const;
  int integer(int lowest, int highest) const;
  /// One word of a list, with did-you-mean.
  std::string choice(const std::vector<std::string>& words) const;

  /// A finite quantity in SI; a bare number is taken in the unit that `units` has for the
  /// dimension.
  double quantity(const spatial::Dimension& dimension, const spatial::UnitSystem& units) const;
  /// The same, above zero.
  double positive(const spatial::Dimension& dimension, const spatial::UnitSystem& units) const;
  /// A quantity that must carry its own unit.
  double quantity_with_unit(const spatial::Dimension& dimension) const;
  /// Three quantities [x, y, z] in SI.
  spatial::Vector3 vector3(const spatial::Dimension& dimension,
                           const spatial::UnitSystem& units) const;
  /// A direction [x, y, z], normalised; zero is refused.
  spatial::Vector3 direction() const;
  /// Six rows of six plain numbers, in the file's units: the owner of the matrix scales its blocks.
  spatial::Matrix6 matrix6() const;

  /// A path, taken relative to the folder of this file; the file must exist.
  std::filesystem::path existing_file() const;

  [[noreturn]] void fail(const std::string& what, const std::string& cure = {}) const;

 private:
  /// The keys of a map with nodes of their own, whose line is the key's, not the value's.
  std::vector<std::pair<std::string, YamlNode>> key_places() const;
  YamlNode child(const YAML::Node& node, const std::string& path) const;
  [[noreturn]] void refuse_control_characters() const;
  void require_sensible(double si, const std::string& value) const;
  template <class Read>
  auto decorated(Read read) const;

  YAML::Node node_;
  std::shared_ptr<const std::filesystem::path> file_;
  std::string path_;
};

/// Meaning of a file: its content without comments, layout and order of keys, with the SHA-256 of
/// every file that it names; two files with the same meaning give the same results.
std::string meaning(const YamlNode& node);

/// Reads a file whose top level is a map. Throws InputError when it is missing, not YAML, empty or
/// another kind of file, or exceeds 16 MiB, a million values (aliases counted as what they stand
/// for) or a depth of 100.
YamlNode read_yaml(const std::filesystem::path& file);
/// The same from text; `name` stands for the file in messages and for relative paths.
YamlNode parse_yaml(const std::string& text, const std::filesystem::path& name);

/// A text as a value on one line of a YAML file: as it is where that can mean nothing else, else in
/// double quotes, with '?' for control characters.
std::string yaml_scalar(const std::string& text);

/// Checks `kinetostat: 1`, the version of the file formats that this program reads.
void check_format_version(const YamlNode& top);

/// `units: {length: mm, force: N, angle: deg, time: s}`. Length and force must be named.
spatial::UnitSystem read_units(const YamlNode& node);

/// A pose: `[x, y, z]`, or `{point: [x, y, z], rpy: [r, p, y]}`, `{point:, rotation_vector:}`,
/// `{point:, x: [..], y: [..]}` (directions of the axes; any two of x, y, z). All parts are
/// optional.
spatial::Pose read_pose(const YamlNode& node, const spatial::UnitSystem& units);

}  // namespace kinetostat::io
