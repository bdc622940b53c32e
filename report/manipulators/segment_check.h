// What finer beams say about an equilibrium, for people and for programs.
#pragma once

#include <string>

#include "kinetostat/io/json.h"
#include "kinetostat/vjm/io/robot_file.h"
#include "kinetostat/vjm/statics/segments.h"

namespace kinetostat::report {

/// Whether a beam buckles that one spring keeps straight, and by how much lumped springs misstate
/// the result; empty where neither is worth a word.
std::string text(const vjm::Robot& robot, const vjm::SegmentCheck& check);
void add_to(io::Json& json, const vjm::SegmentCheck& check);

}  // namespace kinetostat::report
