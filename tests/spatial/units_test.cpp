#include "kinetostat/spatial/units.h"

#include <cmath>
#include <limits>
#include <stdexcept>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/random.h"

namespace kinetostat::spatial::units_test {
namespace {

using testing::HasSubstr;

constexpr double pi = 3.14159265358979323846;

// What parse_quantity complains, or "" when it does not.
std::string complaint(std::string_view text, const Dimension& expected,
                      std::string_view default_unit = {}) {
  try {
    parse_quantity(text, expected, default_unit);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return {};
}

struct KnownUnit {
  const char* text;
  double factor;
  Dimension dimension;
};

class Units : public testing::TestWithParam<KnownUnit> {};

TEST_P(Units, AreWorthTheirDefinition) {
  const Unit unit = parse_unit(GetParam().text);
  EXPECT_DOUBLE_EQ(unit.factor, GetParam().factor);
  EXPECT_EQ(unit.dimension, GetParam().dimension) << to_string(unit.dimension);
}

// Definitions: SI brochure; inch, pound, pound-force of 1959.
INSTANTIATE_TEST_SUITE_P(
    Plain, Units,
    testing::Values(
        KnownUnit{"m", 1, dimension::length}, KnownUnit{"mm", 1e-3, dimension::length},
        KnownUnit{"cm", 1e-2, dimension::length}, KnownUnit{"dm", 1e-1, dimension::length},
        KnownUnit{"km", 1e3, dimension::length}, KnownUnit{"um", 1e-6, dimension::length},
        KnownUnit{"µm", 1e-6, dimension::length}, KnownUnit{"μm", 1e-6, dimension::length},
        KnownUnit{"nm", 1e-9, dimension::length}, KnownUnit{"in", 0.0254, dimension::length},
        KnownUnit{"inch", 0.0254, dimension::length}, KnownUnit{"ft", 0.3048, dimension::length},
        KnownUnit{"g", 1e-3, dimension::mass}, KnownUnit{"kg", 1, dimension::mass},
        KnownUnit{"t", 1e3, dimension::mass}, KnownUnit{"lb", 0.45359237, dimension::mass},
        KnownUnit{"s", 1, dimension::time}, KnownUnit{"ms", 1e-3, dimension::time},
        KnownUnit{"min", 60, dimension::time}, KnownUnit{"h", 3600, dimension::time},
        KnownUnit{"N", 1, dimension::force}, KnownUnit{"kN", 1e3, dimension::force},
        KnownUnit{"MN", 1e6, dimension::force}, KnownUnit{"mN", 1e-3, dimension::force},
        KnownUnit{"lbf", 4.4482216152605, dimension::force},
        KnownUnit{"kgf", 9.80665, dimension::force}, KnownUnit{"kp", 9.80665, dimension::force},
        KnownUnit{"daN", 10, dimension::force}, KnownUnit{"Pa", 1, dimension::pressure},
        KnownUnit{"hPa", 1e2, dimension::pressure}, KnownUnit{"MPa", 1e6, dimension::pressure},
        KnownUnit{"GPa", 1e9, dimension::pressure}, KnownUnit{"bar", 1e5, dimension::pressure},
        KnownUnit{"psi", 6894.757293168361, dimension::pressure},
        KnownUnit{"ksi", 6894757.293168361, dimension::pressure},
        KnownUnit{"J", 1, dimension::moment}, KnownUnit{"l", 1e-3, {.length = 3}},
        KnownUnit{"rad", 1, dimension::angle}, KnownUnit{"mrad", 1e-3, dimension::angle},
        KnownUnit{"urad", 1e-6, dimension::angle}, KnownUnit{"deg", pi / 180, dimension::angle},
        KnownUnit{"degree", pi / 180, dimension::angle}, KnownUnit{"°", pi / 180, dimension::angle},
        KnownUnit{"arcmin", pi / 10800, dimension::angle},
        KnownUnit{"arcsec", pi / 648000, dimension::angle},
        KnownUnit{"K", 1, dimension::temperature}, KnownUnit{"degC", 1, dimension::temperature},
        KnownUnit{"°C", 1, dimension::temperature}, KnownUnit{"%", 0.01, dimension::none},
        KnownUnit{"percent", 0.01, dimension::none}, KnownUnit{"ppm", 1e-6, dimension::none},
        KnownUnit{"1", 1, dimension::none}));

INSTANTIATE_TEST_SUITE_P(
    Compound, Units,
    testing::Values(
        KnownUnit{"N/mm", 1e3, dimension::linear_stiffness},
        KnownUnit{"N / mm", 1e3, dimension::linear_stiffness},
        KnownUnit{"kN/m", 1e3, dimension::linear_stiffness},
        KnownUnit{"N mm^-1", 1e3, dimension::linear_stiffness},
        KnownUnit{"N*m", 1, dimension::moment}, KnownUnit{"N m", 1, dimension::moment},
        KnownUnit{"N.mm", 1e-3, dimension::moment},
        KnownUnit{"N m/rad", 1, dimension::torsional_stiffness},
        KnownUnit{"N*mm/deg", 1e-3 * 180 / pi, dimension::torsional_stiffness},
        KnownUnit{"mm^2", 1e-6, dimension::area}, KnownUnit{"mm2", 1e-6, dimension::area},
        KnownUnit{"mm**2", 1e-6, dimension::area}, KnownUnit{"mm²", 1e-6, dimension::area},
        KnownUnit{"cm^4", 1e-8, dimension::second_moment},
        KnownUnit{"kg/m^3", 1, dimension::density}, KnownUnit{"g/cm³", 1e3, dimension::density},
        KnownUnit{"N/mm^2", 1e6, dimension::pressure}, KnownUnit{"kg m s^-2", 1, dimension::force},
        KnownUnit{"kg m/s^2", 1, dimension::force},
        // A '/' divides by what follows it up to the next '*', '/' or ')'.
        KnownUnit{"1/(N m)", 1, Dimension{} / dimension::moment},
        KnownUnit{"1/N m", 1, Dimension{} / dimension::moment},
        KnownUnit{"m/s/s", 1, {.length = 1, .time = -2}},
        KnownUnit{"m/s*kg", 1, {.length = 1, .mass = 1, .time = -1}},
        KnownUnit{"(mm)^3", 1e-9, {.length = 3}},
        KnownUnit{"(N/mm)^2", 1e6, {.mass = 2, .time = -4}}));

TEST(Quantity, ExamplesOfTheFileFormats) {
  EXPECT_DOUBLE_EQ(parse_quantity("15 um", dimension::length), 15e-6);
  EXPECT_DOUBLE_EQ(parse_quantity("210 GPa", dimension::pressure), 210e9);
  EXPECT_DOUBLE_EQ(parse_quantity("1.0e5 N/mm", dimension::linear_stiffness), 1e8);
  EXPECT_DOUBLE_EQ(parse_quantity("2700 kg/m^3", dimension::density), 2700);
  EXPECT_DOUBLE_EQ(parse_quantity(" -30deg ", dimension::angle), -pi / 6);
  EXPECT_DOUBLE_EQ(parse_quantity("+.5e1mm", dimension::length), 5e-3);
  EXPECT_DOUBLE_EQ(parse_quantity("1 %", dimension::none), 0.01);
  EXPECT_THAT(complaint("180", dimension::length, "deg"), HasSubstr("'180 deg' is in rad"));
  EXPECT_EQ(parse_quantity("inf N/m", dimension::linear_stiffness),
            std::numeric_limits<double>::infinity());
}

TEST(Quantity, BareNumbersTakeTheDefaultUnit) {
  EXPECT_DOUBLE_EQ(parse_quantity("3", dimension::length, "mm"), 3e-3);
  EXPECT_DOUBLE_EQ(parse_quantity("3 m", dimension::length, "mm"), 3);
  EXPECT_DOUBLE_EQ(parse_quantity("0.33", dimension::none), 0.33);
  EXPECT_THAT(complaint("3", dimension::length), HasSubstr("no unit"));
}

constexpr Dimension compliance{.mass = -1, .time = 2};

// As people write them, without anything between a force and its lever.
INSTANTIATE_TEST_SUITE_P(
    AsPeopleWrite, Units,
    testing::Values(
        KnownUnit{"Nm", 1, dimension::moment}, KnownUnit{"kNm", 1e3, dimension::moment},
        KnownUnit{"Nmm", 1e-3, dimension::moment}, KnownUnit{"mNm", 1e-3, dimension::moment},
        KnownUnit{"Ncm", 1e-2, dimension::moment}, KnownUnit{"N·m", 1, dimension::moment},
        KnownUnit{"N⋅mm", 1e-3, dimension::moment}, KnownUnit{"N-m", 1, dimension::moment},
        KnownUnit{"kgfm", 9.80665, dimension::moment},
        KnownUnit{"Nm/rad", 1, dimension::torsional_stiffness},
        KnownUnit{"Nm/deg", 180 / pi, dimension::torsional_stiffness},
        KnownUnit{"Nmm/arcmin", 1e-3 * 10800 / pi, dimension::torsional_stiffness},
        KnownUnit{"N/µm", 1e6, dimension::linear_stiffness},
        KnownUnit{"N/μm", 1e6, dimension::linear_stiffness}, KnownUnit{"um/N", 1e-6, compliance},
        KnownUnit{"µm/N", 1e-6, compliance},
        KnownUnit{"lbf in/deg", 4.4482216152605 * 0.0254 * 180 / pi,
                  dimension::torsional_stiffness},
        KnownUnit{"ft-lbf", 0.3048 * 4.4482216152605, dimension::moment},
        KnownUnit{"lbf/in", 4.4482216152605 / 0.0254, dimension::linear_stiffness},
        KnownUnit{"mil", 25.4e-6, dimension::length},
        KnownUnit{"gon", pi / 200, dimension::angle}));

TEST(Quantity, AnglesArePlainNumbersInsideCompoundUnitsOnly) {
  EXPECT_DOUBLE_EQ(parse_quantity("2 N m", dimension::torsional_stiffness), 2);
  EXPECT_DOUBLE_EQ(parse_quantity("2 N m/rad", dimension::moment), 2);
  EXPECT_THAT(complaint("2 rad", dimension::none), HasSubstr("plain number"));
  EXPECT_THAT(complaint("2 %", dimension::angle), HasSubstr("an angle"));
}

TEST(Quantity, WrongDimensionNamesWhatIsExpected) {
  const std::string text = complaint("3 kg", dimension::length);
  EXPECT_THAT(text, HasSubstr("'3 kg' is in kg"));
  EXPECT_THAT(text, HasSubstr("a length such as"));
}

TEST(Quantity, MisspeltUnitsGetAHint) {
  EXPECT_THAT(complaint("3 Mpa", dimension::pressure), HasSubstr("did you mean 'MPa'?"));
  EXPECT_THAT(complaint("3 nm/radd", dimension::length), HasSubstr("did you mean 'rad'?"));
  // Not the nanometre, which is no moment.
  EXPECT_THAT(complaint("3 NM", dimension::moment), HasSubstr("did you mean 'Nm'?"));
  EXPECT_THAT(complaint("3 KNM/rad", dimension::moment), HasSubstr("did you mean 'kNm'?"));
  EXPECT_THAT(complaint("3 furlong", dimension::length),
              HasSubstr("'furlong' is not a known unit"));
}

TEST(Quantity, RubbishIsRefused) {
  for (const char* text :
       {"", " ", "mm", "abc", "3 mm mm^", "3 mm)", "3 (mm", "3 mm^99", "3 mm^x", "3 /", "3 mm//m",
        "+-3 mm", "--3 mm", "3 mm-1", "3 4 mm", "0x10 mm", "1e999 mm", "nan mm"})
    EXPECT_NE(complaint(text, dimension::length), "") << "'" << text << "'";
  for (const char* text : {"5 12", "1 000", "1,5", "3 1", "3;", "3 *"})
    EXPECT_NE(complaint(text, dimension::none), "") << "'" << text << "'";
}

TEST(Quantity, UnitsBeyondAllMeasureAreRefused) {
  const std::string nested(100'000, '(');
  EXPECT_THAT(complaint("3 " + nested + "m", dimension::length), HasSubstr("nested too deeply"));
  EXPECT_THAT(complaint("3 m^-2147483648", dimension::length), HasSubstr("whole exponent"));
  std::string power = "m";
  for (int i = 0; i < 15; ++i) power = "(" + power + ")^12";
  EXPECT_THAT(complaint("3 " + power, dimension::length), HasSubstr("exponents are too large"));
  EXPECT_THAT(complaint("3 (nm^12/m^12)^8", dimension::none), HasSubstr("range of numbers"));
}

TEST(Quantity, CommaGetsItsOwnHint) {
  EXPECT_THAT(complaint("1,5 mm", dimension::length), HasSubstr("decimal point"));
}

TEST(Format, IsShortAndReadsBackToTheSameNumber) {
  EXPECT_EQ(format_quantity(1.5e-5, "um"), "15 um");
  EXPECT_EQ(format_quantity(210e9, "GPa"), "210 GPa");
  EXPECT_EQ(format_quantity(0, "mm"), "0 mm");
  test::Random random(1);
  for (const char* unit : {"um", "deg", "GPa", "N/mm", "kg/m^3", "inch"})
    for (int i = 0; i < 500; ++i) {
      const double value = random.uniform(-1, 1) * std::pow(10, random.uniform(-12, 12));
      const Unit parsed = parse_unit(unit);
      const double back = parse_quantity(format_quantity(value, unit), parsed.dimension);
      // One division and one multiplication: at most the last digit when no shorter text exists.
      EXPECT_NEAR(back, value, std::abs(value) * 3e-16) << value << " " << unit;
    }
}

TEST(Dimensions, AreSpelledInBaseUnits) {
  EXPECT_EQ(to_string(dimension::force), "N");
  EXPECT_EQ(to_string(dimension::linear_stiffness), "N m^-1");
  EXPECT_EQ(to_string(dimension::mass), "kg");
  EXPECT_EQ(to_string(dimension::none), "1");
  EXPECT_EQ(dimension::force / dimension::area, dimension::pressure);
  EXPECT_EQ(dimension::force * dimension::length, dimension::moment);
}

TEST(UnitSystem, CompoundsFollowTheFile) {
  const UnitSystem units{.length = "mm", .force = "kN", .angle = "deg"};
  const auto factor = [&units](const Dimension& d) { return parse_unit(units.unit_for(d)).factor; };
  EXPECT_DOUBLE_EQ(factor(dimension::length), 1e-3);
  EXPECT_DOUBLE_EQ(factor(dimension::angle), pi / 180);
  EXPECT_DOUBLE_EQ(factor(dimension::linear_stiffness), 1e6);
  EXPECT_DOUBLE_EQ(factor(dimension::moment), 1);
  EXPECT_DOUBLE_EQ(factor(dimension::pressure), 1e9);
  EXPECT_DOUBLE_EQ(factor(dimension::second_moment), 1e-12);
  EXPECT_DOUBLE_EQ(factor(dimension::density), 1e9);
  // Per radian, although angles are in degrees: nobody writes N mm/deg without saying so.
  EXPECT_DOUBLE_EQ(factor(dimension::torsional_stiffness), 1);
  EXPECT_THROW(units.unit_for({.length = 1, .temperature = 1}), std::invalid_argument);
}

}  // namespace
}  // namespace kinetostat::spatial::units_test
