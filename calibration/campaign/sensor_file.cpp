#include "kinetostat/calibration/campaign/sensor_file.h"

#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "kinetostat/calibration/campaign/column_names.h"
#include "kinetostat/calibration/sensors/sensor_places.h"
#include "kinetostat/common/spelling.h"

namespace kinetostat::calibration {
namespace {

using Eigen::Index;
using io::YamlNode;
using spatial::Dimension;
using spatial::Matrix3;
using spatial::Pose;
using spatial::Vector3;
namespace dimension = spatial::dimension;

// A kind as it is written, with what it may say and what it reads.
struct Word {
  const char* name;
  SensorKind kind;
  std::vector<std::string> keys;  // beside kind, noise and datum_noise
  std::vector<Index> axes;        // in the order of component_names
};

const std::vector<Word>& words() {
  static const std::vector<Word> all = {
      {"gauge", SensorKind::pose, {"on", "at", "from", "in", "direction", "minus"}, {0}},
      {"position",
       SensorKind::pose,
       {"on", "at", "from", "in", "axes", "minus", "target_pose"},
       {0, 1, 2}},
      {"rotation",
       SensorKind::pose,
       {"on", "at", "from", "in", "axes", "minus", "target_pose"},
       {3, 4, 5}},
      {"pose",
       SensorKind::pose,
       {"on", "at", "from", "in", "minus", "target_pose"},
       {0, 1, 2, 3, 4, 5}},
      {"tilt", SensorKind::tilt, {"on", "at", "axes", "minus"}, {0, 1}},
      {"distance", SensorKind::distance, {"on", "at", "from"}, {0}},
      {"joint", SensorKind::joint, {"joint"}, {0}},
      {"torque", SensorKind::torque, {"joint"}, {0}}};
  return all;
}

// Axes with x along a direction.
Matrix3 axes_along(const Vector3& direction) {
  Index least = 0;
  direction.cwiseAbs().minCoeff(&least);
  Matrix3 axes;
  axes.col(0) = direction;
  axes.col(1) = direction.cross(Vector3::Unit(least)).normalized();
  axes.col(2) = direction.cross(axes.col(1));
  return axes;
}

// The parts of a robot by the names that a file may give them: "arm.elbow", "elbow". A body wins.
std::map<std::string, std::vector<vjm::CarriedFrame>> places_of(const vjm::Manipulator& robot) {
  std::map<std::string, std::vector<vjm::CarriedFrame>> places;
  places["base"].push_back({});
  for (const SensorPlace& place : sensor_places(robot)) {
    places[place.name] = {place.frame};
    if (!place.frame.chain || place.frame.place == "base") continue;
    auto& alone = places[place.frame.place];
    if (alone.empty() || alone[0].chain) alone.push_back(place.frame);
  }
  return places;
}

// A name that the file gives to a column of its own.
void check_name(const std::string& name, const YamlNode& node, const std::vector<Joint>& joints,
                const Campaign& campaign) {
  const bool is_joint = std::any_of(joints.begin(), joints.end(), [&](const Joint& joint) {
    return joint.name == name || joint.alone == name;
  });
  const bool is_sensor = std::any_of(campaign.sensors.begin(), campaign.sensors.end(),
                                     [&](const Sensor& sensor) { return sensor.name == name; });
  if (is_joint || is_sensor || is_reserved(name) || name == "covariate" || name == "ignore")
    node.fail(fmt::format("a column '{}' means something else already", name),
              "Give it another name");
  if (name.empty() || name.find_first_of("[]()/,; \t") != std::string::npos)
    node.fail(fmt::format("'{}' cannot be the name of a column", name),
              "Use letters, digits, '_' and '-'");
}

vjm::CarriedFrame read_place(const YamlNode& node, const vjm::Manipulator& robot,
                             const Campaign& campaign) {
  const auto places = places_of(robot);
  const YamlNode on = node.at("on");
  std::vector<std::string> names;
  names.reserve(places.size());
  for (const auto& [name, frames] : places) names.push_back(name);
  const std::string name = on.choice(names);
  const auto& frames = places.at(name);
  if (frames.size() > 1)
    on.fail(fmt::format("'{}' is on several chains", name),
            fmt::format("Write {}.{}", robot.chains()[*frames[0].chain].name(), name));
  vjm::CarriedFrame frame = frames[0];
  if (const auto at = node.find("at")) frame.pose = io::read_pose(*at, campaign.units);
  return frame;
}

// `base`, `arm.elbow`, or `{on: arm.elbow, at: [x, y, z]}`.
vjm::CarriedFrame read_end(const YamlNode& node, const vjm::Manipulator& robot,
                           const Campaign& campaign) {
  if (node.is_scalar()) {
    const auto places = places_of(robot);
    const auto found = places.find(node.text());
    if (found != places.end() && found->second.size() == 1) return found->second[0];
    std::vector<std::string> names;
    for (const auto& [name, frames] : places)
      if (frames.size() == 1) names.push_back(name);
    return places.at(node.choice(names))[0];
  }
  node.allow_only({"on", "at"});
  return read_place(node, robot, campaign);
}

struct SpringyJoint {
  vjm::WatchedJoint place;
  bool turns = false;
};

// By its name, where it has a spring; passive ones need none if no torque is in them.
SpringyJoint find_joint(const YamlNode& node, const vjm::Manipulator& robot,
                        const std::vector<Joint>& joints, bool torque) {
  std::vector<std::string> names;
  for (const Joint& joint : joints) {
    names.push_back(joint.name);
    if (joint.alone != joint.name) names.push_back(joint.alone);
  }
  const std::string name = node.choice(names);
  const Joint& joint = *std::find_if(joints.begin(), joints.end(), [&](const Joint& j) {
    return j.name == name || j.alone == name;
  });
  const std::string chain = joint.name.substr(0, joint.name.find('.'));
  vjm::WatchedJoint watched;
  while (robot.chains()[watched.chain].name() != chain) ++watched.chain;
  const vjm::Chain& of = robot.chains()[watched.chain];
  watched.coordinate = of.index_of(joint.name.substr(chain.size() + 1));
  if (!(of.stiffness()(watched.coordinate, watched.coordinate) > 0) && (joint.actuated || torque))
    node.fail(fmt::format("the joint '{}' has no spring: {}", name,
                          joint.actuated ? "it stands where it is commanded"
                                         : "nothing transmits a torque in it"),
              "Name a joint with a stiffness");
  return {watched, joint.dimension == dimension::angle};
}

double positive(const YamlNode& given, const Dimension& of, bool may_be_zero) {
  const double value = given.quantity_with_unit(of);
  if (value > 0 || (may_be_zero && value == 0)) return value;
  given.fail("'" + given.text() + "' is not positive",
             "Give the standard deviation of one reading, or remove the key when it is not known");
}

// One quantity; of a whole pose `{translation: 5 um, rotation: 10 urad}`.
double deviation(const YamlNode& node, const char* key, const Dimension& of, bool of_pose,
                 bool may_be_zero) {
  const auto given = node.find(key);
  if (!given) return not_a_number;
  if (!of_pose) return positive(*given, of, may_be_zero);
  if (!given->is_map())
    given->fail("a pose has translations and rotations",
                fmt::format("Write '{}: {{translation: 5 um, rotation: 10 urad}}'", key));
  given->allow_only({"translation", "rotation"});
  const auto part = given->find(of == dimension::angle ? "rotation" : "translation");
  return part ? positive(*part, of, may_be_zero) : not_a_number;
}

class SensorReader {
 public:
  SensorReader(const vjm::Manipulator& robot, Campaign& campaign)
      : robot_(robot), campaign_(campaign), joints_(joints_of(robot)) {}

  // `all_exact`: no unloaded reading has an error, where a sensor says nothing else.
  Eigen::VectorXd read(const YamlNode& given, bool all_exact) {
    all_exact_ = all_exact;
    sigma_.assign(6, not_a_number);
    datum_.assign(campaign_.datum_noise.begin(), campaign_.datum_noise.end());
    const auto all = given.members();
    for (const auto& [name, node] : all) read_sensor(name, node);
    for (std::size_t s = 0; s < all.size(); ++s)
      if (const auto minus = all[s].second.find("minus")) set_minus(*minus, s + 1);
    campaign_.datum_noise = Eigen::Map<Eigen::VectorXd>(datum_.data(), std::ssize(datum_));
    return Eigen::Map<Eigen::VectorXd>(sigma_.data(), std::ssize(sigma_));
  }

 private:
  void read_sensor(const std::string& name, const YamlNode& node) {
    check_name(name, node, joints_, campaign_);
    std::vector<std::string> kinds;
    for (const Word& word : words()) kinds.emplace_back(word.name);
    if (!node.has("kind"))
      node.fail("no kind is stated", fmt::format("Give one of {}", fmt::join(kinds, ", ")));
    const std::string kind = node.at("kind").choice(kinds);
    const Word& word = *std::find_if(words().begin(), words().end(),
                                     [&](const Word& w) { return w.name == kind; });
    std::vector<std::string> keys = {"kind", "noise", "datum_noise"};
    keys.insert(keys.end(), word.keys.begin(), word.keys.end());
    node.allow_only(keys);
    Sensor sensor{.name = name, .kind = word.kind, .by_instrument = false};
    Dimension own = dimension::length;
    if (word.kind == SensorKind::joint || word.kind == SensorKind::torque)
      own = read_joint(node.at("joint"), sensor);
    else
      read_frames(node, kind, sensor);
    add_components(node, word, own, sensor);
    campaign_.sensors.push_back(sensor);
  }

  Dimension read_joint(const YamlNode& node, Sensor& sensor) {
    const SpringyJoint joint = find_joint(node, robot_, joints_, sensor.kind == SensorKind::torque);
    sensor.joint = campaign_.watch.joints.size();
    campaign_.watch.joints.push_back(joint.place);
    if (sensor.kind == SensorKind::joint) return joint.turns ? dimension::angle : dimension::length;
    return joint.turns ? dimension::moment : dimension::force;
  }

  std::size_t add(const vjm::CarriedFrame& frame) {
    campaign_.watch.frames.push_back(frame);
    return campaign_.watch.frames.size() - 1;
  }

  void read_frames(const YamlNode& node, const std::string& kind, Sensor& sensor) {
    vjm::CarriedFrame frame = read_place(node, robot_, campaign_), from;
    const auto other = node.find("from");
    if (kind == "distance" && !other)
      node.fail("a distance is between two points, and one is stated",
                "Say where the other is: 'from: {on: base, at: [x, y, z]}'");
    // What the instrument of the campaign follows, in the frame that it is in.
    const bool followed = (kind == "position" || kind == "rotation" || kind == "pose") && !other;
    if (followed) from.pose = campaign_.observation.frame;
    if (other) from = read_end(*other, robot_, campaign_);
    if (const auto in = node.find("in")) sensor.own_axes = in->choice({"from", "own"}) == "own";
    if (sensor.own_axes && campaign_.displacement == DisplacementKind::absolute)
      node.at("in").fail("absolute poses cannot be given in axes that move with what is read",
                         "Measure differences, or remove the key");
    if (kind == "gauge") {
      if (!node.has("direction"))
        node.fail("no direction is stated, in which the gauge counts up",
                  "Write 'direction: [0, 0, 1]'");
      Pose& turned = sensor.own_axes ? frame.pose : from.pose;
      turned = turned * Pose::rotation(axes_along(node.at("direction").direction()));
    }
    sensor.by_instrument = frame.by_instrument = followed && !sensor.own_axes;
    if (const auto target = node.find("target_pose"))
      sensor.target_estimated = target->choice({"known", "estimate"}) == "estimate";
    sensor.frame = add(frame);
    sensor.from = add(from);
  }

  // `axes: [x, z]`, among those that the kind has.
  std::vector<Index> read_axes(const YamlNode& node, const Word& word) const {
    const auto given = node.find("axes");
    if (!given) return word.axes;
    const bool tilt = word.kind == SensorKind::tilt;
    const Index first = word.axes.front();
    std::vector<Index> axes;
    const auto take = [&](const YamlNode& item) {
      const std::string name = item.choice({"x", "y", "z"});
      axes.push_back((tilt ? 0 : first) + (name == "x" ? 0 : name == "y" ? 1 : 2));
    };
    if (given->is_scalar())
      take(*given);
    else
      for (const YamlNode& item : given->items()) take(item);
    std::sort(axes.begin(), axes.end());
    if (axes.empty() || std::adjacent_find(axes.begin(), axes.end()) != axes.end())
      given->fail("the axes are not different ones of x, y, z", "Write 'axes: [x, z]'");
    return axes;
  }

  void add_components(const YamlNode& node, const Word& word, const Dimension& own,
                      const Sensor& sensor) {
    const std::vector<Index> axes = read_axes(node, word);
    for (const Index axis : axes) {
      const bool turns = sensor.kind == SensorKind::tilt || is_rotation(axis);
      Component component{.name = sensor.name,
                          .dimension = turns ? dimension::angle : own,
                          .sensor = campaign_.sensors.size(),
                          .axis = axis};
      if (axes.size() > 1)
        component.name += fmt::format(
            ".{}", component_names[static_cast<std::size_t>(turns && axis < 3 ? axis + 3 : axis)]);
      sigma_.push_back(deviation(node, "noise", component.dimension, axes.size() == 6, false));
      datum_.push_back(datum_deviation(node, component.dimension, axes.size() == 6));
      campaign_.components.push_back(std::move(component));
    }
  }

  // That of the unloaded reading; `0` needs no unit.
  double datum_deviation(const YamlNode& node, const Dimension& of, bool of_pose) const {
    const auto given = node.find("datum_noise");
    if (given ? is_all_exact(*given) : all_exact_) return 0;
    return deviation(node, "datum_noise", of, of_pose, true);
  }

  void set_minus(const YamlNode& node, std::size_t index) {
    std::vector<std::string> names;
    for (const Sensor& sensor : campaign_.sensors)
      if (!sensor.is_platform()) names.push_back(sensor.name);
    const std::string name = node.choice(names);
    Sensor& sensor = campaign_.sensors[index];
    const auto other = std::find_if(campaign_.sensors.begin(), campaign_.sensors.end(),
                                    [&](const Sensor& s) { return s.name == name; });
    if (other->name == sensor.name || other->kind != sensor.kind || other->minus)
      node.fail(fmt::format("'{}' cannot be taken off '{}'", name, sensor.name),
                "Name another sensor of the same kind that counts from none");
    sensor.minus = static_cast<std::size_t>(other - campaign_.sensors.begin());
  }

  const vjm::Manipulator& robot_;
  Campaign& campaign_;
  std::vector<Joint> joints_;
  std::vector<double> sigma_, datum_;
  bool all_exact_ = false;
};

}  // namespace

bool is_all_exact(const YamlNode& datum_noise) {
  return datum_noise.is_scalar() && datum_noise.text() == "0";
}

Eigen::VectorXd read_sensors(const YamlNode& top, const vjm::Manipulator& manipulator,
                             Campaign& campaign) {
  const auto given = top.find("sensors");
  if (!given) return Eigen::VectorXd::Constant(6, not_a_number);
  const auto datum_noise = top.find("datum_noise");
  return SensorReader(manipulator, campaign)
      .read(*given, datum_noise && is_all_exact(*datum_noise));
}

namespace {

// A body is loaded at the end of a chain that leads to it; nothing for the base.
void load_at_end(const vjm::Manipulator& robot, vjm::CarriedFrame& frame) {
  if (frame.chain) return;
  for (std::size_t c = 0; c < robot.size() && !frame.chain; ++c)
    if (robot.span(c).to == frame.body) frame.chain = c;
  if (frame.chain) frame.place = "end";
}

// Adds a place to what is watched; returns the node there, for loads.
std::optional<vjm::NodeLoad> add_loaded(const vjm::Manipulator& robot, vjm::CarriedFrame frame,
                                        Campaign& campaign) {
  load_at_end(robot, frame);
  auto& frames = campaign.watch.frames;
  const auto on_chain = std::count_if(frames.begin(), frames.end(), [&](const auto& f) {
    return f.chain && f.chain == frame.chain;
  });
  frames.push_back(frame);
  if (!frame.chain) return std::nullopt;
  return vjm::NodeLoad{
      .chain = *frame.chain,
      .node = robot.chains()[*frame.chain].nodes().size() + static_cast<std::size_t>(on_chain)};
}

}  // namespace

std::vector<Weight> read_weights(const YamlNode& top, const vjm::Manipulator& manipulator,
                                 Campaign& campaign) {
  constexpr double standard_gravity = 9.80665;  // [m/s^2]
  std::vector<Weight> weights;
  const auto given = top.find("weights");
  if (!given) return weights;
  const Vector3 gravity =
      manipulator.gravity().isZero(0) ? Vector3(0, 0, -standard_gravity) : manipulator.gravity();
  for (const auto& [name, node] : given->members()) {
    check_name(name, node, joints_of(manipulator), campaign);
    node.allow_only({"on", "at"});
    auto place = add_loaded(manipulator, read_place(node, manipulator, campaign), campaign);
    if (!place)
      node.at("on").fail("a weight on the base moves nothing", "Name a part of the robot");
    place->force = gravity;
    weights.push_back({name, *place});
  }
  return weights;
}

std::vector<Cylinder> read_cylinders(const YamlNode& top, const vjm::Manipulator& manipulator,
                                     Campaign& campaign) {
  std::vector<Cylinder> cylinders;
  const auto given = top.find("cylinders");
  if (!given) return cylinders;
  for (const auto& [name, node] : given->members()) {
    check_name(name, node, joints_of(manipulator), campaign);
    node.allow_only({"on", "at", "from"});
    Cylinder& cylinder = cylinders.emplace_back();
    cylinder.name = name;
    const std::array ends = {read_place(node, manipulator, campaign),
                             read_end(node.at("from"), manipulator, campaign)};
    for (std::size_t end = 0; end < 2; ++end) {
      cylinder.frames[end] = campaign.watch.frames.size();
      cylinder.ends[end] = add_loaded(manipulator, ends[end], campaign);
    }
    if (!cylinder.ends[0] && !cylinder.ends[1])
      node.fail("a cylinder between the base and itself moves nothing",
                "Name a part of the robot that it pushes: 'on: platform'");
  }
  return cylinders;
}

namespace {

void append(double value, Eigen::VectorXd& vector) {
  vector.conservativeResize(vector.size() + 1);
  vector[vector.size() - 1] = value;
}

// What is set, by its column.
Index read_set(const YamlNode& node, const Campaign& campaign) {
  std::vector<std::string> names;
  for (const Component& component : campaign.components) names.push_back(component.name);
  const Index set = std::find(names.begin(), names.end(), node.choice(names)) - names.begin();
  if (campaign.sensors[campaign.component(set).sensor].minus)
    node.fail("a difference of two sensors cannot be set", "Name one sensor");
  return set;
}

}  // namespace

std::size_t read_control(const YamlNode& top, Campaign& campaign, Eigen::VectorXd& sigma) {
  const auto given = top.find("displacement_control");
  if (!given) return 0;
  given->allow_only({"set", "force", "noise", "datum_noise"});
  if (const auto noise = top.find("wrench_noise"))
    noise->fail("where a displacement is set, the force is the reading and has its own noise",
                "State it as 'noise' under 'displacement_control' instead");
  const std::vector<std::string> forces = {"fx", "fy", "fz", "mx", "my", "mz"};
  const std::string force = given->at("force").choice(forces);
  const auto index =
      static_cast<std::size_t>(std::find(forces.begin(), forces.end(), force) - forces.begin());
  const Dimension of = index < 3 ? dimension::force : dimension::moment;
  campaign.control.emplace();
  campaign.control->set = read_set(given->at("set"), campaign);
  campaign.control->force = campaign.size();
  campaign.components.push_back(
      {.name = force, .dimension = of, .sensor = campaign.sensors.size(), .axis = 0});
  campaign.sensors.push_back({.name = force, .kind = SensorKind::load, .by_instrument = false});
  append(deviation(*given, "noise", of, false, false), sigma);
  const auto all = top.find("datum_noise"), own = given->find("datum_noise");
  const bool exact = own ? is_all_exact(*own) : all && is_all_exact(*all);
  append(exact ? 0 : deviation(*given, "datum_noise", of, false, true), campaign.datum_noise);
  return index;
}

std::vector<Torque> read_torques(const YamlNode& top, const vjm::Manipulator& manipulator,
                                 const Campaign& campaign) {
  std::vector<Torque> torques;
  const auto given = top.find("torques");
  if (!given) return torques;
  const std::vector<Joint> joints = joints_of(manipulator);
  for (const auto& [name, node] : given->members()) {
    check_name(name, node, joints, campaign);
    node.allow_only({"joint"});
    const SpringyJoint joint = find_joint(node.at("joint"), manipulator, joints, true);
    torques.push_back(
        {.name = name,
         .per_unit = {.chain = joint.place.chain, .coordinate = joint.place.coordinate},
         .dimension = joint.turns ? dimension::moment : dimension::force});
  }
  return torques;
}

}  // namespace kinetostat::calibration
