#include "kinetostat/vjm/io/robot_file.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <map>
#include <memory>
#include <stdexcept>

#include <Eigen/Eigenvalues>
#include <fmt/format.h>

#include "kinetostat/common/error.h"
#include "kinetostat/common/spelling.h"
#include "kinetostat/io/text_file.h"
#include "kinetostat/io/yaml.h"
#include "kinetostat/spatial/rotation.h"
#include "kinetostat/vjm/chain/chain_builder.h"
#include "kinetostat/vjm/chain/chain_modifier.h"
#include "kinetostat/vjm/chain/stiffness_table.h"
#include "kinetostat/vjm/io/effect_file.h"
#include "kinetostat/vjm/io/elastic_body_entry.h"
#include "kinetostat/vjm/io/link_entry.h"
#include "kinetostat/vjm/io/machine_element_entry.h"
#include "kinetostat/vjm/io/uncertain_number.h"

namespace kinetostat::vjm {

struct RobotText {
  io::YamlNode top;
  LinkOptions options;
};

namespace {

using io::YamlNode;
using spatial::Pose;
using spatial::UnitSystem;
namespace dimension = spatial::dimension;

// What the elements of a chain refer to.
struct Parts {
  UnitSystem units;
  SourceList& sources;
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

// Of a joint of a chain that is being built.
struct StiffnessReader {
  const Parts& parts;
  Motion motion;
  std::string joint, chain;

  double operator()(const YamlNode& node) const {
    return read_uncertain(
        node, is_rotation(motion) ? dimension::torsional_stiffness : dimension::linear_stiffness,
        parts.units, stiffness_source(node, joint, chain), parts.sources);
  }
};

// `{at: [0, 200, 400], is: [80, 60, 45]}`: the stiffness at commands of the drive.
StiffnessTable read_stiffness_table(const YamlNode& node, const StiffnessReader& read) {
  node.allow_only({"at", "is"});
  const std::vector<YamlNode> places = node.at("at").items(), values = node.at("is").items();
  if (places.size() != values.size() || places.size() < 2)
    node.fail(fmt::format("{} places and {} values of stiffness", places.size(), values.size()),
              "Give two or more places and one value each: {at: [0, 200], is: [80 N/um, 60 N/um]}");
  std::vector<double> commands, stiffness;
  for (std::size_t i = 0; i < places.size(); ++i) {
    commands.push_back(places[i].quantity(coordinate_dimension(read.motion), read.parts.units));
    stiffness.push_back(read(values[i]));
    if (i > 0 && !(commands[i - 1] < commands[i]))
      places[i].fail("the places do not ascend", "Write them from the least to the largest");
  }
  return {std::move(commands), stiffness};
}

// `{ball_screw: {...}}`: of a drive that slides.
StiffnessTable read_screw(const YamlNode& node, const StiffnessReader& read) {
  node.allow_only({"ball_screw"});
  if (is_rotation(read.motion))
    node.fail("a ball screw has a stiffness along its axis, and this joint turns",
              "Write it as 'axis: Tx, Ty or Tz', or state 'stiffness' in N m/rad");
  return read_ball_screw(node.at("ball_screw"), read.parts.units, read.joint, read.parts.sources);
}

// A drive without a spring, with one, or with one that depends on its command.
void add_drive(ChainBuilder& chain, const YamlNode& node, const std::string& name, Motion motion,
               double home, const Parts& parts) {
  const auto given = node.find("stiffness");
  const StiffnessReader read{parts, motion, name, chain.so_far().name()};
  if (!given || !given->is_map() || is_uncertain(*given)) {
    std::optional<double> stiffness;
    if (given) stiffness = read(*given);
    chain.actuator(name, motion, stiffness, home);
    return;
  }
  const StiffnessTable table =
      given->has("ball_screw") ? read_screw(*given, read) : read_stiffness_table(*given, read);
  chain.actuator(name, motion, table.at(home), home);
  chain.law(name, std::make_shared<TabulatedStiffness>(table, home));
}

void add_actuator(ChainBuilder& chain, const YamlNode& node, const Parts& parts) {
  const UnitSystem& units = parts.units;
  node.allow_only({"name", "axis", "stiffness", "home", "range"});
  const Motion motion = read_motion(node.at("axis"));
  const auto home = node.find("home");
  add_drive(chain, node, node.at("name").text(), motion,
            home ? home->quantity(coordinate_dimension(motion), units) : 0, parts);
  if (const auto range = node.find("range")) {
    const std::vector<YamlNode> ends = range->items(2);
    const double least = ends[0].quantity(coordinate_dimension(motion), units),
                 largest = ends[1].quantity(coordinate_dimension(motion), units);
    if (!(least < largest))
      range->fail("needs the least value first",
                  "Write the least value first, as in range: [-90, 110]");
    chain.range(node.at("name").text(), least, largest);
  }
}

// `stops: {lower, upper, stiffness}`: contact springs beyond two values of the joint.
void add_stops(ChainBuilder& chain, const YamlNode& node, const StiffnessReader& read) {
  node.allow_only({"lower", "upper", "stiffness"});
  const auto bound = [&](const char* key, double otherwise) {
    const auto given = node.find(key);
    return given ? given->quantity(coordinate_dimension(read.motion), read.parts.units) : otherwise;
  };
  const double infinity = std::numeric_limits<double>::infinity();
  const double lower = bound("lower", -infinity), upper = bound("upper", infinity);
  chain.law(read.joint, std::make_shared<StopLaw>(lower, upper, read(node.at("stiffness"))));
}

// A joint with one axis may have a spring; with several, each coordinate is "name.axis".
void add_passive(ChainBuilder& chain, const YamlNode& node, const Parts& parts) {
  const UnitSystem& units = parts.units;
  node.allow_only({"name", "axis", "axes", "stiffness", "rest", "home", "stops"});
  const std::string name = node.at("name").text();
  const auto [key, value] = node.one_of({"axis", "axes"});
  const auto home = node.find("home");
  if (key == "axes") {
    for (const char* single : {"stiffness", "rest", "stops"})
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
  const StiffnessReader spring{parts, motion, name, chain.so_far().name()};
  const auto stops = node.find("stops");
  if (const auto stiffness = node.find("stiffness")) {
    chain.passive(name, motion, spring(*stiffness), read("rest", 0), start);
  } else if (const auto rest = node.find("rest")) {
    rest->fail("a rest value means nothing without a stiffness", "Add 'stiffness:' or remove it");
  } else {
    chain.passive(name, motion, start);
  }
  if (stops) add_stops(chain, *stops, spring);
}

// A length per angle, as `factor`, or the other way round. "5 mm" may be meant per turn or per
// radian, so that the angle must be named.
double read_pitch_factor(const YamlNode& node, const spatial::Dimension& dimension) {
  const char* cure = dimension.length > 0 ? "Write 'lead: 5 mm' per turn, 'radius: 20 mm' of a "
                                            "pinion, or a factor such as '5 mm/turn'"
                                          : "Write 'lead: 5 mm' per turn, 'radius: 20 mm' of a "
                                            "pinion, or a factor such as '72 deg/mm'";
  const std::string text = node.text();
  char* unit = nullptr;
  (void)std::strtod(text.c_str(), &unit);
  try {
    if (*unit != '\0' && spatial::parse_unit(unit).dimension == dimension)
      return node.quantity_with_unit(dimension);
  } catch (const std::invalid_argument&) {  // said below
  }
  node.fail("one turns and the other slides: the factor needs a unit of length and angle", cure);
}

// A plain length: "5 mm/turn" is none, though angles count as numbers elsewhere.
double read_plain_length(const YamlNode& node, const UnitSystem& units) {
  if (node.text().find('/') != std::string::npos)
    node.fail("a length is expected", "Write '5 mm', or 'factor: 5 mm/turn'");
  return node.quantity(dimension::length, units);
}

// What a joint that slides moves per radian of one that turns [m/rad], or the inverse. Negative:
// against its axis, as with a left-handed thread.
double read_pitch(const YamlNode& node, bool slides, const UnitSystem& units) {
  const auto [key, value] = node.one_of({"factor", "lead", "radius"});
  if (key == "factor") {
    const spatial::Dimension per_angle{.length = 1, .angle = -1};
    const double factor =
        read_pitch_factor(value, slides ? per_angle : dimension::none / per_angle);
    if (factor == 0) value.fail("it must not be zero");
    return factor;
  }
  const double length = read_plain_length(value, units);
  if (length == 0) value.fail("it must not be zero");
  const double pitch = key == "lead" ? length / (2 * M_PI) : length;
  return slides ? pitch : 1 / pitch;
}

void add_coupled(ChainBuilder& chain, const YamlNode& node, const UnitSystem& units) {
  node.allow_only({"to", "axis", "factor", "lead", "radius"});
  const std::string joint = node.at("to").text();
  const Motion motion = read_motion(node.at("axis"));
  const Motion leading =
      chain.so_far().coordinates()[static_cast<std::size_t>(chain.so_far().index_of(joint))].motion;
  if (is_rotation(leading) != is_rotation(motion)) {
    chain.coupled(joint, motion, read_pitch(node, !is_rotation(motion), units));
    return;
  }
  for (const char* key : {"lead", "radius"})
    if (const auto given = node.find(key))
      given->fail(
          fmt::format("'{}' and this joint both {}", joint, is_rotation(motion) ? "turn" : "slide"),
          "Write 'factor:' with a plain number");
  const auto factor = node.find("factor");
  chain.coupled(joint, motion, factor ? factor->number() : 1.0);
}

// Returns the name of the link in the chain: where it is used again, "name#2" and so on.
std::string add_link(ChainBuilder& chain, const YamlNode& node, const Parts& parts,
                     const std::vector<std::string>& before) {
  std::vector<std::string> names;
  for (const auto& [name, link] : parts.links) names.push_back(name);
  if (names.empty()) node.fail("this file defines no links", "Add 'links:'");
  const std::string name = node.choice(names);
  std::string unique = name;
  const auto taken = [&](const std::string& candidate) {
    return std::find(before.begin(), before.end(), candidate) != before.end() ||
           std::any_of(chain.so_far().springs().begin(), chain.so_far().springs().end(),
                       [&](const Spring& s) {
                         return s.name == candidate || s.name.starts_with(candidate + ".");
                       });
  };
  for (int i = 2; taken(unique); ++i) unique = fmt::format("{}#{}", name, i);
  parts.links.at(name).append_to(chain, unique);
  return unique;
}

void add_mass(ChainBuilder& chain, const YamlNode& node, const Parts& parts) {
  node.allow_only({"name", "mass", "at", "inertia"});
  const auto at = node.find("at"), inertia = node.find("inertia");
  const UnitSystem& units = parts.units;
  const std::string name = node.at("name").text();
  chain.mass(
      name,
      read_uncertain(node.at("mass"), dimension::mass, units,
                     {.name = "mass of " + name, .place = {}, .kind = SourceKind::mass},
                     parts.sources),
      at ? at->vector3(dimension::length, units) : spatial::Vector3(spatial::Vector3::Zero()), {},
      inertia ? read_inertia(*inertia, units) : spatial::Matrix3(spatial::Matrix3::Zero()));
}

void add_node(ChainBuilder& chain, const YamlNode& node, const UnitSystem& units) {
  node.allow_only({"name", "at"});
  const auto at = node.find("at");
  chain.node(node.at("name").text(), at ? at->vector3(dimension::length, units)
                                        : spatial::Vector3(spatial::Vector3::Zero()));
}

// Returns the name by which an error can be placed after the element; empty where it has none.
// `links`: the names of those before it, to which a link is added.
std::string add_element(ChainBuilder& chain, const YamlNode& element, const Parts& parts,
                        std::vector<std::string>& links) {
  const auto [kind, value] =
      element.one_of({"actuator", "passive", "coupled", "link", "offset", "tool", "mass", "node"});
  element.allow_only({kind});
  try {
    if (kind == "actuator") add_actuator(chain, value, parts);
    if (kind == "passive") add_passive(chain, value, parts);
    if (kind == "coupled") add_coupled(chain, value, parts.units);
    if (kind == "link") return links.emplace_back(add_link(chain, value, parts, links));
    if (kind == "mass") add_mass(chain, value, parts);
    if (kind == "node") add_node(chain, value, parts.units);
    if (kind == "offset" || kind == "tool") chain.offset(io::read_pose(value, parts.units));
  } catch (const std::invalid_argument& error) {
    value.fail(error.what());
  }
  const bool has_name = kind == "actuator" || kind == "passive" || kind == "mass" || kind == "node";
  return has_name ? value.at("name").text() : "";
}

// Of a list that may be left out.
std::vector<YamlNode> items_of(const YamlNode& node, const char* key) {
  const auto list = node.find(key);
  return list ? list->items() : std::vector<YamlNode>();
}

// A geometric error of one chain: after the element `at` ("base", "end", or the name of a joint,
// link, mass or node).
struct ChainError {
  YamlNode at;
  Pose pose;
};

std::vector<ChainError> read_errors(const YamlNode& chain, const UnitSystem& units) {
  std::vector<ChainError> errors;
  for (const YamlNode& item : items_of(chain, "errors")) {
    item.allow_only({"at", "point", "rotation_vector"});
    spatial::Vector6 displacement = spatial::Vector6::Zero();
    if (const auto point = item.find("point"))
      displacement.head<3>() = point->vector3(dimension::length, units);
    if (const auto turn = item.find("rotation_vector"))
      displacement.tail<3>() = turn->vector3(dimension::angle, units);
    errors.push_back({item.at("at"), spatial::displaced(Pose(), displacement)});
  }
  return errors;
}

// With its errors, up to where it ends.
Chain read_chain(const YamlNode& elements, const std::string& name, const Pose& base,
                 const std::vector<ChainError>& errors, const Parts& parts) {
  ChainBuilder chain(name, base);
  std::vector<std::string> places, links;
  const auto pass = [&](const std::string& place) {
    places.push_back(place);
    for (const ChainError& error : errors)
      if (error.at.text() == place) chain.error(error.pose);
  };
  pass("base");
  for (const YamlNode& element : elements.items())
    if (const std::string place = add_element(chain, element, parts, links); !place.empty())
      pass(place);
  if (chain.so_far().size() == 0)
    elements.fail("the chain has neither a joint nor a flexible link");
  pass("end");
  for (const ChainError& error : errors) error.at.choice(places);
  return chain.build();
}

YamlNode chain_type(const YamlNode& top, const YamlNode& name) {
  std::vector<std::string> names;
  for (const auto& [type, value] : top.at("chain_types").members()) names.push_back(type);
  return top.at("chain_types").at(name.choice(names));
}

Pose pose_or_identity(const YamlNode& node, const char* key, const UnitSystem& units) {
  const auto given = node.find(key);
  return given ? io::read_pose(*given, units) : Pose();
}

// Copies of a chain, each turned by the next multiple of an angle about an axis through the origin.
struct PatternOfChains {
  std::vector<std::string> names;
  spatial::Vector3 axis = spatial::Vector3::UnitZ();
  double angle = 0;
};

// `pattern: {count: 3, axis: [0, 0, 1], angle: 120 deg, names: [..]}`; the angle divides the full
// turn evenly unless given, the names are "leg1", "leg2", ... unless given.
PatternOfChains read_pattern(const std::optional<YamlNode>& node, const std::string& name,
                             const UnitSystem& units) {
  PatternOfChains pattern;
  if (!node) {
    pattern.names = {name};
    return pattern;
  }
  node->allow_only({"count", "axis", "angle", "names"});
  const int count = node->at("count").integer(2, 1000);
  if (const auto axis = node->find("axis")) pattern.axis = axis->direction();
  const auto angle = node->find("angle");
  pattern.angle = angle ? angle->quantity(dimension::angle, units) : 2 * M_PI / count;
  if (const auto names = node->find("names")) {
    for (const YamlNode& item : names->items(static_cast<std::size_t>(count)))
      pattern.names.push_back(item.text());
    return pattern;
  }
  for (int i = 1; i <= count; ++i) pattern.names.push_back(fmt::format("{}{}", name, i));
  return pattern;
}

// Where the chain ends on the platform. Unless `platform` says otherwise, its last frame is
// parallel to its base frame when the platform is parallel to the robot's base.
Pose attachment(const YamlNode& node, const Pose& base, const UnitSystem& units) {
  if (node.has("platform") && node.has("platform_point"))
    node.fail("'platform' and 'platform_point' exclude each other", "Keep one");
  if (const auto pose = node.find("platform")) return io::read_pose(*pose, units);
  const auto point = node.find("platform_point");
  return Pose(base.rotation(), point ? point->vector3(dimension::length, units)
                                     : spatial::Vector3(spatial::Vector3::Zero()));
}

// The chains of a file with the bodies that they join.
struct Assembly {
  std::vector<Chain> chains;
  std::vector<Span> spans;
  FileBodies bodies;
  std::vector<ElasticBody> elastic_bodies;
};

// One chain, or as many turned copies as its pattern asks for.
void add_chain(const YamlNode& top, const YamlNode& item, const Parts& parts, Assembly& assembly) {
  item.allow_only(
      {"name", "type", "base", "platform", "platform_point", "from", "to", "errors", "pattern"});
  const YamlNode elements = chain_type(top, item.at("type"));
  const BodyPlace from = place_of(item, "from", {Span::base}, assembly.bodies),
                  to = place_of(item, "to", {Span::platform}, assembly.bodies);
  const Span span{from.body, to.body};
  const Pose base = pose_or_identity(item, "base", parts.units);
  const Pose end = attachment(item, base, parts.units);
  const std::vector<ChainError> errors = read_errors(item, parts.units);
  const std::string name = item.at("name").text();
  const auto pattern = item.find("pattern");
  const PatternOfChains copies = read_pattern(pattern, name, parts.units);
  if (pattern && (span.from != Span::base || span.to != Span::platform))
    pattern->fail("a pattern repeats chains from the base to the platform");
  for (std::size_t i = 0; i < copies.names.size(); ++i) {
    const Pose turn =
        Pose::rotation(spatial::exp_rotation(static_cast<double>(i) * copies.angle * copies.axis));
    ChainBuilder chain(
        read_chain(elements, copies.names[i], turn * from.axes * base, errors, parts));
    // The platform turns with the base: its axes are the base's when it is at rest.
    chain.attach((turn * to.axes * end).inverse());
    assembly.chains.push_back(chain.build());
    assembly.spans.push_back(span);
  }
}

Assembly read_assembly(const YamlNode& top, const Parts& parts) {
  const YamlNode node = top.at("manipulator");
  node.allow_only({"chain", "base", "chains", "bodies", "errors"});
  const auto [key, value] = node.one_of({"chain", "chains"});
  Assembly assembly;
  if (key == "chain") {
    if (node.has("bodies")) node.at("bodies").fail("a single chain has no inner bodies");
    const Pose base = pose_or_identity(node, "base", parts.units);
    const YamlNode elements = chain_type(top, value);
    const std::vector<ChainError> errors = read_errors(node, parts.units);
    assembly.chains.push_back(read_chain(elements, value.text(), base, errors, parts));
    assembly.spans.push_back({});
    return assembly;
  }
  for (const char* single : {"base", "errors"})
    if (const auto given = node.find(single))
      given->fail(fmt::format("with several chains each has its own {}", single));
  assembly.bodies = read_bodies(node.find("bodies"), parts.units, parts.sources);
  for (const YamlNode& item : value.items()) add_chain(top, item, parts, assembly);
  if (assembly.chains.empty()) value.fail("at least one chain is expected");
  assembly.elastic_bodies = add_elastic_bodies(assembly.bodies, assembly.chains, assembly.spans);
  return assembly;
}

// `gravity: {direction: [0, 0, -1], acceleration: 9.80665 m/s^2}`.
spatial::Vector3 read_gravity(const YamlNode& top) {
  const auto node = top.find("gravity");
  if (!node) return spatial::Vector3::Zero();
  node->allow_only({"direction", "acceleration"});
  const auto acceleration = node->find("acceleration");
  constexpr spatial::Dimension per_second_squared{.length = 1, .time = -2};
  return (acceleration ? acceleration->quantity_with_unit(per_second_squared) : 9.80665) *
         node->at("direction").direction();
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
  for (const ElasticBody& body : manipulator.elastic_bodies())
    if (body.name == result.name)
      node.fail(
          fmt::format("'{}' is an elastic body, whose stiffness is taken as it is", body.name),
          "Name a joint or a link of a chain");
  if (result.springs.empty()) node.choice(known);
  return result;
}

// `between: [0.5, 2]`: two positive numbers, ascending.
std::pair<double, double> read_factors(const YamlNode& node) {
  const std::vector<YamlNode> items = node.items(2);
  const double lower = items[0].number(), upper = items[1].number();
  if (!(lower > 0 && lower < upper))
    node.fail(fmt::format("{:.6g} to {:.6g} is no range of a factor", lower, upper),
              "Write the smallest and the largest factor on the stiffness: [0.5, 2]");
  return {lower, upper};
}

// By what `fitted:` has multiplied a spring.
double factor_on(const SpringParameter& spring, const std::vector<FittedStiffness>& fitted) {
  double factor = 1;
  for (const FittedStiffness& f : fitted)
    if (std::find(f.springs.begin(), f.springs.end(), spring) != f.springs.end())
      factor *= f.factor;
  return factor;
}

std::vector<UncertainStiffness> read_uncertain(const YamlNode& top, const Manipulator& manipulator,
                                               const std::vector<FittedStiffness>& fitted) {
  std::vector<UncertainStiffness> result;
  for (const YamlNode& item : items_of(top, "uncertain")) {
    if (item.has("effect")) continue;
    item.allow_only({"stiffness", "between"});
    UncertainStiffness found = find_springs(manipulator, item.at("stiffness"));
    for (const UncertainStiffness& other : result)
      if (other.springs == found.springs)
        item.at("stiffness")
            .fail(fmt::format("names what '{}' names already", other.name), "List it once");
    if (const auto between = item.find("between")) {
      const double factor = factor_on(found.springs.front(), fitted);
      const auto [lower, upper] = read_factors(*between);
      found.between = {lower / factor, upper / factor};
    }
    result.push_back(std::move(found));
  }
  return result;
}

// `{effect: hardening, at: x.rho, parameter: k3}`: a value of an effect that the file has.
UncertainValue find_value(const YamlNode& item, const std::vector<Effect>& effects) {
  std::vector<std::string> kinds, places, names;
  for (const Effect& effect : effects) kinds.push_back(effect.kind->name);
  if (kinds.empty())
    item.at("effect").fail("this file has no effects", "List it under 'effects:', with a value");
  const std::string kind = item.at("effect").choice(kinds);
  for (const Effect& effect : effects)
    if (effect.kind->name == kind) places.push_back(effect.at);
  const std::string at = item.at("at").choice(places);
  const auto found = std::find_if(effects.begin(), effects.end(), [&](const Effect& effect) {
    return effect.kind->name == kind && effect.at == at;
  });
  for (const EffectParameter& parameter : found->kind->parameters) names.push_back(parameter.name);
  const std::string name = item.at("parameter").choice(names);
  return {static_cast<std::size_t>(found - effects.begin()),
          std::find(names.begin(), names.end(), name) - names.begin()};
}

std::vector<UncertainValue> read_uncertain_values(const YamlNode& top,
                                                  const std::vector<Effect>& effects) {
  std::vector<UncertainValue> result;
  for (const YamlNode& item : items_of(top, "uncertain"))
    if (item.has("effect")) {
      item.allow_only({"effect", "at", "parameter"});
      result.push_back(find_value(item, effects));
    }
  return result;
}

// Of several factors on one stiffness the last with a standard deviation says what is known of all.
void meet_factors(const std::filesystem::path& file, SourceList& sources,
                  std::vector<FittedStiffness>& fitted) {
  for (auto f = fitted.begin(); f != fitted.end(); ++f) {
    const auto says_more = [&](const FittedStiffness& other) {
      return other.name == f->name && other.deviation > 0;
    };
    if (!(f->deviation > 0) || std::any_of(f + 1, fitted.end(), says_more)) continue;
    const std::string name = fitted_source(f->name);
    const UncertaintySource source{.name = name,
                                   .place = file.string() + ": " + name,
                                   .kind = SourceKind::fitted,
                                   .spread = Spread::log_normal,
                                   .value = f->factor,
                                   .estimate = f->factor,
                                   .deviation = f->deviation};
    f->factor = sources.meet(source).value_or(f->factor);
  }
}

// `{stiffness: q1, factor: 0.87}`, or `factor: {value: 0.87, sd: 0.004}`.
std::vector<FittedStiffness> read_fitted(const YamlNode& top, const Manipulator& manipulator,
                                         SourceList& sources) {
  std::vector<FittedStiffness> result;
  for (const YamlNode& item : items_of(top, "fitted")) {
    if (item.has("effect")) continue;
    item.allow_only({"stiffness", "factor"});
    const UncertainStiffness springs = find_springs(manipulator, item.at("stiffness"));
    const YamlNode given = item.at("factor");
    if (given.is_map()) given.allow_only({"value", "sd"});
    const YamlNode value = given.is_map() ? given.at("value") : given;
    FittedStiffness& fitted =
        result.emplace_back(FittedStiffness{springs.name, springs.springs, value.number()});
    if (!(fitted.factor > 0)) value.fail("a factor on a stiffness must be positive");
    if (const auto sd = given.is_map() ? given.find("sd") : std::nullopt) {
      fitted.deviation = sd->number();
      if (!(fitted.deviation >= 0)) sd->fail("a standard deviation must not be negative");
    }
  }
  meet_factors(top.file(), sources, result);
  return result;
}

// `{effect: hardening, at: x.rho, parameter: k3, value: ...}`: in the place of what the effect has.
void take_fitted_values(const YamlNode& top, const Manipulator& bare,
                        const spatial::UnitSystem& units, std::vector<Effect>& effects) {
  for (const YamlNode& item : items_of(top, "fitted")) {
    if (!item.has("effect")) continue;
    item.allow_only({"effect", "at", "parameter", "value"});
    const UncertainValue place = find_value(item, effects);
    read_effect_value(item.at("value"), units, bare, place.value, effects[place.effect]);
  }
}

// With these springs as the file of a robot has them, without any factor.
Manipulator with_springs_of(Manipulator manipulator, const std::vector<SpringParameter>& springs,
                            const Robot& nominal) {
  for (const SpringParameter& spring : springs) {
    ChainModifier chain(manipulator.chains()[spring.chain]);
    chain.take_spring(spring.spring, nominal.without_effects().chains()[spring.chain]);
    chain.scale_spring(spring.spring, 1 / factor_on(spring, nominal.fitted));
    manipulator = manipulator.with_chain(spring.chain, std::move(chain).chain());
  }
  return manipulator;
}

// The values of effects that have a standard deviation are sources, too.
void meet_values(const std::filesystem::path& file, SourceList& sources,
                 std::vector<Effect>& effects) {
  for (std::size_t e = 0; e < effects.size(); ++e) {
    Effect& effect = effects[e];
    if (!effect.kind->acts_on_chains()) continue;
    for (Eigen::Index k = 0; k < effect.values.size(); ++k) {
      if (!(effect.deviations[k] > 0)) continue;
      const EffectParameter& parameter = effect.kind->parameters[static_cast<std::size_t>(k)];
      const UncertaintySource source{
          .name = effect.name_of(k),
          .place = fmt::format("{}: effects[{}].{}", file.string(), e, parameter.name),
          .kind = SourceKind::effect,
          .value = effect.values[k],
          .estimate = effect.values[k],
          .deviation = effect.deviations[k],
          .lower = parameter.lower,
          .upper = parameter.upper};
      effect.values[k] = sources.meet(source).value_or(effect.values[k]);
    }
  }
}

// `nominal`: the robot of the file, when sources have other values than there. What readings have
// determined is the product of a factor and the spring that the file leads to.
Manipulator with_fitted(Manipulator manipulator, const std::vector<FittedStiffness>& fitted,
                        const Robot* nominal) {
  if (nominal != nullptr)
    for (const FittedStiffness& f : nominal->fitted)
      if (f.deviation > 0) manipulator = with_springs_of(manipulator, f.springs, *nominal);
  for (const FittedStiffness& f : fitted)
    manipulator = with_scaled(manipulator, {f.name, f.springs}, f.factor);
  return manipulator;
}

}  // namespace

std::string fitted_source(const std::string& stiffness) {
  return "fitted stiffness of " + stiffness;
}

EffectKinds Robot::kinds() const {
  EffectKinds all = effect_kinds();
  all.insert(all.end(), own_kinds.begin(), own_kinds.end());
  return all;
}

namespace {

std::size_t find_source(const YamlNode& node, const std::string& name,
                        const std::vector<UncertaintySource>& sources) {
  std::vector<std::string> names;
  names.reserve(sources.size());
  for (const UncertaintySource& source : sources) names.push_back(source.name);
  const auto count = std::count(names.begin(), names.end(), name);
  if (count > 1) node.fail(fmt::format("'{}' stands for several numbers of this file", name));
  if (count == 0) {
    const std::string near = common::nearest_spelling(name, names);
    node.fail(fmt::format("'{}' is no uncertain number of this file", name),
              near.empty() ? "Name two numbers with an 'sd' or a 'plus_minus', as 'stiffness' does "
                             "in the budget of its result"
                           : fmt::format("Did you mean '{}'?", near));
  }
  return static_cast<std::size_t>(std::find(names.begin(), names.end(), name) - names.begin());
}

// `{of: fitted stiffness of q1, with: {fitted stiffness of q2: -0.4}}`.
void read_correlations_of(const YamlNode& item, const std::vector<UncertaintySource>& sources,
                          Eigen::MatrixXd& correlation) {
  item.allow_only({"of", "with"});
  const YamlNode of = item.at("of");
  const auto i = static_cast<Eigen::Index>(find_source(of, of.text(), sources));
  for (const auto& [name, node] : item.at("with").members()) {
    const auto j = static_cast<Eigen::Index>(find_source(node, name, sources));
    const double value = node.number();
    if (i == j) node.fail("a number is not correlated with itself");
    if (!(std::abs(value) <= 1)) node.fail("a correlation is between -1 and 1");
    correlation(i, j) = correlation(j, i) = value;
  }
}

Eigen::MatrixXd read_correlations(const YamlNode& top,
                                  const std::vector<UncertaintySource>& sources) {
  const auto count = static_cast<Eigen::Index>(sources.size());
  Eigen::MatrixXd correlation = Eigen::MatrixXd::Identity(count, count);
  const auto list = top.find("correlations");
  if (!list) return correlation;
  for (const YamlNode& item : list->items()) read_correlations_of(item, sources, correlation);
  const double rounding = 1e-3 * static_cast<double>(count);  // what three digits of each may do
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(correlation, Eigen::EigenvaluesOnly);
  if (count > 0 && eigen.eigenvalues()[0] < -rounding)
    list->fail(
        "together these correlations are impossible: their matrix is not positive semidefinite");
  return correlation;
}

// All links of the file, by name.
struct Links {
  std::map<std::string, LinkModel> models;
  std::vector<std::filesystem::path> files;  // that they were read from
  bool has_beams = false;
};

Links read_links(const YamlNode& top, const UnitSystem& units, const LinkOptions& options) {
  const ReadManipulator read_manipulator = [](const std::filesystem::path& part,
                                              const LinkOptions& part_options) {
    return read_robot(part, part_options).manipulator;
  };
  Links result;
  const auto links = top.find("links");
  if (!links) return result;
  for (const auto& [name, value] : links->members()) {
    const LinkModel link =
        read_link(value, units, top.find("materials"), options, read_manipulator);
    result.has_beams |= value.find("beam").has_value();
    if (link.file) result.files.push_back(*link.file);
    result.models.emplace(name, link);
  }
  return result;
}

// What stands in the file beside the chains, and changes them.
void add_fitted_and_effects(const YamlNode& top, const Manipulator& bare, SourceList& sources,
                            const Robot* nominal, const EffectKinds& given, Robot& robot) {
  robot.fitted = read_fitted(top, bare, sources);
  const Manipulator plain =
      with_fitted(bare, robot.fitted, nominal).with_gravity(read_gravity(top));
  robot.own_kinds = read_effect_kinds(top, given);
  robot.effects = read_effects(top, robot.kinds(), plain, robot.units);
  take_fitted_values(top, plain, robot.units, robot.effects);
  meet_values(robot.file, sources, robot.effects);
  robot.manipulator = with_effects(plain, robot.effects);
  robot.uncertain = read_uncertain(top, plain, robot.fitted);
  if (!robot.effects.empty()) robot.bare = plain;
  robot.uncertain_values = read_uncertain_values(top, robot.effects);
}

LinkOptions options_within(const std::filesystem::path& file, LinkOptions options) {
  std::error_code error;
  options.within.push_back(std::filesystem::weakly_canonical(file, error));
  if (error)
    throw common::InputError(file, "is a pipe, and a robot file is read more than once",
                             "Save it to a file and name that");
  return options;
}

Robot robot_of(const YamlNode& top, const std::filesystem::path& file, const LinkOptions& options,
               const Robot* nominal = nullptr) {
  io::check_format_version(top);
  top.allow_only({"kinetostat", "name", "origin", "units", "gravity", "materials", "links",
                  "chain_types", "manipulator", "uncertain", "fitted", "correlations", "effects",
                  "effect_kinds"});
  SourceList own;
  LinkOptions link_options = options_within(file, options);
  if (link_options.sources == nullptr) link_options.sources = &own;
  SourceList& sources = *link_options.sources;
  Parts parts{.units = io::read_units(top.at("units")), .sources = sources, .links = {}};
  Links links = read_links(top, parts.units, link_options);
  parts.links = std::move(links.models);
  const std::string name = top.at("name").text();
  Assembly assembly = read_assembly(top, parts);
  try {
    const Manipulator bare = Manipulator(name, std::move(assembly.chains),
                                         std::move(assembly.spans), assembly.bodies.inner)
                                 .with_elastic_bodies(std::move(assembly.elastic_bodies));
    for (const ElasticBodyEntry& body : assembly.bodies.elastic) links.files.push_back(body.file);
    Robot robot{.file = file,
                .name = name,
                .units = parts.units,
                .manipulator = bare,
                .uncertain = {},
                .link_files = std::move(links.files),
                .has_beams = links.has_beams};
    add_fitted_and_effects(top, bare, sources, nominal, options.kinds, robot);
    robot.sources = sources.sources();
    robot.correlation = read_correlations(top, robot.sources);
    robot.text = std::make_shared<const RobotText>(RobotText{top, options});
    return robot;
  } catch (const std::invalid_argument& fault) {
    top.at("manipulator").fail(fault.what());
  }
}

}  // namespace

Robot read_robot(const std::filesystem::path& file, const LinkOptions& options) {
  return robot_of(io::read_yaml(file), file, options);
}

Robot parse_robot(const std::string& text, const std::filesystem::path& file,
                  const LinkOptions& options) {
  Robot robot = robot_of(io::parse_yaml(text, file), file, options);
  robot.sha256 = io::sha256(text);
  return robot;
}

Robot with_values(const Robot& robot, const Eigen::VectorXd& values) {
  if (values.size() != static_cast<Eigen::Index>(robot.sources.size()) || !robot.text)
    throw std::invalid_argument("one value for each source of uncertainty is expected");
  SourceList sources(robot.sources, values);
  LinkOptions options = robot.text->options;
  options.sources = &sources;
  Robot other = robot_of(robot.text->top, robot.file, options, &robot);
  other.text = {};
  return other;
}

Manipulator with_scaled(const Manipulator& manipulator, const UncertainStiffness& parameter,
                        double factor) {
  Manipulator copy = manipulator;
  for (const SpringParameter& spring : parameter.springs) {
    ChainModifier chain(copy.chains()[spring.chain]);
    chain.scale_spring(spring.spring, factor);
    copy = copy.with_chain(spring.chain, std::move(chain).chain());
  }
  return copy;
}

}  // namespace kinetostat::vjm
