#include "kinetostat/fea/surface/surface_bodies.h"

#include <algorithm>

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

}  // namespace

std::vector<Body> find_bodies(const SurfaceMesh& mesh, const std::vector<Shell>& shells) {
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
