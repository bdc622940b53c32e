// How probable readings are under a model whose values are known only roughly beforehand.
#pragma once

#include "kinetostat/calibration/regression/base_fit.h"

namespace kinetostat::calibration {

/// The prior width of a value whose scale is unknown: it enters a fit so many times wider than it
/// usually is.
inline constexpr double widest_prior = 3;

/// How much of the readings' weight is left when the misfit of a model is all noise: 1, or less.
double temper_of(const BaseFit& fit);

/// What a fit minimises: squared error and the penalty of its priors.
double penalised_error(const BaseFit& fit);

struct Evidence {
  double log = 0;               // up to a constant that all models of the readings share
  Eigen::VectorXd information;  // of the priors at their most probable scale; 0: no prior
};

/// How large effects may be: log-uniform from a ten-thousandth of the usual size to three times it,
/// or to three hundred times.
enum class Sizes { usual, any };

/// Laplace's approximation of the evidence, the readings counting for `temper`. What is refitted
/// under every model has a flat prior and the same units everywhere, so its constants cancel
/// between models. Nobody knows beforehand within a factor of ten how large an effect is: the
/// priors of one group (Parameter::Prior) share a scale that is log-uniform, and is averaged over;
/// a normal prior of fixed width would prefer whatever kind of effect is usually too small to be
/// seen (Bartlett's paradox; Liang, Paulo, Molina, Clyde and Berger, Mixtures of g priors, 2008).
Evidence evidence(const BaseFit& fit, double temper, Sizes sizes = Sizes::usual);

/// Logarithm of the mean of what the logarithms stand for.
double log_mean_exp(const std::vector<double>& logs);

}  // namespace kinetostat::calibration
