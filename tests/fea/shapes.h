// Solids made up for the tests, as surfaces and as volume meshes.
#pragma once

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <unistd.h>

#include "kinetostat/fea/elasticity/assembly.h"
#include "kinetostat/fea/interface/coupling.h"
#include "kinetostat/fea/mesh/primitive_surface.h"
#include "kinetostat/fea/mesh/tet_mesh.h"
#include "kinetostat/fea/surface/surface_check.h"

#include "support/temporary_folder.h"

namespace kinetostat::fea {

inline SurfaceMesh inverted(SurfaceMesh mesh) {
  for (Triangle& t : mesh.triangles) std::swap(t[1], t[2]);
  return mesh;
}

/// A tube about the z axis from z = 0 to `height`, open through; `sides` facets around.
inline SurfaceMesh tube_surface(double inner, double outer, double height, int sides) {
  SurfaceMesh mesh;
  for (int i = 0; i < sides; ++i) {
    const double angle = 2 * M_PI * i / sides;
    for (const double radius : {inner, outer})
      for (const double z : {0.0, height})
        mesh.points.emplace_back(radius * std::cos(angle), radius * std::sin(angle), z);
  }
  for (int i = 0; i < sides; ++i) {
    const int a = 4 * i, b = 4 * ((i + 1) % sides);  // +0 inner low, +1 inner high, +2, +3 outer
    const auto quad = [&mesh](int p, int q, int r, int s) {
      mesh.triangles.push_back({p, q, r});
      mesh.triangles.push_back({p, r, s});
    };
    quad(a + 2, b + 2, b + 3, a + 3);
    quad(a, a + 1, b + 1, b);
    quad(a + 1, a + 3, b + 3, b + 1);
    quad(a, b, b + 2, a + 2);
  }
  return mesh;
}

/// A box cut into nx x ny x nz cells of six tetrahedra; boundary faces tagged 1 at the lowest x, 2
/// at the highest, 0 elsewhere.
inline TetMesh box_mesh(const Vector3& size, int nx, int ny, int nz) {
  TetMesh mesh;
  const auto number = [&](int i, int j, int k) { return i + (nx + 1) * (j + (ny + 1) * k); };
  for (int k = 0; k <= nz; ++k)
    for (int j = 0; j <= ny; ++j)
      for (int i = 0; i <= nx; ++i)
        mesh.nodes.emplace_back(size.x() * i / nx, size.y() * j / ny, size.z() * k / nz);
  // Kuhn's division: one tetrahedron for each order of steps from corner 000 to corner 111.
  const int paths[6][3] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
  for (int k = 0; k < nz; ++k)
    for (int j = 0; j < ny; ++j)
      for (int i = 0; i < nx; ++i)
        for (const auto& path : paths) {
          std::array<int, 3> at{i, j, k};
          std::array<int, 4> tet{number(i, j, k), 0, 0, 0};
          for (std::size_t step = 0; step < 3; ++step) {
            ++at[static_cast<std::size_t>(path[step])];
            tet[step + 1] = number(at[0], at[1], at[2]);
          }
          const auto p = [&](std::size_t c) {
            return mesh.nodes[static_cast<std::size_t>(tet[c])];
          };
          if (volume({p(0), p(1), p(2), p(3)}) < 0) std::swap(tet[2], tet[3]);
          mesh.connectivity.insert(mesh.connectivity.end(), tet.begin(), tet.end());
        }
  const int sides[4][3] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};
  for (std::size_t e = 0; e < mesh.element_count(); ++e)
    for (const auto& side : sides) {
      BoundaryFace face{.nodes = {-1, -1, -1, -1, -1, -1}, .tag = 0};
      bool low = true, high = true;
      for (std::size_t c = 0; c < 3; ++c) {
        face.nodes[c] = mesh.element(e)[static_cast<std::size_t>(side[c])];
        const double x = mesh.nodes[static_cast<std::size_t>(face.nodes[c])].x();
        low = low && x == 0;
        high = high && x == size.x();
      }
      if (!low && !high) continue;
      face.tag = low ? 1 : 2;
      mesh.boundary.push_back(face);
    }
  return mesh;
}

/// The interfaces of a mesh whose boundary faces are tagged 1 and 2, at their centroids.
inline std::vector<CoupledInterface> coupled_ends(const TetMesh& mesh,
                                                  Coupling fixed = Coupling::rigid,
                                                  Coupling loaded = Coupling::rigid) {
  std::vector<CoupledInterface> ends;
  for (const Coupling coupling : {fixed, loaded}) {
    const Interface geometry = interface_on(mesh, static_cast<int>(ends.size()) + 1);
    ends.push_back({.name = ends.empty() ? "fixed" : "loaded",
                    .geometry = geometry,
                    .point = geometry.centroid,
                    .coupling = coupling});
  }
  return ends;
}

/// The unknowns that give these displacements of all nodes. Requires every node to be free.
inline Eigen::VectorXd values_of(const DofMap& unknowns, const Eigen::Matrix3Xd& displacements) {
  Eigen::VectorXd values(displacements.size());
  for (Eigen::Index n = 0; n < displacements.cols(); ++n)
    values.segment<3>(3 * unknowns.block_of(static_cast<int>(n))) = displacements.col(n);
  return values;
}

using test::TemporaryFolder;

/// ASCII STL of a surface, coordinates times `scale`.
inline std::string ascii_stl(const SurfaceMesh& mesh, double scale) {
  std::string text = "solid test\n";
  char line[200];
  for (std::size_t f = 0; f < mesh.triangles.size(); ++f) {
    text += "facet normal 0 0 0\nouter loop\n";
    for (std::size_t k = 0; k < 3; ++k) {
      const Vector3 p = scale * mesh.corner(f, k);
      std::snprintf(line, sizeof line, "vertex %.9g %.9g %.9g\n", p.x(), p.y(), p.z());
      text += line;
    }
    text += "endloop\nendfacet\n";
  }
  return text + "endsolid test\n";
}

inline std::string binary_stl(const SurfaceMesh& mesh, double scale) {
  std::string bytes(84, '\0');
  const auto count = static_cast<std::uint32_t>(mesh.triangles.size());
  std::memcpy(bytes.data() + 80, &count, sizeof count);
  for (std::size_t f = 0; f < mesh.triangles.size(); ++f) {
    float values[12] = {};
    for (std::size_t k = 0; k < 3; ++k)
      for (std::size_t d = 0; d < 3; ++d)
        values[3 + 3 * k + d] =
            static_cast<float>(scale * mesh.corner(f, k)[static_cast<Eigen::Index>(d)]);
    bytes.append(reinterpret_cast<const char*>(values), sizeof values);
    bytes.append(2, '\0');
  }
  return bytes;
}

}  // namespace kinetostat::fea
