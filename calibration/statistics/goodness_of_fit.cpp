#include "kinetostat/calibration/statistics/goodness_of_fit.h"

#include <algorithm>
#include <cmath>

#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/fisher_f.hpp>

namespace kinetostat::calibration {

using boost::math::cdf;
using boost::math::complement;
using boost::math::quantile;

namespace {

// Whether the chance of a smaller chi-square, at most x^a / gamma(a + 1) for half of it and of its
// degrees of freedom, is below all numbers: the library's own way to it then overflows.
bool is_never_smaller(double statistic, double degrees_of_freedom) {
  const double x = statistic / 2, a = degrees_of_freedom / 2;
  return a * std::log(x) - std::lgamma(a + 1) < -800;
}

}  // namespace

double chance_of_larger_chi_square(double statistic, double degrees_of_freedom) {
  if (is_never_smaller(statistic, degrees_of_freedom)) return 1;
  return cdf(complement(boost::math::chi_squared(degrees_of_freedom), statistic));
}

double chance_of_larger_f(double f, double degrees_of_freedom, double degrees_of_freedom_below) {
  return cdf(complement(boost::math::fisher_f(degrees_of_freedom, degrees_of_freedom_below), f));
}

ChiSquareTest chi_square_test(double statistic, Eigen::Index degrees_of_freedom, double level) {
  const auto n = static_cast<double>(degrees_of_freedom);
  const boost::math::chi_squared distribution(n);
  return {.statistic = statistic,
          .degrees_of_freedom = degrees_of_freedom,
          .level = level,
          .critical = quantile(complement(distribution, level)),
          .p_value = chance_of_larger_chi_square(statistic, n),
          .lower_p_value = is_never_smaller(statistic, n) ? 0 : cdf(distribution, statistic)};
}

LackOfFitTest lack_of_fit_test(double lack, Eigen::Index degrees_of_freedom_lack, double pure,
                               Eigen::Index degrees_of_freedom_pure, double level) {
  const auto n = static_cast<double>(degrees_of_freedom_lack);
  const auto d = static_cast<double>(degrees_of_freedom_pure);
  const boost::math::fisher_f distribution(n, d);
  const double f = (lack / n) / (pure / d);
  return {.f = f,
          .degrees_of_freedom_lack = degrees_of_freedom_lack,
          .degrees_of_freedom_pure = degrees_of_freedom_pure,
          .level = level,
          .critical = quantile(complement(distribution, level)),
          .p_value = cdf(complement(distribution, f))};
}

ChiSquareTest misfit_test(double statistic, Eigen::Index degrees_of_freedom,
                          Eigen::Index degrees_of_freedom_noise) {
  ChiSquareTest test = chi_square_test(statistic, degrees_of_freedom);
  if (degrees_of_freedom_noise == 0 || degrees_of_freedom <= degrees_of_freedom_noise) return test;
  const auto scatter = static_cast<double>(degrees_of_freedom_noise);  // in units of its noise
  test.p_value = lack_of_fit_test(std::max(0.0, statistic - scatter),
                                  degrees_of_freedom - degrees_of_freedom_noise, scatter,
                                  degrees_of_freedom_noise)
                     .p_value;
  test.lower_p_value = 1 - test.p_value;
  return test;
}

}  // namespace kinetostat::calibration
