// "Did you mean": the nearest of a list of words.
#pragma once

#include <string>
#include <vector>

namespace kinetostat::common {

/// The candidate with the smallest edit distance to `word` (ignoring case), or "" when none is near
/// enough to be a plausible typing error (at most a third of the letters, at least one, but not
/// all).
std::string nearest_spelling(const std::string& word, const std::vector<std::string>& candidates);

}  // namespace kinetostat::common
