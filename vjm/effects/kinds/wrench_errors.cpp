// The load that acts is not the one that is written down.
#include "kinetostat/vjm/effects/kinds/kinds.h"

namespace kinetostat::vjm::effects {
namespace {

class WrenchGain : public EffectKind {
 public:
  WrenchGain() {
    name = "wrench_gain";
    effect_class = EffectClass::load;
    is_exact = true;
    summary = "the wrench that acts is a multiple of the one stated";
    law = "[F; M] = gain [F; M] stated";
    source = "gain error of a force transducer: ISO 376";
    signature = "all displacements too large or too small in one proportion";
    confuser =
        "link_compliance of all links, a common scale of all compliances: not distinguishable "
        "without self-weight";
    place = EffectPlace::load;
    parameters = {{.name = "gain",
                   .linear = spatial::dimension::none,
                   .angular = spatial::dimension::none,
                   .lower = 0.1,
                   .upper = 10,
                   .prior_sd = 0.02,
                   .none = 1}};
  }
  void add_to(ReadingErrors& errors, const EffectInput& input) const override {
    errors.wrench_gain += input.values[0] - 1;
  }
  ReadingErrors tangent(Eigen::Index, const EffectInput&) const override {
    ReadingErrors tangent = ReadingErrors::tangent();
    tangent.wrench_gain = 1;
    return tangent;
  }
};

// A wrench that acts beside what is read: wherever a load is, or in all readings.
class WrenchZero : public EffectKind {
 public:
  static constexpr Eigen::Index always = 6;

  void add_to(ReadingErrors& errors, const EffectInput& input) const override {
    const spatial::Vector6 wrench = input.values.head<6>();
    const double share = input.values[always];
    errors.wrench_zero += (1 - share) * wrench;
    if (!input.conditions.unloaded) errors.wrench_beside += share * wrench;
  }
  ReadingErrors tangent(Eigen::Index value, const EffectInput& input) const override {
    ReadingErrors tangent = ReadingErrors::tangent();
    const bool by_share = value == always;
    const spatial::Vector6 wrench =
        by_share ? input.values.head<6>() : spatial::Vector6(spatial::Vector6::Unit(value));
    tangent.wrench_zero = (by_share ? -1 : 1 - input.values[always]) * wrench;
    if (!input.conditions.unloaded)
      tangent.wrench_beside = (by_share ? 1 : input.values[always]) * wrench;
    return tangent;
  }
};

// Its prior is a share of what the campaign states.
EffectParameter load_parameter(const char* name, const spatial::Dimension& dimension, double share,
                               PriorUnit unit) {
  EffectParameter parameter = optional_parameter(name, dimension, 1e6, share);
  parameter.prior_unit = unit;
  return parameter;
}

}  // namespace

Kind wrench_misalignment() {
  auto kind = vector_error(&ReadingErrors::wrench_rotation);
  kind->name = "wrench_misalignment";
  kind->effect_class = EffectClass::load;
  kind->is_exact = true;
  kind->summary = "the wrench that acts is turned against the one stated";
  kind->law = "F and M turned by the rotation vector [rx, ry, rz], axes of the load cell";
  kind->source = "alignment of a force transducer: ISO 376; Rodrigues' formula";
  kind->signature = "displacement across the load, in proportion to it, that turns with it";
  kind->confuser = "sensor_frame, which turns what is read instead";
  kind->place = EffectPlace::load;
  for (const char* axis : {"rx", "ry", "rz"})
    kind->parameters.push_back(optional_parameter(axis, spatial::dimension::angle, 1, 0.01));
  return kind;
}

Kind wrench_zero() {
  auto kind = std::make_shared<WrenchZero>();
  kind->name = "wrench_zero";
  kind->effect_class = EffectClass::load;
  kind->is_exact = true;
  kind->summary =
      "the load cell does not read zero when it bears nothing, or a hook is not counted";
  kind->law =
      "F = F read + [fx, fy, fz], M = M read + [mx, my, mz], axes of the load cell, under any "
      "load; with always = 1 in all readings, loaded or not";
  kind->source = "zero error of a force transducer: ISO 376";
  kind->signature =
      "a displacement that comes with the first load and is the same under all, whatever their "
      "size and sign; with always = 1 it stays when the load is gone";
  kind->confuser =
      "target_slip and session_drift, in which it comes and stays as well; wrench_gain, under "
      "loads of one size and sign";
  kind->place = EffectPlace::load;
  for (const char* name : {"fx", "fy", "fz"})
    kind->parameters.push_back(
        load_parameter(name, spatial::dimension::force, 0.02, PriorUnit::stated_force));
  for (const char* name : {"mx", "my", "mz"})
    kind->parameters.push_back(
        load_parameter(name, spatial::dimension::moment, 0.02, PriorUnit::stated_moment));
  kind->parameters.push_back(either_way("always", "without load as well"));
  kind->parameters.back().is_of_differences = true;  // else it is a payload
  return kind;
}

Kind wrench_channel_gain() {
  auto kind = vector_error(&ReadingErrors::wrench_channels);
  kind->name = "wrench_channel_gain";
  kind->effect_class = EffectClass::load;
  kind->is_exact = true;
  kind->summary = "channels of the load cell have gains of their own";
  kind->law =
      "F = F read + [fx Fx, fy Fy, fz Fz], M = M read + [mx Mx, my My, mz Mz], axes of the load "
      "cell: each a share of what is read";
  kind->source = "sensitivities of a multi-component force transducer: ISO 376, channel by channel";
  kind->signature =
      "displacements under loads along one axis, or under moments, too large or too small in one "
      "proportion, wherever the robot stands";
  kind->confuser =
      "wrench_gain, under loads along one axis; base_tilt and sensor_axis_scale, by which some "
      "directions seem softer as well";
  kind->place = EffectPlace::load;
  for (const char* name : {"fx", "fy", "fz", "mx", "my", "mz"})
    kind->parameters.push_back(optional_parameter(name, spatial::dimension::none, 0.9, 0.02));
  return kind;
}

Kind wrench_saturation() {
  auto kind = vector_error(&ReadingErrors::wrench_curvature);
  kind->name = "wrench_saturation";
  kind->effect_class = EffectClass::load;
  kind->summary = "the load cell reads less and less of a load that grows: it nears its end";
  kind->law = "F = F read (1 + force |F read|^2), M = M read (1 + moment |M read|^2)";
  kind->source =
      "interpolation of a force transducer by a cubic: ISO 376; first term of any odd "
      "characteristic that bends";
  kind->signature =
      "displacements grow more than in proportion to the load that is read, all alike";
  kind->confuser =
      "wrench_gain, under loads of nearly one size; clearance of the joint that bends most";
  kind->place = EffectPlace::load;
  kind->parameters = {load_parameter("force", {.length = -2, .mass = -2, .time = 4}, 0.05,
                                     PriorUnit::per_force_squared),
                      load_parameter("moment", {.length = -4, .mass = -2, .time = 4}, 0.05,
                                     PriorUnit::per_moment_squared)};
  for (EffectParameter& parameter : kind->parameters) parameter.lower = 0;
  return kind;
}

Kind application_point() {
  auto kind = vector_error(&ReadingErrors::wrench_point);
  kind->name = "application_point";
  kind->effect_class = EffectClass::load;
  kind->is_exact = true;
  kind->summary = "the wrench acts beside the point that is stated";
  kind->law = "point = stated point + [x, y, z], platform axes: a moment [x, y, z] x F more";
  kind->source = "a force at another point: the moment of its displacement";
  kind->signature = "rotations, and displacements as from moments, in proportion to the force";
  kind->confuser =
      "geometric_error of the last body: the same lever arm, but of the platform as well";
  kind->place = EffectPlace::load;
  for (const char* axis : {"x", "y", "z"})
    kind->parameters.push_back(optional_parameter(axis, spatial::dimension::length, 10, 5e-3));
  return kind;
}

Kind target_lever_arm() {
  auto kind = vector_error(&ReadingErrors::target);
  kind->name = "target_lever_arm";
  kind->effect_class = EffectClass::instrument;
  kind->is_exact = true;
  kind->moves_like = EffectClass::geometry;  // of the end
  kind->summary = "what is read is another point of the platform than stated";
  kind->law = "read position = position of the point [x, y, z] of the platform";
  kind->source = "Abbe's principle: an offset times the rotation; ISO 230-1";
  kind->signature =
      "translations in proportion to the platform's rotations; in poses an offset "
      "that turns with the platform";
  kind->confuser = "sensor_frame, at few postures; geometric_error of the last body";
  kind->place = EffectPlace::sensor;
  for (const char* axis : {"x", "y", "z"})
    kind->parameters.push_back(optional_parameter(axis, spatial::dimension::length, 10, 5e-3));
  return kind;
}

Kind wrench_gain() { return std::make_shared<WrenchGain>(); }

}  // namespace kinetostat::vjm::effects
