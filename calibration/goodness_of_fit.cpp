#include "kinetostat/calibration/goodness_of_fit.h"

#include <cmath>

#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/fisher_f.hpp>

namespace kinetostat::calibration {

using boost::math::cdf;
using boost::math::complement;
using boost::math::quantile;

double chance_of_larger_chi_square(double statistic, double degrees_of_freedom) {
  return cdf(complement(boost::math::chi_squared(degrees_of_freedom), statistic));
}

// It is the regularised incomplete beta function I_x(a, b), which is about x^a / (a B(a, b)) for
// small x; where that is below all numbers the library's own way to it overflows.
double chance_of_larger_f(double f, double degrees_of_freedom, double degrees_of_freedom_below) {
  const double a = degrees_of_freedom_below / 2, b = degrees_of_freedom / 2;
  const double x = a / (a + b * f);
  const double logarithm =
      a * std::log(x) + std::lgamma(a + b) - std::lgamma(a) - std::lgamma(b) - std::log(a);
  if (logarithm < -800) return 0;
  return cdf(complement(boost::math::fisher_f(degrees_of_freedom, degrees_of_freedom_below), f));
}

ChiSquareTest chi_square_test(double statistic, Eigen::Index degrees_of_freedom, double level) {
  const boost::math::chi_squared distribution(static_cast<double>(degrees_of_freedom));
  return {.statistic = statistic,
          .degrees_of_freedom = degrees_of_freedom,
          .level = level,
          .critical = quantile(complement(distribution, level)),
          .p_value = cdf(complement(distribution, statistic)),
          .lower_p_value = cdf(distribution, statistic)};
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
          .p_value = chance_of_larger_f(f, n, d)};
}

}  // namespace kinetostat::calibration
