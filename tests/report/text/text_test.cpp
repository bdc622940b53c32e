#include "kinetostat/report/text/text.h"

#include <limits>
#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetostat/spatial/rotation.h"

namespace kinetostat::report::text_test {
namespace {

using spatial::Compliance6;
using spatial::Matrix6;
using spatial::Stiffness6;
using spatial::UnitSystem;
using testing::HasSubstr;

const UnitSystem mm_newton{.length = "mm", .force = "N", .angle = "rad"};

// The numbers of the six labelled rows below the two heading lines.
Matrix6 read_back(const std::string& text) {
  std::istringstream lines(text);
  std::string line;
  std::getline(lines, line);
  std::getline(lines, line);
  Matrix6 matrix;
  for (int i = 0; i < 6; ++i) {
    lines >> line;
    for (int j = 0; j < 6; ++j) lines >> matrix(i, j);
  }
  return matrix;
}

TEST(Number, HasTheDigitsAskedForAndNoMore) {
  EXPECT_EQ(number(0.0125), "0.0125");
  EXPECT_EQ(number(123456789, 3), "1.23e+08");
  EXPECT_EQ(number(-0.0), "0");
  EXPECT_EQ(number(std::numeric_limits<double>::infinity()), "inf");
}

TEST(Table, AlignsWordsLeftAndNumbersRight) {
  Table table({"pose", "F [N]"});
  table.add_row({"Q0", "1790"});
  table.add_row({"Q1 far", "-94"});
  table.add_row({"Q2", "-"});
  EXPECT_EQ(table.text(),
            "  pose    F [N]\n"
            "  Q0       1790\n"
            "  Q1 far    -94\n"
            "  Q2          -\n");
}

TEST(Table, CountsCharactersNotBytes) {
  Table table({"unit", "b"});
  table.add_row({"µm°²", "x"});
  EXPECT_EQ(table.text(), "  unit  b\n  µm°²  x\n");
}

TEST(Table, RefusesRowsOfAnotherLength) {
  Table table({"a", "b"});
  EXPECT_THROW(table.add_row({"1"}), std::invalid_argument);
}

// 2 m/N = 2000 mm/N; 2 rad/N; 2 m/(N m) = 2 per N = 2 mm/(N mm); 2 rad/(N m) = 0.002 rad/(N mm).
TEST(MatrixText, ComplianceBlocksAreConverted) {
  const Matrix6 shown = read_back(text(Compliance6(Matrix6::Constant(2)), mm_newton));
  EXPECT_TRUE((shown.topLeftCorner<3, 3>().array() == 2000).all());
  EXPECT_TRUE((shown.topRightCorner<3, 3>().array() == 2).all());
  EXPECT_TRUE((shown.bottomLeftCorner<3, 3>().array() == 2).all());
  EXPECT_TRUE((shown.bottomRightCorner<3, 3>().array() == 0.002).all());
}

// 2 N/m = 0.002 N/mm; 2 N/rad stays; 2 N m/m = 2 N mm/mm; 2 N m/rad = 2000 N mm/rad.
TEST(MatrixText, StiffnessBlocksAreConverted) {
  const UnitSystem degrees{.length = "mm", .force = "N", .angle = "deg"};
  const Matrix6 shown = read_back(text(Stiffness6(Matrix6::Constant(2)), degrees));
  EXPECT_DOUBLE_EQ(shown(0, 0), 0.002);
  EXPECT_DOUBLE_EQ(shown(1, 4), 2);
  EXPECT_DOUBLE_EQ(shown(4, 1), 2);
  EXPECT_DOUBLE_EQ(shown(5, 5), 2000);
}

TEST(MatrixText, SaysPointAxesAndUnits) {
  const std::string plain =
      text(Compliance6(Matrix6::Identity(), {.point = {0.11, 0.11, 0}}), mm_newton);
  EXPECT_THAT(plain, HasSubstr("Compliance at point (110, 110, 0) mm, base axes; "
                               "[mm; rad] per [N; N mm]"));
  const spatial::Matrix3 quarter = spatial::exp_rotation({0, 0, 3.14159265358979323846 / 2});
  const std::string turned = text(Stiffness6(Matrix6::Identity(), {.axes = quarter}), mm_newton);
  EXPECT_THAT(turned, HasSubstr("[N; N mm] per [mm; rad]"));
  EXPECT_THAT(turned, HasSubstr("axes x (0, 1, 0) y (-1, 0, 0) z (0, 0, 1)"));
}

TEST(MatrixText, RoundingIsShownAsZero) {
  Matrix6 matrix = Matrix6::Identity() * 1e-6;
  matrix(0, 1) = 1e-20;
  matrix(0, 2) = 1e-12;
  const Matrix6 shown = read_back(text(Compliance6(matrix), UnitSystem{}));
  EXPECT_EQ(shown(0, 1), 0);
  EXPECT_DOUBLE_EQ(shown(0, 2), 1e-12);
}

TEST(MatrixText, RankDeficientStiffnessIsShown) {
  Matrix6 matrix = Matrix6::Zero();
  matrix(2, 2) = 5e6;
  const Matrix6 shown = read_back(text(Stiffness6(matrix), mm_newton));
  EXPECT_DOUBLE_EQ(shown(2, 2), 5e3);
  EXPECT_EQ(shown.cwiseAbs().sum(), 5e3);
}

TEST(WrenchText, VectorsHaveTheirUnits) {
  const std::string shown = text(spatial::Wrench{{1, 2, 3}, {0.001, 0, 0}}, mm_newton);
  EXPECT_THAT(shown, HasSubstr("(1, 2, 3) N\n"));
  EXPECT_THAT(shown, HasSubstr("(1, 0, 0) N mm\n"));
}

TEST(TwistText, VectorsHaveTheirUnits) {
  const std::string shown = text(spatial::Twist{{0.001, 0, 0}, {0, 0.5, 0}}, mm_newton);
  EXPECT_THAT(shown, HasSubstr("(1, 0, 0) mm\n"));
  EXPECT_THAT(shown, HasSubstr("(0, 0.5, 0) rad\n"));
}

}  // namespace
}  // namespace kinetostat::report::text_test
