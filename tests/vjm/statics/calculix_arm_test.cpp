// The heavy arm under its own weight against beam elements of CalculiX, an independent program.
//
// Beams: B32R of CalculiX, solids inside; with Poisson's ratio 0 their clamped ends hold like those
// of beam theory. Joints: statically determinate, by hand.
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <sstream>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "kinetostat/io/text_file.h"
#include "kinetostat/spatial/rotation.h"
#include "kinetostat/vjm/io/robot_file.h"
#include "kinetostat/vjm/manipulator/posture.h"
#include "kinetostat/vjm/statics/equilibrium.h"
#include "kinetostat/vjm/statics/segments.h"

#include "support/program.h"
#include "support/temporary_folder.h"

namespace kinetostat::vjm::calculix_arm_test {
namespace {

using spatial::Vector3;

constexpr double gravity = 9.80665, young = 210e9, density = 7850;
constexpr double degree = M_PI / 180;

// In the plane of the arm: thickness across it, height in it.
struct Box {
  double thickness, height;
};
constexpr Box upper_box{0.16, 0.22}, forearm_box{0.12, 0.15};

Vector3 turned(double angle, const Vector3& v) { return spatial::exp_rotation({0, angle, 0}) * v; }

// Where the arm of data/robots/heavy_arm.yaml stands with q = (0, 20, -20, 0, 30, 0) degrees.
const Vector3 shoulder(0.35, 0, 0.675);
const Vector3 elbow = shoulder + turned(20 * degree, {0, 0, 1.150});
const Vector3 forearm_start = elbow + Vector3(0.250, 0, -0.041);
const Vector3 wrist = forearm_start + Vector3(0.950, 0, 0);
const Vector3 tool = wrist + turned(30 * degree, {0.240, 0, -0.120});

struct Weight {
  double mass;
  Vector3 center;
};
// Masses at points: elbow casting, flange, payload.
const std::vector<Weight> at_elbow = {{160, elbow + Vector3(0.060, 0, 0)}};
const std::vector<Weight> at_wrist = {{60, wrist + turned(30 * degree, {0.100, 0, 0})},
                                      {150, wrist + turned(30 * degree, {0.290, 0, -0.100})}};

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

// In mm. The solids inside B32R keep a section plane: their shear is not corrected. The arm bends
// in its plane only, so J does not matter.
std::string section(const Box& box) {
  const double t = 1e3 * box.thickness, h = 1e3 * box.height;
  return fmt::format("{{A: {}, Iy: {}, Iz: {}, J: {}, shear_y: 1, shear_z: 1}}", t * h,
                     t * h * h * h / 12, h * t * t * t / 12, t * h * h * h / 12);
}

// The shipped arm without compensator, with the boxes as sections.
Robot arm(int segments, int segment_multiple = 1) {
  std::string text =
      io::read_text(std::string(KINETOSTAT_SOURCE_DIR) + "/data/robots/heavy_arm.yaml");
  const auto box = [&](const char* length, const Box& b, const char* direction) {
    const std::size_t at = text.find(fmt::format("beam: {{length: {}", length));
    const std::size_t end = text.find('\n', at);
    text.replace(
        at, end - at,
        fmt::format("beam: {{length: {}, direction: {}, section: {{general: {}}}, material: "
                    "steel, segments: {}}}",
                    length, direction, section(b), segments));
  };
  box("1150", upper_box, "[0, 0, 1]");
  box("950", forearm_box, "[1, 0, 0]");
  text = replaced(text, "nu: 0.3", "nu: 0.0");
  const std::size_t rod = text.find("    - {name: rod,");
  text.erase(rod, text.find('\n', rod) + 1 - rod);
  const test::TemporaryFolder folder;
  io::write_atomically(folder.path() / "arm.yaml", text);
  return read_robot(folder.path() / "arm.yaml", {.segment_multiple = segment_multiple});
}

// A deck of B32R beams from the shoulder to the tool; returns the number of the tool's node.
class Deck {
 public:
  void beam(const std::string& set, const Vector3& from, const Vector3& to, int elements) {
    if (nodes_ == 0) node(from);
    elements_ += fmt::format("*ELEMENT,TYPE=B32R,ELSET={}\n", set);
    for (int i = 0; i < elements; ++i) {
      const int first = nodes_;
      for (int k = 1; k <= 2; ++k) node(from + (to - from) * (2.0 * i + k) / (2.0 * elements));
      elements_ += fmt::format("{},{},{},{}\n", ++count_, first, first + 1, first + 2);
    }
  }
  int last_node() const { return nodes_; }
  void load(int node, const Vector3& place, const std::vector<Weight>& weights) {
    for (const Weight& w : weights) {
      loads_ += fmt::format("{},3,{}\n", node, -w.mass * gravity);
      loads_ += fmt::format("{},5,{}\n", node, (w.center - place).x() * w.mass * gravity);
    }
  }
  std::string text() const {
    const auto section = [](const char* set, const char* material, const Box& b) {
      return fmt::format("*BEAM SECTION,ELSET={},MATERIAL={},SECTION=RECT\n{},{}\n0.,1.,0.\n", set,
                         material, b.thickness, b.height);
    };
    return "*NODE,NSET=ALL\n" + node_lines_ + elements_ +
           fmt::format(
               "*MATERIAL,NAME=STEEL\n*ELASTIC\n{},0.\n*DENSITY\n{}\n"
               "*MATERIAL,NAME=RIGID\n*ELASTIC\n{},0.\n*DENSITY\n1.\n",
               young, density, 1e4 * young) +
           section("UPPER", "STEEL", upper_box) + section("FOREARM", "STEEL", forearm_box) +
           section("ELBOW", "RIGID", upper_box) + section("TOOL", "RIGID", forearm_box) +
           "*BOUNDARY\n1,1,6\n*STEP\n*STATIC\n*DLOAD\n" +
           fmt::format("UPPER,GRAV,{0},0.,0.,-1.\nFOREARM,GRAV,{0},0.,0.,-1.\n*CLOAD\n", gravity) +
           loads_ + "*NODE PRINT,NSET=ALL\nU\n*END STEP\n";
  }

 private:
  void node(const Vector3& p) {
    node_lines_ += fmt::format("{},{:.9f},{:.9f},{:.9f}\n", ++nodes_, p.x(), p.y(), p.z());
  }

  std::string node_lines_, elements_, loads_;
  int nodes_ = 0, count_ = 0;
};

Vector3 solved(const Deck& deck, int wanted) {
  const test::TemporaryFolder folder;
  std::ofstream(folder.path() / "arm.inp") << deck.text();
  const std::string call = "cd '" + folder.path().string() + "' && ccx arm > ccx.log 2>&1";
  EXPECT_EQ(std::system(call.c_str()), 0) << io::read_text(folder.path() / "ccx.log");
  std::istringstream lines(io::read_text(folder.path() / "arm.dat"));
  for (std::string line; std::getline(lines, line);) {
    std::istringstream row(line);
    int node = 0;
    Vector3 u;
    if (row >> node >> u.x() >> u.y() >> u.z() && node == wanted) return u;
  }
  ADD_FAILURE() << "no displacement of node " << wanted;
  return Vector3::Zero();
}

Vector3 bending_by_calculix() {
  Deck deck;
  deck.beam("UPPER", shoulder, elbow, 20);
  deck.load(deck.last_node(), elbow, at_elbow);
  deck.beam("ELBOW", elbow, forearm_start, 2);
  deck.beam("FOREARM", forearm_start, wrist, 20);
  deck.load(deck.last_node(), wrist, at_wrist);
  deck.beam("TOOL", wrist, tool, 2);
  return solved(deck, deck.last_node());
}

// A hinge about y with a spring gives way by torque over stiffness and swings the tool about it.
Vector3 swing_of_joint(const Vector3& joint, double stiffness, const std::vector<Weight>& beyond) {
  double torque = 0;
  for (const Weight& w : beyond) torque += (w.center - joint).x() * w.mass * gravity;
  return Vector3(0, torque / stiffness, 0).cross(tool - joint);
}

Vector3 swing_of_joints() {
  const Weight upper{density * upper_box.thickness * upper_box.height * 1.150,
                     0.5 * (shoulder + elbow)};
  const Weight forearm{density * forearm_box.thickness * forearm_box.height * 0.950,
                       0.5 * (forearm_start + wrist)};
  std::vector<Weight> beyond = at_wrist;
  Vector3 sum = swing_of_joint(wrist, 3.0e5, beyond);
  beyond.push_back(forearm);
  beyond.insert(beyond.end(), at_elbow.begin(), at_elbow.end());
  sum += swing_of_joint(elbow, 2.5e6, beyond);
  beyond.push_back(upper);
  return sum + swing_of_joint(shoulder, 3.3e6, beyond);
}

// To first order, as CalculiX's linear step: a ten-thousandth of the weight, times ten thousand.
Vector3 first_order_displacement(int segments) {
  const Robot robot = arm(segments);
  const Posture posture = posture_from_joints(robot.manipulator, {}).posture;
  EXPECT_LT((posture.platform.position() - tool).norm(), 1e-9);
  const Equilibrium e = equilibrium_under_load(robot.manipulator, posture, {.gravity = 1e-4});
  EXPECT_EQ(e.status, EquilibriumStatus::converged) << e.reason;
  return 1e4 * e.displacement.translation;
}

Equilibrium under_its_weight(const Robot& robot) {
  return equilibrium_under_load(robot.manipulator,
                                posture_from_joints(robot.manipulator, {}).posture, {});
}

TEST(HeavyArmUnderItsWeight, AgreesWithBeamElementsOfCalculix) {
  ASSERT_TRUE(test::is_installed("ccx"));
  const Vector3 beams = bending_by_calculix(), joints = swing_of_joints();
  const Vector3 expected = beams + joints, ours = first_order_displacement(1);
  RecordProperty("calculix_um", fmt::format("{:.3f}", 1e6 * expected.norm()));
  RecordProperty("ours_um", fmt::format("{:.3f}", 1e6 * ours.norm()));
  EXPECT_GT(beams.norm(), 0.05 * expected.norm());
  // The difference is less than what the library itself says that its lumped beams are worth.
  const std::optional<double> stated =
      lumping_error(under_its_weight(arm(1)), under_its_weight(arm(1, 2)), false);
  ASSERT_TRUE(stated);
  RecordProperty("stated_um", fmt::format("{:.3f}", 1e6 * *stated * expected.norm()));
  EXPECT_LT((ours - expected).norm(), *stated * expected.norm());
}

// One spring per link carries the distributed weight exactly to first order: more segments change
// nothing.
TEST(HeavyArmUnderItsWeight, SegmentsDoNotMatterToFirstOrder) {
  const Vector3 one = first_order_displacement(1);
  EXPECT_LT((first_order_displacement(4) - one).norm(), 1e-4 * one.norm());
}

}  // namespace
}  // namespace kinetostat::vjm::calculix_arm_test
