// Conditions under which a reading was taken, as far as effects depend on them.
#pragma once

#include <map>
#include <optional>
#include <string>

namespace kinetostat::vjm {

/// Neutral by default: nothing that varies with them then acts.
struct Conditions {
  double time = 0;                    // since the first reading of the session [s]
  double time_in_cycle = 0;           // since that of the cycle; without cycles the same [s]
  double elapsed = 0;                 // since the reading before in the same cycle [s]
  std::optional<double> temperature;  // as read [K or degC: what `reference` of an effect is in]
  std::string session, setting;
  bool unloaded = false;    // the state that a cycle starts from
  bool known_load = false;  // by weights: errors of the load cell have no part in it
  std::map<std::string, double> covariates = {};  // further columns that hold numbers, as written

  auto operator<=>(const Conditions&) const = default;
};

}  // namespace kinetostat::vjm
