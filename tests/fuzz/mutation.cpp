#include "fuzz/mutation.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <string_view>

namespace kinetostat::fuzz {
namespace {

using namespace std::string_view_literals;

constexpr std::size_t largest = 1 << 18;  // [bytes] of a file with mistakes

constexpr std::array numbers{
    "0"sv,    "-1"sv,     "1"sv,           "1e308"sv,      "-1e308"sv, "1e-308"sv,
    "1e99"sv, "1e999"sv,  "nan"sv,         "-nan"sv,       "inf"sv,    "-inf"sv,
    ".inf"sv, "-0.0"sv,   "2147483647"sv,  "2147483648"sv, "0x10"sv,   "4294967296"sv,
    "1e"sv,   "1.5.2"sv,  "-2147483649"sv, "9e18"sv,       "1,5"sv,    "18446744073709551616"sv,
    "+3"sv,   "000001"sv, "1e-400"sv,      "3 mm"sv,       "7 kg"sv,   "99999999"sv};

constexpr std::array words{""sv,
                           "&a "sv,
                           "*a"sv,
                           "<<: *a"sv,
                           "!!binary "sv,
                           "---\n"sv,
                           "...\n"sv,
                           "["sv,
                           "]"sv,
                           "{"sv,
                           "}"sv,
                           ","sv,
                           ": "sv,
                           "- "sv,
                           "? "sv,
                           "|"sv,
                           ">"sv,
                           "#"sv,
                           "\""sv,
                           "'"sv,
                           "\\"sv,
                           "\t"sv,
                           "\r\n"sv,
                           "\n"sv,
                           "\0"sv,
                           "\x1b[2J"sv,
                           "\xff"sv,
                           "\xc3\xa9"sv,
                           "null"sv,
                           "true"sv,
                           "~"sv,
                           "%s%n"sv,
                           "../"sv,
                           "/dev/zero"sv,
                           "=cmd"sv,
                           "[[[[[["sv,
                           "{{{{"sv,
                           "&#10;"sv,
                           "<a>"sv,
                           "$End"sv,
                           "*INCLUDE, INPUT=x"sv,
                           "\xe2\x80\xa8"sv,
                           "((((((((((((((((((((((((((((((((((((((((((((((((("sv};

struct Range {
  std::size_t begin = 0, size = 0;
};

Range any_range(const std::string& bytes, Random& random, std::size_t longest) {
  if (bytes.empty()) return {};
  const std::size_t begin = random.below(bytes.size());
  return {begin, 1 + random.below(std::min(longest, bytes.size() - begin))};
}

// The run of characters around a place for which `is_part` holds; empty where it does not.
template <class IsPart>
Range run_around(const std::string& bytes, std::size_t at, IsPart is_part) {
  if (at >= bytes.size() || !is_part(bytes[at])) return {at, 0};
  std::size_t begin = at, end = at;
  while (begin > 0 && is_part(bytes[begin - 1])) --begin;
  while (end < bytes.size() && is_part(bytes[end])) ++end;
  return {begin, end - begin};
}

// The next run after a random place.
template <class IsPart>
Range any_run(const std::string& bytes, Random& random, IsPart is_part) {
  if (bytes.empty()) return {};
  const std::size_t start = random.below(bytes.size());
  for (std::size_t k = 0; k < bytes.size(); ++k)
    if (const std::size_t at = (start + k) % bytes.size(); is_part(bytes[at]))
      return run_around(bytes, at, is_part);
  return {};
}

bool in_number(char c) {
  return std::isdigit(static_cast<unsigned char>(c)) != 0 || c == '.' || c == '-' || c == 'e';
}
bool in_word(char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_'; }
bool in_line(char c) { return c != '\n'; }

void flip_bit(std::string& bytes, Random& random) {
  if (bytes.empty()) return;
  char& byte = bytes[random.below(bytes.size())];
  byte = static_cast<char>(static_cast<unsigned char>(byte) ^ (1U << random.below(8)));
}

void change_byte(std::string& bytes, Random& random) {
  constexpr std::string_view usual("\0\x01\x7f\x80\xff\n \"0", 9);
  if (bytes.empty()) return;
  bytes[random.below(bytes.size())] =
      random.chance(2) ? usual[random.below(usual.size())] : static_cast<char>(random.below(256));
}

void lose(std::string& bytes, Random& random) {
  const Range range = any_range(bytes, random, random.chance(4) ? bytes.size() : 40);
  bytes.erase(range.begin, range.size);
}

void cut(std::string& bytes, Random& random) {
  if (!bytes.empty()) bytes.resize(random.below(bytes.size()));
}

void double_part(std::string& bytes, Random& random) {
  const Range range = any_range(bytes, random, random.chance(4) ? bytes.size() : 60);
  const std::string part = bytes.substr(range.begin, range.size);
  const std::size_t times = random.chance(8) ? 1 + random.below(200) : 1;
  for (std::size_t k = 0; k < times && bytes.size() < largest; ++k) bytes.insert(range.begin, part);
}

void insert_word(std::string& bytes, Random& random) {
  bytes.insert(random.below(bytes.size() + 1), words[random.below(words.size())]);
}

void change_number(std::string& bytes, Random& random) {
  const Range range = any_run(bytes, random, in_number);
  if (random.chance(3) && range.size > 0) {  // one digit
    bytes[range.begin + random.below(range.size)] = static_cast<char>('0' + random.below(10));
    return;
  }
  bytes.replace(range.begin, range.size, numbers[random.below(numbers.size())]);
}

// Another word of the corpus, so that keys and kinds meet that do not belong together.
void change_word(std::string& bytes, const std::vector<std::string>& corpus, Random& random) {
  const std::string& source = corpus[random.below(corpus.size())];
  const Range from = any_run(source, random, in_word), to = any_run(bytes, random, in_word);
  bytes.replace(to.begin, to.size, source.substr(from.begin, from.size));
}

void move_line(std::string& bytes, Random& random) {
  const Range line = any_run(bytes, random, in_line);
  const std::string text = bytes.substr(line.begin, line.size) + "\n";
  if (!random.chance(3)) bytes.erase(line.begin, line.size + 1);
  if (random.chance(4)) return;  // lost
  const Range before = any_run(bytes, random, in_line);
  bytes.insert(before.begin, text);
}

void splice(std::string& bytes, const std::vector<std::string>& corpus, Random& random) {
  const std::string& source = corpus[random.below(corpus.size())];
  const Range part = any_range(source, random, 400);
  const std::size_t at = random.below(bytes.size() + 1);
  const std::size_t replaced = random.chance(2) ? std::min(part.size, bytes.size() - at) : 0;
  bytes.replace(at, replaced, source, part.begin, part.size);
}

void change(std::string& bytes, const std::vector<std::string>& corpus, Random& random) {
  switch (random.below(12)) {
    case 0:
      return flip_bit(bytes, random);
    case 1:
      return change_byte(bytes, random);
    case 2:
      return lose(bytes, random);
    case 3:
      return random.chance(3) ? cut(bytes, random) : flip_bit(bytes, random);
    case 4:
      return double_part(bytes, random);
    case 5:
      return insert_word(bytes, random);
    case 6:
    case 7:
      return change_number(bytes, random);
    case 8:
    case 9:
      return change_word(bytes, corpus, random);
    case 10:
      return move_line(bytes, random);
    default:
      return splice(bytes, corpus, random);
  }
}

}  // namespace

std::uint64_t Random::next() {
  state_ += 0x9e3779b97f4a7c15;
  std::uint64_t z = state_;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9;
  z = (z ^ (z >> 27)) * 0x94d049bb133111eb;
  return z ^ (z >> 31);
}

std::string mutated(std::string bytes, const std::vector<std::string>& corpus, Random& random) {
  const std::size_t changes = 1 + random.below(random.chance(3) ? 8 : 3);
  for (std::size_t k = 0; k < changes; ++k) change(bytes, corpus, random);
  if (bytes.size() > largest) bytes.resize(largest);
  return bytes;
}

}  // namespace kinetostat::fuzz
