// A frame and the legs on it, each by finite elements of its own and put together as a robot,
// against CalculiX on one mesh of all of it.
#include <cstdlib>
#include <functional>
#include <map>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "kinetostat/fea/interface/reduced_stiffness.h"
#include "kinetostat/fea/link/calculix_deck.h"
#include "kinetostat/fea/link/link_response.h"
#include "kinetostat/fea/link/reduced_model.h"
#include "kinetostat/io/text_file.h"
#include "kinetostat/vjm/manipulator/posture.h"
#include "kinetostat/vjm/statics/stiffness.h"
#include "kinetostat/vjm/vibration/natural_modes.h"

#include "fea/calculix_modes.h"
#include "fea/shapes.h"
#include "support/program.h"
#include "vjm/elastic_sample.h"

namespace kinetostat::report::elastic_frame_test {
namespace {

using Eigen::MatrixXd;
using fea::CoupledInterface;
using fea::TetMesh;
using spatial::Matrix6;
using spatial::Vector3;

const std::vector<fea::Material> steel{fea::Material(210e9, 0.3, 7850)};

// A plate of 0.3 x 0.2 x 0.04 m, on which three legs stand, cut from the cells of one box.
// Interface 1 is the side of the plate at x = 0, 2 to 4 are where the legs stand, 5 the tops of all
// of them.
constexpr double top = 0.24, thick = 0.04;
const Vector3 tool(0.14, 0.09, 0.3);
struct Leg {
  double x, y;  // of its lower corner
  Vector3 foot() const { return {x + 0.025, y + 0.025, thick}; }
  Vector3 head() const { return {x + 0.025, y + 0.025, top}; }
  bool has(const Vector3& p) const {
    return p.x() > x - 1e-9 && p.x() < x + 0.05 + 1e-9 && p.y() > y - 1e-9 &&
           p.y() < y + 0.05 + 1e-9;
  }
};
const std::vector<Leg> legs{{0.1, 0}, {0.25, 0.05}, {0.15, 0.15}};

// The part of a mesh that some elements are, by their centroids; faces get the tags of their
// centroids, but for 0.
TetMesh part_of(const TetMesh& all, const std::function<bool(const Vector3&)>& keep,
                const std::function<int(const Vector3& face, const Vector3& element)>& tag) {
  TetMesh part;
  std::map<int, int> numbers;
  const auto number = [&](int node) {
    const auto [at, is_new] = numbers.emplace(node, static_cast<int>(part.nodes.size()));
    if (is_new) part.nodes.push_back(all.nodes[static_cast<std::size_t>(node)]);
    return at->second;
  };
  for (std::size_t e = 0; e < all.element_count(); ++e) {
    const auto corners = all.corners(e);
    const Vector3 center = (corners[0] + corners[1] + corners[2] + corners[3]) / 4;
    if (!keep(center)) continue;
    for (const int node : all.element(e)) part.connectivity.push_back(number(node));
    for (const auto& side : {std::array{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}}) {
      fea::BoundaryFace face{.nodes = {-1, -1, -1, -1, -1, -1}, .tag = 0};
      Vector3 middle = Vector3::Zero();
      for (std::size_t c = 0; c < 3; ++c) {
        face.nodes[c] = number(all.element(e)[static_cast<std::size_t>(side[c])]);
        middle += corners[static_cast<std::size_t>(side[c])] / 3;
      }
      face.tag = tag(middle, center);
      if (face.tag > 0) part.boundary.push_back(face);
    }
  }
  return fea::with_mid_nodes(part);
}

bool in_plate(const Vector3& p) { return p.z() < thick; }

bool in_some_leg(const Vector3& p) {
  return !in_plate(p) &&
         std::any_of(legs.begin(), legs.end(), [&](const Leg& leg) { return leg.has(p); });
}

// Faces between plate and leg are those of the plate.
int tag_of(const Vector3& face, const Vector3& element) {
  if (std::abs(face.x()) < 1e-9) return 1;
  for (std::size_t i = 0; i < legs.size(); ++i)
    if (std::abs(face.z() - thick) < 1e-9 && in_plate(element) && legs[i].has(face))
      return static_cast<int>(i) + 2;
  return std::abs(face.z() - top) < 1e-9 ? 5 : 0;
}

std::vector<CoupledInterface> interfaces_of(const TetMesh& mesh, const std::vector<int>& tags,
                                            const std::vector<Vector3>& points) {
  static const std::vector<std::string> names{"", "side", "a", "b", "c", "tool"};
  std::vector<CoupledInterface> interfaces;
  for (std::size_t i = 0; i < tags.size(); ++i)
    interfaces.push_back({.name = names[static_cast<std::size_t>(tags[i])],
                          .geometry = fea::interface_on(mesh, tags[i]),
                          .point = points[i]});
  return interfaces;
}

MatrixXd flexibility_of(const TetMesh& mesh, const std::vector<CoupledInterface>& interfaces) {
  common::Progress silent;
  return respond(mesh, steel, interfaces, {}, silent).flexibility;
}

class ElasticFrame : public testing::Test {
 protected:
  const TetMesh cells_ = fea::box_mesh({0.3, 0.2, top}, 6, 4, 6);
  const Vector3 side_{0, 0.1, 0.02};

  io::Json frame() const {
    const TetMesh mesh = part_of(cells_, in_plate, tag_of);
    const auto interfaces =
        interfaces_of(mesh, {1, 2, 3, 4}, {side_, legs[0].foot(), legs[1].foot(), legs[2].foot()});
    vjm::samples::BodyBetweenPoints body({}, {}, 0);
    for (const CoupledInterface& interface : interfaces) {
      body.names.push_back(interface.name);
      body.points.push_back(interface.point);
    }
    common::Progress silent;
    const fea::LinkResponse response = respond(mesh, steel, interfaces, {}, silent);
    body.stiffness = fea::reduced_stiffness(response.flexibility, interfaces);
    body.inertia = fea::guyan_mass(mesh, steel, interfaces, response);
    return body.json();
  }

  // As a link of a robot file, from foot to head.
  // With its mass, which two halves have, and its inertia.
  std::string link(const Leg& leg) const {
    const TetMesh mesh = part_of(
        cells_, [&](const Vector3& p) { return !in_plate(p) && leg.has(p); },
        [](const Vector3& face, const Vector3&) {
          return std::abs(face.z() - thick) < 1e-9 ? 1 : std::abs(face.z() - top) < 1e-9 ? 5 : 0;
        });
    const MatrixXd raw =
        flexibility_of(mesh, interfaces_of(mesh, {1, 5}, {leg.foot(), leg.head()}));
    const MatrixXd compliance = 0.5 * (raw + raw.transpose());
    std::string text = "{compliance: [";
    for (int i = 0; i < 6; ++i) {
      text += i == 0 ? "[" : ", [";
      for (int j = 0; j < 6; ++j) text += fmt::format("{}{:.17g}", j ? ", " : "", compliance(i, j));
      text += "]";
    }
    constexpr double wide = 0.05, high = top - thick, mass = 7850 * wide * wide * high;
    constexpr double across = mass * (wide * wide + high * high) / 12,
                     along = mass * wide * wide / 6;
    return text + fmt::format(
                      "], end: [0, 0, {0}], mass: {{mass: {1}, center: [0, 0, {2}], "
                      "inertia: [{3}, 0, 0, {3}, 0, {4}]}}}}",
                      high, mass, high / 2, across, along);
  }

  // `load` [kg]: at the tool.
  vjm::Robot robot(double load = 0) const {
    std::string text =
        "kinetostat: 1\nname: table\nunits: {length: m, force: N, angle: rad}\nlinks:\n";
    std::string types = "chain_types:\n", chains;
    for (std::size_t i = 0; i < legs.size(); ++i) {
      const char name = "abc"[i];
      text += fmt::format("  {}: {}\n", name, link(legs[i]));
      const Vector3 foot = legs[i].foot(), head = legs[i].head() - tool;
      types += fmt::format("  {0}: [{{link: {0}}}", name);
      if (i == 0 && load > 0)
        types += fmt::format(", {{mass: {{name: load, mass: {}, at: [{}, {}, {}]}}}}", load,
                             -head.x(), -head.y(), -head.z());
      types += "]\n";
      chains += fmt::format(
          "    - {{name: {0}, type: {0}, from: frame.{0}, base: [{1}, {2}, {3}], platform_point: "
          "[{4}, {5}, {6}]}}\n",
          name, foot.x(), foot.y(), foot.z(), head.x(), head.y(), head.z());
    }
    return vjm::samples::robot_with_body(
        text + types +
            "manipulator:\n  bodies: [{name: frame, elastic: body.json, interfaces: {side: "
            "base}}]\n  chains:\n" +
            chains,
        frame());
  }
};

TEST_F(ElasticFrame, AgreesWithCalculixOnOneMeshOfFrameAndLegs) {
  ASSERT_TRUE(test::is_installed("ccx"));
  const TetMesh mesh = part_of(
      cells_, [](const Vector3& p) { return in_plate(p) || in_some_leg(p); }, tag_of);
  const auto interfaces = interfaces_of(
      mesh, {1, 2, 3, 4, 5}, {side_, legs[0].foot(), legs[1].foot(), legs[2].foot(), tool});
  const fea::TemporaryFolder folder;
  folder.file("table.inp", calculix_deck("table", mesh, steel, interfaces));
  const std::string call = "cd '" + folder.path().string() + "' && ccx table > ccx.log 2>&1";
  ASSERT_EQ(std::system(call.c_str()), 0) << io::read_text(folder.path() / "ccx.log");
  const Matrix6 other =
      fea::read_calculix_flexibility(io::read_text(folder.path() / "table.dat"), 4)
          .bottomRightCorner<6, 6>();

  const vjm::Robot table = robot();
  const vjm::PostureResult posture = posture_from_joints(table.manipulator, {});
  ASSERT_TRUE(posture.reached) << posture.reason;
  EXPECT_LT((posture.posture.platform.position() - tool).norm(), 1e-12);
  const Matrix6 ours =
      unloaded_stiffness(table.manipulator, posture.posture).compliance.value().matrix();
  double worst = 0;
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 6; ++j)
      worst = std::max(worst,
                       std::abs(ours(i, j) - other(i, j)) / std::sqrt(other(i, i) * other(j, j)));
  RecordProperty("worst", fmt::format("{:.2g}", worst));
  EXPECT_LT(worst, 1e-3);
  // Without the frame it would be another machine.
  const Matrix6 rigid = [&] {
    Matrix6 sum = Matrix6::Zero();
    vjm::ChainKinematics kinematics;
    for (std::size_t c = 0; c < 3; ++c) {
      evaluate(table.manipulator.chains()[c], posture.posture.coordinates[c], kinematics,
               posture.posture.body(table.manipulator.span(c).from));
      sum += vjm::unloaded_stiffness(table.manipulator.chains()[c], kinematics).value().matrix();
    }
    return Matrix6(sum.inverse());
  }();
  EXPECT_GT((ours - rigid).norm(), 0.2 * ours.norm());
}

// A load that stands on the legs, which are links of the robot with masses in two halves; the
// fourth mode bends them.
TEST_F(ElasticFrame, HasTheFrequenciesThatCalculixFindsOnOneMesh) {
  ASSERT_TRUE(test::is_installed("ccx"));
  constexpr double load = 60;
  const TetMesh mesh = part_of(
      cells_, [](const Vector3& p) { return in_plate(p) || in_some_leg(p); }, tag_of);
  const auto interfaces = interfaces_of(
      mesh, {1, 2, 3, 4, 5}, {side_, legs[0].foot(), legs[1].foot(), legs[2].foot(), tool});
  const std::string deck = calculix_deck("table", mesh, steel, interfaces);
  const std::size_t at = deck.rfind("REF NODE=") + 9;
  const std::string node = deck.substr(at, deck.find_first_of(", \n", at) - at);
  const std::vector<double> other =
      fea::frequencies_by_calculix(deck,
                                   "*ELEMENT, TYPE=MASS, ELSET=LOAD\n9999999, " + node +
                                       fmt::format("\n*MASS, ELSET=LOAD\n{}\n", load),
                                   7850, 4);
  ASSERT_EQ(other.size(), 4u);
  const vjm::Robot table = robot(load);
  const vjm::PostureResult posture = posture_from_joints(table.manipulator, {});
  const vjm::NaturalModes ours = natural_modes(table.manipulator, posture.posture, 4);
  for (std::size_t k = 0; k < 4; ++k)
    EXPECT_NEAR(ours.modes[k].frequency, other[k], (k < 3 ? 5e-3 : 1e-2) * other[k]) << k;
}

}  // namespace
}  // namespace kinetostat::report::elastic_frame_test
