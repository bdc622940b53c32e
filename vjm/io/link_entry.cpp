#include "kinetostat/vjm/io/link_entry.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <Eigen/Cholesky>
#include <fmt/format.h>

#include "kinetostat/common/error.h"
#include "kinetostat/io/link_result_file.h"
#include "kinetostat/io/material_table.h"
#include "kinetostat/spatial/rotation.h"
#include "kinetostat/vjm/chain/beam.h"
#include "kinetostat/vjm/chain/particles.h"
#include "kinetostat/vjm/io/link_uncertainty.h"
#include "kinetostat/vjm/io/machine_element_entry.h"
#include "kinetostat/vjm/io/sub_manipulator.h"
#include "kinetostat/vjm/io/uncertain_number.h"

namespace kinetostat::vjm {
namespace {

using io::YamlNode;
using spatial::Compliance6;
using spatial::Frame;
using spatial::Matrix3;
using spatial::Matrix6;
using spatial::Pose;
using spatial::UnitSystem;
using spatial::Vector3;
namespace dimension = spatial::dimension;

// One source for all links of this material.
Material material_of_table(const io::NamedMaterial& named, SourceList& sources) {
  const UncertaintySource young{.name = "E of " + named.name,
                                .place = "table of materials: E of " + named.name,
                                .kind = SourceKind::material,
                                .spread = Spread::log_normal,
                                .value = named.young,
                                .estimate = named.young,
                                .deviation = named.deviation};
  Material material;
  material.young_modulus = sources.meet(young).value_or(named.young);
  material.shear_modulus = material.young_modulus / (2 * (1 + named.poisson));
  material.density = named.density;
  return material;
}

Material read_material(const YamlNode& node, const UnitSystem& units,
                       const std::optional<YamlNode>& materials, SourceList& sources) {
  if (node.is_scalar()) {
    std::vector<std::string> names;
    if (materials)
      for (const auto& [name, value] : materials->members()) names.push_back(name);
    const std::size_t own = names.size();
    for (std::string& name : io::material_names()) names.push_back(std::move(name));
    const std::string name = node.choice(names);
    if (std::find(names.begin(), names.begin() + static_cast<std::ptrdiff_t>(own), name) !=
        names.begin() + static_cast<std::ptrdiff_t>(own))
      return read_material(materials->at(name), units, std::nullopt, sources);
    return material_of_table(io::named_material(name), sources);
  }
  node.allow_only({"E", "G", "nu", "density"});
  Material material;
  const PartNumbers read{units, sources, SourceKind::material};
  material.young_modulus = read(node.at("E"), dimension::pressure);
  const auto [key, value] = node.one_of({"G", "nu"});
  if (key == "G") {
    material.shear_modulus = read(value, dimension::pressure);
  } else {
    const double nu = value.number();
    if (!(nu > -1 && nu < 0.5))
      value.fail(fmt::format("Poisson's ratio {} is not between -1 and 0.5", nu),
                 "Metals have 0.27 to 0.35");
    material.shear_modulus = material.young_modulus / (2 * (1 + nu));
  }
  if (const auto density = node.find("density"))
    material.density = read(*density, dimension::density);
  return material;
}

Section read_general_section(const YamlNode& node, const PartNumbers& read) {
  node.allow_only({"A", "Iy", "Iz", "J", "shear_y", "shear_z"});
  Section section;
  section.area = read(node.at("A"), dimension::area);
  section.second_moment_y = read(node.at("Iy"), dimension::second_moment);
  section.second_moment_z = read(node.at("Iz"), dimension::second_moment);
  section.torsion_constant = read(node.at("J"), dimension::second_moment);
  if (const auto shear = node.find("shear_y"))
    section.shear_coefficient_y = read(*shear, dimension::none);
  if (const auto shear = node.find("shear_z"))
    section.shear_coefficient_z = read(*shear, dimension::none);
  return section;
}

Section read_section(const YamlNode& node, const PartNumbers& read, double poisson_ratio) {
  const auto [kind, value] = node.one_of({"rectangle", "circle", "tube", "general"});
  node.allow_only({kind});
  const auto length = [&](const YamlNode& parent, const char* key) {
    return read(parent.at(key), dimension::length);
  };
  if (kind == "general") return read_general_section(value, read);
  if (kind == "rectangle") {
    value.allow_only({"y", "z"});
    return Section::rectangle(length(value, "y"), length(value, "z"), poisson_ratio);
  }
  if (kind == "circle") {
    value.allow_only({"diameter"});
    return Section::circle(length(value, "diameter"), poisson_ratio);
  }
  value.allow_only({"outer", "inner"});
  const double outer = length(value, "outer"), inner = length(value, "inner");
  if (inner >= outer) value.fail("the inner diameter of a tube must be below the outer one");
  return Section::tube(outer, inner, poisson_ratio);
}

// Axes of the beam in the link's frame: x along the beam; y as given, or so that z is as near as
// can be to the frame's z (to its y for a beam along z).
Matrix3 section_axes(const YamlNode& node, const Vector3& direction) {
  const auto given = node.find("section_y");
  Vector3 y = Vector3::UnitZ().cross(direction);
  if (y.norm() < 1e-9) y = Vector3::UnitY();
  if (given) y = given->direction();
  try {
    return spatial::rotation_from_axes(direction, y);
  } catch (const std::invalid_argument&) {
    given->fail("the section's y axis is parallel to the beam");
  }
}

LinkModel read_beam(const YamlNode& node, const UnitSystem& units,
                    const std::optional<YamlNode>& materials, const LinkOptions& options) {
  node.allow_only(
      {"length", "direction", "section", "section_y", "material", "theory", "segments"});
  const double length = PartNumbers{units, *options.sources, SourceKind::length}(node.at("length"),
                                                                                 dimension::length);
  const auto direction_given = node.find("direction");
  const Vector3 direction = direction_given ? direction_given->direction() : Vector3::UnitX();
  const Material material = read_material(node.at("material"), units, materials, *options.sources);
  const Section section = read_section(
      node.at("section"), {units, *options.sources, SourceKind::section}, material.poisson_ratio());
  const auto theory_given = node.find("theory");
  const BeamTheory theory =
      !theory_given || theory_given->choice({"euler-bernoulli", "timoshenko"}) == "timoshenko"
          ? BeamTheory::timoshenko
          : BeamTheory::euler_bernoulli;
  if (theory == BeamTheory::timoshenko &&
      !(section.shear_coefficient_y && section.shear_coefficient_z))
    node.fail("Timoshenko theory needs shear_y and shear_z of a general section",
              "Add them, or write 'theory: euler-bernoulli'");
  const auto segments_given = node.find("segments");
  const int segments =
      (segments_given ? segments_given->integer(1, 1000) : 1) * options.segment_multiple;

  const double piece = length / segments;
  // The compliance at the tip in section axes, taken in the axes of the link's frame.
  const Matrix3 axes = section_axes(node, direction);
  const Compliance6 tip = beam_compliance(piece, section, material, theory);
  const Compliance6 turned(tip.matrix(), Frame{Vector3::Zero(), axes});
  const LinkPart part{Pose::translation(piece * direction), turned.in(Frame{})};
  LinkModel link{.parts = std::vector<LinkPart>(static_cast<std::size_t>(segments), part)};
  if (material.density)
    link.mass = {*material.density * section.area * length, 0.5 * piece * direction};
  return link;
}

// `mass: {mass: 12 kg, center: [x, y, z], inertia: [...]}` of a rigid, inline or identified link.
std::optional<LinkMass> read_mass(const YamlNode& node, const UnitSystem& units,
                                  SourceList& sources) {
  const auto given = node.find("mass");
  if (!given) return std::nullopt;
  given->allow_only({"mass", "center", "inertia"});
  LinkMass mass{PartNumbers{units, sources, SourceKind::mass}(given->at("mass"), dimension::mass),
                given->at("center").vector3(dimension::length, units)};
  if (const auto inertia = given->find("inertia")) mass.inertia = read_inertia(*inertia, units);
  return mass;
}

Compliance6 divided_by_copies(const Compliance6& compliance, const YamlNode& node) {
  const auto copies = node.find("copies");
  return Compliance6(compliance.matrix() / (copies ? copies->integer(1, 1000) : 1),
                     compliance.frame());
}

LinkModel read_identified(const YamlNode& node, const YamlNode& value, const UnitSystem& units,
                          SourceList& sources) {
  node.allow_only({"compliance", "link_file", "start", "end_axes", "copies", "mass"});
  if (const auto source = node.find("link_file")) (void)source->existing_file();
  const std::filesystem::path file = value.existing_file();
  const io::IdentifiedLink identified = io::read_identified_link(file);
  Pose start;
  if (const auto given = node.find("start")) start = io::read_pose(*given, units);
  Matrix3 end_axes = start.rotation();
  if (const auto given = node.find("end_axes")) end_axes = io::read_pose(*given, units).rotation();
  const Compliance6 compliance = uncertain_compliance(identified, file, sources);
  const Pose end(end_axes, compliance.frame().point);
  const Compliance6 at_end = compliance.in(Frame{end.position(), end.rotation()});
  LinkModel link{.parts = {{start.inverse() * end, divided_by_copies(at_end, node)}}, .file = file};
  const auto copies = node.find("copies");
  if (identified.mass)
    link.mass = LinkMass{*identified.mass * (copies ? copies->integer(1, 1000) : 1),
                         start.inverse() * identified.center_of_mass};
  if (const auto given = read_mass(node, units, sources)) link.mass = given;
  return link;
}

// Scales the blocks of a matrix from the file's units to SI. Exponents: of length for the four
// blocks relative to force per length.
Matrix6 stiffness_to_si(const Matrix6& matrix, const UnitSystem& units) {
  const double force = spatial::parse_unit(units.force).factor;
  const double length = spatial::parse_unit(units.length).factor;
  spatial::Vector6 scale = spatial::Vector6::Ones();
  scale.tail<3>().setConstant(length);
  return (force / length) * (scale.asDiagonal() * matrix * scale.asDiagonal());
}

// A stiffness may leave motions free. Its own blocks say how lengths and rotations compare.
LinkPart stiffness_part(const Pose& end, const Matrix6& stiffness, const YamlNode& value) {
  const double translation = stiffness.diagonal().head<3>().maxCoeff();
  const double rotation = stiffness.diagonal().tail<3>().maxCoeff();
  const bool comparable = translation > 0 && rotation > 0;
  try {
    return part_with_free_motions(end, stiffness,
                                  comparable ? std::sqrt(rotation / translation) : 1.0);
  } catch (const std::invalid_argument& error) {
    value.fail(error.what());
  }
}

void require_positive(const Matrix6& given, const YamlNode& value) {
  if (Eigen::LLT<Matrix6>(given).info() != Eigen::Success)
    value.fail("the 6x6 matrix is not positive definite");
}

LinkModel read_inline(const YamlNode& node, const YamlNode& value, const std::string& kind,
                      const UnitSystem& units, SourceList& sources) {
  node.allow_only({kind, "end", "copies", "mass"});
  const Matrix6 given = value.matrix6();
  if (spatial::symmetry_defect(given) > 1e-6) value.fail("the 6x6 matrix is not symmetric");
  Pose end;
  if (const auto pose = node.find("end")) end = io::read_pose(*pose, units);
  // A compliance scales by the inverse of what its stiffness scales by, entry by entry.
  const Matrix6 unit = stiffness_to_si(Matrix6::Ones(), units);
  LinkModel link;
  if (kind == "stiffness") {
    link.parts = {stiffness_part(end, given.cwiseProduct(unit), value)};
  } else {
    require_positive(given, value);
    link.parts = {{end, Compliance6(given.cwiseQuotient(unit))}};
  }
  link.parts[0].compliance = divided_by_copies(*link.parts[0].compliance, node);
  link.mass = read_mass(node, units, sources);
  return link;
}

LinkModel read_any_link(const YamlNode& node, const UnitSystem& units,
                        const std::optional<YamlNode>& materials, const LinkOptions& options,
                        const ReadManipulator& read) {
  const auto [kind, value] =
      node.one_of({"rigid", "beam", "compliance", "stiffness", "bearing", "guide", "manipulator"});
  if (kind == "rigid") {
    node.allow_only({"rigid", "mass"});
    LinkModel link{.parts = {{io::read_pose(value, units), std::nullopt}}};
    link.mass = read_mass(node, units, *options.sources);
    return link;
  }
  if (kind == "beam") {
    node.allow_only({"beam"});
    return read_beam(value, units, materials, options);
  }
  if (kind == "bearing" || kind == "guide") {
    node.allow_only({kind, "mass"});
    const Matrix6 stiffness = kind == "bearing" ? read_bearing(value, units, *options.sources)
                                                : read_guide(value, units, *options.sources);
    LinkModel link{.parts = {stiffness_part({}, stiffness, value)}};
    link.parts[0].travels = kind == "guide";  // what yields are the carriages, under the table
    link.mass = read_mass(node, units, *options.sources);
    return link;
  }
  if (kind == "manipulator") return read_sub_manipulator(node, units, options, read);
  if (kind == "compliance" && value.is_scalar())
    return read_identified(node, value, units, *options.sources);
  return read_inline(node, value, kind, units, *options.sources);
}

}  // namespace

Matrix3 read_inertia(const YamlNode& node, const UnitSystem& units) {
  const std::vector<YamlNode> items = node.items(6);
  spatial::Vector6 i;
  for (std::size_t k = 0; k < 6; ++k)
    i[static_cast<Eigen::Index>(k)] = items[k].quantity(dimension::inertia, units);
  Matrix3 inertia;
  inertia << i[0], i[1], i[2], i[1], i[3], i[4], i[2], i[4], i[5];
  if (inertia.isZero(0) || !is_possible_inertia(inertia))
    node.fail(
        "no body has this inertia: of its principal moments one is larger than the sum of "
        "the others, or negative",
        "Write [ixx, ixy, ixz, iyy, iyz, izz] about the centre of mass");
  return inertia;
}

LinkModel read_link(const YamlNode& node, const UnitSystem& units,
                    const std::optional<YamlNode>& materials, const LinkOptions& options,
                    const ReadManipulator& read) {
  LinkModel link = read_any_link(node, units, materials, options, read);
  try {
    for (const LinkPart& part : link.parts)
      if (part.compliance) (void)part.compliance->inverse();
  } catch (const std::domain_error&) {
    node.fail(
        "the link is so much softer in one direction than in another that its compliance "
        "has no inverse to working precision",
        "Check its numbers and their units; make it rigid where nothing is meant to yield");
  }
  return link;
}

}  // namespace kinetostat::vjm
