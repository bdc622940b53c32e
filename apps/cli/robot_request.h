// The options that give a robot, a posture, and a load or displacement to commands.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "kinetostat/apps/cli/option_list.h"
#include "kinetostat/vjm/continuation/path.h"
#include "kinetostat/vjm/io/robot_file.h"
#include "kinetostat/vjm/manipulator/posture.h"
#include "kinetostat/vjm/statics/equilibrium.h"
#include "kinetostat/vjm/statics/segments.h"
#include "kinetostat/vjm/uncertainty/draws.h"

namespace kinetostat::apps {

class Run;

/// ROBOT.yaml with --at or --joints.
struct PostureRequest {
  std::string robot_file, at, joints;
  /// Reads a robot that is in memory; none: `robot_file` is read.
  std::function<vjm::Robot(const vjm::LinkOptions&)> source = {};

  void add_options(OptionList& app);
  /// --at and --joints alone.
  void add_posture_options(OptionList& app);
  vjm::Robot read(const vjm::LinkOptions& options = {}) const;
  /// Throws UsageError for a malformed option, common::NoConvergence for an unreachable pose.
  vjm::Posture posture(const vjm::Robot& robot) const;
  /// That of a robot like one whose posture is known, but for uncertain numbers; nothing where it
  /// cannot be reached.
  std::optional<vjm::Posture> posture_like(const vjm::Posture& known, const vjm::Robot& of,
                                           const vjm::Robot& other) const;
};

/// Of each joint that stands outside of its range, a sentence.
std::vector<std::string> beyond_ranges(const vjm::Robot& robot, const vjm::Posture& posture);
/// Warns of them.
void warn_beyond_ranges(const vjm::Robot& robot, const vjm::Posture& posture, const Run& run);

/// --wrench with --point and --node-load, or --move.
struct LoadRequest {
  std::string wrench, point, move;
  std::vector<std::string> node_loads;

  void add_options(OptionList& app);
  /// Only those that say what acts: not --move.
  void add_load_options(OptionList& app);
  bool given() const { return !wrench.empty() || !move.empty() || !node_loads.empty(); }
  /// The same as a path: what grows from nothing to what is given. Loads at nodes grow unless a
  /// displacement does.
  vjm::PathTask task(const vjm::Robot& robot) const;
  /// Throws UsageError.
  vjm::Load load(const vjm::Robot& robot) const;
  vjm::Equilibrium solve(const vjm::Robot& robot, const vjm::Posture& posture) const;
};

class Run;

/// --draws, --seed and --no-uncertainty: how far results are uncertain, where the robot file says
/// that its numbers are.
struct UncertaintyRequest {
  int draws = 0;
  std::uint64_t seed = 1;
  bool none = false;
  bool required = false;  // none is an error
  std::string drawn, part;

  void add_options(OptionList& app);
  /// --drawn and --part, of commands with one set of draws.
  void add_drawn_options(OptionList& app);
  /// None where none is wanted, and for a robot without uncertain numbers; then --draws is a
  /// UsageError. None, with a warning, where robots beside that of the file stand in no
  /// equilibrium; common::NoConvergence where it is `required`.
  std::optional<vjm::Uncertainty> of(const vjm::Robot& robot, const vjm::Computation& compute,
                                     Run& run) const;
  /// Of stiffness_numbers() of the unloaded robot along a unit vector.
  std::optional<vjm::Uncertainty> of(const vjm::Robot& robot, const PostureRequest& request,
                                     const vjm::Posture& posture, const spatial::Vector3& direction,
                                     Run& run) const;
  /// Of deflection_numbers() of an equilibrium under `load`; none where it was not found.
  std::optional<vjm::Uncertainty> of(const vjm::Robot& robot, const PostureRequest& request,
                                     const vjm::Posture& posture, const LoadRequest& load,
                                     const vjm::Equilibrium& equilibrium, Run& run) const;
};

/// Solves again with every beam in two and eight times the segments. `found` takes over the
/// stability of the finer beams where that is less (vjm::take_stability()).
vjm::SegmentCheck check_segments(const vjm::Robot& robot, const PostureRequest& posture,
                                 const LoadRequest& load, vjm::Equilibrium& found);

/// An equilibrium that was not found, or that would not last, is only part of what was asked for.
void stop_short_unless_stable(const LoadRequest& request, const vjm::Robot& robot,
                              const vjm::Equilibrium& equilibrium, Run& run);

}  // namespace kinetostat::apps
