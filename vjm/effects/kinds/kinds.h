// The kinds of effects, one file each. Internal to this module; effect.h lists them.
#pragma once

#include "kinetostat/vjm/effects/effect.h"

namespace kinetostat::vjm::effects {

using Kind = std::shared_ptr<const EffectKind>;

Kind joint_compliance();
Kind link_compliance();
Kind bearing_compliance();
Kind bearing_tilt();
Kind base_compliance();
Kind base_tilt();
Kind platform_compliance();
Kind geometric_error();
Kind joint_offset();
Kind thermal_expansion();
Kind eccentricity();
Kind transmission_ratio();
Kind joint_coupling();
Kind creep();
Kind hardening();
Kind load_hardening();
Kind piecewise_stiffness();
Kind directional_stiffness();
Kind opening_contact();
Kind periodic_stiffness();
Kind stiffness_along_joint();
Kind thermal_softening();
Kind clearance();
Kind biased_clearance();
Kind friction();
Kind load_friction();
Kind preload();
Kind gravity_compensator();
Kind self_weight();
Kind payload();
Kind wrench_gain();
Kind wrench_misalignment();
Kind wrench_zero();
Kind wrench_channel_gain();
Kind wrench_saturation();
Kind application_point();
Kind sensor_frame();
Kind target_lever_arm();
Kind sensor_scale();
Kind sensor_axis_scale();
Kind session_drift();
Kind gauge_play();
Kind target_slip();
Kind cycle_offset();

namespace compliance {
inline constexpr spatial::Dimension linear{.mass = -1, .time = 2};
inline constexpr spatial::Dimension angular{.length = -2, .mass = -1, .time = 2, .angle = 1};
}  // namespace compliance

/// A parameter that need not be given and does nothing at zero, of one dimension everywhere.
EffectParameter optional_parameter(std::string name, const spatial::Dimension& dimension,
                                   double limit, double prior_sd);

/// Whether something is so: 0 (unless given) or 1, and nothing that readings must tell in between.
/// `words`: what 1 means.
EffectParameter either_way(std::string name, std::string words);
/// "settled": 1 where the weight of a cycle's posture has had its effect before the cycle.
EffectParameter settled_weight();

/// A compliance where nothing yielded, of one dimension everywhere; need not be given.
EffectParameter added_compliance(std::string name, const spatial::Dimension& dimension);

/// Numbers that are added to one vector of ReadingErrors.
template <class Vector>
class VectorError : public EffectKind {
 public:
  explicit VectorError(Vector ReadingErrors::*member) : member_(member) {}

  void add_to(ReadingErrors& errors, const EffectInput& input) const override {
    errors.*member_ += input.values;
  }
  ReadingErrors tangent(Eigen::Index value, const EffectInput&) const override {
    ReadingErrors tangent = ReadingErrors::tangent();
    tangent.*member_ = Vector::Unit(value);
    return tangent;
  }

 private:
  Vector ReadingErrors::*member_;
};

template <class Vector>
auto vector_error(Vector ReadingErrors::*member) {
  return std::make_shared<VectorError<Vector>>(member);
}

/// How often what ripples with a joint's command does so in one radian: usually so often a turn, or
/// once a turn of a screw with a lead of 5, 10 or 20 mm.
EffectParameter order_of_ripple(std::vector<double> of_turn);

/// `lag` [s] of a part behind the temperature that is read (temperature_lag).
EffectParameter lag_of_temperature();
/// How far such a part is above the reference, and how that changes with its lag; 0 where no
/// temperature is read.
struct Warming {
  double above = 0, by_lag = 0;
};
Warming warming(const Conditions& conditions, double reference, double lag);

/// Where a coordinate is at home [m or rad].
double home_of(const Chain& chain, Eigen::Index coordinate);
/// Lets a drive lead coordinate `k` too far by a ratio of how far `leader` is commanded from home.
void lead_by_ratio(ChainModifier& modifier, Eigen::Index k, Eigen::Index leader, double ratio);
/// The column of that ratio.
void add_ratio(ChainColumns& columns, Eigen::Index column, Eigen::Index k, Eigen::Index leader);
/// The spring of a joint. Throws std::invalid_argument when the joint has none.
const Spring& spring_of_joint(const Chain& chain, const std::string& joint);
/// The change with a compliance in series with the spring of coordinate `k`.
void add_series_compliance(ChainColumns& columns, Eigen::Index column, Eigen::Index k,
                           double change);
/// Throws std::invalid_argument when the joint is held rigidly.
void require_mobile(const Chain& chain, const std::string& joint);

/// `name`, or with further signs when a node of the chain has it.
std::string free_node_name(const Chain& chain, std::string name);

/// A dead zone with hyperbolas for corners: 0 between -gap and gap, d -+ gap beyond, the corners
/// rounded over `width` (0: sharp); d itself without a gap. Its value, slope, derivatives by gap
/// and width, and integral over d.
struct DeadZone {
  double value = 0, slope = 0, by_gap = 0, by_width = 0;

  DeadZone(double d, double gap, double width);
  double integral() const;

 private:
  double d, gap, width;
  double above = 0, below = 0;  // distances of d from the corners, rounded
};

/// A saturation: u up to 1 - w in magnitude, 1 from 1 + w on, w its rounding; between them its
/// slope falls as 1 - 3 t^2 + 2 t^3. Its value, slope, integral, and the integral of that.
struct Saturation {
  static constexpr double rounding = 0.05;
  double value, slope;

  explicit Saturation(double u);
  double integral() const;
  double second_integral() const;

 private:
  double u, t, inside, outside;  // t: through the corner; u up to its end, and beyond
  double bent() const;           // integral of what is inside
};

}  // namespace kinetostat::vjm::effects
