#include "kinetostat/fea/linear_algebra/partition.h"

#include <algorithm>
#include <metis.h>
#include <new>

#include "kinetostat/common/index.h"

namespace kinetostat::fea {
namespace {

using common::at;

constexpr std::size_t least_points = 20;  // of a part

// Both directions of every link, as METIS wants them.
struct LinkLists {
  std::vector<idx_t> start, neighbour;
};

LinkLists lists_of(const std::vector<std::array<int, 2>>& links, std::size_t points) {
  LinkLists lists{std::vector<idx_t>(points + 1, 0), std::vector<idx_t>(2 * links.size())};
  for (const auto& [a, b] : links) {
    ++lists.start[at(a) + 1];
    ++lists.start[at(b) + 1];
  }
  for (std::size_t p = 0; p < points; ++p) lists.start[p + 1] += lists.start[p];
  std::vector<idx_t> next(lists.start.begin(), lists.start.end() - 1);
  for (const auto& [a, b] : links) {
    lists.neighbour[at(next[at(a)]++)] = b;
    lists.neighbour[at(next[at(b)]++)] = a;
  }
  return lists;
}

}  // namespace

std::vector<int> partition(const std::vector<std::array<int, 2>>& links,
                           const std::vector<int>& weights, int parts) {
  std::vector<idx_t> part(weights.size(), 0);
  idx_t count = static_cast<idx_t>(std::min(at(parts), weights.size() / least_points));
  const bool all_weightless =
      std::all_of(weights.begin(), weights.end(), [](int weight) { return weight == 0; });
  if (count > 1 && !all_weightless) {
    LinkLists lists = lists_of(links, weights.size());
    std::vector<idx_t> weight(weights.begin(), weights.end());
    idx_t points = static_cast<idx_t>(weights.size()), constraints = 1, cut = 0;
    idx_t options[METIS_NOPTIONS];
    METIS_SetDefaultOptions(options);
    options[METIS_OPTION_SEED] = 1;
    if (METIS_PartGraphRecursive(&points, &constraints, lists.start.data(), lists.neighbour.data(),
                                 weight.data(), nullptr, nullptr, &count, nullptr, nullptr, options,
                                 &cut, part.data()) != METIS_OK)
      throw std::bad_alloc();
  }
  return {part.begin(), part.end()};
}

}  // namespace kinetostat::fea
