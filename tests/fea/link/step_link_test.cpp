// Links from STEP files.
#include <cmath>
#include <numbers>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetostat/common/error.h"
#include "kinetostat/fea/link/identify.h"

#include "fea/surface/step_parts.h"
#include "support/temporary_folder.h"

namespace kinetostat::fea::step_link_test {
namespace {

using testing::HasSubstr;

constexpr double young = 210e9, length = 0.2, diameter = 0.04;
const double bending = young * std::numbers::pi * std::pow(diameter, 4) / 64;

class StepLink : public testing::Test {
 protected:
  void SetUp() override { test::write_round_bar(folder_.path() / "bar.step", 40, 200); }

  LinkResult identified(double nu, const std::string& coupling, const std::string& elements) {
    const LinkSpec spec = read_link(folder_.file(
        "bar.yaml",
        fmt::format("kinetostat: 1\nlink: bar\nmesh: {{file: bar.step}}\n"
                    "material: {{E: 210 GPa, nu: {}}}\n"
                    "fixed: {{face: foot, coupling: {}}}\nloaded: {{face: head, coupling: {}}}\n"
                    "elements: {{{}}}\n",
                    nu, coupling, coupling, elements)));
    common::Progress silent;
    return identify(spec, read_geometry(spec, silent), {.bracket = BracketWanted::never}, silent);
  }

  // Off the exact value by less than the bar, and the bar as small as was asked for.
  static void expect_in_bar(const LinkResult& link, Eigen::Index i, Eigen::Index j, double exact) {
    const double found = link.response.flexibility(i, j), bar = link.accuracy.bars.bar(i, j);
    EXPECT_LE(std::abs(found - exact), bar) << i << " " << j << " off by " << found / exact - 1;
    EXPECT_LE(bar, *link.accuracy.asked * std::abs(exact));
  }

  test::TemporaryFolder folder_;
};

// Without lateral contraction a round bar between rigid ends bends, twists and stretches as beam
// theory says, exactly; so it does with it when the ends are held by tractions.
TEST_F(StepLink, TheRoundSectionLiesWithinTheBarAtAnyAccuracy) {
  for (const auto& [nu, coupling] : {std::pair{0.0, "rigid"}, std::pair{0.3, "distributing"}})
    for (const char* accuracy : {"1 %", "0.1 %", "0.02 %"}) {
      const LinkResult link = identified(nu, coupling, fmt::format("accuracy: {}", accuracy));
      ASSERT_TRUE(link.accuracy.converged) << link.accuracy.shortfall;
      expect_in_bar(link, 4, 4, length / bending);
      expect_in_bar(link, 5, 5, length / bending);
      expect_in_bar(link, 1, 5, length * length / 2 / bending);
      expect_in_bar(link, 3, 3, length / (bending / (1 + nu)));
      expect_in_bar(link, 0, 0, length * diameter * diameter / 16 / bending);
      EXPECT_EQ(link.mesh.straightened, 0u);
    }
}

// Straight elements leave a polygon: its error must be in the bar, too.
TEST_F(StepLink, WhatFourNodeElementsMissIsInTheBar) {
  const LinkResult link = identified(0, "rigid", "order: 1, size: 5");
  const double off = link.response.flexibility(0, 0) - length * diameter * diameter / 16 / bending;
  EXPECT_GT(off, 0);  // a polygon has less area: softer, against what elements usually are
  EXPECT_LE(off, link.accuracy.bars.bar(0, 0));
  EXPECT_GT(2 * off, link.accuracy.bars.geometry(0, 0) / ErrorBars::safety);
}

// Solids by their names; their meshes do not fit, and the joint has curved edges or is curved.
class StepAssembly : public StepLink {
 protected:
  LinkResult joined(const std::string& file, const std::string& first, const std::string& second,
                    const std::string& elements) {
    const LinkSpec spec = read_link(folder_.file(
        "pair.yaml", fmt::format("kinetostat: 1\nlink: pair\nmesh: {{file: {}}}\nbodies:\n"
                                 "  {}: {{material: {{E: 210 GPa, nu: 0}}}}\n"
                                 "  {}: {{material: {{E: 70 GPa, nu: 0}}}}\n"
                                 "joints: [{{between: [{}, {}], bonded: true}}]\n"
                                 "fixed: {{plane: {{point: [0, 0, 0], normal: [-1, 0, 0]}}}}\n"
                                 "loaded: {{plane: {{point: [200, 0, 0], normal: [1, 0, 0]}}}}\n"
                                 "elements: {{{}}}\n",
                                 file, first, second, first, second, elements)));
    common::Progress silent;
    return identify(spec, read_geometry(spec, silent), {.bracket = BracketWanted::never}, silent);
  }
};

TEST_F(StepAssembly, HalvesOfARoundBarAddUp) {
  test::write_round_bar_in_two(folder_.path() / "halves.step", 40, 200);
  const LinkResult link = joined("halves.step", "near half", "far half", "accuracy: 0.1 %");
  ASSERT_TRUE(link.accuracy.converged) << link.accuracy.shortfall;
  const double bend = (0.5 + 0.5 * 3) * length / bending;  // a third of the modulus in one half
  expect_in_bar(link, 4, 4, bend);
  expect_in_bar(link, 5, 5, bend);
  expect_in_bar(link, 3, 3, bend);
  expect_in_bar(link, 0, 0, bend * diameter * diameter / 16);
  const double section = std::numbers::pi * diameter * diameter / 4;
  EXPECT_NEAR(link.joints[0].area, section, 1e-3 * section);
}

TEST_F(StepAssembly, SolidsThatTouchAreNoLinkOfOneBody) {
  test::write_round_bar_in_two(folder_.path() / "halves.step", 40, 200);
  const auto message = [&](const std::string& mesh) -> std::string {
    try {
      common::Progress silent;
      read_geometry(
          read_link(folder_.file("one.yaml",
                                 "kinetostat: 1\nlink: one\nmesh: {file: halves.step" + mesh +
                                     "}\nmaterial: steel_s235\n"
                                     "fixed: {plane: {point: [0, 0, 0], normal: [-1, 0, 0]}}\n"
                                     "loaded: {plane: {point: [100, 0, 0], normal: [1, 0, 0]}}\n")),
          silent);
    } catch (const common::InputError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_THAT(message(""),
              HasSubstr("2 separate bodies, a link is one: near half (100 x 40 x 40 mm)"
                        ", far half (100 x 40 x 40 mm). Pick one with 'mesh: {body: "
                        "near half}', join them with 'bodies' and 'joints'"));
  EXPECT_EQ(message(", body: near half"), "");
  EXPECT_EQ(message(", body: 1"), "");
}

TEST_F(StepAssembly, ACoreInASleeveIsTheSumOfBoth) {
  test::write_core_and_sleeve(folder_.path() / "fit.step", 20, 40, 200);
  const LinkResult link = joined("fit.step", "core", "sleeve", "accuracy: 1 %");
  ASSERT_TRUE(link.accuracy.converged) << link.accuracy.shortfall;
  // pi d^4 / 64 of the core is a sixteenth of the whole, its area a quarter.
  const double bend = length / (bending * (1.0 / 16 + 15.0 / 16 / 3));
  expect_in_bar(link, 4, 4, bend);
  expect_in_bar(link, 5, 5, bend);
  expect_in_bar(link, 3, 3, bend);
  expect_in_bar(link, 0, 0, length * diameter * diameter / 16 / (bending * (0.25 + 0.75 / 3)));
  const double around = std::numbers::pi * diameter / 2 * length;
  EXPECT_NEAR(link.joints[0].area, around, 1e-3 * around);
}

TEST_F(StepLink, SameBytesForAnyNumberOfThreads) {
  IdentifyOptions options{.bracket = BracketWanted::never};
  common::Progress silent;
  identified(0.3, "rigid", "size: 12");
  const LinkSpec spec = read_link(folder_.path() / "bar.yaml");
  const LinkGeometry geometry = read_geometry(spec, silent);
  const LinkResult one = identify(spec, geometry, options, silent);
  options.solver.threads = 3;
  const LinkResult three = identify(spec, geometry, options, silent);
  EXPECT_EQ(one.mesh.nodes, three.mesh.nodes);
  EXPECT_EQ(one.response.flexibility, three.response.flexibility);
  EXPECT_EQ(one.accuracy.bars.bar, three.accuracy.bars.bar);
}

TEST_F(StepLink, FacesThatAreNotThereAreRefusedByName) {
  const auto message = [&](const std::string& fixed) -> std::string {
    const auto file =
        folder_.file("bar.yaml", fmt::format("kinetostat: 1\nlink: bar\nmesh: {{file: bar.step}}\n"
                                             "material: {{E: 210 GPa, nu: 0.3}}\nfixed: {{{}}}\n"
                                             "loaded: {{face: head}}\n",
                                             fixed));
    try {
      common::Progress silent;
      read_geometry(read_link(file), silent);
    } catch (const common::InputError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(message("face: foot"), "");
  EXPECT_THAT(message("face: food"), HasSubstr("bar.yaml:5: fixed.face: no facet of the mesh is "
                                               "selected. Did you mean 'foot'?"));
  EXPECT_THAT(message("face: 9"), HasSubstr("The faces are 1 to 3"));
  EXPECT_THAT(message("face: 0"), HasSubstr("fixed.face"));
  EXPECT_THAT(message("colour: red"), HasSubstr("Write red as \"#ff0000\", in quotes"));
  EXPECT_THAT(message("colour: \"#123456\""), HasSubstr("The colours of its faces: #"));
}

}  // namespace
}  // namespace kinetostat::fea::step_link_test
