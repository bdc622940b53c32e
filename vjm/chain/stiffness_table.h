// A drive whose stiffness depends on where it stands: a ball screw, a telescope.
#pragma once

#include <vector>

#include "kinetostat/vjm/chain/coordinate_law.h"

namespace kinetostat::vjm {

/// Stiffness of a joint at a few commands, between which its compliance is linear (that of a screw
/// grows with its free length, ISO 3408-4) and beyond which it stays:
///
///   1/k(u) = (1 - t) / k_i + t / k_(i+1),   t = (u - u_i) / (u_(i+1) - u_i).
class StiffnessTable {
 public:
  /// Commands [m or rad], ascending, and stiffnesses [N/m or N m/rad]. Throws std::invalid_argument
  /// unless there are as many of both, two or more, the former ascending, the latter positive.
  StiffnessTable(std::vector<double> commands, const std::vector<double>& stiffness);
  double at(double command) const;

 private:
  std::vector<double> commands_, compliance_;
};

/// What a joint's spring lacks to the stiffness of a table: with the spring k0 = k(u0) at the
/// command u0, F = (k(u) / k0 - 1) k d for a deflection d. A factor on the spring is one on all.
class TabulatedStiffness : public CoordinateLaw {
 public:
  TabulatedStiffness(StiffnessTable table, double at_spring);
  Value at(const JointState& joint) const override;
  double energy(const JointState& joint) const override;

 private:
  double more(const JointState& joint) const;

  StiffnessTable table_;
  double of_spring_;
};

}  // namespace kinetostat::vjm
