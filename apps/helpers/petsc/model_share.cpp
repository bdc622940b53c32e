#include "kinetostat/apps/helpers/petsc/model_share.h"

#include <stdexcept>
#include <string>
#include <utility>

#include "kinetostat/apps/helpers/petsc/processes.h"
#include "kinetostat/common/byte_blocks.h"

namespace kinetostat::petsc {
namespace {

using fea::BlockNumbers;
using fea::DofMap;
using fea::ModelPart;

// A share as plain arrays, for a message.
struct Message {
  std::vector<int> sizes;  // order, curved, unknowns and those of the corners, first blocks
  std::vector<fea::Vector3> nodes;
  std::vector<int> connectivity, element_materials, fixed;
  std::vector<double> materials;  // modulus [Pa], Poisson's ratio
  std::vector<fea::Vector3> body_points;
  std::vector<int> body_sizes, body_nodes;
  std::vector<fea::GroundSpring> springs;
  std::vector<int> fine_nodes, fine_bodies, corner_nodes, corner_bodies;
};

template <class Work>
auto with_blocks(Message& m, const Work& work) {
  return work(m.sizes, m.nodes, m.connectivity, m.element_materials, m.fixed, m.materials,
              m.body_points, m.body_sizes, m.body_nodes, m.springs, m.fine_nodes, m.fine_bodies,
              m.corner_nodes, m.corner_bodies);
}

void add_unknowns(const DofMap& unknowns, std::size_t nodes, Message& message) {
  for (int n = 0; n < static_cast<int>(nodes); ++n)
    if (unknowns.is_fixed(n)) message.fixed.push_back(n);
  for (const fea::ReferenceBody& body : unknowns.bodies()) {
    message.body_points.push_back(body.point);
    message.body_sizes.push_back(static_cast<int>(body.nodes.size()));
    message.body_nodes.insert(message.body_nodes.end(), body.nodes.begin(), body.nodes.end());
  }
  message.springs = unknowns.springs();
}

std::string bytes_of(ModelShare share) {
  ModelPart& part = share.part;
  const BlockNumbers &fine = part.fine, &corners = part.corners;
  Message message{.sizes = {part.mesh.order, part.mesh.curved ? 1 : 0, share.unknowns,
                            share.corner_unknowns, fine.first, fine.first_of_bodies, fine.end,
                            corners.first, corners.first_of_bodies, corners.end},
                  .nodes = std::move(part.mesh.nodes),
                  .connectivity = std::move(part.mesh.connectivity),
                  .element_materials = std::move(part.mesh.materials),
                  .fixed = {},
                  .materials = {},
                  .body_points = {},
                  .body_sizes = {},
                  .body_nodes = {},
                  .springs = {},
                  .fine_nodes = std::move(part.fine.of_nodes),
                  .fine_bodies = fine.of_bodies,
                  .corner_nodes = std::move(part.corners.of_nodes),
                  .corner_bodies = corners.of_bodies};
  for (const fea::Material& material : share.materials)
    message.materials.insert(message.materials.end(), {material.young(), material.poisson()});
  add_unknowns(part.unknowns, message.nodes.size(), message);
  return with_blocks(message, [](auto&... blocks) { return common::encode_blocks(blocks...); });
}

DofMap unknowns_of(Message& message, const fea::TetMesh& mesh) {
  std::vector<fea::ReferenceBody> bodies;
  auto node = message.body_nodes.begin();
  for (std::size_t b = 0; b < message.body_points.size(); ++b) {
    const auto end = node + message.body_sizes[b];
    bodies.push_back({message.body_points[b], {node, end}});
    node = end;
  }
  DofMap unknowns(mesh, message.fixed, std::move(bodies), fea::BlockOrder::as_nodes);
  unknowns.set_springs(std::move(message.springs));
  return unknowns;
}

ModelShare share_of(std::string bytes) {
  Message message;
  if (!with_blocks(message,
                   [&](auto&... blocks) { return common::decode_blocks(bytes, blocks...); }))
    throw std::runtime_error("a part of the model came in pieces");
  bytes = {};
  const std::vector<int>& size = message.sizes;
  fea::TetMesh mesh{.order = size[0],
                    .nodes = std::move(message.nodes),
                    .connectivity = std::move(message.connectivity),
                    .materials = std::move(message.element_materials),
                    .curved = size[1] != 0};
  DofMap unknowns = unknowns_of(message, mesh);
  std::vector<fea::Material> materials;
  for (std::size_t m = 0; m + 1 < message.materials.size(); m += 2)
    materials.emplace_back(message.materials[m], message.materials[m + 1]);
  return {.part = {.mesh = std::move(mesh),
                   .unknowns = std::move(unknowns),
                   .fine = {size[4], size[5], size[6], std::move(message.fine_nodes),
                            std::move(message.fine_bodies)},
                   .corners = {size[7], size[8], size[9], std::move(message.corner_nodes),
                               std::move(message.corner_bodies)}},
          .materials = std::move(materials),
          .columns = {},
          .unknowns = size[2],
          .corner_unknowns = size[3]};
}

}  // namespace

ModelShare share_model(RequestFile& request) {
  if (rank() != 0) return share_of(receive(0));
  const WholeModel whole = request.model();
  const fea::ModelDivision division(whole.mesh, whole.unknowns, processes());
  const auto share = [&](int process) -> ModelShare {
    return {.part = division.part(process),
            .materials = whole.materials,
            .columns = {},
            .unknowns = 3 * whole.unknowns.blocks(),
            .corner_unknowns = 3 * division.corner_blocks()};
  };
  for (int process = 1; process < processes(); ++process) send(bytes_of(share(process)), process);
  ModelShare own = share(0);
  own.columns = ColumnExchange(division.blocks_in_order(), division.first_blocks());
  return own;
}

}  // namespace kinetostat::petsc
