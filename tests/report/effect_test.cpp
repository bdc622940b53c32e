#include "kinetostat/report/screen/effect.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetostat/io/text_file.h"
#include "kinetostat/report/diagnosis.h"
#include "kinetostat/spatial/units.h"

namespace kinetostat::report::effect_test {
namespace {

// The page of the theory of effects tells of each what the program prints.
TEST(EffectText, IsThatOfThePage) {
  const std::string page =
      io::read_text(std::string(KINETOSTAT_SOURCE_DIR) + "/docs/theory/effects.md");
  for (const auto& kind : vjm::effect_kinds()) {
    for (const std::string* part :
         {&kind->summary, &kind->law, &kind->source, &kind->signature, &kind->confuser})
      EXPECT_FALSE(part->empty()) << kind->name;
    std::string text = report::text(*kind);
    while (text.back() == '\n') text.pop_back();
    EXPECT_THAT(page, testing::HasSubstr("### " + kind->name + "\n\n```text\n" + text + "\n```"));
    if (kind->name == "joint_coupling") continue;  // chains of the Orthoglide have one drive each
    EXPECT_THAT(page, testing::HasSubstr("| `" + kind->name + "` | orthoglide,"))
        << "has no signature";
  }
}

// Whatever the units of a campaign, a value can be read back in the unit that is shown.
TEST(UnitForPeople, IsOfTheDimensionOfTheValue) {
  const calibration::Campaign campaign;
  for (const auto& kind : vjm::effect_kinds())
    for (const vjm::EffectParameter& parameter : kind->parameters)
      for (const bool angular : {false, true}) {
        const spatial::Dimension& dimension = angular ? parameter.angular : parameter.linear;
        const std::string unit = unit_for_people(campaign, parameter, angular);
        if (dimension == spatial::dimension::none) {
          EXPECT_EQ(unit, "") << kind->name;
        } else {
          EXPECT_EQ(spatial::parse_unit(unit).dimension, dimension) << kind->name << " " << unit;
        }
      }
}

}  // namespace
}  // namespace kinetostat::report::effect_test
