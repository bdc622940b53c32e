#include "kinetostat/apps/helpers/petsc/request_file.h"

#include <utility>

#include "kinetostat/common/index.h"
#include "kinetostat/fea/elasticity/petsc_protocol.h"

namespace kinetostat::petsc {
namespace {

using common::at;
using fea::petsc::Request;

std::vector<fea::ReferenceBody> bodies_of(const Request& request) {
  std::vector<fea::ReferenceBody> bodies;
  auto node = request.body_nodes.begin();
  for (std::size_t b = 0; b < request.body_sizes.size(); ++b) {
    const auto end = node + request.body_sizes[b];
    bodies.push_back({fea::Vector3(request.body_points.data() + 3 * b), {node, end}});
    node = end;
  }
  return bodies;
}

fea::TetMesh mesh_of(Request& request) {
  fea::TetMesh mesh{.order = request.shape.at(0),
                    .connectivity = std::move(request.connectivity),
                    .materials = std::move(request.element_materials),
                    .curved = request.shape.at(1) != 0};
  mesh.nodes.reserve(request.nodes.size() / 3);
  for (std::size_t n = 0; n + 2 < request.nodes.size(); n += 3)
    mesh.nodes.emplace_back(request.nodes.data() + n);
  return mesh;
}

fea::DofMap unknowns_of(const Request& request, const fea::TetMesh& mesh) {
  fea::DofMap unknowns(mesh, request.fixed, bodies_of(request));
  std::vector<fea::GroundSpring> springs;
  for (std::size_t s = 0; s < request.spring_nodes.size(); ++s)
    springs.push_back({request.spring_nodes[s], fea::Matrix3(request.springs.data() + 9 * s)});
  unknowns.set_springs(std::move(springs));
  return unknowns;
}

}  // namespace

WholeModel RequestFile::model() {
  Request request;
  std::uint64_t values = 0;
  if (!read(file_, request) || request.shape.size() != 2) throw BadRequest();
  fea::TetMesh mesh = mesh_of(request);
  std::vector<fea::Material> materials;
  for (std::size_t m = 0; m + 1 < request.materials.size(); m += 2)
    materials.emplace_back(request.materials[m], request.materials[m + 1]);
  fea::DofMap unknowns = unknowns_of(request, mesh);
  unknowns_ = 3 * at(unknowns.blocks());
  if (unknowns_ == 0 || !common::take_count(file_, sizeof(double), values) ||
      values % unknowns_ != 0)
    throw BadRequest();
  columns_ = static_cast<int>(values / unknowns_);
  return {std::move(mesh), std::move(materials), std::move(unknowns)};
}

std::vector<double> RequestFile::next_column() {
  std::vector<double> column(unknowns_);
  if (!file_.read(reinterpret_cast<char*>(column.data()),
                  static_cast<std::streamsize>(sizeof(double) * unknowns_)))
    throw BadRequest();
  return column;
}

}  // namespace kinetostat::petsc
