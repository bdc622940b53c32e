#include "kinetostat/vjm/io/robot_file.h"

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <unistd.h>

#include <Eigen/LU>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetostat/common/error.h"
#include "kinetostat/io/json.h"
#include "kinetostat/vjm/chain/beam.h"
#include "kinetostat/vjm/manipulator/posture.h"
#include "kinetostat/vjm/statics/stiffness.h"

namespace kinetostat::vjm::robot_file_test {
namespace {

using spatial::Pose;
using spatial::Vector3;
using ::testing::HasSubstr;

const std::string good = R"(kinetostat: 1
name: arm
units: {length: mm, force: N, angle: deg}
materials:
  steel: {E: 210 GPa, nu: 0.3}
links:
  upper: {beam: {length: 400, section: {circle: {diameter: 30}}, material: steel}}
  lower: {rigid: [300, 0, 0]}
chain_types:
  arm:
    - actuator: {name: q1, axis: Rz, stiffness: 2.0e7, home: 10}
    - link: upper
    - passive: {name: p, axis: Ry, stiffness: 5 N m/rad, rest: 3}
    - link: lower
    - tool: [50, 0, 0]
manipulator: {chain: arm}
uncertain: [{stiffness: upper}]
)";

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

class RobotFile : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::path(::testing::TempDir()) /
              ("robot_file_" + std::to_string(::getpid()) + "_" +
               ::testing::UnitTest::GetInstance()->current_test_info()->name());
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  Robot read(const std::string& text) {
    const auto file = folder_ / "robot.yaml";
    std::ofstream(file) << text;
    return read_robot(file);
  }
  std::string error_of(const std::string& text) {
    try {
      read(text);
    } catch (const common::InputError& error) {
      return error.what();
    }
    ADD_FAILURE() << "was accepted";
    return {};
  }

  std::filesystem::path folder_;
};

TEST_F(RobotFile, IsReadWithItsUnits) {
  const Robot robot = read(good);
  const Chain& chain = robot.manipulator.chains().at(0);
  EXPECT_EQ(robot.name, "arm");
  ASSERT_EQ(chain.springs().size(), 3u);
  EXPECT_NEAR(chain.springs()[0].stiffness(0, 0), 2.0e4, 1e-9);  // N mm/rad to N m/rad
  EXPECT_NEAR(chain.springs()[2].stiffness(0, 0), 5, 1e-12);
  EXPECT_NEAR(chain.default_rest()[chain.index_of("p")], 3 * M_PI / 180, 1e-15);
  EXPECT_NEAR(chain.home()[0], 10 * M_PI / 180, 1e-15);
  ASSERT_EQ(robot.uncertain.size(), 1u);
  EXPECT_EQ(robot.uncertain[0].springs.at(0).spring, "upper");
}

// Twice on one spring multiplies; a bound stays where the file's own stiffness puts it.
TEST_F(RobotFile, FittedFactorsMultiplyTheSprings) {
  const std::string uncertain = "uncertain: [{stiffness: upper}]";
  const Robot as_built = read(good);
  const Robot robot = read(replaced(
      good, uncertain,
      "uncertain: [{stiffness: q1, between: [0.5, 2]}]\nfitted:\n"
      "  - {stiffness: q1, factor: {value: 0.8, sd: 0.1}}\n  - {stiffness: arm.upper, factor: 2}\n"
      "  - {stiffness: q1, factor: 0.5}\n"));
  const auto& before = as_built.manipulator.chains()[0].springs();
  const auto& after = robot.manipulator.chains()[0].springs();
  EXPECT_NEAR(after[0].stiffness(0, 0), 0.4 * before[0].stiffness(0, 0), 1e-9);
  EXPECT_LT((after[1].stiffness - 2 * before[1].stiffness).norm(),
            1e-12 * before[1].stiffness.norm());
  EXPECT_EQ(after[2].stiffness, before[2].stiffness);
  ASSERT_EQ(robot.fitted.size(), 3u);
  EXPECT_DOUBLE_EQ(robot.fitted[0].deviation, 0.1);
  EXPECT_TRUE(std::isnan(robot.fitted[1].deviation));
  ASSERT_TRUE(robot.uncertain[0].between);
  EXPECT_NEAR(robot.uncertain[0].between->first, 0.5 / 0.4, 1e-12);
  EXPECT_NEAR(robot.uncertain[0].between->second, 2 / 0.4, 1e-12);
}

TEST_F(RobotFile, AFittedValueTakesThePlaceOfTheEffects) {
  const std::string with_effect = replaced(good, "uncertain:",
                                           "effects: [{effect: preload, at: q1, force: 3 N m}]\n"
                                           "fitted: [{effect: preload, at: q1, parameter: force, "
                                           "value: {value: 5 N m, sd: 0.1 N m}}]\nuncertain:");
  const Robot robot = read(with_effect);
  ASSERT_EQ(robot.effects.size(), 1u);
  EXPECT_DOUBLE_EQ(robot.effects[0].values[0], 5);
  EXPECT_DOUBLE_EQ(robot.effects[0].deviations[0], 0.1);
  EXPECT_THAT(error_of(replaced(with_effect, "parameter: force", "parameter: forze")),
              HasSubstr("Did you mean 'force'?"));
}

TEST_F(RobotFile, ABeamLinkHasTheBeamsStiffness) {
  const Robot robot = read(good);
  const auto tip = beam_compliance(0.4, Section::circle(0.03, 0.3), {210e9, 210e9 / 2.6, {}},
                                   BeamTheory::timoshenko);
  const Spring& spring = robot.manipulator.chains()[0].springs()[1];
  const spatial::Matrix6 product = spring.stiffness * tip.matrix();
  EXPECT_LT((product - spatial::Matrix6::Identity()).norm(), 1e-8);
}

// A name of the file goes before one of the table, and one of the table is a source.
TEST_F(RobotFile, ABeamMayNameACommonMaterial) {
  const std::string written = "material: steel}";
  const Robot robot = read(replaced(good, written, "material: aluminium_6082}"));
  const auto tip = beam_compliance(0.4, Section::circle(0.03, 0.3), {70e9, 70e9 / 2.6, {}},
                                   BeamTheory::timoshenko);
  const Spring& spring = robot.manipulator.chains()[0].springs()[1];
  EXPECT_LT((spring.stiffness * tip.matrix() - spatial::Matrix6::Identity()).norm(), 1e-8);
  ASSERT_EQ(robot.sources.size(), 1u);
  EXPECT_EQ(robot.sources[0].name, "E of aluminium_6082");
  EXPECT_NEAR(robot.sources[0].deviation, 0.02 * 70e9, 1);
  const std::string own =
      replaced(replaced(good, "steel:", "steel_s235:"), written, "material: steel_s235}");
  EXPECT_TRUE(read(own).sources.empty());
  EXPECT_THAT(error_of(replaced(good, written, "material: aluminum_6082}")),
              HasSubstr("Did you mean 'aluminium_6082'?"));
}

// The shear of a beam knows the material: Cowper's coefficients with nu of the file, or of E and G.
TEST_F(RobotFile, TheShearOfABeamIsThatOfItsMaterial) {
  struct Case {
    std::string material, section;
    double shear_modulus, kappa, area;
  };
  const double m2 = 0.64, wide = (1 + m2) * (1 + m2), nu = 0.25;
  const std::vector<Case> cases = {
      {"{E: 200 GPa, nu: 0.25}", "circle: {diameter: 30}", 80e9, 7.5 / 8.5, M_PI * 0.015 * 0.015},
      {"{E: 200 GPa, G: 80 GPa}", "circle: {diameter: 30}", 80e9, 7.5 / 8.5, M_PI * 0.015 * 0.015},
      {"{E: 200 GPa, G: 100 GPa}", "circle: {diameter: 30}", 100e9, 6.0 / 7, M_PI * 0.015 * 0.015},
      {"{E: 200 GPa, nu: 0.25}", "rectangle: {y: 30, z: 20}", 80e9, 12.5 / 14.75, 0.03 * 0.02},
      {"{E: 200 GPa, nu: 0.25}", "tube: {outer: 30, inner: 24}", 80e9,
       6 * (1 + nu) * wide / ((7 + 6 * nu) * wide + (20 + 12 * nu) * m2),
       M_PI * (0.015 * 0.015 - 0.012 * 0.012)}};
  const std::string written = "section: {circle: {diameter: 30}}, material: steel";
  for (const Case& c : cases) {
    const auto compliance = [&](const std::string& theory) {
      const Robot robot = read(replaced(
          good, written,
          "section: {" + c.section + "}, material: " + c.material + ", theory: " + theory));
      return spatial::Matrix6(
          spatial::Matrix6(robot.manipulator.chains()[0].springs()[1].stiffness).inverse());
    };
    const double shear = compliance("timoshenko")(1, 1) - compliance("euler-bernoulli")(1, 1);
    const double expected = 0.4 / (c.kappa * c.shear_modulus * c.area);
    EXPECT_NEAR(shear, expected, 1e-6 * expected) << c.material << c.section;
  }
}

// A beam along y with its section turned, against the same beam along x seen from a turned frame.
TEST_F(RobotFile, TheDirectionOfABeamTurnsItsCompliance) {
  const auto with_beam = [&](const std::string& extra) {
    return read(replaced(good, "{beam: {length: 400, section: {circle: {diameter: 30}}",
                         "{beam: {length: 400, section: {rectangle: {y: 30, z: 12}}" + extra));
  };
  const auto compliance = [](const Robot& robot) {
    return spatial::Matrix6(
        spatial::Matrix6(robot.manipulator.chains()[0].springs()[1].stiffness).inverse());
  };
  const spatial::Matrix6 along_x = compliance(with_beam(""));
  const spatial::Matrix6 along_y = compliance(with_beam(", direction: [0, 1, 0]"));
  const spatial::Matrix6 flipped = compliance(with_beam(", section_y: [0, 0, 1]"));
  const spatial::Matrix3 quarter = (spatial::Matrix3() << 0, -1, 0, 1, 0, 0, 0, 0, 1).finished();
  const spatial::Matrix6 turned = spatial::Compliance6(along_x, {.axes = quarter}).in({}).matrix();
  EXPECT_LT((turned - along_y).norm(), 1e-12 * turned.norm());
  EXPECT_NEAR(flipped(1, 1), along_x(2, 2), 1e-12 * flipped(1, 1));
}

TEST_F(RobotFile, SegmentsInSeriesAreTheWholeLink) {
  const Robot one = read(good);
  const Robot four = read(replaced(good, "material: steel}", "material: steel, segments: 4}"));
  EXPECT_EQ(four.manipulator.chains()[0].springs().size(), 6u);
  EXPECT_EQ(four.uncertain[0].springs.size(), 4u);
  const auto stiffness = [](const Robot& robot) {
    const Posture posture = posture_from_joints(robot.manipulator, {}).posture;
    return unloaded_stiffness(robot.manipulator, posture).stiffness->matrix();
  };
  EXPECT_LT((stiffness(one) - stiffness(four)).norm(), 1e-9 * stiffness(one).norm());
}

TEST_F(RobotFile, InlineMatricesAndIdentifiedLinksAreTheSameLink) {
  const auto tip = beam_compliance(0.4, Section::circle(0.03, 0.3), {210e9, 210e9 / 2.6, {}},
                                   BeamTheory::timoshenko);
  io::write_json(folder_ / "upper.link.json", io::to_json(tip));
  const std::string from_file =
      replaced(good, "{beam: {length: 400, section: {circle: {diameter: 30}}, material: steel}}",
               "{compliance: upper.link.json, copies: 2}");
  const Robot identified = read(from_file);
  // The same matrix typed in, in N and mm.
  std::string rows = "{compliance: [";
  for (int i = 0; i < 6; ++i) {
    rows += i ? ", [" : "[";
    for (int j = 0; j < 6; ++j) {
      const double scale = (i < 3 ? 1e3 : 1) * (j < 3 ? 1 : 1e-3);
      char entry[40];
      std::snprintf(entry, sizeof entry, "%s%.17g", j ? ", " : "", tip.matrix()(i, j) * scale);
      rows += entry;
    }
    rows += "]";
  }
  const Robot typed =
      read(replaced(from_file, "{compliance: upper.link.json", rows + "], end: [400, 0, 0]"));
  const auto& a = identified.manipulator.chains()[0];
  const auto& b = typed.manipulator.chains()[0];
  EXPECT_LT((a.stiffness() - b.stiffness()).norm(), 1e-9 * a.stiffness().norm());
  EXPECT_LT((a.joints()[1].before.position() - b.joints()[1].before.position()).norm(), 1e-15);
  EXPECT_EQ(identified.link_files.size(), 1u);
}

// A link file repaired by hand: its mass is either usable or refused by name.
TEST_F(RobotFile, TheMassOfAnIdentifiedLinkNeedsACentre) {
  const auto refusal = [&](const io::Json& mass, const io::Json& center) {
    io::Json link = io::to_json(beam_compliance(0.4, Section::circle(0.03, 0.3),
                                                {210e9, 210e9 / 2.6, {}}, BeamTheory::timoshenko));
    link["mass"] = mass;
    if (!center.is_null()) link["center_of_mass"] = center;
    io::write_json(folder_ / "upper.link.json", link);
    try {
      read(replaced(good,
                    "{beam: {length: 400, section: {circle: {diameter: 30}}, material: steel}}",
                    "{compliance: upper.link.json}"));
    } catch (const common::InputError& error) {
      EXPECT_THAT(error.what(), HasSubstr("upper.link.json"));
      return error.details().key;
    }
    return std::string("none");
  };
  const io::Json middle{0.2, 0.0, 0.0};
  EXPECT_EQ(refusal(2.2, middle), "none");
  EXPECT_EQ(refusal(nullptr, nullptr), "none");
  EXPECT_EQ(refusal(2.2, nullptr), "center_of_mass");
  EXPECT_EQ(refusal(2.2, 0.2), "center_of_mass");
  EXPECT_EQ(refusal(2.2, {0.2, 0.0}), "center_of_mass");
  EXPECT_EQ(refusal(2.2, {0.2, "0", 0.0}), "center_of_mass");
  EXPECT_EQ(refusal("2.2", middle), "mass");
  EXPECT_EQ(refusal(-1, middle), "mass");
}

// Of a link that the robot file gives a mass it is that, in the file's units, kg mm^2 here.
TEST_F(RobotFile, AnIdentifiedLinkMayHaveAMassAndInertiaOfTheRobotFile) {
  io::Json link = io::to_json(beam_compliance(0.4, Section::circle(0.03, 0.3),
                                              {210e9, 210e9 / 2.6, {}}, BeamTheory::timoshenko));
  link["mass"] = 1;
  link["center_of_mass"] = {0.2, 0.0, 0.0};
  io::write_json(folder_ / "upper.link.json", link);
  const auto with = [](const std::string& mass) {
    return replaced(good,
                    "{beam: {length: 400, section: {circle: {diameter: 30}}, material: steel}}",
                    "{compliance: upper.link.json, mass: " + mass + "}");
  };
  const Robot robot =
      read(with("{mass: 3 kg, center: [100, 0, 0], inertia: [1000, 0, 0, 2e3, 0, 0.0015 kg m^2]}"));
  const std::vector<PointMass>& masses = robot.manipulator.chains()[0].masses();
  ASSERT_EQ(masses.size(), 2u);
  EXPECT_DOUBLE_EQ(masses[0].mass + masses[1].mass, 3);
  const spatial::Matrix3 inertia = masses[0].inertia + masses[1].inertia;
  EXPECT_LT((inertia.diagonal() - spatial::Vector3(0.001, 0.002, 0.0015)).norm(), 1e-15);
  EXPECT_THAT(error_of(with("{mass: 3 kg, center: [0, 0, 0], inertia: [1, 0, 0, 1, 0, 3]}")),
              HasSubstr("no body has this inertia"));
  EXPECT_THAT(error_of(with("{mass: 3 kg, center: [0, 0, 0], inertia: [1, 0, 0, -1, 0, 1]}")),
              HasSubstr("no body has this inertia"));
  EXPECT_THAT(error_of(with("{mass: 3 kg, center: [0, 0, 0], inertia: [1, 0, 0]}")),
              HasSubstr("links.upper.mass.inertia"));
}

TEST_F(RobotFile, UnitsOfTheFileDoNotMatter) {
  const Robot mm = read(good);
  std::string metres =
      replaced(good, "{length: mm, force: N, angle: deg}", "{length: m, force: kN, angle: rad}");
  metres = replaced(metres, "2.0e7, home: 10}", "20, home: 10 deg}");
  metres = replaced(metres, "length: 400", "length: 0.4");
  metres = replaced(metres, "diameter: 30}", "diameter: 3 cm}");
  metres = replaced(metres, "rest: 3}", "rest: 3 deg}");
  metres = replaced(metres, "[300, 0, 0]", "[0.3, 0, 0]");
  metres = replaced(metres, "[50, 0, 0]", "[5 cm, 0, 0]");
  const Robot m = read(metres);
  EXPECT_LT((mm.manipulator.chains()[0].stiffness() - m.manipulator.chains()[0].stiffness()).norm(),
            1e-10 * mm.manipulator.chains()[0].stiffness().norm());
}

struct Mistake {
  const char* name;
  const char* from;
  const char* to;
  const char* line;      // ":12:"
  const char* expected;  // part of the message
};

class RobotMistakes : public RobotFile, public ::testing::WithParamInterface<Mistake> {};

TEST_P(RobotMistakes, NameFileLineKeyAndCure) {
  const Mistake& mistake = GetParam();
  const std::string message = error_of(replaced(good, mistake.from, mistake.to));
  EXPECT_THAT(message, HasSubstr("robot.yaml"));
  EXPECT_THAT(message, HasSubstr(mistake.line));
  EXPECT_THAT(message, HasSubstr(mistake.expected));
}

const Mistake mistakes[] = {
    {"version", "kinetostat: 1", "kinetostat: 7", ":1:", "This program reads version 1"},
    {"no_units", "units: {length: mm, force: N, angle: deg}\n", "", ":1:", "'units' is missing"},
    {"wrong_unit", "length: mm", "length: N", ":3:", "'N' is not a unit of length"},
    {"misspelt_key", "chain_types:", "chain_tpyes:", ":9:", "Did you mean 'chain_types'?"},
    {"misspelt_axis", "axis: Rz", "axis: Rx_", ":11:", "Did you mean 'Rx'?"},
    {"negative_modulus", "E: 210 GPa", "E: -210 GPa", ":5:", "is not positive"},
    {"poisson", "nu: 0.3", "nu: 0.5", ":5:", "not between -1 and 0.5"},
    {"wrong_dimension", "E: 210 GPa", "E: 210 N", ":5:", "modulus"},
    {"negative_stiffness", "2.0e7", "-2.0e7", ":11:", "is not positive"},
    {"unknown_material", "material: steel", "material: stel", ":7:", "Did you mean 'steel'?"},
    {"unknown_link", "link: upper", "link: uper", ":12:", "Did you mean 'upper'?"},
    {"unknown_type", "{chain: arm}", "{chain: amr}", ":16:", "Did you mean 'arm'?"},
    {"missing_file", "{rigid: [300, 0, 0]}", "{compliance: nothing.json}", ":8:", "does not exist"},
    {"short_vector", "[300, 0, 0]", "[300, 0]", ":8:", "a list of 3 is expected"},
    {"text_for_number", "[300, 0, 0]", "[three, 0, 0]", ":8:", "'three'"},
    {"name_twice", "name: p,", "name: q1,", ":13:", "two joints or links named 'q1'"},
    {"rest_alone", "stiffness: 5 N m/rad, ", "", ":13:", "without a stiffness"},
    {"two_kinds", "{rigid: [300, 0, 0]}", "{rigid: [1, 0, 0], stiffness: 3}", ":8:", "exclude"},
    {"key_twice", "home: 10}", "home: 10, home: 11}", ":11:", "given twice"},
    {"effects", "uncertain:", "effects: [{effect: hardning, at: q1}]\nuncertain:", ":17:",
     "Did you mean 'hardening'?"},
    {"uncertain", "[{stiffness: upper}]", "[{stiffness: uper}]", ":17:", "Did you mean 'upper'?"},
    {"uncertain_twice", "[{stiffness: upper}]", "[{stiffness: upper}, {stiffness: upper}]",
     ":17:", "names what 'upper' names already"},
    {"fitted",
     "uncertain:", "fitted: [{stiffness: q1, factor: -1}]\nuncertain:", ":17:", "must be positive"},
    {"not_yaml", "{chain: arm}", "{chain: arm", ":1", "not valid YAML"},
    {"no_inverse", "length: 400", "length: 4e20", ":7:", "has no inverse to working precision"},
    {"slide_for_turn", "home: 10}", "home: 10 mm}", ":11:", "an angle such as"},
};

INSTANTIATE_TEST_SUITE_P(All, RobotMistakes, ::testing::ValuesIn(mistakes),
                         [](const auto& mistake) { return mistake.param.name; });

// The same file is held against the published schema in tests/tree/schema_test.
TEST_F(RobotFile, EveryOptionalKeyOfTheSchemaIsRead) {
  const Manipulator robot =
      read_robot(KINETOSTAT_SOURCE_DIR "/tests/tree/full_robot.yaml").manipulator;
  EXPECT_EQ(robot.gravity(), Vector3(0, 0, -9.81));
  EXPECT_EQ(robot.body_names(), (std::vector<std::string>{"platform", "crosspiece"}));
  ASSERT_EQ(robot.size(), 5u);
  EXPECT_EQ(robot.span(0).to, 1);
  EXPECT_EQ(robot.span(1).from, 1);
  const Chain& turned = robot.chains()[3];
  EXPECT_EQ(turned.name(), "b");
  EXPECT_TRUE(turned.has_errors());
  EXPECT_EQ(turned.laws().size(), 1u);
  EXPECT_NO_THROW(turned.node_index("hook"));
  double mass = 0;
  for (const PointMass& point : turned.masses()) mass += point.mass;
  EXPECT_DOUBLE_EQ(mass, 2 + 2 + 3 + 1);
}

TEST_F(RobotFile, ALinkFileWithANonSymmetricMatrixIsRefused) {
  auto json = io::to_json(spatial::Compliance6(1e-6 * spatial::Matrix6::Identity()));
  json["compliance"][0][1] = 1e-7;
  io::write_json(folder_ / "bad.link.json", json);
  const std::string message =
      error_of(replaced(good, "{rigid: [300, 0, 0]}", "{compliance: bad.link.json}"));
  EXPECT_THAT(message, HasSubstr("bad.link.json"));
  EXPECT_THAT(message, HasSubstr("not symmetric"));
}

TEST_F(RobotFile, AMissingFileIsSaidSo) {
  EXPECT_THROW(read_robot(folder_ / "nowhere.yaml"), common::InputError);
}

}  // namespace
}  // namespace kinetostat::vjm::robot_file_test
