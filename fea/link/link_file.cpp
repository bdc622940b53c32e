#include "kinetostat/fea/link/link_file.h"

#include <algorithm>
#include <cctype>
#include <stdexcept>
#include <tuple>
#include <utility>

#include <fmt/format.h>

#include "kinetostat/fea/mesh/surface_import.h"
#include "kinetostat/io/material_table.h"
#include "kinetostat/io/text_file.h"
#include "kinetostat/io/yaml.h"

namespace kinetostat::fea {
namespace {

using io::YamlNode;
using spatial::UnitSystem;
namespace dimension = spatial::dimension;

constexpr spatial::Dimension stiffness_per_area{.length = -2, .mass = 1, .time = -2};

std::string read_unit(const YamlNode& mesh, const std::filesystem::path& mesh_file) {
  const auto unit = mesh.find("unit");
  // Without one, identify() refuses with the sizes to choose by.
  if (!unit) return unit_of_format(mesh_file);
  try {
    spatial::parse_quantity("1 " + unit->text(), dimension::length);
  } catch (const std::invalid_argument& error) {
    unit->fail(error.what(), "Use mm, m or inch");
  }
  return unit->text();
}

// {value, sd}: one standard deviation, as a pressure or in percent.
double read_deviation(const YamlNode& node, double value) {
  const bool relative = node.text().find('%') != std::string::npos;
  const double deviation = relative ? value * node.quantity(dimension::none, {})
                                    : node.quantity_with_unit(dimension::pressure);
  if (!(deviation >= 0 && deviation < value))
    node.fail("'" + node.text() + "' is not between zero and the value", "Steel has 3 %");
  return deviation;
}

// Young's modulus and its deviation.
std::pair<double, double> read_young(const YamlNode& node) {
  if (!node.is_map()) return {node.quantity_with_unit(dimension::pressure), 0};
  node.allow_only({"value", "sd"});
  const double value = node.at("value").quantity_with_unit(dimension::pressure);
  return {value, read_deviation(node.at("sd"), value)};
}

Material material_of_values(const YamlNode& node, double& deviation) {
  node.allow_only({"E", "nu", "density"});
  double young = 0;
  std::tie(young, deviation) = read_young(node.at("E"));
  if (!(young > 0))
    node.at("E").fail("'" + node.at("E").text() + "' is not above zero",
                      "Give Young's modulus, for steel 210 GPa");
  const double poisson = node.at("nu").number();
  if (!(poisson > -1 && poisson < 0.5))
    node.at("nu").fail(
        "'" + node.at("nu").text() + "' is not between -1 and 0.5",
        "0.5 is incompressible, which these elements cannot be; rubber is near 0.49");
  std::optional<double> density;
  if (const auto value = node.find("density")) {
    density = value->quantity_with_unit(dimension::density);
    if (!(*density > 0))
      value->fail("'" + value->text() + "' is not above zero", "Steel has 7850 kg/m^3");
  }
  return Material(young, poisson, density);
}

// Where the values stand in the file, or the table, with their deviation and the name.
struct GivenMaterial {
  Material material;
  double deviation = 0;
  std::string name = {};
};

GivenMaterial read_material(const YamlNode& node) {
  if (node.is_scalar()) {
    const io::NamedMaterial& found = io::named_material(node.choice(io::material_names()));
    return {Material(found.young, found.poisson, found.density), found.deviation, found.name};
  }
  double deviation = 0;
  const Material material = material_of_values(node, deviation);
  return {material, deviation};
}

CylinderSelector read_cylinder(const YamlNode& node, const UnitSystem& units) {
  node.allow_only({"axis_point", "axis", "radius", "length"});
  CylinderSelector cylinder{.axis_point = node.at("axis_point").vector3(dimension::length, units),
                            .axis = node.at("axis").direction(),
                            .radius = node.at("radius").positive(dimension::length, units),
                            .length = {}};
  if (const auto length = node.find("length"))
    cylinder.length = length->positive(dimension::length, units);
  return cylinder;
}

BoxSelector read_box(const YamlNode& node, const UnitSystem& units) {
  node.allow_only({"min", "max"});
  const Vector3 low = node.at("min").vector3(dimension::length, units);
  const Vector3 high = node.at("max").vector3(dimension::length, units);
  if ((low.array() > high.array()).any())
    node.fail("a coordinate of min is above that of max", "Swap them");
  return {Box(low, high)};
}

PatchSelector read_patch(const YamlNode& node, const UnitSystem& units) {
  ImportedSurface patch = read_surface(node.existing_file(), units.length);
  return {std::move(patch.mesh), std::move(patch.sha256)};
}

CadFaceSelector read_cad_face(const YamlNode& node) {
  const std::string text = node.text();
  if (text.find_first_not_of("0123456789") != std::string::npos) return {.name = text};
  return {.number = node.integer(1, 1'000'000)};
}

ColourSelector read_colour(const YamlNode& node) {
  std::string text = node.text();
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (text.size() != 7 || text.front() != '#' ||
      text.find_first_not_of("0123456789abcdef", 1) != std::string::npos)
    node.fail("'" + node.text() + "' is not a colour", "Write red as \"#ff0000\", in quotes");
  return {text};
}

Selector read_selector(const std::string& kind, const YamlNode& node, const UnitSystem& units) {
  if (kind == "group") return GroupSelector{node.text()};
  if (kind == "face") return read_cad_face(node);
  if (kind == "colour") return read_colour(node);
  if (kind == "stl") return read_patch(node, units);
  if (kind == "sphere") {
    node.allow_only({"center", "radius"});
    return SphereSelector{node.at("center").vector3(dimension::length, units),
                          node.at("radius").positive(dimension::length, units)};
  }
  if (kind == "cylinder") return read_cylinder(node, units);
  if (kind == "box") return read_box(node, units);
  if (kind == "plane") {
    node.allow_only({"point", "normal"});
    return PlaneSelector{node.at("point").vector3(dimension::length, units),
                         node.at("normal").direction()};
  }
  node.allow_only({"point", "direction"});
  return NearestFaceSelector{node.at("point").vector3(dimension::length, units),
                             node.at("direction").direction()};
}

common::InputError::Details place(const YamlNode& node) {
  common::InputError::Details details;
  details.file = node.file();
  details.line = node.line();
  details.key = node.path();
  return details;
}

const std::vector<std::string> selector_kinds{
    "plane", "cylinder", "sphere", "box", "nearest_face", "group", "stl", "face", "colour"};

double read_layer_stiffness(const YamlNode& node) {
  const double stiffness = node.quantity_with_unit(stiffness_per_area);
  if (!(stiffness > 0))
    node.fail("'" + node.text() + "' is not above zero",
              "A bolted joint has about 1e12 N/m^3, that is 1 N/(um mm^2)");
  return stiffness;
}

ElasticLayer read_layer(const YamlNode& node) {
  node.allow_only({"normal", "tangential"});
  return {.normal = read_layer_stiffness(node.at("normal")),
          .tangential = read_layer_stiffness(node.at("tangential"))};
}

Coupling read_coupling(const YamlNode& node) {
  if (node.is_map()) return Coupling::elastic;
  const std::string word = node.choice({"rigid", "distributing", "body"});
  if (word == "body") return Coupling::body;
  return word == "rigid" ? Coupling::rigid : Coupling::distributing;
}

double read_modulus_ratio(const YamlNode& node, Coupling coupling) {
  if (coupling != Coupling::body)
    node.fail("only a body has a modulus", "Add 'coupling: body', or leave it out");
  const double ratio = node.number();
  if (!(ratio >= 1 && ratio <= largest_modulus_ratio))
    node.fail(
        fmt::format("'{}' is not between 1 and {:g}", node.text(), largest_modulus_ratio),
        fmt::format("Leave it out for {:g}; beyond, use 'coupling: rigid'", default_modulus_ratio));
  return ratio;
}

// What the lengths and names in an interface refer to.
struct Surroundings {
  UnitSystem units = {};
  std::vector<std::string> bodies = {};
};

std::size_t number_of(const YamlNode& name, const std::vector<std::string>& names) {
  const std::string word = name.choice(names);
  return static_cast<std::size_t>(std::find(names.begin(), names.end(), word) - names.begin());
}

InterfaceSpec read_interface(const std::string& name, const YamlNode& node,
                             const Surroundings& around) {
  const UnitSystem& units = around.units;
  std::vector<std::string> keys = selector_kinds;
  keys.insert(keys.end(), {"coupling", "modulus_ratio", "point"});
  if (!around.bodies.empty()) keys.emplace_back("body");
  node.allow_only(keys);
  const auto [kind, selection] = node.one_of(selector_kinds);
  InterfaceSpec spec;
  spec.name = name;
  if (const auto coupling = node.find("coupling")) {
    spec.coupling = read_coupling(*coupling);
    if (spec.coupling == Coupling::elastic) spec.layer = read_layer(*coupling);
  }
  if (const auto ratio = node.find("modulus_ratio"))
    spec.modulus_ratio = read_modulus_ratio(*ratio, spec.coupling);
  spec.selector = read_selector(kind, selection, units);
  spec.origin = place(selection);
  if (const auto point = node.find("point")) spec.point = point->vector3(dimension::length, units);
  if (const auto body = node.find("body")) spec.body = number_of(*body, around.bodies);
  return spec;
}

// Named interfaces, and which of them is fixed.
std::vector<InterfaceSpec> read_named_interfaces(const YamlNode& top, const Surroundings& around) {
  const YamlNode node = top.at("interfaces");
  std::vector<std::string> names;
  for (const auto& [name, member] : node.members()) names.push_back(name);
  if (names.size() < 2)
    node.fail("a link has two interfaces at least", "Give the fixed one and a loaded one");
  if (const auto loaded = top.find("loaded"))
    loaded->fail("all of `interfaces` are loaded but the fixed one", "Leave 'loaded' out");
  const std::string fixed = top.at("fixed").choice(names);
  std::vector<InterfaceSpec> specs{read_interface(fixed, node.at(fixed), around)};
  for (const auto& [name, member] : node.members())
    if (name != fixed) specs.push_back(read_interface(name, member, around));
  return specs;
}

std::vector<InterfaceSpec> read_interfaces(const YamlNode& top, const Surroundings& around) {
  if (top.has("interfaces")) return read_named_interfaces(top, around);
  std::vector<InterfaceSpec> specs;
  for (const char* name : {"fixed", "loaded"})
    specs.push_back(read_interface(name, top.at(name), around));
  return specs;
}

// "1 %" or 0.01.
double read_accuracy(const YamlNode& node) {
  const double accuracy = node.quantity(dimension::none, {});
  if (!(accuracy >= 1e-5 && accuracy <= 0.5))
    node.fail("'" + node.text() + "' is not between 0.001 % and 50 %",
              "1 % is usual, 0.1 % costs a good deal more");
  return accuracy;
}

RepairOptions read_repair(const YamlNode& mesh, const UnitSystem& units) {
  RepairOptions options;
  if (const auto steps = mesh.find("repair"))
    for (const YamlNode& step : steps->items())
      options.steps.push_back(repair_step(step.choice(repair_steps())));
  for (const char* key : {"tolerance", "limit"})
    if (const auto value = mesh.find(key); value && options.steps.empty())
      value->fail("it is for 'repair', which is not asked for", "Add 'repair: [weld, orient]'");
  if (const auto tolerance = mesh.find("tolerance"))
    options.tolerance = tolerance->positive(dimension::length, units);
  if (const auto limit = mesh.find("limit"))
    options.limit = limit->positive(dimension::none, units);
  return options;
}

Vector6 read_preload(const YamlNode& node, const UnitSystem& units, const LinkSpec& spec) {
  node.allow_only({"force", "moment"});
  const bool all_rigid =
      std::all_of(spec.interfaces.begin(), spec.interfaces.end(),
                  [](const InterfaceSpec& i) { return i.coupling == Coupling::rigid; });
  if (spec.interfaces.size() != 2 || !all_rigid)
    node.fail("a preload acts between two rigid interfaces, 'fixed' and 'loaded'",
              "Use 'coupling: rigid' at both, or leave the preload out");
  Vector6 wrench = Vector6::Zero();
  wrench.head<3>() = node.at("force").vector3(dimension::force, units);
  if (const auto moment = node.find("moment"))
    wrench.tail<3>() = moment->vector3(dimension::moment, units);
  return wrench;
}

void read_elements(const YamlNode& node, const UnitSystem& units, LinkSpec& spec) {
  node.allow_only({"order", "size", "accuracy"});
  if (const auto order = node.find("order")) spec.order = order->integer(1, 2);
  if (const auto size = node.find("size")) spec.size = size->positive(dimension::length, units);
  if (const auto accuracy = node.find("accuracy")) {
    if (spec.size)
      accuracy->fail("both a size and an accuracy are asked for",
                     "Give the accuracy alone: the sizes follow from it");
    spec.accuracy = read_accuracy(*accuracy);
  }
}

// Mesh and material: all that a body has.
LinkSpec read_body(const std::string& name, const YamlNode& mesh, const YamlNode& of) {
  mesh.allow_only({"file", "unit", "body", "repair", "tolerance", "limit"});
  const std::filesystem::path mesh_file = mesh.at("file").existing_file();
  const std::string unit = read_unit(mesh, mesh_file);
  UnitSystem units;
  if (!unit.empty()) units.length = unit;
  // Filled one by one: when a value in nested braces throws, g++ 12 destroys members never made.
  const GivenMaterial material = read_material(of);
  LinkSpec spec(material.material);
  spec.name = name;
  spec.file = mesh.file();
  spec.material_name = material.name;
  spec.young_deviation = material.deviation;
  spec.mesh_file = mesh_file;
  spec.mesh_name = mesh.at("file").text();
  spec.unit = unit;
  spec.mesh_origin = place(mesh);
  spec.material_origin = place(of);
  if (const auto body = mesh.find("body")) spec.body = body->text();
  spec.repair = read_repair(mesh, units);
  return spec;
}

std::vector<LinkSpec> read_bodies(const YamlNode& top) {
  const YamlNode node = top.at("bodies");
  std::vector<LinkSpec> bodies;
  std::vector<std::string> names;
  for (const auto& [name, body] : node.members()) {
    body.allow_only({"mesh", "material"});
    names.push_back(name);
    const YamlNode mesh = body.has("mesh") || !top.has("mesh") ? body.at("mesh") : top.at("mesh");
    bodies.push_back(read_body(
        name, mesh,
        body.has("material") || !top.has("material") ? body.at("material") : top.at("material")));
    // A file with several bodies has them by name.
    if (bodies.back().body.empty() && !body.has("mesh")) bodies.back().body = name;
  }
  node.allow_only(names);
  if (bodies.size() < 2)
    node.fail("an assembly has two bodies at least", "Write one body as 'mesh' and 'material'");
  return bodies;
}

JointSpec read_joint(const YamlNode& node, const Surroundings& around) {
  node.allow_only({"between", "bonded", "layer", "within"});
  const std::vector<YamlNode> ends = node.at("between").items(2);
  JointSpec joint{.bodies = {number_of(ends[0], around.bodies), number_of(ends[1], around.bodies)}};
  joint.origin = place(node);
  if (joint.bodies[0] == joint.bodies[1])
    node.at("between").fail("a body has no joint with itself", "Name two bodies");
  const auto [kind, value] = node.one_of({"bonded", "layer"});
  if (kind == "layer") joint.layer = read_layer(value);
  if (kind == "bonded" && !value.boolean())
    value.fail("bodies that touch are bonded, or have a layer between them",
               "Write 'bonded: true', or leave the joint out where they slide");
  if (const auto within = node.find("within"))
    joint.within = within->positive(dimension::length, around.units);
  return joint;
}

std::vector<JointSpec> read_joints(const YamlNode& top, const Surroundings& around) {
  const auto node = top.find("joints");
  if (!node) return {};
  if (around.bodies.empty())
    node->fail("joints are between bodies, and there are none", "Give 'bodies' instead of 'mesh'");
  std::vector<JointSpec> joints;
  for (const YamlNode& item : node->items()) {
    joints.push_back(read_joint(item, around));
    for (std::size_t j = 0; j + 1 < joints.size(); ++j)
      if (std::is_permutation(joints[j].bodies.begin(), joints[j].bodies.end(),
                              joints.back().bodies.begin()))
        item.at("between").fail("these bodies have a joint already", "Leave one of the two out");
  }
  return joints;
}

// With the bodies, whose elements are as the link's.
LinkSpec read_solids(const YamlNode& top) {
  const std::string name = top.at("link").text();
  if (!top.has("bodies")) return read_body(name, top.at("mesh"), top.at("material"));
  const std::vector<LinkSpec> bodies = read_bodies(top);
  LinkSpec spec = bodies.front();
  spec.name = name;
  for (std::size_t b = 1; b < bodies.size(); ++b)
    if (bodies[b].mesh_name != bodies[b - 1].mesh_name)
      spec.mesh_name += ", " + bodies[b].mesh_name;
  spec.bodies = bodies;
  return spec;
}

void read_rest(const YamlNode& top, LinkSpec& spec) {
  Surroundings around;
  if (!spec.unit.empty()) around.units.length = spec.unit;
  for (const LinkSpec& body : spec.bodies) around.bodies.push_back(body.name);
  spec.interfaces = read_interfaces(top, around);
  spec.joints = read_joints(top, around);
  if (const auto preload = top.find("preload"))
    spec.preload = read_preload(*preload, around.units, spec);
  if (const auto elements = top.find("elements")) read_elements(*elements, around.units, spec);
  for (LinkSpec& body : spec.bodies) {
    body.order = spec.order;
    body.size = spec.size;
    body.accuracy = spec.accuracy;
  }
}

}  // namespace

Material parse_material(const std::string& text) {
  return read_material(io::parse_yaml("material: " + text, "").at("material")).material;
}

double parse_accuracy(const std::string& text) {
  return read_accuracy(io::parse_yaml("accuracy: " + text, "").at("accuracy"));
}

LinkSpec read_link(const std::filesystem::path& file) {
  const YamlNode top = io::read_yaml(file);
  io::check_format_version(top);
  top.allow_only({"kinetostat", "link", "mesh", "material", "bodies", "joints", "interfaces",
                  "fixed", "loaded", "preload", "elements"});
  LinkSpec spec = read_solids(top);
  spec.file = file;
  read_rest(top, spec);
  spec.sha256 = io::sha256(io::read_text(file));
  spec.meaning = io::meaning(top);
  return spec;
}

std::vector<Material> materials_of(const LinkSpec& spec) {
  if (spec.bodies.empty()) return {spec.material};
  std::vector<Material> materials;
  for (const LinkSpec& body : spec.bodies) materials.push_back(body.material);
  return materials;
}

}  // namespace kinetostat::fea
