#include "kinetostat/fea/linear_algebra/partition.h"

#include <algorithm>
#include <array>
#include <vector>

#include <gtest/gtest.h>

#include "kinetostat/common/index.h"

namespace kinetostat::fea::partition_test {
namespace {

using common::at;

using Links = std::vector<std::array<int, 2>>;

// Points of a square, each linked with its right and its upper neighbour.
Links square_links(int side) {
  Links links;
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x) {
      if (x + 1 < side) links.push_back({y * side + x, y * side + x + 1});
      if (y + 1 < side) links.push_back({y * side + x, (y + 1) * side + x});
    }
  return links;
}

std::vector<int> weights_of_parts(const std::vector<int>& part, const std::vector<int>& weights,
                                  int parts) {
  std::vector<int> sums(at(parts), 0);
  for (std::size_t p = 0; p < part.size(); ++p) sums[at(part[p])] += weights[p];
  return sums;
}

// Four strips cut 3 x 40 links of a square, four quarters 2 x 40.
TEST(Partition, CutsASquareNoWorseThanStrips) {
  constexpr int side = 40;
  const Links links = square_links(side);
  const std::vector<int> part = partition(links, std::vector<int>(side * side, 1), 4);
  const auto cut = std::count_if(links.begin(), links.end(), [&part](const std::array<int, 2>& l) {
    return part[at(l[0])] != part[at(l[1])];
  });
  EXPECT_LE(cut, 3 * side);
}

TEST(Partition, BalancesWeightsNotPoints) {
  constexpr int side = 30, parts = 3;
  std::vector<int> weights(side * side, 1);
  std::fill(weights.begin(), weights.begin() + side * side / 3, 7);
  const std::vector<int> part = partition(square_links(side), weights, parts);
  const double even = (7.0 + 1 + 1) / 3 * side * side / parts;
  for (const int sum : weights_of_parts(part, weights, parts)) EXPECT_NEAR(sum, even, 0.05 * even);
}

TEST(Partition, LeavesPartsEmptyWherePointsAreFew) {
  const std::vector<int> part = partition(square_links(5), std::vector<int>(25, 1), 8);
  EXPECT_EQ(std::count(part.begin(), part.end(), 0), 25);
  EXPECT_TRUE(partition({}, {}, 3).empty());
}

}  // namespace
}  // namespace kinetostat::fea::partition_test
