#include "kinetostat/vjm/chain/beam.h"

#include <cmath>
#include <stdexcept>

#include <gtest/gtest.h>

namespace kinetostat::vjm::beam_test {
namespace {

using spatial::Compliance6;
using spatial::Frame;
using spatial::Matrix6;

const Material steel{210e9, 210e9 / 2.6, std::nullopt};

TEST(Beam, TipComplianceIsTheTextbookCantilever) {
  const double l = 1.0, b = 0.1, h = 0.06;
  const Section s = Section::rectangle(b, h, 0.3);
  const Matrix6 c = beam_compliance(l, s, steel, BeamTheory::euler_bernoulli).matrix();
  const double e = steel.young_modulus, iz = h * b * b * b / 12, iy = b * h * h * h / 12;
  EXPECT_DOUBLE_EQ(c(0, 0), l / (e * b * h));
  EXPECT_DOUBLE_EQ(c(1, 1), l * l * l / (3 * e * iz));
  EXPECT_DOUBLE_EQ(c(2, 2), l * l * l / (3 * e * iy));
  EXPECT_DOUBLE_EQ(c(4, 4), l / (e * iy));
  EXPECT_DOUBLE_EQ(c(1, 5), l * l / (2 * e * iz));   // a force up turns the tip anticlockwise
  EXPECT_DOUBLE_EQ(c(2, 4), -l * l / (2 * e * iy));  // Fz turns it about -y
  EXPECT_DOUBLE_EQ((c - c.transpose()).norm(), 0);
}

TEST(Beam, TorsionConstantOfASquareAndAThinStripIsSaintVenants) {
  // Exact series: square 0.140577 a^4; strip 10:1 0.312335 (a b^3).
  EXPECT_NEAR(Section::rectangle(1, 1, 0.3).torsion_constant, 0.140577, 0.140577 * 5e-3);
  EXPECT_NEAR(Section::rectangle(10, 1, 0.3).torsion_constant, 3.12335, 3.12335 * 1e-3);
  EXPECT_DOUBLE_EQ(Section::rectangle(2, 3, 0.3).torsion_constant,
                   Section::rectangle(3, 2, 0.3).torsion_constant);
}

TEST(Beam, TubeTendsToTheSolidCircle) {
  const Section tube = Section::tube(0.02, 1e-9, 0.3), circle = Section::circle(0.02, 0.3);
  EXPECT_NEAR(tube.area, circle.area, 1e-12);
  EXPECT_NEAR(tube.second_moment_y, circle.second_moment_y, 1e-18);
  EXPECT_NEAR(tube.torsion_constant, circle.torsion_constant, 1e-18);
  EXPECT_NEAR(*tube.shear_coefficient_y, *circle.shear_coefficient_y, 1e-12);
}

// Cowper (1966) for nu = 0, 0.3 and 0.5, to three digits; thin tubes are 2 (1 + nu) / (4 + 3 nu).
TEST(Beam, ShearCoefficientsFollowPoissonsRatio) {
  const auto circle = [](double nu) { return *Section::circle(0.02, nu).shear_coefficient_z; };
  const auto rectangle = [](double nu) {
    return *Section::rectangle(0.02, 0.01, nu).shear_coefficient_y;
  };
  const auto thin = [](double nu) {
    return *Section::tube(0.02, 0.02 * (1 - 1e-7), nu).shear_coefficient_y;
  };
  EXPECT_NEAR(circle(0), 0.857, 5e-4);
  EXPECT_NEAR(circle(0.3), 0.886, 5e-4);
  EXPECT_NEAR(circle(0.5), 0.900, 5e-4);
  EXPECT_NEAR(rectangle(0), 0.833, 5e-4);
  EXPECT_NEAR(rectangle(0.3), 0.850, 5e-4);
  EXPECT_NEAR(rectangle(0.5), 0.857, 5e-4);
  for (const double nu : {0.0, 0.25, 0.3, 0.5})
    EXPECT_NEAR(thin(nu), 2 * (1 + nu) / (4 + 3 * nu), 1e-9) << nu;
}

TEST(Beam, PoissonsRatioIsThatOfTheModuli) { EXPECT_NEAR(steel.poisson_ratio(), 0.3, 1e-15); }

// Pieces in series, each taken to the tip, give the whole beam (JAMRIS09 section 4.2).
TEST(Beam, AChainOfPiecesIsTheWholeBeam) {
  const Section s = Section::rectangle(0.02, 0.03, 0.3);
  const double l = 0.5;
  for (const BeamTheory theory : {BeamTheory::euler_bernoulli, BeamTheory::timoshenko}) {
    const Compliance6 whole = beam_compliance(l, s, steel, theory);
    Matrix6 sum = Matrix6::Zero();
    const int n = 7;
    for (int i = 0; i < n; ++i) {
      const Compliance6 piece = beam_compliance(l / n, s, steel, theory);
      const Compliance6 placed(piece.matrix(), Frame{{l * (i + 1) / n, 0, 0}});
      sum += placed.in(whole.frame()).matrix();
    }
    EXPECT_LT((sum - whole.matrix()).norm(), 1e-13 * whole.matrix().norm());
  }
}

TEST(Beam, ShearAddsLengthOverKappaGA) {
  const Section s = Section::rectangle(0.02, 0.03, 0.3);
  const Matrix6 difference = beam_compliance(0.5, s, steel, BeamTheory::timoshenko).matrix() -
                             beam_compliance(0.5, s, steel, BeamTheory::euler_bernoulli).matrix();
  const double kappa = 10 * 1.3 / (12 + 11 * 0.3);
  const double expected = 0.5 / (kappa * steel.shear_modulus * 0.02 * 0.03);
  EXPECT_NEAR(difference(1, 1), expected, 1e-6 * expected);
  EXPECT_NEAR(difference(2, 2), expected, 1e-6 * expected);
  EXPECT_DOUBLE_EQ(difference(0, 0), 0);
}

TEST(Beam, RefusesWhatIsNotABeam) {
  const Section good = Section::circle(0.02, 0.3);
  EXPECT_THROW(beam_compliance(-1, good, steel, BeamTheory::timoshenko), std::invalid_argument);
  EXPECT_THROW(beam_compliance(1, {}, steel, BeamTheory::timoshenko), std::invalid_argument);
  EXPECT_THROW(beam_compliance(1, good, {}, BeamTheory::timoshenko), std::invalid_argument);
  Section no_shear = good;
  no_shear.shear_coefficient_y.reset();
  EXPECT_THROW(beam_compliance(1, no_shear, steel, BeamTheory::timoshenko), std::invalid_argument);
  EXPECT_NO_THROW(beam_compliance(1, no_shear, steel, BeamTheory::euler_bernoulli));
}

}  // namespace
}  // namespace kinetostat::vjm::beam_test
