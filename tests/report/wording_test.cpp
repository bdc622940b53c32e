#include "kinetostat/report/screen/wording.h"

#include <limits>
#include <sstream>

#include <gtest/gtest.h>

#include "kinetostat/vjm/chain/chain_builder.h"

namespace kinetostat::report::wording_test {
namespace {

TEST(Wording, SmallLengthsAreInMicrometres) {
  EXPECT_EQ(length_in_words(3.03e-6, "mm"), "3.03 um");
  EXPECT_EQ(length_in_words(2.44e-4, "mm"), "0.244 mm");
  EXPECT_EQ(length_in_words(5e-5, "m"), "50 um");
  EXPECT_EQ(length_in_words(2.54e-6, "inch"), "0.0001 inch");
}

TEST(Wording, LinesAreNoWiderThanAScreenAndNoWordIsLost) {
  std::string text;
  for (int i = 0; i < 80; ++i) text += "word" + std::to_string(i * i) + " ";
  const std::string lines = wrapped(text, 2, 4);
  std::istringstream stream(lines);
  bool is_first = true;
  for (std::string line; std::getline(stream, line); is_first = false) {
    EXPECT_LE(line.size(), screen_columns);
    EXPECT_EQ(line.find_first_not_of(' '), is_first ? 2u : 4u);
  }
  std::istringstream a(text), b(lines);
  for (std::string x, y; a >> x;) {
    ASSERT_TRUE(b >> y);
    EXPECT_EQ(x, y);
  }
  EXPECT_EQ(wrapped(""), "");
  EXPECT_EQ(wrapped(std::string(97, 'x') + " 64 %, and"), std::string(97, 'x') + "\n64 %, and\n");
  EXPECT_EQ(wrapped("  "), "");
}

// As many digits as the deviation has a claim to.
TEST(Wording, ValuesHaveTheDigitsOfTheirDeviation) {
  EXPECT_EQ(with_error(0.5712, 0.0391), "0.57 +- 0.04");
  EXPECT_EQ(with_error(0.5712, 0.0121), "0.571 +- 0.012");
  EXPECT_EQ(with_error(-1234.5, 71), "-1230 +- 70");
  EXPECT_EQ(with_error(1234.4, 7.1), "1234 +- 7");
  EXPECT_EQ(with_error(2, std::numeric_limits<double>::quiet_NaN()), "2");
  EXPECT_EQ(with_error(0, 0), "0");
  EXPECT_EQ(with_error(1.234e-8, 2e-10), "(1.23 +- 0.02)e-08");
  EXPECT_EQ(change(1.16, 0.07), "+16 % +- 7");
  EXPECT_EQ(change(0.968, 0.012), "-3.2 % +- 1.2");
}

TEST(Wording, FiguresHaveNoExponentWherePeopleWriteNone) {
  EXPECT_EQ(figure(1063.4), "1060");
  EXPECT_EQ(figure(-16412), "-16,400");
  EXPECT_EQ(figure(106973, 4), "107,000");
  EXPECT_EQ(figure(0.02817), "0.0282");
  EXPECT_EQ(figure(999.6), "1000");
  EXPECT_EQ(figure(0), "0");
}

TEST(Wording, UnitsAreWrittenAsPeopleWriteThem) {
  EXPECT_EQ(unit_in_words("N m^-1"), "N/m");
  EXPECT_EQ(unit_in_words("N m rad^-1"), "N m/rad");
  EXPECT_EQ(unit_in_words("K^-1"), "1/K");
  EXPECT_EQ(unit_in_words("m N^-1 rad^-2"), "m/(N rad^2)");
  EXPECT_EQ(unit_in_words("um"), "um");
  EXPECT_EQ(unit_in_words(""), "");
}

TEST(Wording, ErrorsProbabilitiesAndOdds) {
  EXPECT_EQ(times(1.004), "1.00");
  EXPECT_EQ(times(9.996), "10.0");
  EXPECT_EQ(times(312.4), "312");
  EXPECT_EQ(short_percent(0.9995), "over 99.9 %");
  EXPECT_EQ(short_percent(0.564), "56 %");
  EXPECT_EQ(odds(1.0 / 1201), "1 : 1,200");
  EXPECT_EQ(odds(0.25), "1 : 3");
  EXPECT_EQ(odds(0), "below 1 : 10^12");
  EXPECT_EQ(chance(1e-30), "below 1e-8");
  EXPECT_EQ(chance(0.34), "34 %");
}

TEST(Wording, PlacesAreNamedAsPeopleCallThem) {
  vjm::ChainBuilder arm("arm");
  arm.actuator("q1", vjm::Motion::rz, 1e5)
      .link("upper", spatial::Pose::translation({0.3, 0, 0}),
            spatial::Compliance6(spatial::Matrix6(1e-8 * spatial::Matrix6::Identity())));
  const vjm::Manipulator one("one", {arm.build()});
  EXPECT_EQ(place_in_words(one, "arm.q1"), "joint q1");
  EXPECT_EQ(place_in_words(one, "arm.upper"), "link upper");
  EXPECT_EQ(place_in_words(one, "platform"), "platform");
  EXPECT_EQ(effect_in_words(one, "thermal_expansion", "arm.upper"),
            "thermal expansion at link upper");
  EXPECT_EQ(effect_in_words(one, "wrench_gain", "load"), "wrench gain");
  vjm::ChainBuilder x("x"), y("y");
  x.actuator("rho", vjm::Motion::tx, 1e6);
  y.actuator("rho", vjm::Motion::ty, 1e6);
  const vjm::Manipulator two("two", {x.build(), y.build()});
  EXPECT_EQ(place_in_words(two, "x.rho"), "joint x.rho");
  EXPECT_EQ(place_in_words(two, "rho"), "joint rho of every chain");
  EXPECT_EQ(place_in_words(two, "x.tilt at base.Rx"), "tilt Rx at the base of chain x");
  EXPECT_EQ(place_in_words(two, "foundation"), "the foundation of all chains");
  const vjm::Manipulator held("held", {x.build(), vjm::ChainBuilder("tool").build()});
  EXPECT_EQ(place_in_words(held, "tool.mount at base.Tz"), "mount Tz at the tool on the platform");
  EXPECT_EQ(short_name(two, "x.rho"), "x.rho");
  EXPECT_EQ(short_name(one, "arm.q1"), "q1");
}

// A command goes on as a shell takes it, and is what was to be typed.
TEST(Wording, NextStepsFitAndCanBeTyped) {
  EXPECT_EQ(next_step("kinetostat plan a.yaml", "what next"),
            "Next: kinetostat plan a.yaml    what next\n");
  const std::string file(60, 'f'),
      step = next_step("kinetostat adopt " + file + " " + file, "then");
  std::istringstream lines(step);
  for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), screen_columns);
  EXPECT_NE(step.find(" \\\n"), std::string::npos);
  EXPECT_EQ(quoted("a b.yaml"), "'a b.yaml'");
  EXPECT_EQ(quoted("it's"), "'it'\\''s'");
  EXPECT_EQ(quoted("data/a-b_1.yaml"), "data/a-b_1.yaml");
}

}  // namespace
}  // namespace kinetostat::report::wording_test
