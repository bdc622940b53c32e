// How probable readings are under a model whose values are known only roughly beforehand.
#pragma once

#include "kinetostat/calibration/regression/base_fit.h"

namespace kinetostat::calibration {

/// The prior width of a value whose scale is unknown: it enters a fit so many times wider than it
/// usually is.
inline constexpr double widest_prior = 3;

/// Power-posterior exponent t = min(1, (n - p) / |r|^2): the weight that is left to the readings
/// when the misfit r of a model is all noise.
double exponent_of(const BaseFit& fit);

/// Cost that a fit minimises: |r|^2 + sum over k of ((x_k - m_k) / s_k)^2, squared error and the
/// penalty of priors with mean m and deviation s.
double penalised_error(const BaseFit& fit);

struct Evidence {
  double log = 0;               // up to a constant that all models of the readings share
  Eigen::VectorXd information;  // of the priors at their most probable scale; 0: no prior
};

/// How large effects may be: log-uniform from a ten-thousandth of the usual size to three times it,
/// or to three hundred times.
enum class Sizes { usual, any };

/// Laplace's approximation of the logarithm of the evidence, with the power-posterior exponent t =
/// `exponent`:
///
///   log E(g) = -t/2 |r|^2 - 1/2 d'P d + 1/2 b'A^-1 b + 1/2 log det P - 1/2 log det A
///   A = t J'J + P,   P = diag(1 / (g s_k)^2),   d_k = x_k - m_k,   b = (t P_0 - P) d
///   log E = log of the mean of E(g) over the scales g of each group in turn
///
/// with b limited to the pull -t J'r of the readings, and b'A^-1 b - d'P d to what the values can
/// explain of r at all: no evidence exceeds the best fit of the readings alone.
///
/// r: whitened residual at the best fit x; J: its Jacobian; m_k, s_k: mean and usual deviation of
/// the prior of x_k; P_0: the P of the fit itself; det P is over the values that have a prior. b
/// has no entry for values that a bound holds. A value at the end of its range costs 5, and a
/// one-sided range adds ln 2.
///
/// Parameters that are fitted under every model have a flat prior and the same units everywhere, so
/// their constants cancel between models. The size of an effect is not known within a factor of ten
/// beforehand: the priors of one group (Parameter::Prior) share the scale g, which is log-uniform.
/// A normal prior of fixed width would prefer whatever kind of effect is usually too small to be
/// seen (Bartlett's paradox; Liang, Paulo, Molina, Clyde and Berger, Mixtures of g priors, 2008).
Evidence evidence(const BaseFit& fit, double exponent, Sizes sizes = Sizes::usual);

/// log((1/n) sum of exp(x_i)) of the logarithms x_i.
double log_mean_exp(const std::vector<double>& logs);

}  // namespace kinetostat::calibration
