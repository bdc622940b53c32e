#include "kinetostat/report/manipulators/map.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace kinetostat::report::map_test {
namespace {

using testing::HasSubstr;

// A map of made-up values: the sum of the coordinates of each pose in mm.
class MapReport : public testing::Test {
 protected:
  void make(const std::array<std::size_t, 6>& shape) {
    list.shape = shape;
    std::size_t count = 1;
    for (const std::size_t size : shape) count *= size;
    for (std::size_t n = 0; n < count; ++n) {
      std::array<double, 6> at{};
      std::size_t rest = n;
      for (std::size_t i = 6; i-- > 0; rest /= shape[i])
        at[i] = 0.001 * static_cast<double>(rest % shape[i]);
      list.poses.push_back({spatial::Pose::translation({at[0], at[1], at[2]})});
      points.push_back({vjm::MapState::reached, {at[0] + at[1] + at[2]}});
    }
  }
  Map map() const { return {robot, list, indices, points}; }

  const vjm::Robot robot =
      vjm::read_robot(std::filesystem::path(KINETOSTAT_SOURCE_DIR) / "data/robots/orthoglide.yaml");
  vjm::PoseList list;
  std::vector<NamedIndex> indices{{.name = "deflection",
                                   .index = {.kind = vjm::MapIndex::Kind::deflection},
                                   .unit = "mm",
                                   .factor = 1e-3}};
  std::vector<vjm::MapPoint> points;
};

TEST_F(MapReport, CellsOfAGridJoinNeighboursAndFillItsBox) {
  make({4, 1, 3, 1, 1, 1});
  const io::VtuGrid grid = vtu(map());
  EXPECT_EQ(grid.cell, io::VtuCell::quad);
  ASSERT_EQ(grid.connectivity.size(), 4u * 3 * 2);
  for (std::size_t cell = 0; cell < grid.connectivity.size(); cell += 4)
    for (std::size_t k = 0; k < 4; ++k) {
      const auto a = static_cast<std::size_t>(grid.connectivity[cell + k]);
      const auto b = static_cast<std::size_t>(grid.connectivity[cell + (k + 1) % 4]);
      double apart = 0;
      for (std::size_t i = 0; i < 3; ++i)
        apart += std::abs(grid.points[3 * a + i] - grid.points[3 * b + i]);
      EXPECT_NEAR(apart, 0.001, 1e-12);
    }
}

TEST_F(MapReport, WhereThePlatformTurnsPointsStandAlone) {
  make({2, 2, 1, 1, 1, 3});
  const io::VtuGrid grid = vtu(map());
  EXPECT_EQ(grid.cell, io::VtuCell::vertex);
  EXPECT_EQ(grid.connectivity.size(), 12u);
}

TEST_F(MapReport, TableHasARowForEachPoseInItsUnits) {
  make({1, 1, 2, 1, 1, 1});
  points[1] = {vjm::MapState::unreachable, {std::numeric_limits<double>::quiet_NaN()}};
  EXPECT_EQ(csv(map()),
            "x [mm],y [mm],z [mm],rx [deg],ry [deg],rz [deg],state,deflection [mm]\n"
            "0,0,0,0,0,0,reached,0\n"
            "0,0,1,0,0,0,unreachable,\n");
}

TEST_F(MapReport, SummaryCountsStatesAndNamesTheExtremes) {
  make({2, 2, 1, 1, 1, 1});
  points[0].state = vjm::MapState::unstable;
  EXPECT_THAT(text(map()), HasSubstr("4 poses, 3 reached, 1 unstable\n"));
  const io::Json json = to_json(map());
  EXPECT_EQ(json["states"]["reached"], 3);
  EXPECT_EQ(json["states"]["unreachable"], 0);
  EXPECT_DOUBLE_EQ(json["indices"][0]["largest"], 0.002);
  EXPECT_EQ(json["indices"][0]["largest_at"]["position"], io::Json({0.001, 0.001, 0.0}));
}

}  // namespace
}  // namespace kinetostat::report::map_test
