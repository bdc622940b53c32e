#include "kinetostat/fea/surface/one_solid.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "kinetostat/fea/surface/surface_bodies.h"
#include "kinetostat/fea/surface/surface_check.h"

namespace kinetostat::fea {
namespace {

SurfaceReport check(const SurfaceMesh& mesh) {
  return check_surface(mesh, weld_tolerance(mesh.points));
}

void keep_largest(const std::vector<Shell>& shells, OneSolid& solid) {
  const std::vector<Body> bodies = find_bodies(solid.surface, shells);
  if (bodies.size() < 2) return;
  const auto volume = [](const Body& body) { return std::abs(body.volume); };
  const auto largest =
      std::max_element(bodies.begin(), bodies.end(),
                       [&volume](const Body& a, const Body& b) { return volume(a) < volume(b); });
  double all = 0;
  for (const Body& body : bodies) all += volume(body);
  solid.bodies = bodies.size();
  solid.share = all > 0 ? volume(*largest) / all : 0;
  keep_body(solid.surface, *largest);
  drop_unused_points(solid.surface);
}

void repair_by(const std::vector<RepairStep>& steps, RepairOptions options, OneSolid& solid,
               common::Progress& progress) {
  options.steps = steps;
  for (const RepairAction& action : repair(solid.surface, options, progress).actions)
    if (action.done) solid.repairs.push_back(action.step);
  drop_unused_points(solid.surface);
}

}  // namespace

std::optional<OneSolid> one_solid(const SurfaceMesh& mesh, const RepairOptions& options,
                                  common::Progress& progress) {
  const SurfaceReport given = check(mesh);
  if (given.sound() && given.bodies() == 1) return OneSolid{.surface = mesh};
  using Step = RepairStep;
  const std::vector<Step> gentle{Step::weld, Step::orient, Step::fill, Step::unite},
      any{Step::weld, Step::orient, Step::fill, Step::unite, Step::wrap};
  for (const std::vector<Step>& steps : {gentle, any}) {
    OneSolid solid{.surface = mesh};
    repair_by(steps, options, solid, progress);
    const SurfaceReport report = check(solid.surface);
    if (!report.sound()) continue;
    keep_largest(report.shells, solid);
    return solid;
  }
  OneSolid shell{.surface = mesh};
  keep_largest(given.shells, shell);
  if (shell.bodies < 2) return std::nullopt;
  repair_by(any, options, shell, progress);
  const SurfaceReport report = check(shell.surface);
  if (!report.sound() || report.bodies() != 1) return std::nullopt;
  return shell;
}

}  // namespace kinetostat::fea
