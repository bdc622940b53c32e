#include "kinetostat/vjm/robot_file.h"

#include <algorithm>
#include <map>
#include <stdexcept>

#include <fmt/format.h>

#include "kinetostat/files/error.h"
#include "kinetostat/files/yaml.h"
#include "kinetostat/vjm/link_model.h"

namespace kinetostat::vjm {
namespace {

using files::YamlNode;
using spatial::Pose;
using spatial::UnitSystem;
namespace dimension = spatial::dimension;

// What the elements of a chain refer to.
struct Parts {
  UnitSystem units;
  std::map<std::string, LinkModel> links;
};

Motion read_motion(const YamlNode& node) {
  static const std::vector<std::string> names = {"Tx", "Ty", "Tz", "Rx", "Ry", "Rz"};
  const std::string name = node.choice(names);
  return static_cast<Motion>(std::find(names.begin(), names.end(), name) - names.begin());
}

spatial::Dimension coordinate_dimension(Motion motion) {
  return is_rotation(motion) ? dimension::angle : dimension::length;
}

double read_stiffness(const YamlNode& node, Motion motion, const UnitSystem& units) {
  return node.positive(
      is_rotation(motion) ? dimension::torsional_stiffness : dimension::linear_stiffness, units);
}

void add_actuator(Chain& chain, const YamlNode& node, const UnitSystem& units) {
  node.allow_only({"name", "axis", "stiffness", "home"});
  const Motion motion = read_motion(node.at("axis"));
  std::optional<double> stiffness;
  if (const auto given = node.find("stiffness")) stiffness = read_stiffness(*given, motion, units);
  const auto home = node.find("home");
  chain.actuator(node.at("name").text(), motion, stiffness,
                 home ? home->quantity(coordinate_dimension(motion), units) : 0);
}

// A joint with one axis may have a spring; with several, each coordinate is "name.axis".
void add_passive(Chain& chain, const YamlNode& node, const UnitSystem& units) {
  node.allow_only({"name", "axis", "axes", "stiffness", "rest", "home"});
  const std::string name = node.at("name").text();
  const auto [key, value] = node.one_of({"axis", "axes"});
  const auto home = node.find("home");
  if (key == "axes") {
    for (const char* single : {"stiffness", "rest"})
      if (const auto given = node.find(single))
        given->fail("a spring needs a passive joint with one axis",
                    "Write one 'passive' per axis, each with 'axis:'");
    const std::vector<YamlNode> axes = value.items();
    if (axes.empty()) value.fail("at least one axis is expected");
    const std::vector<YamlNode> homes = home ? home->items(axes.size()) : std::vector<YamlNode>{};
    for (std::size_t i = 0; i < axes.size(); ++i) {
      const Motion motion = read_motion(axes[i]);
      chain.passive(name + "." + to_string(motion), motion,
                    home ? homes[i].quantity(coordinate_dimension(motion), units) : 0);
    }
    return;
  }
  const Motion motion = read_motion(value);
  const auto read = [&](const char* name_of, double otherwise) {
    const auto given = node.find(name_of);
    return given ? given->quantity(coordinate_dimension(motion), units) : otherwise;
  };
  const double start = read("home", 0);
  if (const auto stiffness = node.find("stiffness")) {
    chain.passive(name, motion, read_stiffness(*stiffness, motion, units), read("rest", 0), start);
  } else if (const auto rest = node.find("rest")) {
    rest->fail("a rest value means nothing without a stiffness", "Add 'stiffness:' or remove it");
  } else {
    chain.passive(name, motion, start);
  }
}

void add_coupled(Chain& chain, const YamlNode& node) {
  node.allow_only({"to", "axis", "factor"});
  const auto factor = node.find("factor");
  chain.coupled(node.at("to").text(), read_motion(node.at("axis")),
                factor ? factor->number() : 1.0);
}

void add_link(Chain& chain, const YamlNode& node, const Parts& parts) {
  std::vector<std::string> names;
  for (const auto& [name, link] : parts.links) names.push_back(name);
  if (names.empty()) node.fail("this file defines no links", "Add 'links:'");
  std::string name = node.choice(names);
  // The same link twice in a chain: its springs need names of their own.
  std::string unique = name;
  const auto taken = [&chain](const std::string& candidate) {
    return std::any_of(chain.springs().begin(), chain.springs().end(), [&](const Spring& s) {
      return s.name == candidate || s.name.starts_with(candidate + ".");
    });
  };
  for (int i = 2; taken(unique); ++i) unique = fmt::format("{}#{}", name, i);
  parts.links.at(name).append_to(chain, unique);
}

void add_element(Chain& chain, const YamlNode& element, const Parts& parts) {
  const auto [kind, value] =
      element.one_of({"actuator", "passive", "coupled", "link", "offset", "tool"});
  element.allow_only({kind});
  try {
    if (kind == "actuator") add_actuator(chain, value, parts.units);
    if (kind == "passive") add_passive(chain, value, parts.units);
    if (kind == "coupled") add_coupled(chain, value);
    if (kind == "link") add_link(chain, value, parts);
    if (kind == "offset" || kind == "tool") chain.offset(files::read_pose(value, parts.units));
  } catch (const std::invalid_argument& error) {
    value.fail(error.what());
  }
}

Chain read_chain(const YamlNode& elements, const std::string& name, const Pose& base,
                 const Parts& parts) {
  Chain chain(name, base);
  for (const YamlNode& element : elements.items()) add_element(chain, element, parts);
  if (chain.size() == 0) elements.fail("the chain has neither a joint nor a flexible link");
  return chain;
}

YamlNode chain_type(const YamlNode& top, const YamlNode& name) {
  std::vector<std::string> names;
  for (const auto& [type, value] : top.at("chain_types").members()) names.push_back(type);
  return top.at("chain_types").at(name.choice(names));
}

Pose pose_or_identity(const YamlNode& node, const char* key, const UnitSystem& units) {
  const auto given = node.find(key);
  return given ? files::read_pose(*given, units) : Pose();
}

// Where the chain ends on the platform. Unless `platform` says otherwise, its last frame is
// parallel to its base frame when the platform is parallel to the robot's base.
Pose attachment(const YamlNode& node, const Pose& base, const UnitSystem& units) {
  if (node.has("platform") && node.has("platform_point"))
    node.fail("'platform' and 'platform_point' exclude each other", "Keep one");
  if (const auto pose = node.find("platform")) return files::read_pose(*pose, units);
  const auto point = node.find("platform_point");
  return Pose(base.rotation(), point ? point->vector3(dimension::length, units)
                                     : spatial::Vector3(spatial::Vector3::Zero()));
}

std::vector<Chain> read_chains(const YamlNode& top, const Parts& parts) {
  const YamlNode node = top.at("manipulator");
  node.allow_only({"chain", "base", "chains"});
  const auto [key, value] = node.one_of({"chain", "chains"});
  if (key == "chain") {
    const Pose base = pose_or_identity(node, "base", parts.units);
    return {read_chain(chain_type(top, value), value.text(), base, parts)};
  }
  if (node.has("base")) node.at("base").fail("with several chains each has its own base");
  std::vector<Chain> chains;
  for (const YamlNode& item : value.items()) {
    item.allow_only({"name", "type", "base", "platform", "platform_point"});
    const Pose base = pose_or_identity(item, "base", parts.units);
    chains.push_back(
        read_chain(chain_type(top, item.at("type")), item.at("name").text(), base, parts));
    chains.back().offset(attachment(item, base, parts.units).inverse());
  }
  if (chains.empty()) value.fail("at least one chain is expected");
  return chains;
}

// "leg" means the springs of that name (all its segments) in every chain, "x.leg" those in chain x.
UncertainStiffness find_springs(const Manipulator& manipulator, const YamlNode& node) {
  UncertainStiffness result{.name = node.text(), .springs = {}};
  std::vector<std::string> known;
  for (std::size_t c = 0; c < manipulator.size(); ++c) {
    const Chain& chain = manipulator.chains()[c];
    for (const Spring& spring : chain.springs()) {
      known.push_back(spring.name);
      known.push_back(chain.name() + "." + spring.name);
      for (const std::string& name : {spring.name, chain.name() + "." + spring.name})
        if (name == result.name || name.starts_with(result.name + ".")) {
          result.springs.push_back({c, spring.name});
          break;
        }
    }
  }
  if (result.springs.empty()) node.choice(known);
  return result;
}

std::vector<UncertainStiffness> read_uncertain(const YamlNode& top,
                                               const Manipulator& manipulator) {
  std::vector<UncertainStiffness> result;
  const auto list = top.find("uncertain");
  if (!list) return result;
  for (const YamlNode& item : list->items()) {
    item.allow_only({"stiffness"});
    result.push_back(find_springs(manipulator, item.at("stiffness")));
  }
  return result;
}

void refuse_effects(const YamlNode& top) {
  const auto effects = top.find("effects");
  if (effects && !(effects->is_sequence() && effects->items().empty()))
    effects->fail("this version of kinetostat knows no effects", "Leave 'effects: []'");
}

}  // namespace

Robot read_robot(const std::filesystem::path& file) {
  const YamlNode top = files::read_yaml(file);
  files::check_format_version(top);
  top.allow_only({"kinetostat", "name", "origin", "units", "materials", "links", "chain_types",
                  "manipulator", "uncertain", "effects"});
  refuse_effects(top);
  Parts parts{.units = files::read_units(top.at("units")), .links = {}};
  std::vector<std::filesystem::path> link_files;
  if (const auto links = top.find("links")) {
    for (const auto& [name, value] : links->members()) {
      const LinkModel link = read_link(value, parts.units, top.find("materials"));
      if (link.file) link_files.push_back(*link.file);
      parts.links.emplace(name, link);
    }
  }
  const std::string name = top.at("name").text();
  std::vector<Chain> chains = read_chains(top, parts);
  try {
    Manipulator manipulator(name, std::move(chains));
    std::vector<UncertainStiffness> uncertain = read_uncertain(top, manipulator);
    return {file, name, parts.units, std::move(manipulator), std::move(uncertain), link_files};
  } catch (const std::invalid_argument& error) {
    top.at("manipulator").fail(error.what());
  }
}

Manipulator with_scaled(const Manipulator& manipulator, const UncertainStiffness& parameter,
                        double factor) {
  Manipulator copy = manipulator;
  for (const SpringParameter& spring : parameter.springs)
    copy = copy.with_chain(spring.chain,
                           copy.chains()[spring.chain].with_scaled_spring(spring.spring, factor));
  return copy;
}

}  // namespace kinetostat::vjm
