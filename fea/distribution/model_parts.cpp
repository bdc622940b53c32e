#include "kinetostat/fea/distribution/model_parts.h"

#include <algorithm>
#include <array>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>

#include "kinetostat/common/index.h"
#include "kinetostat/fea/elasticity/p1_coarse_space.h"
#include "kinetostat/fea/linear_algebra/partition.h"

namespace kinetostat::fea {
namespace {

using common::at;

using Ends = std::vector<std::array<int, 2>>;

bool is_corner(const Ends& ends, std::size_t node) {
  return ends[node][0] == static_cast<int>(node);
}

// The corner with which a node goes: of the ends of edges now the first, now the second, so that
// both sides of a border get their share.
int leader(const Ends& ends, std::size_t node) { return ends[node][node % 2]; }

void require_elements(const DofMap& unknowns, const Ends& ends) {
  for (std::size_t n = 0; n < ends.size(); ++n)
    if (ends[n][0] < 0 && unknowns.block_of(static_cast<int>(n)) >= 0)
      throw std::invalid_argument(fmt::format("node {} belongs to no element", n));
}

// The free nodes in the order of their blocks.
std::vector<int> nodes_in_order(const DofMap& unknowns, std::size_t nodes) {
  std::vector<int> order(at(unknowns.node_blocks()));
  for (std::size_t n = 0; n < nodes; ++n)
    if (const int block = unknowns.block_of(static_cast<int>(n)); block >= 0)
      order[at(block)] = static_cast<int>(n);
  return order;
}

// The place of each of these nodes among them, -1 for others.
std::vector<int> places_of(const std::vector<int>& nodes, std::size_t all) {
  std::vector<int> place(all, -1);
  for (std::size_t i = 0; i < nodes.size(); ++i) place[at(nodes[i])] = static_cast<int>(i);
  return place;
}

TetMesh mesh_of(const TetMesh& whole, const std::vector<int>& elements,
                const std::vector<int>& nodes, const std::vector<int>& place) {
  TetMesh mesh{.order = whole.order, .curved = whole.curved};
  mesh.nodes.reserve(nodes.size());
  for (const int node : nodes) mesh.nodes.push_back(whole.nodes[at(node)]);
  mesh.connectivity.reserve(whole.nodes_per_element() * elements.size());
  for (const int e : elements) {
    for (const int node : whole.element(at(e))) mesh.connectivity.push_back(place[at(node)]);
    if (!whole.materials.empty()) mesh.materials.push_back(whole.materials[at(e)]);
  }
  return mesh;
}

DofMap unknowns_of(const DofMap& whole, const TetMesh& mesh, const std::vector<int>& nodes,
                   const std::vector<int>& place) {
  std::vector<int> fixed;
  for (std::size_t i = 0; i < nodes.size(); ++i)
    if (whole.is_fixed(nodes[i])) fixed.push_back(static_cast<int>(i));
  std::vector<ReferenceBody> bodies;
  for (const ReferenceBody& body : whole.bodies()) {
    bodies.push_back({body.point, {}});
    for (const int node : body.nodes)
      if (place[at(node)] >= 0) bodies.back().nodes.push_back(place[at(node)]);
  }
  DofMap unknowns(mesh, fixed, std::move(bodies), BlockOrder::as_nodes);
  std::vector<GroundSpring> springs;
  for (const GroundSpring& spring : whole.springs())
    if (place[at(spring.node)] >= 0) springs.push_back({place[at(spring.node)], spring.stiffness});
  unknowns.set_springs(std::move(springs));
  return unknowns;
}

}  // namespace

int BlockNumbers::of_block(int block) const {
  const int nodes = static_cast<int>(of_nodes.size());
  if (block < nodes) return of_nodes[at(block)];
  return of_bodies[at((block - nodes) / 2)] + (block - nodes) % 2;
}

int BlockNumbers::first_block() const {
  return static_cast<int>(std::lower_bound(of_nodes.begin(), of_nodes.end(), first) -
                          of_nodes.begin());
}

ModelDivision::ModelDivision(const TetMesh& mesh, const DofMap& unknowns, int parts)
    : mesh_(mesh), unknowns_(unknowns), parts_(parts), owner_(mesh.nodes.size(), -1) {
  const Ends ends = edge_ends(mesh);
  require_elements(unknowns, ends);
  const std::vector<int> part = parts_of_nodes(ends), body_part = parts_of_bodies(part);
  for (std::size_t n = 0; n < owner_.size(); ++n) {
    const int node = static_cast<int>(n), body = unknowns.body_of(node);
    if (unknowns.block_of(node) >= 0) owner_[n] = part[n];
    if (body >= 0) owner_[n] = body_part[at(body)];
  }
  std::vector<int> nodes = nodes_in_order(unknowns, mesh.nodes.size());
  fine_ = number(nodes, part, body_part);
  std::erase_if(nodes, [&ends](int node) { return !is_corner(ends, at(node)); });
  corners_ = number(nodes, part, body_part);
}

std::vector<int> ModelDivision::parts_of_nodes(const Ends& ends) const {
  std::vector<int> corner(ends.size(), -1);
  int corners = 0;
  for (std::size_t n = 0; n < ends.size(); ++n)
    if (is_corner(ends, n)) corner[n] = corners++;
  std::vector<int> weight(at(corners), 0);
  Ends links;
  links.reserve(ends.size() - weight.size());
  for (std::size_t n = 0; n < ends.size(); ++n) {
    if (ends[n][0] < 0) continue;
    if (unknowns_.block_of(static_cast<int>(n)) >= 0) ++weight[at(corner[at(leader(ends, n))])];
    if (!is_corner(ends, n)) links.push_back({corner[at(ends[n][0])], corner[at(ends[n][1])]});
  }
  const std::vector<int> part_of_corner = partition(links, weight, parts_);
  std::vector<int> part(ends.size(), -1);
  for (std::size_t n = 0; n < ends.size(); ++n)
    if (ends[n][0] >= 0) part[n] = part_of_corner[at(corner[at(leader(ends, n))])];
  return part;
}

std::vector<int> ModelDivision::parts_of_bodies(const std::vector<int>& part) const {
  std::vector<int> body_part;
  for (const ReferenceBody& body : unknowns_.bodies()) {
    std::vector<int> nodes(at(parts_), 0);
    for (const int node : body.nodes)
      if (part[at(node)] >= 0) ++nodes[at(part[at(node)])];
    body_part.push_back(
        static_cast<int>(std::max_element(nodes.begin(), nodes.end()) - nodes.begin()));
  }
  return body_part;
}

ModelDivision::Level ModelDivision::number(const std::vector<int>& nodes,
                                           const std::vector<int>& part,
                                           const std::vector<int>& body_part) const {
  Level level{.of_node = std::vector<int>(part.size(), -1),
              .of_body = {},
              .first = std::vector<int>(at(parts_) + 1, 0),
              .first_of_bodies = std::vector<int>(at(parts_), 0)};
  for (const int node : nodes) ++level.first_of_bodies[at(part[at(node)])];
  for (std::size_t p = 0; p < at(parts_); ++p) {
    level.first_of_bodies[p] += level.first[p];
    const auto bodies = std::count(body_part.begin(), body_part.end(), static_cast<int>(p));
    level.first[p + 1] = level.first_of_bodies[p] + 2 * static_cast<int>(bodies);
  }
  std::vector<int> next = level.first;
  for (const int node : nodes) level.of_node[at(node)] = next[at(part[at(node)])]++;
  next = level.first_of_bodies;
  for (const int p : body_part)
    level.of_body.push_back(std::exchange(next[at(p)], next[at(p)] + 2));
  return level;
}

std::vector<int> ModelDivision::blocks_in_order() const {
  std::vector<int> blocks(at(unknowns_.blocks()));
  for (std::size_t n = 0; n < mesh_.nodes.size(); ++n)
    if (const int number = fine_.of_node[n]; number >= 0)
      blocks[at(number)] = unknowns_.block_of(static_cast<int>(n));
  for (std::size_t b = 0; b < fine_.of_body.size(); ++b)
    for (int k = 0; k < 2; ++k) blocks[at(fine_.of_body[b] + k)] = unknowns_.body_block(b) + k;
  return blocks;
}

std::vector<int> ModelDivision::elements_of(int number) const {
  std::vector<int> elements;
  for (std::size_t e = 0; e < mesh_.element_count(); ++e) {
    const auto nodes = mesh_.element(e);
    if (std::any_of(nodes.begin(), nodes.end(),
                    [&](int node) { return owner_[at(node)] == number; }))
      elements.push_back(static_cast<int>(e));
  }
  return elements;
}

// In the order of the unknowns of all parts; behind them those that have none of their own.
std::vector<int> ModelDivision::nodes_of(const std::vector<int>& elements) const {
  std::vector<bool> is_here(mesh_.nodes.size(), false);
  for (const int e : elements)
    for (const int node : mesh_.element(at(e))) is_here[at(node)] = true;
  std::vector<int> nodes;
  for (std::size_t n = 0; n < is_here.size(); ++n)
    if (is_here[n]) nodes.push_back(static_cast<int>(n));
  std::stable_sort(nodes.begin(), nodes.end(), [this](int a, int b) {
    // -1 comes last as the largest number without a sign.
    return static_cast<unsigned>(fine_.of_node[at(a)]) <
           static_cast<unsigned>(fine_.of_node[at(b)]);
  });
  return nodes;
}

BlockNumbers ModelDivision::numbers_of(const Level& level, int number,
                                       const std::vector<int>& nodes) {
  const std::size_t p = at(number);
  BlockNumbers numbers{.first = level.first[p],
                       .first_of_bodies = level.first_of_bodies[p],
                       .end = level.first[p + 1],
                       .of_nodes = {},
                       .of_bodies = level.of_body};
  for (const int node : nodes)
    if (level.of_node[at(node)] >= 0) numbers.of_nodes.push_back(level.of_node[at(node)]);
  return numbers;
}

ModelPart ModelDivision::part(int number) const {
  const std::vector<int> elements = elements_of(number), nodes = nodes_of(elements);
  const std::vector<int> place = places_of(nodes, mesh_.nodes.size());
  TetMesh mesh = mesh_of(mesh_, elements, nodes, place);
  DofMap unknowns = unknowns_of(unknowns_, mesh, nodes, place);
  return {.mesh = std::move(mesh),
          .unknowns = std::move(unknowns),
          .fine = numbers_of(fine_, number, nodes),
          .corners = numbers_of(corners_, number, nodes)};
}

}  // namespace kinetostat::fea
