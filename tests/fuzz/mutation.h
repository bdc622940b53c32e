// Files with mistakes in them, made from sound ones; the same for the same seed on every machine.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace kinetostat::fuzz {

/// SplitMix64 (Steele, Lea and Flood 2014): the standard library's distributions differ between
/// implementations.
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}
  std::uint64_t next();
  /// Below `count`, which is not 0.
  std::size_t below(std::size_t count) { return next() % count; }
  bool chance(unsigned of) { return below(of) == 0; }  // one in `of`

 private:
  std::uint64_t state_;
};

/// One to eight changes: flipped, lost, doubled and foreign bytes; parts of another file of the
/// corpus; numbers, words and lines exchanged, doubled, moved and lost.
std::string mutated(std::string bytes, const std::vector<std::string>& corpus, Random& random);

}  // namespace kinetostat::fuzz
