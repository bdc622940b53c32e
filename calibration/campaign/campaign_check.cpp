#include "kinetostat/calibration/campaign/campaign_check.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <set>

#include <Eigen/SVD>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "kinetostat/calibration/campaign/load_history.h"
#include "kinetostat/calibration/campaign/replicates.h"
#include "kinetostat/calibration/sensors/weight.h"
#include "kinetostat/spatial/rotation.h"
#include "kinetostat/vjm/effects/watcher.h"
#include "kinetostat/vjm/manipulator/posture.h"

namespace kinetostat::calibration {
namespace {

// Words for a count: "1 posture", "3 postures".
std::string counted(std::size_t count, const std::string& noun) {
  return fmt::format("{} {}{}", count, noun, count == 1 ? "" : "s");
}

std::string levels_text(std::size_t count) { return counted(count, "level") + " of load"; }

struct Topic {
  const char *effect, *cure;
};

// What a topic is about, and what to measure for it, each in a few words.
Topic topic_of(const std::string& name) {
  static const std::map<std::string, Topic> topics = {
      {"noise", {"whether the model is adequate", "state 'noise', or repeat some readings"}},
      {"control", {"play that no load shows", "it is: a displacement is set, the force is read"}},
      {"wrench_noise", {"errors of the load cell", "state 'wrench_noise' (loads count as exact)"}},
      {"offsets",
       {"weight, geometry, thermal offsets", "read absolute poses: they cancel in differences"}},
      {"components", {"all six components", "read the components that are missing"}},
      {"load_directions", {"loads in all directions", "load along the other axes, too"}},
      {"poses", {"dependence on the posture", "read in other postures"}},
      {"nonlinearity", {"nonlinearity", "load in three steps or more along one direction"}},
      {"reversal", {"play, preload, one-sided contact", "repeat loads with the opposite sign"}},
      {"hysteresis", {"hysteresis", "unload in steps, with the columns cycle and step"}},
      {"clearance_or_friction", {"play against friction", "reverse loads, and take them back"}},
      {"return_to_zero", {"return to zero", "read the unloaded state after each cycle"}},
      {"sessions", {"drift between sessions", "repeat some readings on another day"}},
      {"time", {"creep and drift", "add a column 'time'"}},
      {"temperature", {"thermal effects", "add a column 'temperature', and let it change"}},
      {"roles",
       {"the error on readings kept out", "keep a session or some postures back: 'roles'"}},
      {"parameters",
       {"the uncertain parameters", "take more readings, or state fewer as uncertain"}},
      {"session_frames", {"where the instrument stood", "it is estimated session by session"}},
      {"target_pose",
       {"where on the platform the target sits", "read absolute poses that turn the platform"}}};
  return topics.at(name);
}

class Check {
 public:
  Check(const Campaign& campaign, const vjm::Robot& robot)
      : campaign_(campaign), robot_(robot), changing_(changing_loads(campaign)) {
    for (std::size_t i = 0; i < campaign.readings.size(); ++i)
      if (is_used(campaign.readings[i])) used_.push_back(i);
  }

  std::vector<Observability> all() const {
    std::vector<Observability> result = {
        noise(),       wrench_noise(), offsets(),  components(),    load_directions(),
        poses(),       levels(),       reversal(), branches_seen(), clearance_or_friction(),
        zero_return(), sessions(),     time(),     temperature(),   roles(),
        parameters()};
    if (campaign_.control) result.push_back(control());
    if (campaign_.session_frame == SessionFrame::estimated) result.push_back(frames());
    for (std::size_t sensor = 0; sensor < campaign_.sensors.size(); ++sensor)
      if (campaign_.estimates_target(sensor)) result.push_back(target(sensor));
    for (Observability& item : result) {
      item.effect = topic_of(item.topic).effect;
      item.cure = topic_of(item.topic).cure;
    }
    return result;
  }

 private:
  const Reading& reading(std::size_t used) const { return campaign_.readings[used]; }

  Observability noise() const {
    const std::vector<ReplicateGroup> groups = replicate_groups(campaign_);
    std::size_t repeated = 0, freedom = 0;
    for (const ReplicateGroup& group : groups) {
      repeated += group.readings.size() > 1;
      freedom += group.readings.size() - 1;
    }
    if (repeated > 0)
      return {"noise", true,
              fmt::format("Adequacy: {} values are repeated ({} degrees of freedom){}.", repeated,
                          freedom,
                          campaign_.noise_stated
                              ? ", and the noise is stated: the two are checked against each other"
                              : "; the noise is taken from their scatter")};
    if (campaign_.noise_stated)
      return {"noise", true,
              "Adequacy: the noise is stated, but nothing is repeated, so that nothing checks it. "
              "Repeat some readings."};
    return {"noise", false,
            "Adequacy is not evaluated: no noise is stated and no reading is repeated. State "
            "'noise' in the campaign file, or repeat readings."};
  }

  // Deflections in units of their noise, where the table has deflections.
  double largest_deflection_over_noise() const {
    double largest = 0;
    if (campaign_.displacement == DisplacementKind::absolute || !campaign_.noise_stated)
      return largest;
    for (const std::size_t i : used_)
      for (const Eigen::Index k : components_in_use(reading(i)))
        largest = std::max(largest, std::abs(reading(i).displacement[k]) / reading(i).sigma[k]);
    return largest;
  }

  Observability control() const {
    const DisplacementControl& control = *campaign_.control;
    return {"control", true,
            fmt::format("A displacement is set, {}, and the force that it takes is read, {}: play "
                        "shows in how far it goes without force.",
                        campaign_.component(control.set).name,
                        campaign_.component(control.force).name)};
  }

  Observability wrench_noise() const {
    if (campaign_.control)
      return {"wrench_noise", true,
              "Errors of the load cell show in what it reads: a displacement is set, and the force "
              "is the reading."};
    if (!campaign_.wrench_covariance.empty())
      return {"wrench_noise", true,
              "The noise of the wrenches is stated: it is carried to the displacements."};
    std::string sentence = "The noise of the wrenches is not stated: loads count as exact.";
    if (const double ratio = 0.005 * largest_deflection_over_noise(); ratio > 0.3)
      sentence += fmt::format(
          " A load cell that is off by 0.5 % moves the largest deflection by {:.2g} times its "
          "noise: "
          "state 'wrench_noise'.",
          ratio);
    return {"wrench_noise", false, sentence};
  }

  Observability offsets() const {
    if (campaign_.displacement == DisplacementKind::absolute)
      return {"offsets", true,
              "Gravity, geometric errors and thermal offsets are observable: displacements are "
              "absolute."};
    return {"offsets", false,
            "Gravity, geometric errors and thermal offsets are not observable: displacements are "
            "differences to a reference state, in which they cancel. Measure absolute poses."};
  }

  Observability components() const {
    std::vector<std::string> missing;
    if (!campaign_.reads_platform())
      return {"components", false,
              fmt::format("The pose of the platform is not measured, but {}. Errors that move none "
                          "of these are not observable.",
                          fmt::join(sensor_names(), ", "))};
    for (Eigen::Index k = 0; k < campaign_.size(); ++k)
      if (campaign_.is_of_platform(k) &&
          std::none_of(used_.begin(), used_.end(),
                       [&](std::size_t i) { return reading(i).uses(k); }))
        missing.push_back(campaign_.component(k).name);
    if (missing.empty()) return {"components", true, "All six components are measured."};
    return {"components", false,
            fmt::format("Not measured: {}. Errors that move the platform only that way are not "
                        "observable.",
                        fmt::join(missing, ", "))};
  }

  std::vector<std::string> sensor_names() const {
    std::vector<std::string> names;
    for (const Sensor& sensor : campaign_.sensors)
      if (!sensor.is_platform()) names.push_back("'" + sensor.name + "'");
    return names;
  }

  // Independent directions, with rotations made comparable by the scale of each kind.
  Observability load_directions() const {
    Eigen::MatrixXd wrenches = Eigen::MatrixXd::Zero(6, static_cast<Eigen::Index>(used_.size()));
    for (std::size_t i = 0; i < used_.size(); ++i) {
      const vjm::Load& load = reading(used_[i]).load;
      wrenches.col(static_cast<Eigen::Index>(i)) =
          load.at_reference_point(spatial::Pose()) + load_in_joints(load);
      wrenches.col(static_cast<Eigen::Index>(i)).head<3>() += force_at_nodes(load);
    }
    for (const Eigen::Index first : {0, 3}) {
      const double largest = wrenches.middleRows<3>(first).cwiseAbs().maxCoeff();
      if (largest > 0) wrenches.middleRows<3>(first) /= largest;
    }
    const spatial::Matrix6 gram = wrenches * wrenches.transpose();
    const Eigen::JacobiSVD<spatial::Matrix6> svd(gram);
    const double largest = svd.singularValues()[0];
    // What a load cell reads across the load is no load in another direction.
    const auto rank = (svd.singularValues().array() > same_load * same_load * largest).count();
    if (rank == 6) return {"load_directions", true, "Loads act in all six independent directions."};
    return {"load_directions", false,
            fmt::format("Loads span {} of 6 independent directions: compliance in the others is "
                        "not observable.",
                        largest > 0 ? rank : 0)};
  }

  Observability poses() const {
    std::set<std::size_t> configurations;
    for (const std::size_t i : used_) configurations.insert(reading(i).configuration);
    if (configurations.size() > 1)
      return {"poses", true,
              fmt::format("Errors that depend on the posture are observable: {}.",
                          counted(configurations.size(), "posture"))};
    return {"poses", false,
            "One posture: errors that depend on the posture are not observable, and springs in "
            "series are not distinguishable. Measure in other postures."};
  }

  // The most levels along one line of load in one posture.
  Observability levels() const {
    using Line = std::pair<spatial::Vector6, std::vector<double>>;  // direction, levels
    std::map<std::size_t, std::vector<Line>> lines;
    for (const std::size_t i : used_) {
      const spatial::Vector6 u = direction_of(changing_[i]);
      if (u.isZero(0)) continue;
      auto& known = lines[reading(i).configuration];
      auto line = std::find_if(known.begin(), known.end(), [&u](const auto& other) {
        return (other.first - u).norm() <= same_load;
      });
      if (line == known.end()) line = known.insert(known.end(), {u, {}});
      line->second.push_back(level_of(changing_[i]));
    }
    std::size_t most = 0;
    for (const auto& [configuration, known] : lines)
      for (const auto& [direction, values] : known)
        most = std::max(most, distinct_values(values, same_load).size());
    if (most >= 3)
      return {"nonlinearity", true,
              fmt::format("Nonlinearity is observable: up to {} along one direction.",
                          levels_text(most))};
    return {"nonlinearity", false,
            fmt::format("Nonlinearity is not observable: at most {} along one direction in one "
                        "posture. Load in three steps or more.",
                        levels_text(most))};
  }

  Observability reversal() const {
    const std::size_t pairs = reversed_pairs(campaign_).size();
    if (pairs > 0)
      return {"reversal", true,
              fmt::format(
                  "Odd and even parts of the error are observable: {} of equal and opposite load.",
                  counted(pairs, "pair"))};
    return {"reversal", false,
            "No load is reversed: clearance, preload and one-sided stiffness are not observable. "
            "Repeat loads with the opposite sign."};
  }

  bool both_branches() const {
    return has_branch(campaign_, LoadDirection::loading) &&
           has_branch(campaign_, LoadDirection::unloading);
  }

  Observability branches_seen() const {
    if (both_branches())
      return {"hysteresis", true, "Hysteresis is observable: there is loading and unloading."};
    return {"hysteresis", false,
            "Hysteresis is not observable: no reading was taken while unloading, or nothing says "
            "which. Unload in steps, with the columns cycle and step, or direction."};
  }

  Observability clearance_or_friction() const {
    const bool reversed = !reversed_pairs(campaign_).empty(), both = both_branches();
    if (reversed && both)
      return {"clearance_or_friction", true,
              "Clearance and friction are distinguishable: loads are reversed and unloaded."};
    return {"clearance_or_friction", false,
            fmt::format("Clearance and friction are not distinguishable: {}.",
                        reversed ? "there is no unloading"
                        : both   ? "no load is reversed"
                                 : "there is neither reversal nor unloading")};
  }

  Observability zero_return() const {
    std::size_t returns = 0;
    for (const Cycle& cycle : load_cycles(campaign_)) {
      bool loaded = false;
      double size = 0;
      for (const std::size_t i : cycle) size = std::max(size, level_of(changing_[i]));
      for (const std::size_t i : cycle) {
        const bool zero = level_of(changing_[i]) <= same_load * size;
        returns += zero && loaded;
        loaded = loaded || !zero;
      }
    }
    if (returns > 0)
      return {"return_to_zero", true,
              fmt::format("The return to zero is observable: {} without load after loading.",
                          counted(returns, "reading"))};
    return {
        "return_to_zero", false,
        "The return to zero is not observable: no cycle reads the unloaded state after a load."};
  }

  Observability sessions() const {
    std::set<std::size_t> sessions;
    for (const std::size_t i : used_) sessions.insert(reading(i).session);
    if (sessions.size() > 1)
      return {"sessions", true,
              fmt::format("Differences between sessions are observable: {}.",
                          counted(sessions.size(), "session"))};
    return {"sessions", false,
            "One session: drift from session to session and errors of setting up are not "
            "observable."};
  }

  // Of a number that readings may carry.
  template <class Get>
  std::size_t distinct(Get get) const {
    std::vector<double> values;
    for (const std::size_t i : used_)
      if (const std::optional<double> value = get(reading(i))) values.push_back(*value);
    return distinct_values(std::move(values)).size();
  }

  Observability time() const {
    if (distinct([](const Reading& r) { return r.time; }) > 1)
      return {"time", true, "Drift and creep are observable: readings carry their time."};
    return {"time", false, "Drift and creep are not observable: there is no column 'time'."};
  }

  Observability temperature() const {
    const std::size_t count = distinct([](const Reading& r) { return r.temperature; });
    if (count > 1)
      return {"temperature", true,
              "Thermal effects are observable: readings carry their temperature."};
    return {"temperature", false,
            count == 0
                ? "Thermal effects are not observable: there is no column 'temperature'."
                : "Thermal effects are not observable: the temperature is the same throughout."};
  }

  Observability roles() const {
    const auto kept =
        static_cast<std::size_t>(std::count_if(used_.begin(), used_.end(), [this](std::size_t i) {
          return reading(i).role != Role::fit;
        }));
    if (kept > 0)
      return {
          "roles", true,
          fmt::format("The error of the model on held-out readings is observable: {} kept out of "
                      "the fit.",
                      counted(kept, "reading") + (kept == 1 ? " is" : " are"))};
    return {"roles", false,
            "The error of the model on held-out readings is not observable: all are fitted. Keep a "
            "session or some poses back with 'roles' or the column role."};
  }

  Observability frames() const {
    const bool difference = campaign_.displacement == DisplacementKind::difference;
    return {"session_frames", false,
            difference
                ? "The position of the measuring frame is not observable, since it cancels in "
                  "differences; only its rotation is estimated, session by session."
                : "The place of the robot in the measuring frame is not observable: every "
                  "session has an unknown frame of its own, with which it is confounded."};
  }

  // Of what carries the target of a sensor.
  spatial::Matrix3 axes_of_target(const vjm::Manipulator& robot, std::size_t sensor,
                                  const vjm::Posture& posture) const {
    if (campaign_.sensors[sensor].is_platform()) return posture.platform.rotation();
    const vjm::Watched watched = vjm::watched_at_rest(campaign_.watch, robot, posture, 0);
    const Sensor& of = campaign_.sensors[sensor];
    return watched.frames[of.from].rotation().transpose() * watched.frames[of.frame].rotation();
  }

  // By how much that turns between postures.
  Observability target(std::size_t sensor) const {
    const std::string& name = campaign_.sensors[sensor].name;
    const std::string whose = name.empty() ? "the target" : fmt::format("the target of '{}'", name);
    const std::string what = name.empty() ? "the platform" : "it";
    if (campaign_.displacement == DisplacementKind::difference)
      return {"target_pose", false,
              fmt::format("The place of {} shows in differences by what the load turns alone: "
                          "hardly.",
                          whose)};
    const vjm::Manipulator robot = vjm::with_watched(robot_.without_effects(), campaign_.watch);
    std::optional<spatial::Matrix3> first;
    double most = 0;
    std::set<std::size_t> seen;
    for (const std::size_t i : used_) {
      if (!seen.insert(reading(i).configuration).second) continue;
      const Configuration& configuration = campaign_.configurations[reading(i).configuration];
      const vjm::PostureResult posture =
          configuration.target ? vjm::posture_at(robot, *configuration.target)
                               : vjm::posture_from_joints(robot, configuration.joints);
      const spatial::Matrix3 axes = axes_of_target(robot, sensor, posture.posture);
      if (!first) first = axes;
      most = std::max(most, spatial::log_rotation(first->transpose() * axes).norm());
    }
    const double degrees = most * 180 / std::numbers::pi;
    constexpr double enough = 10;  // [deg]
    return {"target_pose", degrees > enough,
            fmt::format(
                "The place of {}: the postures turn {} by up to {:.3g} deg{}", whose, what, degrees,
                degrees > enough
                    ? "."
                    : ", hardly enough to distinguish it from where the instrument stands.")};
  }

  // Zero offsets and frames that are estimated as well.
  std::size_t session_unknowns() const {
    std::set<std::pair<std::size_t, Eigen::Index>> zeros;
    std::set<std::size_t> frames;
    for (const std::size_t i : used_) {
      frames.insert(reading(i).session);
      for (const Eigen::Index k : components_in_use(reading(i)))
        zeros.emplace(reading(i).session, k);
    }
    const std::size_t of_frame = campaign_.displacement == DisplacementKind::absolute ? 6 : 3;
    std::size_t targets = 0;
    for (std::size_t sensor = 0; sensor < campaign_.sensors.size(); ++sensor)
      targets += campaign_.estimates_target(sensor);
    return (campaign_.zero == ZeroReading::estimated ? zeros.size() : 0) +
           (campaign_.session_frame == SessionFrame::estimated ? of_frame * frames.size() : 0) +
           of_frame * targets;
  }

  Observability parameters() const {
    std::size_t values = 0;
    for (const std::size_t i : used_) values += components_in_use(reading(i)).size();
    const std::size_t uncertain = robot_.uncertain.size() + robot_.uncertain_values.size();
    if (uncertain == 0)
      return {"parameters", true,
              fmt::format("{}; the robot file declares nothing uncertain, so nothing is fitted.",
                          counted(values, "value"))};
    const std::size_t sessions = session_unknowns();
    const std::string besides = sessions > 0
                                    ? fmt::format(" and {} of sessions (zero offsets, frames)",
                                                  counted(sessions, "unknown"))
                                    : "";
    const bool enough = values > uncertain + sessions;
    return {"parameters", enough,
            fmt::format("{} for {}{}{}.", counted(values, "value"),
                        counted(uncertain, "uncertain parameter"), besides,
                        enough ? "" : ": too few to fit them")};
  }

  const Campaign& campaign_;
  const vjm::Robot& robot_;
  std::vector<vjm::Load> changing_;
  std::vector<std::size_t> used_;
};

}  // namespace

std::vector<Observability> check_campaign(const Campaign& campaign, const vjm::Robot& robot) {
  return Check(campaign, robot).all();
}

}  // namespace kinetostat::calibration
