// Readings that are off by a constant: those after a target has slipped, those of a cycle whose
// zero was taken wrong.
#include "kinetostat/vjm/effects/kinds/kinds.h"

namespace kinetostat::vjm::effects {
namespace reading_offsets_kind {
namespace {

constexpr Eigen::Index first_of_names = 6;  // among the values, after x, y, z, rx, ry, rz

// Adds a value that says which readings are meant.
void add_name(std::string name, const spatial::Dimension& dimension, NamesReadings names,
              EffectKind& kind) {
  kind.parameters.push_back({.name = std::move(name),
                             .linear = dimension,
                             .angular = dimension,
                             .lower = 0,
                             .upper = 1e9,
                             .prior_sd = 1,
                             .is_shape = true,
                             .usual_linear = {1},
                             .usual_angular = {1},
                             .names_readings = names});
}

class ReadingOffset : public EffectKind {
 public:
  ReadingOffset() {
    effect_class = EffectClass::instrument;
    is_exact = true;
    place = EffectPlace::sensor;
    offsets_readings = true;
    for (const char* axis : {"x", "y", "z"})
      parameters.push_back(optional_parameter(axis, spatial::dimension::length, 10, 0.05));
    for (const char* axis : {"rx", "ry", "rz"})
      parameters.push_back(optional_parameter(axis, spatial::dimension::angle, 3, 0.05));
    for (EffectParameter& parameter : parameters) parameter.prior_unit = PriorUnit::change_read;
  }
};

class TargetSlip : public ReadingOffset {
 public:
  TargetSlip() {
    name = "target_slip";
    summary = "the target or the instrument slips once, in a session or before it";
    law =
        "read = u + [x, y, z, rx, ry, rz] in the session of that number, counted from 1, from "
        "`time` after its first reading on (0: of all that session), to its end or to that of a "
        "load "
        "cycle of that number (0: none), after which differences are counted anew; of each number "
        "that is read by itself, or, with turns_along = 1, of the platform in its own axes";
    source =
        "a shift in the mean at an unknown time: Page, Continuous inspection schemes, Biometrika "
        "41 "
        "(1954) 100; Hinkley, Biometrika 57 (1970) 1";
    signature =
        "all readings of a session, or the rest of a cycle that is zeroed by itself, are off by "
        "one "
        "constant from one moment on, which turns with the platform where it is the target that "
        "has "
        "slipped";
    confuser = "session_drift, at few readings; cycle_offset, in the last cycle of a session";
    add_name("session", spatial::dimension::none, NamesReadings::session, *this);
    add_name("time", spatial::dimension::time, NamesReadings::time, *this);
    add_name("turns_along", spatial::dimension::none, NamesReadings::axes, *this);
    parameters.back().upper = 1;
    parameters.back().required = false;
    add_name("cycle", spatial::dimension::none, NamesReadings::cycle, *this);
    parameters.back().required = false;
  }
  bool is_off(const ReadingMoment& reading, const Eigen::VectorXd& values) const override {
    const double cycle = values[first_of_names + 3];
    return reading.session == values[first_of_names] &&
           reading.time >= values[first_of_names + 1] && (cycle == 0 || reading.cycle == cycle);
  }
  bool turns_along(const Eigen::VectorXd& values) const override {
    return values[first_of_names + 2] != 0;
  }
};

class CycleOffset : public ReadingOffset {
 public:
  CycleOffset() {
    name = "cycle_offset";
    summary = "one load cycle is off by a constant: its zero was taken wrong";
    law =
        "read = u + [x, y, z, rx, ry, rz] in the load cycle of that number, counted from 1 in the "
        "order of sessions and names; of each number that is read by itself";
    source =
        "an additive outlier in a batch: Barnett and Lewis, Outliers in Statistical Data, 1994";
    signature = "all readings of one cycle are off by one constant, whatever the load";
    confuser = "target_slip, in the last cycle of a session; session_drift, at few cycles";
    add_name("cycle", spatial::dimension::none, NamesReadings::cycle, *this);
  }
  bool is_off(const ReadingMoment& reading, const Eigen::VectorXd& values) const override {
    return reading.cycle == values[first_of_names];
  }
};

}  // namespace
}  // namespace reading_offsets_kind

Kind target_slip() { return std::make_shared<reading_offsets_kind::TargetSlip>(); }
Kind cycle_offset() { return std::make_shared<reading_offsets_kind::CycleOffset>(); }

}  // namespace kinetostat::vjm::effects
