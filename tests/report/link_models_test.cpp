#include "kinetostat/report/screen/link_models.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace kinetostat::report::link_models_test {
namespace {

using testing::HasSubstr;

LinkModelFigure stiffness() { return stiffness_figure({.length = "mm", .force = "N"}); }
const std::vector<LinkModelRow> rows = {
    {.model = "1 beam", .value = 75e3, .by_link = {{"leg", 99e3}, {"foot", 76e3}}},
    {.model = "4 beams", .value = 104e3, .by_link = {{"leg", 103e3}, {"foot", 101e3}}},
    {.model = "FEA", .value = 100e3, .by_link = {}}};

TEST(LinkModelFigure, IsInTheUnitsOfTheRobotFile) {
  EXPECT_EQ(stiffness().unit, "N/mm");
  EXPECT_DOUBLE_EQ(stiffness().factor, 1e3);
}

TEST(LinkModelRows, NameTheLinkThatMakesMostOfTheDifference) {
  EXPECT_EQ(in_short(rows), "1 beam -25 % and 4 beams +4 % against FEA; most of it by link foot");
  const std::string table = text(stiffness(), rows);
  EXPECT_THAT(table, HasSubstr("link foot (-24 %)"));
  EXPECT_THAT(table, HasSubstr("link leg (+3 %)"));
}

TEST(LinkModelRows, AreRatiosToTheLast) {
  const io::Json json = to_json(stiffness(), rows);
  EXPECT_NEAR(json["rows"][0]["difference"].get<double>(), -0.25, 1e-12);
  EXPECT_NEAR(json["rows"][1]["by_link"]["leg"].get<double>(), 0.03, 1e-12);
  EXPECT_EQ(json["rows"][2]["difference"].get<double>(), 0);
  EXPECT_TRUE(json["rows"][2]["by_link"].empty());
}

}  // namespace
}  // namespace kinetostat::report::link_models_test
