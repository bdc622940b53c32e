// What the instrument shows is not what the platform does.
#include "kinetostat/vjm/effects/kinds.h"

namespace kinetostat::vjm::effects {
namespace {

// A displacement of all that is read: fixed, or in proportion to time.
class SensorDisplacement : public EffectKind {
 public:
  explicit SensorDisplacement(bool drifts) { varies = drifts; }

  void add_to(ReadingErrors& errors, const EffectInput& input) const override {
    errors.sensor += amount(input) * input.values;
  }
  ReadingErrors tangent(Eigen::Index value, const EffectInput& input) const override {
    ReadingErrors tangent = ReadingErrors::tangent();
    tangent.sensor = amount(input) * spatial::Vector6::Unit(value);
    return tangent;
  }

 private:
  double amount(const EffectInput& input) const { return varies ? input.conditions.time : 1; }
};

}  // namespace

Kind sensor_frame() {
  auto kind = std::make_shared<SensorDisplacement>(false);
  kind->name = "sensor_frame";
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
  auto kind = std::make_shared<SensorDisplacement>(true);
  kind->name = "session_drift";
  kind->summary = "readings drift with the time since their session began";
  kind->law = "read pose = [exp(r t), v t] pose, v = [x, y, z], r = [rx, ry, rz] per time";
  kind->source = "drift of an instrument: ISO 230-3, environmental temperature variation error";
  kind->signature = "residuals grow in proportion to time in each session, whatever the load";
  kind->confuser =
      "sensor_frame, in one short session; thermal_expansion, when the temperature follows time";
  kind->place = EffectPlace::sensor;
  for (const char* axis : {"x", "y", "z"})
    kind->parameters.push_back(optional_parameter(axis, {.length = 1, .time = -1}, 1, 3e-9));
  for (const char* axis : {"rx", "ry", "rz"})
    kind->parameters.push_back(optional_parameter(axis, {.time = -1, .angle = 1}, 1, 3e-9));
  return kind;
}

}  // namespace kinetostat::vjm::effects
