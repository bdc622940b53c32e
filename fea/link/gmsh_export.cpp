#include "kinetostat/fea/link/gmsh_export.h"

#include <algorithm>
#include <iterator>

#include <fmt/format.h>

#include "kinetostat/common/index.h"
#include "kinetostat/common/printable.h"

namespace kinetostat::fea {
namespace {

using common::at;

// Gmsh's element types and its order of nodes: the last two mid nodes change places.
constexpr int triangle3 = 2, tetrahedron4 = 4, triangle6 = 9, tetrahedron10 = 11;
constexpr std::size_t tetrahedron_order[] = {0, 1, 2, 3, 4, 5, 6, 7, 9, 8};

int material_count(const TetMesh& mesh) {
  return mesh.materials.empty()
             ? 1
             : 1 + *std::max_element(mesh.materials.begin(), mesh.materials.end());
}

}  // namespace

std::string gmsh_mesh(const TetMesh& mesh, const std::vector<CoupledInterface>& interfaces) {
  std::string text = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n";
  const auto out = std::back_inserter(text);
  const int materials = material_count(mesh), faces = static_cast<int>(interfaces.size());
  fmt::format_to(out, "{}\n", materials + faces);
  for (int i = 0; i < faces; ++i)
    fmt::format_to(out, "2 {} \"{}\"\n", i + 1, common::plain_name(interfaces[at(i)].name, "\""));
  for (int m = 0; m < materials; ++m)
    fmt::format_to(out, "3 {} \"{}\"\n", faces + m + 1,
                   m == 0 ? std::string("link") : fmt::format("body {}", m));
  fmt::format_to(out, "$EndPhysicalNames\n$Nodes\n{}\n", mesh.nodes.size());
  for (std::size_t n = 0; n < mesh.nodes.size(); ++n)
    fmt::format_to(out, "{} {} {} {}\n", n + 1, mesh.nodes[n].x(), mesh.nodes[n].y(),
                   mesh.nodes[n].z());

  std::string elements;
  const auto list = std::back_inserter(elements);
  std::size_t count = 0;
  for (const BoundaryFace& face : mesh.boundary) {
    const auto group = std::find_if(interfaces.begin(), interfaces.end(),
                                    [&](const auto& i) { return i.geometry.tag == face.tag; });
    if (group == interfaces.end()) continue;
    const auto tag = group - interfaces.begin() + 1;
    fmt::format_to(list, "{} {} 2 {} {}", ++count, mesh.order == 2 ? triangle6 : triangle3, tag,
                   tag);
    for (std::size_t k = 0; k < mesh.nodes_per_face(); ++k)
      fmt::format_to(list, " {}", face.nodes[k] + 1);
    elements += '\n';
  }
  for (std::size_t e = 0; e < mesh.element_count(); ++e) {
    const int tag = faces + 1 + static_cast<int>(mesh.material_of(e));
    fmt::format_to(list, "{} {} 2 {} {}", ++count, mesh.order == 2 ? tetrahedron10 : tetrahedron4,
                   tag, tag);
    for (std::size_t k = 0; k < mesh.nodes_per_element(); ++k)
      fmt::format_to(list, " {}", mesh.element(e)[tetrahedron_order[k]] + 1);
    elements += '\n';
  }
  fmt::format_to(out, "$EndNodes\n$Elements\n{}\n", count);
  return text + elements + "$EndElements\n";
}

}  // namespace kinetostat::fea
