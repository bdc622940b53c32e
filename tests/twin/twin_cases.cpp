// twin_cases: makes cases with hidden effects.
#include <cstdio>
#include <exception>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "case.h"

namespace {

constexpr const char* usage =
    "usage: twin_cases --list                         names and classes of all cases\n"
    "       twin_cases --case NAME FOLDER TRUTH.json  writes one case\n"
    "       twin_cases --agreement ROBOT PLAN FOLDER  no noise, nothing hidden, the true "
    "stiffnesses\n";

int run(const std::vector<std::string>& words) {
  if (words == std::vector<std::string>{"--list"}) {
    for (const twin::Case& c : twin::suite()) fmt::print("{} {}\n", c.name, c.kind);
    return 0;
  }
  if (words.size() == 4 && words[0] == "--agreement") {
    twin::write_agreement(words[1], words[2], 16, words[3]);
    return 0;
  }
  if (words.size() == 4 && words[0] == "--case") {
    for (const twin::Case& c : twin::suite())
      if (c.name == words[1]) {
        twin::write_case(c, words[2], words[3]);
        return 0;
      }
    fmt::print(stderr, "no case {}\n", words[1]);
    return 2;
  }
  fmt::print(stderr, "{}", usage);
  return 2;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run({argv + 1, argv + argc});
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}\n", error.what());
    return 1;
  }
}
