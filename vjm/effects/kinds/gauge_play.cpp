// An instrument that lags behind what it looks at by the play of its works.
#include <algorithm>

#include "kinetostat/vjm/effects/kinds/kinds.h"

namespace kinetostat::vjm::effects {
namespace gauge_play_kind {
namespace {

// What is less is taken to turn round as soon [m or rad]: no instrument sees the difference.
constexpr double least_gap = 1e-9;

// With u of what it looks at it shows u + gap z; z, from -1 to 1, is its state.
class GaugePlay : public EffectKind {
 public:
  GaugePlay() {
    name = "gauge_play";
    effect_class = EffectClass::instrument;
    summary = "a gauge lags behind what it looks at: play or friction in its works, a bent stylus";
    law =
        "read = u + gap s(z), z = z' - (u - u') / gap with z' and u' after the reading before, "
        "then "
        "z = s(z); s as of friction: play, of each number that is read by itself. A cycle starts "
        "in the middle of the gap, from the state without load, or in poses from its first reading";
    source =
        "play operator: Krasnosel'skii and Pokrovskii, Systems with Hysteresis, 1989; hysteresis "
        "of "
        "dial gauges: ISO 463";
    signature =
        "loading and unloading differ by twice the gap, as much at every posture, load and lever "
        "arm";
    confuser =
        "friction, where the readings all move along one line: not tried there; geometric_error, "
        "at few loads";
    place = EffectPlace::sensor;
    lags_behind = true;
    for (const char* axis : {"x", "y", "z"})
      parameters.push_back(optional_parameter(axis, spatial::dimension::length, 0.1, 0.02));
    for (const char* axis : {"rx", "ry", "rz"})
      parameters.push_back(optional_parameter(axis, spatial::dimension::angle, 0.1, 0.02));
    for (EffectParameter& parameter : parameters) {
      parameter.lower = 0;
      parameter.prior_unit = PriorUnit::change_read;
    }
  }

  Lag lag(double moved, double state, double gap) const override {
    const double length = std::max(least_gap, gap);
    const Saturation z(state - moved / length);
    Lag lag{.shown = gap * z.value, .state = z.value};
    lag.state_by_moved = -z.slope / length;
    lag.state_by_state = z.slope;
    lag.state_by_value = gap < least_gap ? 0 : z.slope * moved / (length * length);
    lag.shown_by_moved = gap * lag.state_by_moved;
    lag.shown_by_state = gap * lag.state_by_state;
    lag.shown_by_value = z.value + gap * lag.state_by_value;
    return lag;
  }
};

}  // namespace
}  // namespace gauge_play_kind

Kind gauge_play() { return std::make_shared<gauge_play_kind::GaugePlay>(); }

}  // namespace kinetostat::vjm::effects
