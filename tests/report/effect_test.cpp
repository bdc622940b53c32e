#include "kinetostat/report/screen/effect.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetostat/io/text_file.h"

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

}  // namespace
}  // namespace kinetostat::report::effect_test
