#include "kinetostat/fea/link/link_model.h"

#include <new>

#include <fmt/format.h>

#include "kinetostat/common/out_of_memory.h"
#include "kinetostat/fea/interface/stiff_body.h"
#include "kinetostat/fea/link/geometric_stiffness.h"

namespace kinetostat::fea {
namespace {

LinkModel model_on(const LinkSpec& spec, const LinkGeometry& geometry, LinkMesher& mesher,
                   const Respond& respond, const TetrahedralizeOptions& meshing,
                   common::Progress& progress) {
  LinkModel model{.mesh = fill(spec, geometry, mesher, meshing, progress),
                  .materials = materials_of(spec)};
  model.interfaces = interfaces_on(spec, model.mesh);
  explained(spec, model.mesh, [&] { model.response = respond(model); });
  return model;
}

}  // namespace

RefinedModel model_as_asked(const LinkSpec& spec, const LinkGeometry& geometry, LinkMesher& mesher,
                            const Respond& respond, const LinkModelOptions& options,
                            common::Progress& progress) {
  TetrahedralizeOptions meshing = options.meshing;
  if (spec.size || geometry.is_meshed()) {
    meshing.edge_length = spec.size.value_or(0);
    LinkModel model = model_on(spec, geometry, mesher, respond, meshing, progress);
    progress.report("error estimate", 0);
    Accuracy accuracy = accuracy_of(model, options.threads);
    return {.model = std::move(model), .accuracy = std::move(accuracy)};
  }
  const Solve solve = [&](const SizeField& sizes) {
    meshing.sizes = sizes;
    LinkModel model = model_on(spec, geometry, mesher, respond, meshing, progress);
    // The next ones: there are about five unknowns for each element, and a mesher may overshoot.
    meshing.most_elements = options.refinement.most_unknowns / 2;
    return model;
  };
  RefinementOptions refinement = options.refinement;
  refinement.accuracy = spec.accuracy;
  refinement.threads = options.threads;
  return refine(solve, first_sizes(geometry), refinement, progress);
}

void explained(const LinkSpec& spec, const TetMesh& mesh, const std::function<void()>& work) {
  using common::InputError;
  try {
    work();
  } catch (const NoStiffBody& error) {
    throw InputError(spec.file, error.what(), "Use another coupling for it");
  } catch (const BeyondBuckling& error) {
    throw InputError(spec.file, error.what(), "Use a smaller preload");
  } catch (const SingularStiffness& error) {
    throw InputError(spec.file, error.what(),
                     "Is the body in one piece and the fixed interface a proper face of it?");
  } catch (const MemoryLimit& error) {
    throw common::OutOfMemory(
        error.what(), "Use a larger element size, ask for less accuracy, or allow more (--memory)",
        spec.file.string());
  } catch (const PetscFailure& error) {
    throw InputError(spec.file, error.what(), "Use another solver (--solver)");
  } catch (const common::OutOfMemory&) {
    throw;
  } catch (const std::bad_alloc&) {
    throw common::OutOfMemory(
        fmt::format("{} nodes need more memory than there is", mesh.nodes.size()),
        "Use a larger element size, or ask for less accuracy", spec.file.string());
  }
}

}  // namespace kinetostat::fea
