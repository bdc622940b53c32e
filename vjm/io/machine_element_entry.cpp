#include "kinetostat/vjm/io/machine_element_entry.h"

#include <cmath>
#include <numbers>
#include <stdexcept>

#include <fmt/format.h>

#include "kinetostat/spatial/rotation.h"
#include "kinetostat/vjm/io/uncertain_number.h"
#include "kinetostat/vjm/machine_elements/ball_screw.h"
#include "kinetostat/vjm/machine_elements/bearing.h"
#include "kinetostat/vjm/machine_elements/guide.h"

namespace kinetostat::vjm {
namespace {

using io::YamlNode;
using spatial::Matrix3;
using spatial::Matrix6;
using spatial::UnitSystem;
using spatial::Vector3;
namespace dimension = spatial::dimension;

constexpr int most_elements = 1000;
constexpr double usual_conformity = 0.52;

Matrix6 in_axes(const Matrix6& stiffness, const Matrix3& axes) {
  Matrix6 turn = Matrix6::Zero();
  turn.topLeftCorner<3, 3>() = turn.bottomRightCorner<3, 3>() = axes;
  return turn * stiffness * turn.transpose();
}

// `held: true`: a drive beside the element holds the motion that it leaves free, so that what it
// yields there is nothing worth the name.
void hold(const YamlNode& node, Eigen::Index free, Matrix6& stiffness) {
  constexpr double stiffer = 1e3;  // than the stiffest other of its three
  const auto held = node.find("held");
  if (held && held->boolean())
    stiffness(free, free) = stiffer * stiffness.diagonal().segment<3>(free - free % 3).maxCoeff();
}

// `factor: {value: 1, sd: 10 %}`: how well the whole is known.
double factor_of(const YamlNode& node, const PartNumbers& read) {
  const auto given = node.find("factor");
  return given ? read(*given, dimension::none) : 1;
}

// One row at a place of the axis, bearing pushes along z or against it.
BearingRow read_row(const YamlNode& node, const PartNumbers& read, double sign, double place) {
  const auto [kind, count] = node.one_of({"balls", "rollers"});
  const double angle = sign * node.at("contact_angle").quantity(dimension::angle, read.units);
  if (!(std::abs(angle) < 1.5))
    node.at("contact_angle")
        .fail("a contact angle is less than 86 deg",
              "Usual are 0, 15 and 25 deg, of axial bearings 60 deg");
  const double pitch = node.at("pitch_diameter").positive(dimension::length, read.units);
  const int elements = count.integer(3, most_elements);
  if (kind == "rollers")
    return roller_row(elements, node.at("roller_length").positive(dimension::length, read.units),
                      pitch, angle, place);
  const auto groove = [&](const char* key) {
    const auto given = node.find(key);
    return given ? given->number() : usual_conformity;
  };
  return ball_row(elements, node.at("ball_diameter").positive(dimension::length, read.units), pitch,
                  angle, groove("inner_groove"), groove("outer_groove"), place);
}

double approach_of(const YamlNode& node, const PartNumbers& read, const BearingRow& row) {
  const auto [kind, given] = node.one_of({"preload", "interference"});
  if (kind == "preload" && row.contact_angle == 0)
    given.fail("an axial preload does not load a bearing whose contact angle is zero",
               "State its radial 'interference: 5 um', or its 'contact_angle'");
  if (kind == "preload")
    return axial_approach(row, std::copysign(read(given, dimension::force), row.contact_angle));
  const double along = read(given, dimension::length);
  return row.contact_angle < 0 ? -along : along;
}

// Which way each row bears a push, and where it stands.
std::vector<std::pair<double, double>> arrangement_of(const YamlNode& node,
                                                      const UnitSystem& units) {
  const auto given = node.find("arrangement");
  const std::string how =
      given ? given->choice({"single", "back-to-back", "face-to-face"}) : "single";
  if (how == "single") {
    if (const auto spacing = node.find("spacing"))
      spacing->fail("one row has no spacing",
                    "Add 'arrangement: back-to-back' or 'face-to-face', or remove it");
    return {{1, 0}};
  }
  const double half = node.at("spacing").positive(dimension::length, units) / 2;
  const double above = how == "back-to-back" ? -1 : 1;
  return {{above, half}, {-above, -half}};
}

}  // namespace

Matrix6 read_bearing(const YamlNode& node, const UnitSystem& units, SourceList& sources) {
  node.allow_only({"balls", "rollers", "ball_diameter", "roller_length", "pitch_diameter",
                   "contact_angle", "inner_groove", "outer_groove", "preload", "interference",
                   "arrangement", "spacing", "axis", "held", "factor"});
  const PartNumbers read{units, sources, SourceKind::element};
  std::vector<PreloadedRow> rows;
  try {
    for (const auto& [sign, place] : arrangement_of(node, units)) {
      const BearingRow row = read_row(node, read, sign, place);
      rows.push_back({row, approach_of(node, read, row)});
    }
  } catch (const std::invalid_argument& error) {
    node.fail(error.what());
  }
  Matrix6 stiffness = bearing_stiffness(rows);
  hold(node, 5, stiffness);
  const auto axis = node.find("axis");
  const Vector3 along = axis ? axis->direction() : Vector3::UnitZ();
  return factor_of(node, read) *
         in_axes(stiffness,
                 Eigen::Quaterniond::FromTwoVectors(Vector3::UnitZ(), along).toRotationMatrix());
}

namespace {

std::vector<Carriage> read_carriages(const YamlNode& node, const PartNumbers& read) {
  Carriage one{.lateral = read(node.at("lateral"), dimension::linear_stiffness),
               .normal = read(node.at("normal"), dimension::linear_stiffness)};
  for (const auto& [key, value] :
       {std::pair("roll", &one.roll), std::pair("pitch", &one.pitch), std::pair("yaw", &one.yaw)})
    if (const auto given = node.find(key)) *value = read(*given, dimension::torsional_stiffness);
  const auto places = node.find("carriages");
  if (!places) return {one};
  std::vector<Carriage> carriages;
  for (const YamlNode& place : places->items()) {
    one.place = place.vector3(dimension::length, read.units);
    carriages.push_back(one);
  }
  if (carriages.empty()) places->fail("at least one carriage is expected");
  return carriages;
}

}  // namespace

Matrix6 read_guide(const YamlNode& node, const UnitSystem& units, SourceList& sources) {
  node.allow_only(
      {"lateral", "normal", "roll", "pitch", "yaw", "carriages", "along", "up", "held", "factor"});
  const PartNumbers read{units, sources, SourceKind::element};
  Matrix6 stiffness = guide_stiffness(read_carriages(node, read));
  for (const auto& [k, cure] : {std::pair(3, "roll"), std::pair(4, "pitch"), std::pair(5, "yaw")})
    if (!(stiffness(k, k) > 0))
      node.fail(fmt::format("nothing of this guide resists its {}", cure),
                fmt::format("State '{}' of a carriage, or more carriages that are apart", cure));
  hold(node, 0, stiffness);
  const auto along = node.find("along"), up = node.find("up");
  const Vector3 x = along ? along->direction() : Vector3::UnitX(),
                z = up ? up->direction() : Vector3::UnitZ();
  if (!(z.cross(x).norm() > 1e-6)) node.fail("'up' of this guide is along its rail");
  return factor_of(node, read) * in_axes(stiffness, spatial::rotation_from_axes(x, z.cross(x)));
}

StiffnessTable read_ball_screw(const YamlNode& node, const UnitSystem& units,
                               const std::string& joint, SourceList& sources) {
  constexpr int places = 33;
  node.allow_only({"core_diameter", "length", "zero", "E", "nut", "bearing", "other_bearing"});
  const auto read = [&](const YamlNode& given, const spatial::Dimension& of) {
    UncertaintySource source{
        .name = given.path().substr(given.path().rfind('.') + 1) + " of the screw of " + joint,
        .place = {},
        .kind = SourceKind::element};
    return read_uncertain(given, of, units, std::move(source), sources);
  };
  const double core = read(node.at("core_diameter"), dimension::length);
  BallScrew screw{.shaft_area = std::numbers::pi / 4 * core * core,
                  .length = node.at("length").positive(dimension::length, units),
                  .nut = read(node.at("nut"), dimension::linear_stiffness),
                  .bearing = read(node.at("bearing"), dimension::linear_stiffness)};
  if (const auto given = node.find("E")) screw.young_modulus = read(*given, dimension::pressure);
  if (const auto given = node.find("other_bearing"))
    screw.other_bearing = read(*given, dimension::linear_stiffness);
  const double zero = node.at("zero").quantity(dimension::length, units);
  std::vector<double> commands, stiffness;
  for (int i = 0; i < places; ++i) {
    const double place = screw.length * i / (places - 1);
    commands.push_back(place - zero);
    stiffness.push_back(axial_stiffness(screw, place));
  }
  return {std::move(commands), stiffness};
}

}  // namespace kinetostat::vjm
