// Conditions under which a reading was taken, as far as effects depend on them.
#pragma once

#include <compare>
#include <cstddef>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace kinetostat::vjm {

/// A temperature and when it was read [s], counted from any moment.
struct TemperatureAt {
  double time = 0, temperature = 0;
};

/// The temperatures of a session up to a reading.
struct TemperaturePast {
  std::shared_ptr<const std::vector<TemperatureAt>> of_session;  // in the order of time
  std::size_t count = 0;  // of them, that of the reading itself the last; 0: not known

  /// Within one session.
  auto operator<=>(const TemperaturePast& other) const { return count <=> other.count; }
  bool operator==(const TemperaturePast& other) const { return count == other.count; }
};

/// By how much a part is behind the temperature that is read, and how that changes with its lag.
struct TemperatureLag {
  double behind = 0;  // T' - T [K]
  double by_lag = 0;  // d(T' - T)/d lag [K/s]
};

/// A part of which all has one temperature T' and takes up heat in proportion to T - T':
///
///   lag dT'/dt + T' = T,
///
/// T straight between readings, T' = T at the first one. 0 without a past. Incropera and DeWitt,
/// Fundamentals of Heat and Mass Transfer, ch. 5 (lumped capacitance). Requires lag >= 0 [s].
TemperatureLag temperature_lag(const TemperaturePast& past, double lag);

/// Neutral by default: nothing that varies with them then acts.
struct Conditions {
  double time = 0;           // since the first reading of the session [s]
  double time_in_cycle = 0;  // since that of the cycle; without cycles the same [s]
  double elapsed = 0;        // since the reading before in the same cycle [s]
  std::optional<double> temperature =
      {};  // as read [K or degC: what `reference` of an effect is in]
  TemperaturePast past = {};
  std::string session = {}, setting = {};
  bool unloaded = false;    // the state that a cycle starts from
  bool known_load = false;  // by weights: errors of the load cell have no part in it
  std::map<std::string, double> covariates = {};  // further columns that hold numbers, as written

  auto operator<=>(const Conditions&) const = default;
};

}  // namespace kinetostat::vjm
