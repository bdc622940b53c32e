// The bodies of an assembly as one link, and what joins them.
#include <algorithm>
#include <numeric>

#include <fmt/format.h>

#include "kinetostat/common/index.h"
#include "kinetostat/fea/link/link_geometry.h"
#include "kinetostat/fea/mesh/face_contact.h"
#include "kinetostat/io/text_file.h"
#include "kinetostat/spatial/units.h"

namespace kinetostat::fea::link_bodies {
namespace {

using common::at;
using common::InputError;

void add(WeldReport& sum, const WeldReport& weld) {
  sum.tolerance = std::max(sum.tolerance, weld.tolerance);
  sum.points_before += weld.points_before;
  sum.points_after += weld.points_after;
  sum.collapsed.insert(sum.collapsed.end(), weld.collapsed.begin(), weld.collapsed.end());
}

void add(SurfaceReport& sum, const SurfaceReport& report) {
  sum.facets += report.facets;
  sum.points += report.points;
  sum.box.extend(report.box);
  sum.area += report.area;
  sum.volume += report.volume;
  sum.defects.insert(sum.defects.end(), report.defects.begin(), report.defects.end());
}

void require_same_kind(const LinkSpec& spec, const std::vector<LinkGeometry>& bodies) {
  for (std::size_t b = 1; b < bodies.size(); ++b) {
    if (bodies[b].is_meshed() == bodies[0].is_meshed()) continue;
    InputError::Details details = spec.bodies[b].mesh_origin;
    details.what =
        fmt::format("{} is a {}, that of {} is not", spec.bodies[b].mesh_name,
                    bodies[b].is_meshed() ? "volume mesh" : "surface", spec.bodies[0].name);
    details.cure = "Give the surfaces of all bodies, or the volume meshes of all";
    throw InputError(details);
  }
}

// Which bodies move together: the smallest number of those that a body hangs together with.
class Groups {
 public:
  explicit Groups(std::size_t bodies) : first_(bodies) {
    std::iota(first_.begin(), first_.end(), std::size_t{0});
  }
  void unite(std::size_t a, std::size_t b) {
    const auto [low, high] = std::minmax(first_[a], first_[b]);
    const std::size_t kept = low, replaced = high;
    std::replace(first_.begin(), first_.end(), replaced, kept);
  }
  std::size_t of(std::size_t body) const { return first_[body]; }

 private:
  std::vector<std::size_t> first_;
};

std::vector<std::size_t> bodies_of(const LinkGeometry& geometry, int interface) {
  std::vector<std::size_t> bodies;
  for (std::size_t b = 0; b < geometry.bodies.size(); ++b) {
    const LinkGeometry& body = geometry.bodies[b];
    if (std::any_of(body.tags.begin(), body.tags.end(),
                    [&](int tag) { return tag % body.tags_of_face == interface; }))
      bodies.push_back(b);
  }
  return bodies;
}

double gap_of(const JointSpec& joint, const LinkGeometry& geometry) {
  const auto size = [&](std::size_t b) { return geometry.bodies[b].report.box.diagonal().norm(); };
  return joint.within.value_or(JointSpec::default_gap *
                               std::min(size(joint.bodies[0]), size(joint.bodies[1])));
}

std::string length(double metres, const LinkSpec& spec) {
  const std::string unit = spec.unit.empty() ? "m" : spec.unit;
  return fmt::format("{:.3g} {}", metres / spatial::parse_unit(unit).factor, unit);
}

[[noreturn]] void refuse_apart(const LinkSpec& spec, const LinkGeometry& geometry,
                               const JointSpec& joint) {
  const auto [a, b] = joint.bodies;
  const double distance =
      distance_between(geometry.bodies[a].imported.mesh, geometry.bodies[b].imported.mesh);
  const double within = gap_of(joint, geometry);
  InputError::Details details = joint.origin;
  details.what =
      fmt::format("the faces of {} and {} do not touch: within {}, none lie on each other",
                  spec.bodies[a].name, spec.bodies[b].name, length(within, spec));
  details.cure =
      distance > within
          ? fmt::format("They are {} apart: bring them together, or give 'within: {}'",
                        length(distance, spec), length(1.01 * distance, spec))
          : "They meet in edges or corners alone, or cross: repair that in the CAD program";
  throw InputError(details);
}

// A node cannot follow an interface and be free to move with a joint.
void require_free(const LinkSpec& spec, const JointSpec& joint, const TetMesh& mesh,
                  const FaceContact& contact) {
  for (const int f : contact.faces) {
    const BoundaryFace& face = mesh.boundary[at(f)];
    const auto p = [&](std::size_t k) { return mesh.nodes[at(face.nodes[k])]; };
    const double area = 0.5 * (p(1) - p(0)).cross(p(2) - p(0)).norm();
    if (face.tag == 0 || at(face.tag) > spec.interfaces.size() || contact.area() < 1e-3 * area)
      continue;
    const InterfaceSpec& interface = spec.interfaces[at(face.tag - 1)];
    InputError::Details details = interface.origin;
    details.what =
        fmt::format("the {} interface lies on the joint of {} and {}", interface.name,
                    spec.bodies[joint.bodies[0]].name, spec.bodies[joint.bodies[1]].name);
    details.cure = "Choose faces that no other body touches";
    throw InputError(details);
  }
}

std::vector<FaceContact> contacts_of(const LinkSpec& spec, const LinkGeometry& geometry,
                                     std::size_t number, const TetMesh& mesh) {
  const JointSpec& joint = spec.joints[number];
  std::vector<FaceContact> contacts =
      find_contacts(mesh, static_cast<int>(joint.bodies[0]), static_cast<int>(joint.bodies[1]),
                    gap_of(joint, geometry));
  if (contacts.empty()) refuse_apart(spec, geometry, joint);
  for (FaceContact& contact : contacts) {
    require_free(spec, joint, mesh, contact);
    contact.joint = static_cast<int>(number);
    if (!joint.layer) continue;
    contact.normal_flexibility = 1 / joint.layer->normal;
    contact.tangential_flexibility = 1 / joint.layer->tangential;
  }
  return contacts;
}

}  // namespace
}  // namespace kinetostat::fea::link_bodies

namespace kinetostat::fea {

LinkGeometry together(const LinkSpec& spec, std::vector<LinkGeometry> bodies) {
  using namespace link_bodies;
  require_same_kind(spec, bodies);
  LinkGeometry all;
  std::string hashes;
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    const LinkGeometry& body = bodies[b];
    append(all.imported.mesh, body.imported.mesh);
    add(all.imported.weld, body.imported.weld);
    add(all.report, body.report);
    hashes += body.imported.sha256;
    for (const std::string& note : body.notes)
      all.notes.push_back(fmt::format("{}: {}", spec.bodies[b].name, note));
  }
  all.imported.sha256 = io::sha256(hashes);
  all.bodies = std::move(bodies);
  return all;
}

void require_held(const LinkSpec& spec, const LinkGeometry& geometry) {
  using namespace link_bodies;
  Groups groups(spec.bodies.size());
  for (const JointSpec& joint : spec.joints) groups.unite(joint.bodies[0], joint.bodies[1]);
  for (std::size_t i = 0; i < spec.interfaces.size(); ++i) {
    if (spec.interfaces[i].coupling != Coupling::rigid) continue;
    const std::vector<std::size_t> bodies = bodies_of(geometry, static_cast<int>(i) + 1);
    for (const std::size_t b : bodies) groups.unite(bodies.front(), b);
  }
  const std::size_t held = bodies_of(geometry, 1).front();
  for (std::size_t b = 0; b < spec.bodies.size(); ++b) {
    if (groups.of(b) == groups.of(held)) continue;
    InputError::Details details = spec.bodies[b].mesh_origin;
    details.what = fmt::format("nothing holds the body {}: no joint leads to it from {}",
                               spec.bodies[b].name, spec.bodies[held].name);
    details.cure =
        fmt::format("Add to 'joints', for example '- {{between: [{}, {}], bonded: true}}'",
                    spec.bodies[held].name, spec.bodies[b].name);
    throw InputError(details);
  }
}

void join_bodies(const LinkSpec& spec, const LinkGeometry& geometry, TetMesh& mesh) {
  for (std::size_t j = 0; j < spec.joints.size(); ++j)
    for (FaceContact& contact : link_bodies::contacts_of(spec, geometry, j, mesh))
      mesh.contacts.push_back(std::move(contact));
  for (const FaceContact& contact : mesh.contacts)
    for (const int face : contact.faces)
      if (int& tag = mesh.boundary[common::at(face)].tag; tag == 0)
        tag = static_cast<int>(spec.interfaces.size()) + 1;
  set_traces(mesh);
}

}  // namespace kinetostat::fea
