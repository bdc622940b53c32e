// Identifiability of the unknowns of a fit, in sentences.
#pragma once

#include <string>
#include <vector>

#include "kinetostat/calibration/statistics/least_squares.h"

namespace kinetostat::calibration {

/// Relative size below which a sensitivity is nothing but rounding of the equilibrium.
inline constexpr double sensitivity_rounding = 1e-9;

/// An unknown of a fit as it is called in sentences.
struct UnknownName {
  std::string phrase;         // "the stiffness of 'leg'"
  bool is_parameter = false;  // of the model; else a zero offset or a frame of a session
  bool is_logarithm = false;  // a change of it is a factor
  std::string unit = {};      // SI, where it is no logarithm
  double typical = 1;         // size of a change that is worth knowing, in SI (or of a logarithm)
};

/// Indices of columns that depend linearly on earlier independent columns: residual norm after
/// projection below `least` (one entry a column).
std::vector<Eigen::Index> made_up_by_those_before(const Eigen::MatrixXd& columns,
                                                  const Eigen::VectorXd& least);

/// Throws common::NotIdentifiable naming the unknowns among `free` that no residual depends on, or
/// a combination of them that changes none. `scale`: norm of the readings, in units of their noise.
void require_identifiable(const std::vector<UnknownName>& names, const Eigen::MatrixXd& jacobian,
                          const std::vector<Eigen::Index>& free, double scale);

/// One sentence for each weak combination: who can be traded for whom, by how much, within one
/// standard deviation of the fit. `deviation`: of a whitened residual, 1 when the noise is known.
std::vector<std::string> weak_sentences(const std::vector<UnknownName>& names,
                                        const std::vector<WeakCombination>& weak, double deviation);

}  // namespace kinetostat::calibration
