// Independent programs that tests compare with.
#pragma once

#include <cstdlib>
#include <string>

#include <gtest/gtest.h>

namespace kinetostat::test {

/// A test that needs a program fails without it: skipped, it would say nothing while all is green.
inline testing::AssertionResult is_installed(const std::string& program) {
  if (std::system(("command -v " + program + " > /dev/null 2>&1").c_str()) == 0)
    return testing::AssertionSuccess();
  return testing::AssertionFailure()
         << program << " is not installed: run scripts/install-packages test";
}

}  // namespace kinetostat::test
