// What the instrument shows is not what the platform does.
#include "kinetostat/vjm/effects/kinds/kinds.h"

namespace kinetostat::vjm::effects {
namespace {

// A displacement of all that is read, in proportion to time.
class SessionDrift : public EffectKind {
 public:
  SessionDrift() { varies = true; }

  void add_to(ReadingErrors& errors, const EffectInput& input) const override {
    errors.sensor += seconds(input) * input.values.head<6>();
  }
  ReadingErrors tangent(Eigen::Index value, const EffectInput& input) const override {
    ReadingErrors tangent = ReadingErrors::tangent();
    if (value == each_cycle)
      tangent.sensor = -before_the_cycle(input) * input.values.head<6>();
    else
      tangent.sensor = seconds(input) * spatial::Vector6::Unit(value);
    return tangent;
  }

  static constexpr Eigen::Index each_cycle = 6;

 private:
  static double before_the_cycle(const EffectInput& input) {
    return input.conditions.time - input.conditions.time_in_cycle;
  }
  static double seconds(const EffectInput& input) {
    return input.conditions.time - input.values[each_cycle] * before_the_cycle(input);
  }
};

// Positions that are read in a wrong unit, as it were.
class SensorScale : public EffectKind {
 public:
  SensorScale() {
    name = "sensor_scale";
    effect_class = EffectClass::instrument;
    is_exact = true;
    summary = "positions are read too large or too small in one proportion";
    law = "read position = (1 + scale) position, from the origin of the base";
    source = "refractive index of air in laser trackers: ISO 10360-10; scale of cameras and arms";
    signature = "in poses, errors that grow with the distance from the instrument, in proportion";
    confuser = "geometric_error of the first body, at few postures; thermal_expansion of the arm";
    place = EffectPlace::sensor;
    parameters = {{.name = "scale",
                   .linear = spatial::dimension::none,
                   .angular = spatial::dimension::none,
                   .lower = -0.1,
                   .upper = 0.1,
                   .prior_sd = 1e-4}};
  }
  void add_to(ReadingErrors& errors, const EffectInput& input) const override {
    errors.sensor_scale += input.values[0];
  }
  ReadingErrors tangent(Eigen::Index, const EffectInput&) const override {
    ReadingErrors tangent = ReadingErrors::tangent();
    tangent.sensor_scale = 1;
    return tangent;
  }
};

}  // namespace

Kind sensor_scale() { return std::make_shared<SensorScale>(); }

Kind sensor_axis_scale() {
  auto kind = vector_error(&ReadingErrors::sensor_axes);
  kind->name = "sensor_axis_scale";
  kind->effect_class = EffectClass::instrument;
  kind->is_exact = true;
  kind->is_of_gauges = true;
  kind->summary = "gauges along each axis read too much or too little in their own proportion";
  kind->law =
      "read = [(1 + x) X, (1 + y) Y, (1 + z) Z], base axes; of poses from the base's origin";
  kind->source = "sensitivity of displacement transducers, one an axis: DIN 32876";
  kind->signature =
      "what is read along one axis is off in proportion, under all loads and everywhere";
  kind->confuser = "sensor_scale, where one axis is read; wrench_channel_gain of a Cartesian robot";
  kind->place = EffectPlace::sensor;
  for (const char* axis : {"x", "y", "z"})
    kind->parameters.push_back(optional_parameter(axis, spatial::dimension::none, 0.9, 0.02));
  return kind;
}

Kind sensor_frame() {
  auto kind = vector_error(&ReadingErrors::sensor);
  kind->name = "sensor_frame";
  kind->effect_class = EffectClass::instrument;
  kind->moves_like = EffectClass::geometry;  // of the base
  kind->is_exact = true;
  kind->summary = "the frame in which displacements are read is displaced";
  kind->law = "read pose = [exp(r), t] pose with t = [x, y, z], r = [rx, ry, rz], base axes";
  kind->source = "registration of a measuring frame: ISO 9283";
  kind->signature = "displacements turned, the same everywhere; in poses an offset, too";
  kind->confuser = "geometric_error of the first body; session_drift";
  kind->place = EffectPlace::sensor;
  for (const char* axis : {"x", "y", "z"})
    kind->parameters.push_back(optional_parameter(axis, spatial::dimension::length, 100, 1e-3));
  for (const char* axis : {"rx", "ry", "rz"})
    kind->parameters.push_back(optional_parameter(axis, spatial::dimension::angle, 3, 5e-3));
  return kind;
}

Kind session_drift() {
  auto kind = std::make_shared<SessionDrift>();
  kind->name = "session_drift";
  kind->effect_class = EffectClass::time;
  kind->summary = "readings drift with the time since they were zeroed";
  kind->law =
      "read pose = [exp(r t), v t] pose, v = [x, y, z], r = [rx, ry, rz] per time; t since the "
      "session started, or with each_cycle = 1 the load cycle";
  kind->source = "drift of an instrument: ISO 230-3, environmental temperature variation error";
  kind->signature =
      "residuals grow in proportion to time in each session or cycle, whatever the load";
  kind->confuser =
      "sensor_frame, in one short session; thermal_expansion, when the temperature follows time";
  kind->place = EffectPlace::sensor;
  constexpr double share = 0.1;  // of what is read, in a session
  for (const char* axis : {"x", "y", "z"})
    kind->parameters.push_back(optional_parameter(axis, {.length = 1, .time = -1}, 1, share));
  for (const char* axis : {"rx", "ry", "rz"})
    kind->parameters.push_back(optional_parameter(axis, {.time = -1, .angle = 1}, 1, share));
  for (EffectParameter& parameter : kind->parameters)
    parameter.prior_unit = PriorUnit::change_in_session;
  kind->parameters.push_back(either_way("each_cycle", "zeroed in each load cycle"));
  return kind;
}

}  // namespace kinetostat::vjm::effects
