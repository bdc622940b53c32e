// Where a link is joined to its neighbour, found by the axis of the joint.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "kinetostat/fea/interface/interface_selection.h"

namespace kinetostat::fea {

/// The axis of a joint of a link.
struct JointAxis {
  Vector3 point;      // [m] of the joint's frame
  Vector3 direction;  // unit
};

/// A face of the link that the joint may hold.
struct JointInterface {     // NOLINT(bugprone-exception-escape): strings move without throwing
  Selector selector;        // a cylinder, a plane or a box; it picks just these facets
  std::vector<int> facets;  // ascending
  double area = 0;          // [m^2]
  double off = 0;           // [m] along the axis, from the point to the middle of the face
  std::string words;        // "bore of radius 20 mm"
  double rank = 0;          // the smaller the likelier
};

/// Bores and bosses around the axis and flat faces across it that lie about it, the likeliest
/// first: bores before flat faces before bosses, near the point before far from it, large before
/// small. None is farther along the axis than a third of the diagonal of the bounding box, from the
/// point or, where that is beside the mesh, from where the mesh is nearest to it along the axis,
/// and none is a face that the selectors of link files cannot pick alone.
std::vector<JointInterface> joint_interfaces(const SurfaceMesh& surface, const JointAxis& axis);

/// What there is without such a face: the surface in a cube about that place of the axis, as much
/// as a ring about it would have, then less. Less likely than any face. None where no facet is
/// nearer than a third of the diagonal.
std::vector<JointInterface> surroundings(const SurfaceMesh& surface, const JointAxis& axis);

/// The likeliest two that have no point in common.
std::optional<std::pair<JointInterface, JointInterface>> apart(
    const SurfaceMesh& surface, const std::vector<JointInterface>& first,
    const std::vector<JointInterface>& second);

}  // namespace kinetostat::fea
