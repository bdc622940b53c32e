#include "kinetostat/fea/surface/surface_bodies.h"

#include <algorithm>
#include <map>
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "kinetostat/common/index.h"
#include "kinetostat/spatial/units.h"

namespace kinetostat::fea {
namespace {

using common::at;

// For each facet the one group that holds it; -1 where none or several do.
std::vector<int> group_of_facets(const SurfaceMesh& mesh) {
  std::vector<int> group_of(mesh.triangles.size(), -1);
  std::vector<int> count(mesh.triangles.size(), 0);
  for (std::size_t g = 0; g < mesh.groups.size(); ++g)
    for (const int f : mesh.groups[g].facets) {
      ++count[at(f)];
      group_of[at(f)] = count[at(f)] == 1 ? static_cast<int>(g) : -1;
    }
  return group_of;
}

// Names are of bodies when every facet has one and no shell has two: a group may also be a face.
bool names_tell_bodies(const std::vector<Shell>& shells, const std::vector<int>& group_of) {
  return std::all_of(shells.begin(), shells.end(), [&](const Shell& shell) {
    const int group = group_of[at(shell.facets.front())];
    return group >= 0 && std::all_of(shell.facets.begin(), shell.facets.end(),
                                     [&](int f) { return group_of[at(f)] == group; });
  });
}

void add(Body& body, const Shell& shell) {
  body.facets.insert(body.facets.end(), shell.facets.begin(), shell.facets.end());
  body.volume += shell.volume;
  body.box.extend(shell.box);
}

std::vector<Body> named(const SurfaceMesh& mesh, const std::vector<Shell>& shells,
                        const std::vector<int>& group_of) {
  std::vector<Body> bodies(mesh.groups.size());
  for (std::size_t g = 0; g < bodies.size(); ++g) bodies[g].name = mesh.groups[g].name;
  for (const Shell& shell : shells) add(bodies[at(group_of[at(shell.facets.front())])], shell);
  return bodies;
}

// A cavity belongs to the smallest box around it that is a body's; what floats in it is a body,
// too.
std::vector<Body> numbered(const std::vector<Shell>& shells) {
  std::vector<Body> bodies;
  std::vector<const Shell*> outermost;
  for (const Shell& shell : shells) {
    if (shell.depth % 2 != 0) continue;
    outermost.push_back(&shell);
    bodies.push_back({.name = std::to_string(outermost.size()), .facets = {}, .box = {}});
    add(bodies.back(), shell);
  }
  for (const Shell& shell : shells) {
    if (shell.depth % 2 == 0) continue;
    std::size_t owner = outermost.size();
    for (std::size_t i = 0; i < outermost.size(); ++i)
      if (outermost[i]->box.contains(shell.box) &&
          (owner == outermost.size() || outermost[owner]->box.contains(outermost[i]->box)))
        owner = i;
    if (owner < bodies.size()) add(bodies[owner], shell);
  }
  return bodies;
}

// The solids of a CAD file, by name where each has one of its own. They may touch, so that shells
// do not distinguish them.
std::vector<Body> solids(const SurfaceMesh& mesh, const std::vector<int>& face_of) {
  std::map<int, Body> found;
  std::set<std::string> names;
  for (std::size_t f = 0; f < face_of.size(); ++f) {
    const CadFace& face = mesh.faces[at(face_of[f] - 1)];
    Body& body = found[face.solid];
    if (body.facets.empty()) {
      body.name = face.solid_name;
      names.insert(face.solid_name);
    }
    body.facets.push_back(static_cast<int>(f));
    for (std::size_t k = 0; k < 3; ++k) body.box.extend(mesh.corner(f, k));
    body.volume += mesh.corner(f, 0).dot(mesh.corner(f, 1).cross(mesh.corner(f, 2))) / 6;
  }
  const bool are_named = names.size() == found.size() && !names.contains("");
  std::vector<Body> bodies;
  for (auto& [number, body] : found) {
    if (!are_named) body.name = std::to_string(bodies.size() + 1);
    bodies.push_back(std::move(body));
  }
  return bodies;
}

// Every facet is on a face of a solid, and there are several of these.
bool has_solids(const SurfaceMesh& mesh, const std::vector<int>& face_of) {
  std::set<int> numbers;
  for (const int face : face_of) numbers.insert(face > 0 ? mesh.faces[at(face - 1)].solid : 0);
  return numbers.size() > 1 && !numbers.contains(0);
}

}  // namespace

std::vector<Body> find_bodies(const SurfaceMesh& mesh, const std::vector<Shell>& shells) {
  const std::vector<int> face_of = face_of_facets(mesh);
  if (has_solids(mesh, face_of)) return solids(mesh, face_of);
  const std::vector<int> group_of = group_of_facets(mesh);
  std::vector<Body> bodies =
      mesh.faces.empty() && mesh.groups.size() > 1 && names_tell_bodies(shells, group_of)
          ? named(mesh, shells, group_of)
          : numbered(shells);
  for (Body& body : bodies) std::sort(body.facets.begin(), body.facets.end());
  return bodies;
}

void keep_body(SurfaceMesh& mesh, const Body& body) {
  std::vector<int> kept(mesh.triangles.size(), -1);
  for (std::size_t i = 0; i < body.facets.size(); ++i)
    kept[at(body.facets[i])] = static_cast<int>(i);
  keep_facets(mesh, kept);
}

std::string list_bodies(std::vector<Body> bodies, const std::string& unit) {
  const double length = spatial::parse_quantity("1 " + unit, spatial::dimension::length);
  std::stable_sort(bodies.begin(), bodies.end(), [](const Body& a, const Body& b) {
    return a.box.diagonal().norm() > b.box.diagonal().norm();
  });
  constexpr std::size_t most = 12;
  std::vector<std::string> texts;
  for (std::size_t i = 0; i < std::min(most, bodies.size()); ++i) {
    const Vector3 size = bodies[i].box.sizes() / length;
    texts.push_back(fmt::format("{} ({:.4g} x {:.4g} x {:.4g} {})", bodies[i].name, size.x(),
                                size.y(), size.z(), unit));
  }
  return fmt::format("{}{}", fmt::join(texts, ", "),
                     bodies.size() > most ? fmt::format(" and {} more", bodies.size() - most) : "");
}

}  // namespace kinetostat::fea
