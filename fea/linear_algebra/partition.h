// Points with links between them, divided into parts that few links cross.
#pragma once

#include <array>
#include <vector>

namespace kinetostat::fea {

/// The part of each point, 0 to parts - 1: of about equal weight, with few links between them
/// (METIS, multilevel recursive bisection: Karypis and Kumar, SIAM J. Sci. Comput. 20, 1998). The
/// same input gives the same parts. Fewer are made where there would be less than 20 points in
/// each; the last ones are empty then. `links` are pairs of different points, each pair once;
/// `weights` are those of the points, at least 0. Requires parts >= 1. Throws std::bad_alloc.
std::vector<int> partition(const std::vector<std::array<int, 2>>& links,
                           const std::vector<int>& weights, int parts);

}  // namespace kinetostat::fea
