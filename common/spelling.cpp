#include "kinetostat/common/spelling.h"

#include <algorithm>
#include <cctype>

namespace kinetostat::common {
namespace {

char lower(char c) { return static_cast<char>(std::tolower(static_cast<unsigned char>(c))); }

// One letter wrong costs `edit`; a letter of the wrong case costs so little that it only selects
// between candidates that are equally near otherwise: "Mpa" is "MPa" rather than "mPa".
constexpr std::size_t edit = 1000;
constexpr std::size_t wrong_case = 1;

std::size_t replacement(char a, char b) {
  if (a == b) return 0;
  return lower(a) == lower(b) ? wrong_case : edit;
}

// Optimal string alignment: insertions, deletions, replacements and swaps of neighbours.
std::size_t edit_distance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> before(b.size() + 1), last(b.size() + 1), row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) last[j] = j * edit;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    row[0] = i * edit;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      row[j] = std::min(
          {last[j] + edit, row[j - 1] + edit, last[j - 1] + replacement(a[i - 1], b[j - 1])});
      if (i > 1 && j > 1 && lower(a[i - 1]) == lower(b[j - 2]) &&
          lower(a[i - 2]) == lower(b[j - 1]))
        row[j] = std::min(row[j], before[j - 2] + edit);
    }
    std::swap(before, last);
    std::swap(last, row);
  }
  return last[b.size()];
}

}  // namespace

std::string nearest_spelling(const std::string& word, const std::vector<std::string>& candidates) {
  constexpr std::size_t longest = 200;  // no word: comparing takes the product of two lengths
  std::string best;
  if (word.size() > longest) return best;
  std::size_t best_distance = (std::max<std::size_t>(1, word.size() / 3) + 1) * edit;
  for (const std::string& candidate : candidates) {
    const std::size_t longer = std::max(word.size(), candidate.size());
    const std::size_t shorter = std::min(word.size(), candidate.size());
    if ((longer - shorter) * edit >= best_distance) continue;  // whatever the letters are
    const std::size_t distance = edit_distance(word, candidate);
    const bool something_in_common = distance < longer * edit;
    if (something_in_common && distance < best_distance) {
      best_distance = distance;
      best = candidate;
    }
  }
  return best;
}

}  // namespace kinetostat::common
