// Paths of equilibria, for people, for spreadsheets and for programs.
#pragma once

#include <optional>
#include <string>

#include "kinetostat/io/json.h"
#include "kinetostat/vjm/continuation/path.h"
#include "kinetostat/vjm/io/robot_file.h"
#include "kinetostat/vjm/statics/segments.h"

namespace kinetostat::report {

/// "First critical point, a bifurcation, at 332 N and 0.0475 mm; beyond it the path is unstable."
std::string headline(const vjm::Robot& robot, const vjm::PathTask& task, const vjm::Path& path);
/// Critical points with force, deflection and stiffness before and after (as in MMT11 Table 2),
/// branches and how they end, the equilibria at the target.
std::string text(const vjm::Robot& robot, const vjm::PathTask& task, const vjm::Path& path);
/// Everything, with the full equilibrium at every point.
io::Json to_json(const vjm::Robot& robot, const vjm::PathTask& task, const vjm::Path& path);
/// One row a point, in the units of the robot file; critical points are rows of their own.
std::string csv(const vjm::Robot& robot, const vjm::PathTask& task, const vjm::Path& path);

/// What the charts of a page need: the posture at every point, branch by branch.
io::Json picture(const vjm::Robot& robot, const vjm::PathTask& task, const vjm::Path& path);
/// What to_json() made, without the equilibria at its points: picture() has them in a shorter form.
io::Json without_equilibria(io::Json path);

/// That a beam buckles where the given segments show nothing; empty when they show it.
std::string warning(const vjm::Robot& robot, const vjm::PathTask& task,
                    const vjm::SegmentStudy& study);

/// The force at the first critical point of the first branch over the number of segments.
std::string text(const vjm::Robot& robot, const vjm::PathTask& task,
                 const vjm::SegmentStudy& study);
io::Json to_json(const vjm::SegmentStudy& study);

}  // namespace kinetostat::report
