#include "kinetostat/vjm/vibration/frequency_response.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "kinetostat/vjm/vibration/mass_spectrum.h"

namespace kinetostat::vjm {
namespace response {
namespace {

// Of the platform, for y' (K + s M) y = 1.
struct Motion {
  spatial::Vector6 platform;
  double stiffness = 0, theta = 0;  // y' K y, y' M y
};

// Over the response to a unit of what pushes along the motion.
std::complex<double> resistance(const Motion& motion, const Damping& damping, double omega) {
  const double inertia = omega * omega * motion.theta;
  if (damping.kind == Damping::Kind::structural)
    return {motion.stiffness - inertia, damping.value * motion.stiffness};
  return {motion.stiffness - inertia,
          2 * damping.value * omega * std::sqrt(motion.stiffness * motion.theta)};
}

std::vector<Motion> motions_of(const SmallMotions& small) {
  const MassSpectrum spectrum(small.stiffness, small.mass);
  std::vector<Motion> motions;
  for (Eigen::Index i = 0; i < spectrum.size(); ++i)
    motions.push_back({small.platform * spectrum.vector(i), spectrum.stiffness(i),
                       spectrum.has_mass(i) ? spectrum.theta(i) : 0});
  return motions;
}

}  // namespace
}  // namespace response

FrequencyResponse frequency_response(const SmallMotions& small, const Damping& damping,
                                     const std::vector<double>& frequencies) {
  const std::vector<response::Motion> motions = response::motions_of(small);
  FrequencyResponse result{frequencies, {}};
  for (const double frequency : frequencies) {
    Receptance receptance = Receptance::Zero();
    for (const response::Motion& motion : motions)
      receptance += motion.platform * motion.platform.transpose() /
                    response::resistance(motion, damping, 2 * std::numbers::pi * frequency);
    result.receptance.push_back(receptance);
  }
  return result;
}

std::vector<double> response_frequencies(double least, double most, int count,
                                         const std::vector<double>& peaks) {
  std::vector<double> frequencies{least};
  const double step = std::log(most / least) / (count - 1);
  for (int k = 1; k + 1 < count; ++k) frequencies.push_back(least * std::exp(step * k));
  frequencies.push_back(most);
  for (const double peak : peaks)
    if (least < peak && peak < most) frequencies.push_back(peak);
  std::sort(frequencies.begin(), frequencies.end());
  frequencies.erase(std::unique(frequencies.begin(), frequencies.end()), frequencies.end());
  return frequencies;
}

}  // namespace kinetostat::vjm
