// The bar of the acceptance test: 310 x 20 x 12 mm of steel along x, root held, tip rigid.
#pragma once

#include "kinetostat/fea/link/link_response.h"
#include "kinetostat/fea/mesh/tetrahedralize.h"

#include "fea/shapes.h"

namespace kinetostat::fea {

struct ReferenceBar {
  static constexpr double length = 0.31, width = 0.02, height = 0.012;  // along x, y, z [m]
  Material steel{210e9, 0.3};
  Vector3 tip{length, 0, 0};
  TetMesh mesh;

  explicit ReferenceBar(double size) {
    const SurfaceMesh surface =
        box_surface({0, -width / 2, -height / 2}, {length, width / 2, height / 2});
    std::vector<int> tags(12, 0);
    tags[8] = tags[9] = 1;
    tags[10] = tags[11] = 2;
    TetrahedralizeOptions options;
    options.edge_length = size;
    options.helper = KINETOSTAT_TETGEN;
    common::Progress silent;
    mesh = with_mid_nodes(tetrahedralize(surface, tags, options, silent));
  }

  Matrix6 compliance() const {
    common::Progress silent;
    std::vector<CoupledInterface> ends = coupled_ends(mesh);
    ends[1].point = tip;
    return respond(mesh, {steel}, ends, {}, silent).compliance();
  }
};

}  // namespace kinetostat::fea
