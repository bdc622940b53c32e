// From readings to the missing effect, into the robot file and out again, as users meet it.
#include <algorithm>
#include <map>
#include <numbers>
#include <numeric>
#include <random>
#include <string>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetostat/io/csv.h"
#include "kinetostat/io/json.h"
#include "kinetostat/io/text_file.h"

#include "apps/run_program.h"
#include "support/two_arms.h"

namespace kinetostat::diagnose_test {
namespace {

using test::kinetostat;
using test::Outcome;
using test::working_folder;
using testing::HasSubstr;

// A few candidates of several sorts: the whole catalogue takes longer than a test should.
const std::string few =
    " --effects clearance,friction,hardening,joint_compliance,preload,wrench_gain --draws 199 ";

class Diagnose : public testing::Test {
 protected:
  Diagnose() {
    shown_ = io::read_text(working_folder() / "data/robots/orthoglide.yaml");
    if (shown_.find("uncertain:") == std::string::npos)
      shown_ += "uncertain:\n  - {stiffness: rho}\n  - {stiffness: foot}\n  - {stiffness: leg}\n";
    io::write_atomically(working_folder() / "shown.yaml", shown_);
  }

  // Readings of the shown robot with something that it does not have.
  void measure(const std::string& effects, const std::string& noise = "5um",
               const std::string& seed = "1") {
    io::write_atomically(working_folder() / "truth.yaml", shown_ + effects);
    const Outcome outcome = kinetostat(
        "simulate truth.yaml --plan data/measurements/plans/orthoglide.csv "
        "--noise-translation " +
        noise + " --noise-rotation 20urad -o campaign --seed " + seed);
    ASSERT_EQ(outcome.code, 0) << outcome.err;
  }
  static Outcome diagnose(const std::string& more = "") {
    return kinetostat("diagnose shown.yaml campaign/campaign.yaml -q -o diagnosis.json" + few +
                      more);
  }
  static io::Json result() { return io::read_json(working_folder() / "diagnosis.json"); }

  std::string shown_;
};

TEST_F(Diagnose, NamesTheHiddenClearanceAndAdoptingItLetsTheErrorFall) {
  measure("effects:\n  - {effect: clearance, at: y.rho, gap: 0.05 mm}\n");
  const Outcome outcome = diagnose();
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const io::Json json = result();
  EXPECT_EQ(json["verdict"], "identified");
  ASSERT_EQ(json["found"].size(), 1u);
  EXPECT_EQ(json["found"][0]["effect"], "clearance");
  EXPECT_EQ(json["found"][0]["at"], "y.rho");
  const double gap = json["found"][0]["values"][0], sd = json["found"][0]["deviations"][0];
  EXPECT_NEAR(gap, 5e-5, 4 * sd);
  const io::Json& confusion = json["steps"][0]["confusion"];
  ASSERT_GE(confusion["candidates"].size(), 2u);
  EXPECT_THAT(confusion["candidates"].dump(), HasSubstr("clearance at y.rho"));
  EXPECT_EQ(confusion["cosines"][0][0], 1);
  const double cosine = confusion["cosines"][0][1];
  EXPECT_GT(cosine, 0);
  EXPECT_LE(cosine, 1);
  const io::Json& stages = json["waterfall"];
  ASSERT_EQ(stages.size(), 5u);
  EXPECT_GT(stages[0]["whitened"], stages[1]["whitened"]);
  EXPECT_GT(stages[1]["whitened"].get<double>(), 1.5);
  EXPECT_LT(stages[2]["whitened"].get<double>(), 1.1);

  const Outcome adopted = kinetostat("adopt shown.yaml diagnosis.json -o better.yaml");
  ASSERT_EQ(adopted.code, 0) << adopted.err;
  EXPECT_THAT(adopted.out, HasSubstr("clearance at joint y.rho and 3 fitted values (rho"));
  const std::string better = io::read_text(working_folder() / "better.yaml");
  EXPECT_TRUE(better.starts_with(shown_));
  EXPECT_THAT(better, HasSubstr("gap: {value: 0.0"));  // in the file's mm
  const Outcome compared =
      kinetostat("compare better.yaml campaign/campaign.yaml -q --json better.json");
  EXPECT_THAT(compared.out, HasSubstr("The model explains the readings"));
  // As it stands it has the error that the diagnosis shows last.
  EXPECT_EQ(stages[3]["name"], "as adopted");
  EXPECT_NEAR(io::read_json(working_folder() / "better.json")["as_designed"]["error_over_noise"]
                  .get<double>(),
              stages[3]["whitened"].get<double>(), 1e-4);
  // Its refit ends where the search for the effect did, as far as that settled.
  const io::Json parity = io::read_json(working_folder() / "better.json");
  EXPECT_NEAR(parity["refitted"]["chi_square"]["chi_square"].get<double>(),
              json["chi_square_after"]["chi_square"].get<double>(), 0.05);
  const Outcome both = kinetostat(
      "compare --before shown.yaml --after better.yaml campaign/campaign.yaml -q --json both.json");
  EXPECT_EQ(both.code, 0) << both.err;
  EXPECT_THAT(both.out, HasSubstr("The held-out error falls from"));
  const io::Json fall = io::read_json(working_folder() / "both.json")["waterfall"];
  ASSERT_EQ(fall.size(), 5u);
  EXPECT_EQ(fall[1]["name"], "before, refitted");
  EXPECT_NEAR(fall[1]["whitened"].get<double>(), stages[1]["whitened"].get<double>(), 1e-6);
  EXPECT_LT(fall[3]["whitened"].get<double>(), 1.1);
  EXPECT_EQ(kinetostat("compare --before shown.yaml campaign/campaign.yaml").code, 2);

  ASSERT_EQ(kinetostat("revert better.yaml").code, 0);
  EXPECT_EQ(io::read_text(working_folder() / "better.yaml"), shown_);
}

TEST_F(Diagnose, NamesNothingInReadingsWithNothingHidden) {
  for (const char* seed : {"3", "4"}) {
    measure("", "5um", seed);
    EXPECT_EQ(diagnose().code, 0);
    EXPECT_EQ(result()["verdict"], "none needed") << seed;
    EXPECT_TRUE(result()["found"].empty());
  }
  const Outcome nothing = kinetostat("adopt shown.yaml diagnosis.json -o x.yaml");
  EXPECT_EQ(nothing.code, 5);
  EXPECT_THAT(nothing.err, HasSubstr("there is no effect to adopt"));
  EXPECT_FALSE(std::filesystem::exists(working_folder() / "x.yaml"));
}

// In units of the noise: their squares are the chi-square that is printed, the fit left nothing of
// its own in the residual, and 2 % more load is 2 % more of every displacement.
TEST_F(Diagnose, WritesResidualAndSignaturesForOtherMethods) {
  measure("");
  EXPECT_EQ(diagnose("--signatures signatures.csv").code, 0);
  const io::CsvTable table(io::read_text(working_folder() / "signatures.csv"), "signatures.csv");
  const io::CsvTable readings(io::read_text(working_folder() / "campaign/readings.csv"),
                              "readings.csv");
  const std::size_t residual = *table.find("residual"), component = *table.find("component");
  double chi_square = 0, left = 0, fitted = 0, along = 0, gain = 0, motion = 0;
  for (std::size_t r = 0; r < table.rows(); ++r) {
    const double value = table.number(r, residual), by_fit = table.number(r, residual + 1);
    chi_square += value * value;
    left += value * by_fit;
    fitted += by_fit * by_fit;
    const std::string name(table.cell(r, component));
    const double sigma = name[0] == 'd' ? 5e-3 : 20e-6 * 180 / std::numbers::pi;  // mm, deg
    // Readings without a name have their number.
    const auto row = static_cast<std::size_t>(table.number(r, *table.find("reading"))) - 1;
    const double predicted = readings.number(row, *readings.find(name)) / sigma - value;
    const double signature = table.number(r, *table.find("wrench_gain at load"));
    along += signature * predicted;
    gain += signature * signature;
    motion += predicted * predicted;
  }
  EXPECT_NEAR(chi_square, result()["chi_square_before"]["chi_square"].get<double>(),
              1e-6 * chi_square);
  EXPECT_LT(std::abs(left), 1e-3 * std::sqrt(chi_square * fitted));
  EXPECT_NEAR(along / motion, 0.02, 0.0005);
  EXPECT_GT(along / std::sqrt(gain * motion), 0.999);
}

// A wrench gain and a global change of stiffness are the same in such readings: no confident name.
TEST_F(Diagnose, DoesNotNameWhatIsConfoundedWithTheFit) {
  measure("effects:\n  - {effect: wrench_gain, at: load, gain: 1.1}\n");
  const Outcome outcome = diagnose();
  EXPECT_EQ(outcome.code, 5);
  EXPECT_THAT(outcome.out, HasSubstr("wrench_gain at load alone, at gain = 1.1"));
  const io::Json json = result();
  EXPECT_EQ(json["verdict"], "inconclusive");
  EXPECT_EQ(json["instead_of_refit"]["effect"], "wrench_gain");
  EXPECT_NEAR(json["instead_of_refit"]["values"][0].get<double>(), 1.1, 0.002);
  EXPECT_TRUE(json["found"].empty());
  bool said = false;
  for (const io::Json& ranked : json["steps"][0]["ranking"])
    said |= ranked["effect"] == "wrench_gain" && !ranked["observable"].get<bool>();
  EXPECT_TRUE(said);
}

TEST_F(Diagnose, IsInconclusiveWithoutKnownNoise) {
  measure("");
  std::string campaign = io::read_text(working_folder() / "campaign/campaign.yaml");
  const std::size_t at = campaign.find("noise:");
  ASSERT_NE(at, std::string::npos);
  campaign.erase(at, campaign.find('\n', at) + 1 - at);
  io::write_atomically(working_folder() / "campaign/campaign.yaml", campaign);
  const Outcome outcome = diagnose();
  EXPECT_EQ(outcome.code, 5);
  EXPECT_EQ(result()["verdict"], "inconclusive");
  EXPECT_THAT(outcome.out, HasSubstr("how exact the readings are"));
}

TEST_F(Diagnose, SameBytesForAnyNumberOfThreads) {
  measure("effects:\n  - {effect: preload, at: x.rho, force: 40 N}\n");
  diagnose("--threads 1 --no-cache");
  const std::string one = io::read_text(working_folder() / "diagnosis.json");
  diagnose("--threads 2 --no-cache");
  EXPECT_EQ(io::read_text(working_folder() / "diagnosis.json"), one);
}

// The same readings in other units, the rows in another order.
void rewrite(const std::filesystem::path& from, const std::filesystem::path& to) {
  const io::CsvTable table(io::read_text(from / "readings.csv"), "readings.csv");
  const std::map<char, double> factors{{'f', 1e-3}, {'d', 1e3}, {'r', std::numbers::pi / 180}};
  std::vector<std::size_t> order(table.rows());
  std::iota(order.begin(), order.end(), 0);
  std::shuffle(order.begin(), order.end(), std::mt19937(5));
  std::string text = fmt::format("{}\n", fmt::join(table.columns(), ","));
  for (const std::size_t row : order) {
    std::vector<double> values;
    for (std::size_t c = 0; c < table.columns().size(); ++c) {
      const std::string& name = table.columns()[c];
      // Poses x, y, z in micrometres like the displacements.
      const double factor = name.size() == 1 ? 1e3 : factors.at(name[0]);
      values.push_back(factor * table.number(row, c));
    }
    text += fmt::format("{}\n", fmt::join(values, ","));
  }
  std::string campaign = io::read_text(from / "campaign.yaml");
  const std::string units = "length: mm, force: N, angle: deg";
  campaign.replace(campaign.find(units), units.size(), "length: um, force: kN, angle: rad");
  std::filesystem::create_directories(to);
  io::write_atomically(to / "readings.csv", text);
  io::write_atomically(to / "campaign.yaml", campaign);
}

TEST_F(Diagnose, SaysTheSameInOtherUnitsAndOfRowsInAnotherOrder) {
  measure("effects:\n  - {effect: clearance, at: y.rho, gap: 0.05 mm}\n");
  const std::string two = " -q --effects clearance,wrench_gain --draws 99 -o ";
  ASSERT_EQ(kinetostat("diagnose shown.yaml campaign/campaign.yaml" + two + "read.json").code, 0);
  const io::Json as_read = io::read_json(working_folder() / "read.json");
  rewrite(working_folder() / "campaign", working_folder() / "other");
  ASSERT_EQ(kinetostat("diagnose shown.yaml other/campaign.yaml" + two + "other.json").code, 0);
  const io::Json other = io::read_json(working_folder() / "other.json");
  EXPECT_EQ(other["verdict"], as_read["verdict"]);
  ASSERT_EQ(other["found"].size(), 1u);
  EXPECT_EQ(other["found"][0]["at"], as_read["found"][0]["at"]);
  const double gap = as_read["found"][0]["values"][0];
  EXPECT_NEAR(other["found"][0]["values"][0], gap, 1e-6 * gap);
  const io::Json &a = as_read["steps"][0]["ranking"], &b = other["steps"][0]["ranking"];
  for (std::size_t i = 0; i < a.size(); ++i)
    EXPECT_NEAR(b[i].value("surprise", 0.0), a[i].value("surprise", 0.0), 1e-4);
}

TEST_F(Diagnose, MistakesAreNamed) {
  measure("");
  for (const char* option : {"--effects", "--without"}) {
    const Outcome typo =
        kinetostat(fmt::format("diagnose shown.yaml campaign/campaign.yaml {} clearence", option));
    EXPECT_EQ(typo.code, 2);
    EXPECT_THAT(typo.err, HasSubstr("did you mean 'clearance'"));
  }
  io::write_atomically(working_folder() / "no.json", "{}");
  EXPECT_EQ(kinetostat("adopt shown.yaml no.json").code, 3);
}

// Two torques that lift the tool nearly alike, one up and one down: neither shows alone.
TEST(Adopt, TakesAllThatWasFoundTogether) {
  const auto write = [](const char* name, const std::string& text) {
    io::write_atomically(working_folder() / name, text);
  };
  write("arms.yaml", test::two_arms);
  write("truth.yaml",
        test::two_arms + fmt::format("effects:\n  - {{effect: preload, at: q1, force: {}}}\n"
                                     "  - {{effect: preload, at: q2, force: {}}}\n",
                                     test::torque_1, test::torque_2));
  write("arms.csv", test::lifts());
  ASSERT_EQ(kinetostat("simulate truth.yaml --plan arms.csv --absolute --noise-translation 3um "
                       "--components dz -o lifts --seed 2")
                .code,
            0);
  ASSERT_EQ(kinetostat("diagnose arms.yaml lifts/campaign.yaml -q -o arms.json "
                       "--effects preload,clearance,wrench_gain")
                .code,
            0);
  io::Json json = io::read_json(working_folder() / "arms.json");
  ASSERT_EQ(json["found"].size(), 2u);
  // Alone neither is a help.
  EXPECT_EQ(kinetostat("adopt arms.yaml arms.json --effect 'preload at arm.q1' -o one.yaml").code,
            5);
  const Outcome all = kinetostat("adopt arms.yaml arms.json --all -o both.yaml");
  EXPECT_EQ(all.code, 0) << all.err;
  EXPECT_THAT(all.out, HasSubstr("preload at joint q1, preload at joint q2"));
  EXPECT_THAT(kinetostat("compare both.yaml lifts/campaign.yaml -q").out,
              HasSubstr("The model explains the readings"));

  // What only came nearest is not adopted, unless somebody insists.
  json["verdict"] = "none of the above";
  write("arms.json", json.dump());
  const Outcome nearest = kinetostat("adopt arms.yaml arms.json --all -o forced.yaml");
  EXPECT_EQ(nearest.code, 5);
  EXPECT_THAT(nearest.err, HasSubstr("does not explain these readings"));
  EXPECT_EQ(kinetostat("adopt arms.yaml arms.json --all --force -o forced.yaml").code, 0);

  // What is left out, and what else it may be, is said.
  json["found"][0]["instead"] = {"clearance at arm.q1"};
  json["or_something_else"] = true;
  write("arms.json", json.dump());
  const Outcome one =
      kinetostat("adopt arms.yaml arms.json --effect 'preload at arm.q1' --force -o forced.yaml");
  EXPECT_THAT(one.out, HasSubstr("not adopted: preload at arm.q2"));
  EXPECT_THAT(one.out, HasSubstr("reload at arm.q1 may be something else: clearance at arm.q1"));
  EXPECT_THAT(one.out, HasSubstr("an effect outside the catalogue"));
}

TEST(CompareBeforeAfter, RefusesARobotThatWasNotMeasured) {
  const std::string folder = "data/measurements/arm_hysteresis";
  const Outcome other =
      kinetostat("compare --before " + folder + "/robot.yaml --after data/robots/bench.yaml " +
                 folder + "/campaign.yaml");
  EXPECT_EQ(other.code, 3) << other.err;
  EXPECT_THAT(other.err, HasSubstr("has other joints in these readings"));
}

}  // namespace
}  // namespace kinetostat::diagnose_test
