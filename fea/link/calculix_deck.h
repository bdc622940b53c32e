// The finite-element model of a link as a CalculiX deck, for checking by an independent program.
#pragma once

#include <string>
#include <vector>

#include "kinetostat/fea/elasticity/elasticity.h"
#include "kinetostat/fea/interface/coupling.h"
#include "kinetostat/fea/mesh/tet_mesh.h"

namespace kinetostat::fea {

/// The exact model that respond() solves, in SI units: the same elements, materials and couplings,
/// one *STATIC step per unit wrench on the loaded interfaces, in their order and that of Fx Fy Fz
/// Mx My Mz. A rigid loaded interface is a *RIGID BODY; the motion of a distributing one is tied to
/// its reference nodes by *EQUATION, which makes a load on them act as it must; the fixed interface
/// is held by *BOUNDARY or by equations. Every step prints the displacements of two nodes per
/// loaded interface to the .dat file: the translation of its point, then its rotation. `mesh`
/// includes bodies grown on the interfaces.
std::string calculix_deck(const std::string& title, const TetMesh& mesh,
                          const std::vector<Material>& materials,
                          const std::vector<CoupledInterface>& interfaces);

/// The flexibility, 6m x 6m for m loaded interfaces, from the .dat file that CalculiX writes for
/// such a deck. Throws std::runtime_error when the text does not hold 2 m rows for each of 6 m
/// steps.
Eigen::MatrixXd read_calculix_flexibility(const std::string& dat, int loaded_interfaces);

}  // namespace kinetostat::fea
