// Effects that can be hidden in a twin: those of the product's catalogue in other mathematical
// forms, and some that no catalogue has.
#pragma once

#include <string>
#include <vector>

#include "robot.h"

namespace twin {

/// One thing that is wrong with the model that the product is shown.
struct HiddenEffect {
  std::string name, at;  // as the product calls it, if it knows it
  double size = 0;       // its leading number, SI; 0 for none
  int form = 0;          // of those that its other numbers give it; 0 where it is hidden
};

/// The conditions and the load of one reading.
struct Row {
  int posture = 0;
  std::string session;
  int cycle = 0, step = 0;
  double time = 0;                                 // [s], since the session started
  double temperature = 20, link_temperature = 20;  // as read; of the links, which lag behind [degC]
  Vector3 force = Vector3::Zero();                 // [N], at the platform's reference point
  bool unloading = false;
  bool starts = false;   // a cycle: the unloaded state was read just before
  bool weighed = false;  // loaded by known weights: no error of the load cell acts
};

/// A usual size of an effect, from which the size for a wanted detectability is sought. Throws
/// std::invalid_argument for a name that nobody knows.
double usual_size(const RobotSpec& robot, const HiddenEffect& effect);

/// Whether its readings depend on the loads before.
bool remembers_loads(const HiddenEffect& effect);

/// All that an effect can look like: one of these lists, and of its members, which have their usual
/// sizes, any combination.
std::vector<std::vector<HiddenEffect>> looks_of(const RobotSpec& robot, const HiddenEffect& effect);

/// Changes bodies, springs and laws of a built robot. Once for each cycle; a law of a joint takes
/// the place of the one before, but friction comes beside it.
void apply_to_structure(const HiddenEffect& effect, const RobotSpec& robot, const Posture& posture,
                        Built& built);
/// Lets what depends on the conditions of a row follow them. `rests`: what the couplings had.
void apply_conditions(const std::vector<HiddenEffect>& effects, const std::vector<Vector6>& rests,
                      const Row& row, Built& built);
/// The load that really acts.
DeadLoad actual_load(const std::vector<HiddenEffect>& effects, const Row& row,
                     const Mark& platform);
/// The pose that the instrument shows for one of the platform when a row is read.
Pose seen(const std::vector<HiddenEffect>& effects, const Pose& platform, const Row& row);

}  // namespace twin
