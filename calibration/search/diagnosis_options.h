// What a diagnosis tries, and for how long.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "kinetostat/calibration/search/fit_journal.h"

namespace kinetostat::calibration {

struct DiagnosisOptions {
  std::vector<std::string> kinds;  // of effects that are tried; empty: the whole catalogue
  int draws = 500;                 // of the bootstraps
  std::uint64_t seed = 1;
  std::size_t most_effects = 3;   // that are named one after the other
  std::size_t profiles = 0;       // most likelihood profiles of the final model
  bool signatures = false;        // whether they are kept, for others
  FitJournal* journal = nullptr;  // what it has is not computed; it decides nothing
};

}  // namespace kinetostat::calibration
