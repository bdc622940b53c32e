// Effect of the clamping assumption, lower and upper bound: the same mesh with the stiffest and the
// softest coupling.
#pragma once

#include <vector>

#include "kinetostat/fea/link/link_response.h"

namespace kinetostat::fea {

/// Flexibilities (LinkResponse), made symmetric, with all interfaces rigid and with all of them
/// distributing. Real fastenings that carry the whole interface lie between: the difference has no
/// negative eigenvalue. So each diagonal entry lies between its two bounds; an entry off the
/// diagonal need not.
struct CouplingBracket {
  Eigen::MatrixXd rigid, distributing;
};

/// `response` is that of the same model with the couplings in `interfaces`, which saves one of the
/// two solutions when they are all rigid or all distributing. Throws what respond() throws.
CouplingBracket coupling_bracket(const TetMesh& mesh, const std::vector<Material>& materials,
                                 const std::vector<CoupledInterface>& interfaces,
                                 const LinkResponse& response, const SolverOptions& options,
                                 common::Progress& progress);

}  // namespace kinetostat::fea
