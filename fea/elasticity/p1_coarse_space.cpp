#include "kinetostat/fea/elasticity/p1_coarse_space.h"

#include <algorithm>
#include <array>
#include <stdexcept>
#include <utility>

#include "kinetostat/common/index.h"

namespace kinetostat::fea {
namespace {

using common::at;

// Numbers of the corners among themselves, -1 for middle nodes.
std::vector<int> corner_numbers(const TetMesh& mesh) {
  std::vector<int> number(mesh.nodes.size(), -1);
  for (std::size_t e = 0; e < mesh.element_count(); ++e)
    for (const int node : mesh.element(e).first(4)) number[at(node)] = 0;
  int corners = 0;
  for (int& n : number)
    if (n == 0) n = corners++;
  return number;
}

TetMesh corner_mesh(const TetMesh& mesh, const std::vector<int>& number) {
  TetMesh corners{.order = 1, .materials = mesh.materials};
  for (std::size_t n = 0; n < number.size(); ++n)
    if (number[n] >= 0) corners.nodes.push_back(mesh.nodes[n]);
  corners.connectivity.reserve(4 * mesh.element_count());
  for (std::size_t e = 0; e < mesh.element_count(); ++e)
    for (const int node : mesh.element(e).first(4))
      corners.connectivity.push_back(number[at(node)]);
  corners.contacts = mesh.contacts;  // with linear displacements, but the same traces
  return corners;
}

// That of a middle node goes to the ends of its edge, half to each.
std::vector<GroundSpring> corner_springs(const TetMesh& mesh, const DofMap& unknowns,
                                         const std::vector<int>& number) {
  std::vector<GroundSpring> springs;
  std::vector<std::array<int, 2>> ends;
  for (const GroundSpring& spring : unknowns.springs()) {
    if (const int corner = number[at(spring.node)]; corner >= 0) {
      springs.push_back({corner, spring.stiffness});
      continue;
    }
    if (ends.empty()) ends = edge_ends(mesh);
    for (const int end : ends[at(spring.node)])
      springs.push_back({number[at(end)], 0.5 * spring.stiffness});
  }
  return springs;
}

DofMap corner_unknowns(const TetMesh& mesh, const TetMesh& corners, const DofMap& unknowns,
                       const std::vector<int>& number) {
  std::vector<int> fixed;
  for (std::size_t n = 0; n < number.size(); ++n)
    if (number[n] >= 0 && unknowns.is_fixed(static_cast<int>(n))) fixed.push_back(number[n]);
  std::vector<ReferenceBody> bodies;
  for (const ReferenceBody& body : unknowns.bodies()) {
    bodies.push_back({body.point, {}});
    for (const int node : body.nodes)
      if (const int corner = number[at(node)]; corner >= 0) bodies.back().nodes.push_back(corner);
  }
  DofMap coarse(corners, fixed, std::move(bodies), unknowns.order());
  coarse.set_springs(corner_springs(mesh, unknowns, number));
  return coarse;
}

// work(b) for every block, some thousands at a time.
template <class Work>
void in_pieces(int blocks, common::ThreadPool& pool, const Work& work) {
  constexpr int at_once = 2048;
  pool.for_each((blocks + at_once - 1) / at_once, [&](int piece) {
    for (int b = piece * at_once; b < std::min((piece + 1) * at_once, blocks); ++b) work(b);
  });
}

}  // namespace

std::vector<std::array<int, 2>> edge_ends(const TetMesh& mesh) {
  std::vector<std::array<int, 2>> ends(mesh.nodes.size(), {-1, -1});
  for (std::size_t e = 0; e < mesh.element_count(); ++e) {
    const auto tet = mesh.element(e);
    for (std::size_t c = 0; c < 4; ++c) ends[at(tet[c])] = {tet[c], tet[c]};
    for (std::size_t edge = 0; edge < tet_edges.size(); ++edge) {
      const auto [a, b] = tet_edges[edge];
      ends[at(tet[4 + edge])] = {tet[at(a)], tet[at(b)]};
    }
  }
  return ends;
}

P1CoarseSpace p1_coarse_space(const TetMesh& mesh, const DofMap& unknowns) {
  if (mesh.order != 2) throw std::invalid_argument("p1_coarse_space: the mesh has no middle nodes");
  const std::vector<int> number = corner_numbers(mesh);
  TetMesh corners = corner_mesh(mesh, number);
  DofMap coarse = corner_unknowns(mesh, corners, unknowns, number);
  return {std::move(corners), std::move(coarse)};
}

Prolongation::Prolongation(const TetMesh& mesh, const DofMap& fine, const DofMap& coarse)
    : parent_(2 * at(fine.blocks()), -1), child_start_(at(coarse.blocks()) + 1, 0) {
  const std::vector<int> number = corner_numbers(mesh);
  const std::vector<std::array<int, 2>> ends = edge_ends(mesh);
  for (std::size_t n = 0; n < mesh.nodes.size(); ++n) {
    const int block = fine.block_of(static_cast<int>(n));
    if (block < 0 || ends[n][0] < 0) continue;
    for (std::size_t k = 0; k < 2; ++k) {
      const int corner = number[at(ends[n][k])];
      if (const int body = coarse.body_of(corner); body >= 0) {
        const auto b = at(body);
        const Vector3 arm = mesh.nodes[at(ends[n][k])] - coarse.bodies()[b].point;
        body_links_.push_back({block, coarse.body_block(b), 0.5 * spatial::rigid_motion(arm)});
      } else {
        parent_[2 * at(block) + k] = coarse.block_of(corner);
      }
    }
  }
  for (int b = 0; b < 2 * static_cast<int>(fine.bodies().size()); ++b)
    for (std::size_t k = 0; k < 2; ++k)
      parent_[2 * at(fine.node_blocks() + b) + k] = coarse.node_blocks() + b;

  for (const int parent : parent_)
    if (parent >= 0) ++child_start_[at(parent) + 1];
  for (std::size_t b = 1; b < child_start_.size(); ++b) child_start_[b] += child_start_[b - 1];
  child_.resize(at(child_start_.back()));
  std::vector<int> next(child_start_.begin(), child_start_.end() - 1);
  for (std::size_t i = 0; i < parent_.size(); ++i)
    if (parent_[i] >= 0) child_[at(next[at(parent_[i])]++)] = static_cast<int>(i / 2);
}

void Prolongation::visit_parts(const std::function<void(int, int, const Matrix3&)>& visit) const {
  for (std::size_t i = 0; i < parent_.size(); ++i)
    if (parent_[i] >= 0) visit(static_cast<int>(i / 2), parent_[i], 0.5 * Matrix3::Identity());
  for (const BodyLink& link : body_links_) {
    visit(link.block, link.body_block, link.half_motion.leftCols<3>());
    visit(link.block, link.body_block + 1, link.half_motion.rightCols<3>());
  }
}

void Prolongation::prolong(const MultiVector& coarse, MultiVector& fine,
                           common::ThreadPool& pool) const {
  const int blocks = static_cast<int>(parent_.size() / 2);
  in_pieces(blocks, pool, [&](int b) {
    Lanes* out = fine.data() + std::ptrdiff_t{3} * b;
    for (int a = 0; a < 3; ++a) out[a] = Lanes{};
    for (int k = 0; k < 2; ++k) {
      const int parent = parent_[at(2 * b + k)];
      if (parent < 0) continue;
      for (int a = 0; a < 3; ++a)
        for (int lane = 0; lane < lane_count; ++lane)
          out[a].v[lane] += 0.5 * coarse[at(3 * parent + a)].v[lane];
    }
  });
  for (const BodyLink& link : body_links_)
    for (int a = 0; a < 3; ++a)
      for (int c = 0; c < 6; ++c)
        for (int lane = 0; lane < lane_count; ++lane)
          fine[at(3 * link.block + a)].v[lane] +=
              link.half_motion(a, c) * coarse[at(3 * link.body_block + c)].v[lane];
}

void Prolongation::restrict(const MultiVector& fine, MultiVector& coarse,
                            common::ThreadPool& pool) const {
  in_pieces(coarse_blocks(), pool, [&](int b) {
    Lanes* out = coarse.data() + std::ptrdiff_t{3} * b;
    for (int a = 0; a < 3; ++a) out[a] = Lanes{};
    for (int k = child_start_[at(b)]; k < child_start_[at(b) + 1]; ++k)
      for (int a = 0; a < 3; ++a)
        for (int lane = 0; lane < lane_count; ++lane)
          out[a].v[lane] += 0.5 * fine[at(3 * child_[at(k)] + a)].v[lane];
  });
  for (const BodyLink& link : body_links_)
    for (int a = 0; a < 3; ++a)
      for (int c = 0; c < 6; ++c)
        for (int lane = 0; lane < lane_count; ++lane)
          coarse[at(3 * link.body_block + c)].v[lane] +=
              link.half_motion(a, c) * fine[at(3 * link.block + a)].v[lane];
}

RigidPoints rigid_points(const TetMesh& mesh, const DofMap& unknowns) {
  RigidPoints points{.points = std::vector<Vector3>(at(unknowns.node_blocks())),
                     .bodies = static_cast<int>(unknowns.bodies().size())};
  for (std::size_t n = 0; n < mesh.nodes.size(); ++n)
    if (const int block = unknowns.block_of(static_cast<int>(n)); block >= 0)
      points.points[at(block)] = mesh.nodes[n];
  for (const ReferenceBody& body : unknowns.bodies()) points.points.push_back(body.point);
  return points;
}

}  // namespace kinetostat::fea
