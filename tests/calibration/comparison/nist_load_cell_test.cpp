// Real readings with a published verdict: NIST StRD "Pontius" and the NIST/SEMATECH handbook
// (section 4.6.2): a straight line through the load cell data fails its lack-of-fit test with
// F = 214.7 against 2.15.
#include <map>

#include <gtest/gtest.h>

#include "kinetostat/calibration/campaign/campaign_file.h"
#include "kinetostat/io/csv.h"

#include "calibration/synthetic.h"

namespace kinetostat::calibration::nist_load_cell_test {
namespace {

const std::string folder = std::string(KINETOSTAT_SOURCE_DIR) + "/data/measurements/nist_load_cell";

// Straight line by the textbook's closed form, straight from the table [mm, N].
struct StraightLine {
  double slope = 0, intercept = 0, deviation = 0, slope_error = 0, lack_of_fit = 0;
};

StraightLine straight_line() {
  const io::CsvTable table = io::read_csv(folder + "/readings.csv");
  const std::size_t fz = *table.find("fz"), dz = *table.find("dz");
  const auto n = static_cast<double>(table.rows());
  double sx = 0, sy = 0, sxx = 0, sxy = 0;
  std::map<double, std::vector<double>> groups;
  for (std::size_t i = 0; i < table.rows(); ++i) {
    const double x = table.number(i, fz), y = table.number(i, dz);
    sx += x;
    sy += y;
    groups[x].push_back(y);
  }
  for (std::size_t i = 0; i < table.rows(); ++i) {
    const double x = table.number(i, fz) - sx / n, y = table.number(i, dz) - sy / n;
    sxx += x * x;
    sxy += x * y;
  }
  StraightLine line;
  line.slope = sxy / sxx;
  line.intercept = (sy - line.slope * sx) / n;
  double squares = 0, pure = 0;
  for (const auto& [x, values] : groups) {
    double mean = 0;
    for (const double y : values) mean += y / static_cast<double>(values.size());
    for (const double y : values) {
      squares += std::pow(y - line.intercept - line.slope * x, 2);
      pure += std::pow(y - mean, 2);
    }
  }
  const auto m = static_cast<double>(groups.size());
  line.deviation = std::sqrt(squares / (n - 2));
  line.slope_error = line.deviation / std::sqrt(sxx);
  line.lack_of_fit = ((squares - pure) / (m - 2)) / (pure / (n - m));
  return line;
}

class NistLoadCell : public testing::Test {
 protected:
  static const Comparison& comparison() {
    static const Comparison c = test::compare_files(
        vjm::read_robot(*robot_named_in(folder + "/campaign.yaml")), folder + "/campaign.yaml");
    return c;
  }
  static const Assessment& fitted() { return comparison().fitted.value(); }
};

TEST_F(NistLoadCell, StraightLineFailsWithThePublishedFigure) {
  const LackOfFitTest& test = fitted().lack_of_fit.value();
  EXPECT_NEAR(test.f, 214.7, 0.05);
  EXPECT_NEAR(test.critical, 2.15, 0.005);
  EXPECT_EQ(test.degrees_of_freedom_lack, 18);
  EXPECT_EQ(test.degrees_of_freedom_pure, 20);
  EXPECT_EQ(fitted().adequacy, Adequacy::inadequate);
}

TEST_F(NistLoadCell, FitIsTheStraightLineOfTheTextbook) {
  const StraightLine line = straight_line();
  EXPECT_NEAR(fitted().lack_of_fit->f, line.lack_of_fit, 1e-8 * line.lack_of_fit);
  EXPECT_NEAR(*fitted().residual_deviation * 1e3, line.deviation, 1e-10 * line.deviation);
  const ParameterEstimate& spring = fitted().fit.parameters.at(0);
  const double stiffness = 1e-3 * *spring.parameter.stiffness * std::exp(spring.value);
  EXPECT_NEAR(stiffness * line.slope, 1, 1e-10);
  EXPECT_NEAR(fitted().fit.zeros.at(0).value * 1e3, line.intercept, 1e-10);
}

TEST_F(NistLoadCell, WithoutAStatedNoiseThereIsNoChiSquare) {
  EXPECT_EQ(comparison().noise.source, NoiseSource::replicates);
  EXPECT_FALSE(fitted().chi_square);
  EXPECT_FALSE(comparison().noise_check);
}

// With a spring whose compliance falls with its load the model is the certified quadratic
// y = b0 + b1 x + b2 x^2 of NIST StRD "Pontius" [mm, N]: b0 the zero, b1 = 1/k, b2 = -b.
TEST_F(NistLoadCell, HardeningReachesTheCertifiedQuadratic) {
  const vjm::Robot robot =
      vjm::read_robot(std::string(KINETOSTAT_SOURCE_DIR) + "/data/robots/bench_hardening.yaml");
  const Comparison c = test::compare_files(robot, folder + "/campaign.yaml");
  ASSERT_TRUE(c.fitted) << c.refit_failure;
  const Assessment& fitted = *c.fitted;
  ASSERT_EQ(fitted.fit.parameters.size(), 2u);
  const ParameterEstimate &spring = fitted.fit.parameters[0], &b = fitted.fit.parameters[1];
  const double b1 = 1e3 / (*spring.parameter.stiffness * std::exp(spring.value));
  EXPECT_NEAR(fitted.fit.zeros.at(0).value * 1e3 / 0.673565789473684E-03, 1, 5e-7);
  EXPECT_NEAR(b1 / 0.732059160401003E-06, 1, 5e-7);
  EXPECT_NEAR(-b.value * 1e3 / -0.316081871345029E-14, 1, 5e-7);
  EXPECT_NEAR(*fitted.residual_deviation * 1e3 / 0.205177424076185E-03, 1, 5e-7);
  RecordProperty(
      "zero",
      fmt::format("{:.3e}", fitted.fit.zeros.at(0).value * 1e3 / 0.673565789473684E-03 - 1));
  RecordProperty("linear", fmt::format("{:.3e}", b1 / 0.732059160401003E-06 - 1));
  RecordProperty("quadratic", fmt::format("{:.3e}", -b.value * 1e3 / -0.316081871345029E-14 - 1));
  // Certified deviations, by the certified scatter instead of that of the replicates.
  const double scatter = std::sqrt(fitted.fit.squared_error / 37);
  EXPECT_NEAR(b.standard_error * scatter * 1e3 / 0.486652849992036E-16, 1, 1e-4);
  ASSERT_TRUE(fitted.lack_of_fit);
  EXPECT_LT(fitted.lack_of_fit->f, fitted.lack_of_fit->critical);
  EXPECT_EQ(fitted.lack_of_fit->degrees_of_freedom_lack, 17);
  EXPECT_EQ(fitted.adequacy, Adequacy::adequate);
}

// Without its replicates the same campaign has nothing but the residual: no verdict.
TEST_F(NistLoadCell, OneRunAloneIsNotJudged) {
  const io::CsvTable table = io::read_csv(folder + "/readings.csv");
  std::string csv = "fz,dz\n";
  for (std::size_t i = 0; i < 20; ++i)
    csv +=
        fmt::format("{},{}\n", table.cell(i, *table.find("fz")), table.cell(i, *table.find("dz")));
  const auto file = test::write_campaign(
      "kinetostat: 1\ncampaign: one run\nunits: {length: mm, force: N}\ndisplacement: difference\n"
      "zero: estimate\nreadings: readings.csv\n",
      csv);
  const Comparison c = test::compare_files(test::bench(1.37e9), file);
  EXPECT_EQ(c.noise.source, NoiseSource::unknown);
  EXPECT_EQ(c.fitted->adequacy, Adequacy::not_evaluated);
  EXPECT_FALSE(c.fitted->lack_of_fit);
  EXPECT_FALSE(c.fitted->chi_square);
  // The standard error of the slope is then the textbook's, from the residual, and says so.
  EXPECT_EQ(c.fitted->fit.error_source, NoiseSource::unknown);
}

}  // namespace
}  // namespace kinetostat::calibration::nist_load_cell_test
