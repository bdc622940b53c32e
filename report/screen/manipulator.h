// First screens of `stiffness`, `deflect` and `assemble`.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "kinetostat/io/json.h"
#include "kinetostat/vjm/continuation/path_result.h"
#include "kinetostat/vjm/io/robot_file.h"
#include "kinetostat/vjm/statics/assembly.h"
#include "kinetostat/vjm/statics/equilibrium_result.h"
#include "kinetostat/vjm/statics/spring_shares.h"
#include "kinetostat/vjm/statics/stiffness.h"
#include "kinetostat/vjm/uncertainty/draws.h"

namespace kinetostat::report {

/// In which translation a platform yields most to a force.
struct SoftestDirection {
  spatial::Vector3 direction;  // unit vector, base axes; its largest component is positive
  double compliance = 0;       // [m/N]
  int dimensions = 1;          // of the directions that are as soft: 3 where all are alike
};
SoftestDirection softest_direction(const spatial::Compliance6& compliance);
/// "joint q2" or "link upper" with its share, the largest first; small ones are left out.
std::vector<std::pair<std::string, double>> by_place(const vjm::Robot& robot,
                                                     const std::vector<vjm::SpringShare>& shares);
/// "z", "-z", "(0.5, 0, 0.87)"
std::string direction_in_words(const spatial::Vector3& direction);

/// "Softest along (0.54, 0, 0.84): 1.06 N/um. Half of it is joint q2, a fifth joint q3." With the
/// uncertainty of stiffness_numbers() along that direction, where there is one: "1.06 N/um +- 9 %",
/// and what it comes from.
std::string headline(const vjm::Robot& robot, const vjm::UnloadedStiffness& stiffness,
                     const std::vector<vjm::SpringShare>& shares,
                     const std::optional<vjm::Uncertainty>& uncertainty = {});
/// Headline, stiffness against translation, and the springs that yield most along the softest
/// direction; the sources of its uncertainty.
std::string first_screen(const vjm::Robot& robot, const vjm::Posture& posture,
                         const vjm::UnloadedStiffness& stiffness,
                         const std::vector<vjm::SpringShare>& shares,
                         const std::optional<vjm::Uncertainty>& uncertainty = {});

/// Each spring with its share of the compliance along the softest direction, the largest first.
io::Json to_json(const vjm::Robot& robot, const std::vector<vjm::SpringShare>& shares);

/// "200 N along -z: the platform moves 162 um (...) and turns 0.0105 deg. Stable." With the
/// uncertainty of deflection_numbers(), where there is one.
std::string headline(const vjm::Robot& robot, const vjm::Equilibrium& equilibrium,
                     const std::optional<vjm::Uncertainty>& uncertainty = {});
/// Headline, the displacement by components, what holds it; the sources of its uncertainty.
std::string first_screen(const vjm::Robot& robot, const vjm::Equilibrium& equilibrium,
                         const std::optional<vjm::Uncertainty>& uncertainty = {});

/// The sources of the uncertainty of deflection_numbers(): of the displacement, or of the force
/// that holds a given one.
std::string displacement_budget(const vjm::Robot& robot, const vjm::Uncertainty& uncertainty);

/// The sources of the uncertainty of a path's force (`number` 0) or deflection (1) at its first
/// critical point, or at its end.
std::string path_budget(const vjm::Robot& robot, const vjm::PathTask& task,
                        const vjm::Uncertainty& uncertainty, Eigen::Index number, bool is_critical);

/// How far the platform is off after assembly, and the largest internal force.
std::string headline(const vjm::Robot& robot, const vjm::Assembly& assembly);
std::string first_screen(const vjm::Robot& robot, const vjm::Assembly& assembly);

}  // namespace kinetostat::report
