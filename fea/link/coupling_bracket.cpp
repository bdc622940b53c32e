#include "kinetostat/fea/link/coupling_bracket.h"

#include <algorithm>

namespace kinetostat::fea {

CouplingBracket coupling_bracket(const TetMesh& mesh, const std::vector<Material>& materials,
                                 const std::vector<CoupledInterface>& interfaces,
                                 const LinkResponse& response, const SolverOptions& options,
                                 common::Progress& progress) {
  const auto with = [&](Coupling coupling) -> Eigen::MatrixXd {
    const bool is_known = std::all_of(interfaces.begin(), interfaces.end(), [&](const auto& i) {
      return i.coupling == coupling || i.coupling == Coupling::elastic;
    });
    std::vector<CoupledInterface> all = interfaces;
    for (CoupledInterface& interface : all)
      if (interface.coupling != Coupling::elastic) interface.coupling = coupling;
    const Eigen::MatrixXd raw = is_known
                                    ? response.flexibility
                                    : respond(mesh, materials, all, options, progress).flexibility;
    return 0.5 * (raw + raw.transpose());
  };
  return {.rigid = with(Coupling::rigid), .distributing = with(Coupling::distributing)};
}

}  // namespace kinetostat::fea
