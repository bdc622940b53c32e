// Effects into robot files, and out again.
#include "kinetostat/calibration/diagnosis/adoption.h"

#include <cmath>
#include <stdexcept>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace kinetostat::calibration {
namespace {

using testing::HasSubstr;

const Adoption clearance{.effect = "clearance",
                         .at = "x.rho",
                         .values = {{"gap", "m", 0.1 + 0.2, 1e-6}, {"n", "", 3, std::nan("")}},
                         .reasons = {"because of a: test"}};

const std::string robot =
    "kinetostat: 1   # a comment\nname: r\n\n# the end\nmanipulator: {chain: c}\n";

TEST(Adoption, ChangesNothingButTheEffects) {
  const std::string with = adopted(robot, clearance);
  EXPECT_TRUE(with.starts_with(robot));
  EXPECT_THAT(with, HasSubstr("effects:\n"));
  EXPECT_THAT(with, HasSubstr("  # because of a: test\n"));
  EXPECT_THAT(with, HasSubstr("gap: {value: 0.30000000000000004 m, sd: 1e-06 m}, n: 3}"));
  EXPECT_EQ(reverted(with), robot);
}

TEST(Adoption, GoesBehindTheEffectsThatAreThere) {
  const std::string text =
      "kinetostat: 1\neffects:   # found before\n  - {effect: preload, at: a}\n\n  # two\n  - "
      "{effect: preload, at: b}\n\nunits: {length: mm}\n";
  const std::string once = adopted(text, clearance);
  EXPECT_LT(once.find("at: b"), once.find("x.rho"));
  EXPECT_LT(once.find("x.rho"), once.find("units:"));
  const std::string twice = adopted(once, clearance);
  EXPECT_EQ(reverted(twice), once);
  EXPECT_EQ(reverted(once), text);
}

TEST(Adoption, RefusesWhatItCannotExtendOrTakeBack) {
  EXPECT_THROW(adopted("effects: [{effect: preload, at: a}]\n", clearance), std::invalid_argument);
  EXPECT_THROW(adopted("name: x", clearance), std::invalid_argument);
  EXPECT_THROW(reverted(robot), std::invalid_argument);
}

}  // namespace
}  // namespace kinetostat::calibration
