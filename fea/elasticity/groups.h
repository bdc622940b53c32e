// Items by their owners, for example elements by the nodes that they touch.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "kinetostat/common/index.h"

namespace kinetostat::fea {

/// Those of owner i are item[start[i]] to item[start[i + 1] - 1], ascending.
struct Groups {
  std::vector<int> start, item;

  std::span<const int> of(int owner) const {
    const auto first = common::at(start[common::at(owner)]);
    const auto last = common::at(start[common::at(owner) + 1]);
    return std::span(item).subspan(first, last - first);
  }
};

/// `owners_of(i)` are the owners of item i, a range of int; called twice for each item.
template <class OwnersOf>
Groups group(std::size_t owners, std::size_t items, OwnersOf owners_of) {
  Groups groups{std::vector<int>(owners + 1, 0), {}};
  for (std::size_t i = 0; i < items; ++i)
    for (const int owner : owners_of(i)) ++groups.start[common::at(owner) + 1];
  for (std::size_t o = 0; o < owners; ++o) groups.start[o + 1] += groups.start[o];
  groups.item.resize(common::at(groups.start.back()));
  std::vector<int> next(groups.start.begin(), groups.start.end() - 1);
  for (std::size_t i = 0; i < items; ++i)
    for (const int owner : owners_of(i))
      groups.item[common::at(next[common::at(owner)]++)] = static_cast<int>(i);
  return groups;
}

}  // namespace kinetostat::fea
