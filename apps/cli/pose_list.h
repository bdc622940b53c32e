// The options that give many poses to commands: a grid, or a path from a file.
#pragma once

#include <string>

#include "kinetostat/apps/cli/robot_request.h"
#include "kinetostat/io/table_parts.h"
#include "kinetostat/vjm/workspace/pose_list.h"

namespace kinetostat::apps {

/// "x=-70:120:20,y=0,z=0:100:5": from, to and number of points, or one value; coordinates that are
/// not named are 0. Likewise of the drives of a robot of one chain, "q2=-60:60:13,q3=90": those
/// that are not named stay at home. Of a part there are its poses alone. Throws UsageError for the
/// option that it comes from.
vjm::PoseList read_grid(const std::string& grid, const vjm::Robot& robot, const vjm::Load& load,
                        const std::string& option = "--grid", const io::Part& part = {});

/// A CSV file with columns x, y, z, rx, ry, rz (rotation vector) and, for loads of each pose, fx,
/// fy, fz, mx, my, mz; those left out are 0. A column of an actuated joint of a redundant robot is
/// where the joint is held; without coordinates the joints alone say where to go. Columns are in
/// the units of the robot file, or in one of their own: "x [m]". Throws common::InputError;
/// UsageError when both the file and `load` have a wrench.
vjm::PoseList read_path(const std::string& file, const vjm::Robot& robot, const vjm::Load& load,
                        const io::Part& part = {});

/// Says what was assumed of the poses.
void remark_on(const vjm::PoseList& list, const Run& run);

}  // namespace kinetostat::apps
