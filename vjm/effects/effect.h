// Physical effects: named terms beside the springs and weights of a manipulator, in its equations
// of equilibrium and in how it is loaded and read.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "kinetostat/spatial/units.h"
#include "kinetostat/vjm/chain/kinematics.h"
#include "kinetostat/vjm/effects/conditions.h"
#include "kinetostat/vjm/effects/reading_errors.h"
#include "kinetostat/vjm/manipulator/shared_mounts.h"
#include "kinetostat/vjm/statics/equilibrium.h"

namespace kinetostat::vjm {

class ChainModifier;

/// Place on which an effect acts: an element of a chain (a flexible link, one of these or a joint,
/// an element with a mass or a flexible link), its start or end, the platform, the stated wrench,
/// or the instrument.
enum class EffectPlace { joint, link, element, mass, base, end, platform, load, sensor };
std::string to_string(EffectPlace place);

/// Effects that call for the same action. The kinds of one class are laws of it.
enum class EffectClass {
  backlash,
  stiffening,  // or softening, under load
  friction,    // or hysteresis
  compliance,  // more than the model has
  varying,     // stiffness, with the joint's position or with temperature
  geometry,
  preload,
  weight,
  temperature,
  time,  // creep, drift
  load,  // is not the one stated
  instrument,
  other  // of a user: each kind is a class of its own
};
/// "backlash", "stiffens or softens under load".
std::string to_string(EffectClass effect_class);
/// A place has one law of the class, as a joint has one friction: beside it another one takes the
/// shape of whatever else is missing.
bool has_one_law(EffectClass effect_class);

/// What a prior width is counted in.
enum class PriorUnit {
  absolute,           // SI
  stiffness,          // of the joint's spring, or
  compliance,         // one over that
  joint_load,         // the load that the joint bears
  joint_play,         // the motion of it that would show as much as the readings do
  cubic_stiffness,    // of a spring that its deflection by that load makes twice as stiff
  load_compliance,    // compliance over load: what such a load adds to the spring's
  per_joint_span,     // one over the range of its commands
  change_read,        // the largest change that is read, of translations or of rotations
  change_in_session,  // the same over the longest time that a session lasts
  stated_force,       // the largest force that is stated, and the largest moment; of what is not
  stated_moment,      // stated, the other at 0.3 m
  per_force_squared,  // one over the square of those
  per_moment_squared,
  soft_compliance  // the same of the softest joint of the manipulator, at a lever of 0.3 m where
                   // the one slides or shifts and the other turns
};

/// What a value says of the readings that an effect is of: a search takes those that a campaign
/// has. `axes`: 1 where what they are off turns along with the platform, else 0.
enum class NamesReadings { no, session, time, cycle, axes };

/// Which reading of a campaign: session and cycle, counted from 1 (0: of no cycle), and the time
/// since the first reading of the session [s].
struct ReadingMoment {
  double session = 0, cycle = 0, time = 0;
};

/// How far a joint is loaded and deflected: what sizes of effects there are counted in.
struct JointScale {
  double load = 500;     // [N or N m]
  double travel = 1e-3;  // by its spring [m or rad]
  double play = 1e-3;    // what would move the robot as far as it is seen to move [m or rad]
  int commands = 2;      // how many there are, as far as they differ by a hundredth of their range
  double span = 1;       // range of its commands [m or rad]; 1 where it is not moved
};
/// What readings do to a robot: usual values by default.
struct ReadingScales {
  std::vector<std::vector<JointScale>> joints;  // one a chain and coordinate; empty: usual ones
  double shift = 1e-3, turn = 3e-3;             // the largest change that is read [m], [rad]
  double force = 500, moment = 150;             // the largest load that is stated [N], [N m]
  double session = 3600;                        // the longest time that a session lasts [s]
  /// They move in several directions and back, so that an instrument which lags behind does not
  /// look like a joint with friction.
  bool tell_lag = true;
  bool differences = true;  // what is read; else poses
  /// Between how many readings a target may have slipped; how many cycles may be off.
  std::size_t slips = 1, cycles = 1;
};

/// One number of an effect; SI inside.
struct EffectParameter {
  std::string name;
  spatial::Dimension linear, angular;  // on a joint that slides (or no joint), on one that turns
  double lower = 0, upper = 0;         // physical range, in SI; the value must lie in it
  double prior_sd = 0;                 // how far from `none` it usually is
  PriorUnit prior_unit = PriorUnit::absolute;
  double none = 0;       // the value at which there is no effect
  bool required = true;  // otherwise `none` when not given
  /// Not how large the effect is but how it acts: without the effect it means nothing.
  bool is_shape = false;
  /// An angle about which the effect goes round [rad]: any may be the right one, and a search
  /// starts from all sides.
  bool is_phase = false;
  /// Of a series: the effect may act at one place once for each.
  bool is_order = false;
  /// Where design fixes it: the values that it usually has [SI]. A search for what is missing tries
  /// each, and fits none.
  std::vector<double> usual_linear = {}, usual_angular = {};
  /// What each of these means, in a word or two of an answer; empty: name and value say it.
  std::vector<std::string> usual_in_words = {};
  /// Another value than `none` makes it another effect where poses are read, not differences.
  bool is_of_differences = false;
  /// It says what becomes of the weight before a cycle.
  bool is_of_weight = false;
  NamesReadings names_readings = NamesReadings::no;
};

/// Inputs of an effect.
struct EffectInput {
  const Eigen::VectorXd& values;  // of its parameters
  const Conditions& conditions;
  const Eigen::VectorXd& history;  // its state after the reading before; zero at the start
};

/// An equilibrium of one chain, as an effect sees it.
struct ChainState {
  const Chain& chain;          // with all effects applied
  Eigen::VectorXd x;           // all coordinates [m or rad]
  Eigen::VectorXd deflection;  // the same from their rest values
  Eigen::VectorXd travel;      // the same from the commands themselves
  const ChainKinematics& kinematics;
  spatial::Pose origin;            // of the body that the chain starts from
  spatial::Vector3 gravity;        // [m/s^2], base axes, as far as it acts
  std::vector<PointWrench> loads;  // at the end, then at nodes

  /// Force that the drive of a coordinate transmits [N or N m]: its spring and the laws in it.
  double drive_force(Eigen::Index coordinate) const;
  /// Its derivative with respect to the deflection.
  double drive_stiffness(Eigen::Index coordinate) const;
};

/// Where a place of a chain stands (chain.h, ChainDisplacement), before it is displaced.
struct PlaceFrame {
  spatial::Pose pose;
  Eigen::Index joints = 0;  // that lead there
  bool in_front = false;    // of what stands in the frame there
};
PlaceFrame frame_of(const ChainState& state, const std::string& element, bool in_front);

/// A motion [translation of `point`; rotation increment], base axes, of all of a chain behind the
/// frame that its first `joints` joints lead to; `in_front`: not of what stands in that frame.
struct PlaceMotion {
  Eigen::Index joints = 0;
  bool in_front = false;
  spatial::Vector3 point;
  spatial::Vector6 motion;
};

/// Derivatives of one chain's equations with respect to the values of an effect, then to its
/// history: one column each, zero unless added to.
class ChainColumns {
 public:
  ChainColumns() = default;
  ChainColumns(const ChainState& state, Eigen::Index columns) { renew(state, columns); }
  /// All zero, about another state, which outlives them; in the same memory.
  void renew(const ChainState& state, Eigen::Index columns);

  const ChainState& state() const { return *state_; }
  /// A force on a coordinate [N or N m]: by its drive, or by what is beside the drive.
  void add_drive_force(Eigen::Index column, Eigen::Index coordinate, double force);
  void add_force(Eigen::Index column, Eigen::Index coordinate, double force);
  /// A dead wrench.
  void add_wrench(Eigen::Index column, const PointWrench& wrench);
  /// A motion [translation; rotation increment] of all behind a place, of the point given.
  void add_motion(Eigen::Index column, const PlaceFrame& place, const spatial::Vector3& point,
                  const spatial::Vector6& motion);
  /// The change of ChainModifier::add_displacement's value at a place.
  void add_displacement(Eigen::Index column, const std::string& element, bool in_front,
                        const spatial::Vector6& change);
  /// The change of the rest value of a coordinate [m or rad].
  void add_transmission_error(Eigen::Index column, Eigen::Index coordinate, double change);
  /// The change of a compliance behind an element, ChainModifier::add_compliance_behind.
  void add_compliance_behind(Eigen::Index column, const std::string& element,
                             const std::string& name, Motion motion, double change);

  const Eigen::MatrixXd& force() const { return force_; }  // on all coordinates
  const Eigen::MatrixXd& drive() const { return drive_; }  // the part of it that is of drives
  const Matrix6X& end() const { return end_; }             // motion of the chain's end
  const Matrix6X& origin() const { return origin_; }  // wrench on the body that the chain starts at
  /// What moves by itself, of one column.
  const std::vector<PlaceMotion>& motions(Eigen::Index column) const {
    return motions_[static_cast<std::size_t>(column)];
  }

 private:
  const ChainState* state_ = nullptr;
  Eigen::MatrixXd force_, drive_;
  Matrix6X end_, origin_;
  std::vector<std::vector<PlaceMotion>> motions_;
};

/// The state of a history after an equilibrium, with its exact derivatives.
struct HistoryStep {
  Eigen::VectorXd next;
  Eigen::MatrixXd by_coordinates;  // all of the chain
  Eigen::MatrixXd by_input;        // values, then the history before
  /// By what the drive of the effect's joint transmits, coordinates held; this covers whatever of
  /// the effect's own input acts through the drive.
  Eigen::VectorXd by_drive_force;

  /// To a state that depends on nothing yet; in the same memory.
  void start(const Eigen::Ref<const Eigen::VectorXd>& state, Eigen::Index coordinates,
             Eigen::Index inputs);
};

/// By how much an instrument shows more than there is [m or rad], and the state that it carries to
/// the next reading, with derivatives by what it reads (`moved`), by the state before and by the
/// value.
struct Lag {
  double shown = 0, state = 0;
  double shown_by_moved = 0, state_by_moved = 0;
  double shown_by_state = 0, state_by_state = 0;
  double shown_by_value = 0, state_by_value = 0;
};

/// A kind of effect: one file in vjm/effects/, listed in effect_kinds(). Does nothing by default.
/// Immutable; parts of one kind at different places know nothing of each other.
class EffectKind {
 public:
  std::string name;
  std::string summary;    // one line
  std::string law;        // the formula
  std::string source;     // where it comes from
  std::string signature;  // how it shows in measurements
  std::string confuser;   // the effect that looks most like it
  EffectClass effect_class = EffectClass::other;
  /// The class that has laws which move the target as it does, in any posture and under any load: a
  /// balancer turns its joint by an angle that follows it, as an eccentric drive does, and a target
  /// beside its place is one on an end that is beside its own. No reading of the target tells the
  /// two apart in principle.
  std::optional<EffectClass> moves_like = {};
  /// A displacement of rigid bodies, a weight, a number of an instrument: a law that idealises
  /// nothing.
  bool is_exact = false;
  EffectPlace place = EffectPlace::joint;
  std::vector<EffectParameter> parameters;  // the first says how large it is
  bool varies = false;                      // with the conditions of a reading
  Eigen::Index history = 0;                 // numbers that it carries along a cycle, at each place
  bool by_temperature = false;              // does nothing where a reading states none
  bool by_stated_load = false;              // it may depend on the wrench that is stated
  /// Nobody builds it but at a drive that lifts weight, though it may be given elsewhere.
  bool balances_weight = false;
  /// Commands of its joint in which it must be seen: with fewer its law is any change between them.
  int least_commands = 1;

  /// The instrument lags behind what it looks at: all that it does is lag(), of each number that is
  /// read by itself, along a cycle. Its values are one an axis: x, y, z, rx, ry, rz.
  bool lags_behind = false;
  /// Of gauges, which read differences: what reads poses has no such error.
  bool is_of_gauges = false;
  /// All that it does is to add its first six values to what is read along x, y, z, rx, ry, rz in
  /// those readings that are off.
  bool offsets_readings = false;

  /// One value of it may be that of all parts of a robot, the place "all parts".
  bool acts_on_all = false;

  /// All that it does is a force on its joint that depends on this one alone: on its coordinate,
  /// its command and those of others, its spring, and the input. So do its derivatives and history.
  bool acts_on_joint_alone = false;

  virtual ~EffectKind() = default;

  /// Changes the chain at `element` (empty for the platform). Throws std::invalid_argument when it
  /// cannot act there.
  virtual void act(ChainModifier& chain, const std::string& element,
                   const EffectInput& input) const;
  /// Exact derivatives of what that does, at an equilibrium.
  virtual void differentiate(ChainColumns& columns, const std::string& element,
                             const EffectInput& input) const;
  /// Adds to how readings are taken, and the tangent of that with respect to one value.
  virtual void add_to(ReadingErrors& errors, const EffectInput& input) const;
  virtual ReadingErrors tangent(Eigen::Index value, const EffectInput& input) const;
  /// Where lags_behind: `moved` since the reading before in the cycle [m or rad], the state after
  /// that reading (0 at the start), and the value for the number that is read.
  virtual Lag lag(double moved, double state, double value) const;
  /// Where offsets_readings.
  virtual bool is_off(const ReadingMoment& reading, const Eigen::VectorXd& values) const;
  /// Whether its first six values are along axes of the platform; else along those of the readings.
  virtual bool turns_along(const Eigen::VectorXd& values) const;
  /// Carries the history over an equilibrium. Required where history > 0.
  virtual void advance(const ChainState& state, const std::string& element,
                       const EffectInput& input, HistoryStep& step) const;

  /// It acts on numbers that are read: equilibria know nothing of it.
  bool acts_on_numbers() const { return lags_behind || offsets_readings; }
  /// It acts on what is read: equilibria and histories know nothing of it.
  bool acts_on_readings_alone() const { return place == EffectPlace::sensor; }
  bool acts_on_chains() const { return place != EffectPlace::load && place != EffectPlace::sensor; }
};

using EffectKinds = std::vector<std::shared_ptr<const EffectKind>>;

/// The catalogue, in the order in which effects of one robot are applied, whatever the order in
/// which they are given: what inserts springs first.
const EffectKinds& effect_kinds();
/// Throws std::invalid_argument with did-you-mean.
std::shared_ptr<const EffectKind> effect_kind(const std::string& name,
                                              const EffectKinds& kinds = effect_kinds());

/// Where an effect acts.
struct EffectSite {
  std::size_t chain = 0;  // or one of what several chains share (SharedMounts)
  std::string element;    // empty for the platform
};

/// An effect with its values [SI] in the order of the kind's parameters; at several sites the same
/// values act at each.
struct Effect {
  std::shared_ptr<const EffectKind> kind;
  std::string at;                 // as written: "x.rho", "leg", "platform"
  std::vector<EffectSite> sites;  // none for what acts on load or sensor
  Eigen::VectorXd values;
  Eigen::VectorXd deviations = {};  // their standard deviations; NaN where not stated

  /// Numbers of history of all sites together.
  Eigen::Index history_size() const;
  /// "force of friction at x.rho"
  std::string name_of(Eigen::Index value) const;
};

/// One vector an effect: the histories of its sites, one after the other.
using Histories = std::vector<Eigen::VectorXd>;
/// All zero: nothing has happened since the manipulator stood relaxed.
Histories no_history(const std::vector<Effect>& effects);

/// The sites of a kind of effect in a manipulator that a name stands for: "x.rho" one, "rho" that
/// of every chain; "all parts"; "foundation" and "tool", which chains share; "platform", "load",
/// "sensor". Throws std::invalid_argument with did-you-mean.
std::vector<EffectSite> effect_sites(const EffectKind& kind, const Manipulator& manipulator,
                                     const std::string& name);
/// The names that effect_sites knows.
std::vector<std::string> effect_places(const EffectKind& kind, const Manipulator& manipulator);
/// Those of them at which it can act with values of its usual size: not a joint without a spring,
/// say, where the law needs one.
std::vector<std::string> acting_places(const std::shared_ptr<const EffectKind>& kind,
                                       const Manipulator& manipulator);
/// Prior standard deviation of a value [SI], where the manipulator has the effect. `scales`: what
/// readings do to each joint; a usual load and travel where there are none.
double prior_deviation(const Effect& effect, Eigen::Index value, const Manipulator& bare,
                       const ReadingScales& scales = {});
/// Whether the unit of an effect's parameters there is that of a joint that turns.
bool turns(const Effect& effect, const Manipulator& manipulator);

/// What several chains share, as far as effects act there.
SharedMounts mounts_of(const std::vector<Effect>& effects);
/// With sites on the chains of a manipulator that has these mounts.
std::vector<Effect> on_mounts(const SharedMounts& mounts, const Manipulator& without,
                              std::vector<Effect> effects);

/// The manipulator with the effects in its equations of equilibrium, the same in whatever order
/// they are given. Its postures are those of the manipulator without them, or, where effects act
/// on what chains share, those of SharedMounts. Throws std::invalid_argument when one cannot act
/// where it is put.
Manipulator with_effects(const Manipulator& manipulator, const std::vector<Effect>& effects,
                         const Conditions& conditions, const Histories& histories);
/// Under neutral conditions, without history.
Manipulator with_effects(const Manipulator& manipulator, const std::vector<Effect>& effects);
/// Whether one of them has a site on a chain.
bool act_on(std::size_t chain, const std::vector<Effect>& effects);
/// Numbers of effects in the order in which they are applied: as in the catalogue, then others.
std::vector<std::size_t> in_order(const std::vector<Effect>& effects);
/// Puts one on those of its sites that are on the chain of `modifier`.
void put_on(std::size_t chain, const Effect& effect, const Conditions& conditions,
            const Eigen::VectorXd& history, ChainModifier& modifier);
/// Whether it can act at its sites with its values.
bool can_act(const Effect& effect, const Manipulator& bare);
/// Whether an effect has a part in readings that are taken so.
bool acts_under(const EffectKind& kind, const Conditions& conditions);
/// How readings are taken under the effects.
ReadingErrors reading_errors(const std::vector<Effect>& effects, const Conditions& conditions);

}  // namespace kinetostat::vjm
