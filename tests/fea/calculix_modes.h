// Frequencies that CalculiX finds for the model of a static deck.
#pragma once

#include <cstdlib>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "kinetostat/io/text_file.h"

#include "support/temporary_folder.h"

namespace kinetostat::fea {

/// [Hz], ascending. `more`: cards of the model that are added; `density` [kg/m^3] of all of it.
inline std::vector<double> frequencies_by_calculix(std::string deck, const std::string& more,
                                                   double density, std::size_t count) {
  deck.resize(deck.find("*STEP"));
  deck.insert(deck.find("*SOLID SECTION"), "*DENSITY\n" + std::to_string(density) + "\n");
  const test::TemporaryFolder folder;
  folder.file("link.inp",
              deck + more + "*STEP\n*FREQUENCY\n" + std::to_string(count) + "\n*END STEP\n");
  const std::string call = "cd '" + folder.path().string() + "' && ccx link > ccx.log 2>&1";
  EXPECT_EQ(std::system(call.c_str()), 0) << io::read_text(folder.path() / "ccx.log");
  std::istringstream lines(io::read_text(folder.path() / "link.dat"));
  std::vector<double> frequencies;
  for (std::string line; std::getline(lines, line) && frequencies.size() < count;) {
    int mode = 0;
    double eigenvalue = 0, omega = 0, hertz = 0, imaginary = 0;
    if (std::istringstream row(line); row >> mode >> eigenvalue >> omega >> hertz >> imaginary)
      frequencies.push_back(hertz);
  }
  return frequencies;
}

}  // namespace kinetostat::fea
