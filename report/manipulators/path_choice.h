// What was chosen of the free motions of a path, in words and for programs.
#pragma once

#include <string>
#include <vector>

#include "kinetostat/io/json.h"
#include "kinetostat/report/manipulators/map.h"
#include "kinetostat/vjm/workspace/path_choice.h"

namespace kinetostat::report {

/// A choice with what the index was at the poses as they were given.
struct PathChoiceText {
  const vjm::Robot& robot;
  const NamedIndex& index;
  const std::vector<vjm::MapPoint>& given;
  const vjm::PathChoice& choice;
  const std::vector<std::string>& joints;  // "chain.joint", those of choice.joints
  const spatial::Pose& place;              // of the base
  const vjm::JointStep& step;  // the largest, where joints are free; without a name: not said
};

/// "At the worst pose of the path stiffness=1 0 0 is 1.9 times as good: 310 -> 590 N/mm, ..."
std::string sentence(const PathChoiceText& said);
/// The same, SI units; null where there is no number.
io::Json to_json(const PathChoiceText& said);

}  // namespace kinetostat::report
