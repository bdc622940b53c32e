// A link on the meshes that its link file asks for, whatever is computed on them.
#pragma once

#include <functional>

#include "kinetostat/fea/link/link_geometry.h"
#include "kinetostat/fea/link/refinement.h"

namespace kinetostat::fea {

/// What is computed on a mesh: a flexibility and the fields that it comes from. The model has no
/// response yet.
using Respond = std::function<LinkResponse(const LinkModel& model)>;

struct LinkModelOptions {
  TetrahedralizeOptions meshing = {};  // edge_length and sizes are set from the link file
  RefinementOptions refinement = {};   // accuracy is set from the link file
  int threads = 1;                     // of the error estimate
};

/// On one mesh where the link file gives its size or the mesh itself, else refined to its accuracy.
/// `mesher` is one of `geometry`. Throws what fill() does, and what `respond` does,
/// explained.
RefinedModel model_as_asked(const LinkSpec& spec, const LinkGeometry& geometry, LinkMesher& mesher,
                            const Respond& respond, const LinkModelOptions& options,
                            common::Progress& progress);

/// Calls work(), which computes on this mesh: those of its ways to fail that the user can repair
/// become common::InputError and common::OutOfMemory with the link file and the cure.
void explained(const LinkSpec& spec, const TetMesh& mesh, const std::function<void()>& work);

}  // namespace kinetostat::fea
