// How the platform answers a wrench that oscillates.
#pragma once

#include <complex>
#include <vector>

#include "kinetostat/vjm/vibration/natural_modes.h"

namespace kinetostat::vjm {

/// What is stated of damping; it comes from no computation.
struct Damping {
  enum class Kind {
    modal,      // `value` is the damping ratio zeta of every mode: 1 aperiodic
    structural  // `value` is the loss factor eta of all springs: K (1 + i eta)
  };
  Kind kind = Kind::modal;
  double value = 0;  // >= 0
};

using Receptance = Eigen::Matrix<std::complex<double>, 6, 6>;

struct FrequencyResponse {
  std::vector<double> frequencies;     // [Hz]
  std::vector<Receptance> receptance;  // one each
};

/// Displacement of the platform [translation m; rotation rad] at its reference point, base axes,
/// over a wrench [force; moment] there that oscillates as exp(i omega t): the receptance
///
///   modal:       sum_k  u_k u_k' / (omega_k^2 - omega^2 + 2 i zeta omega_k omega)
///   structural:  sum_k  u_k u_k' / ((1 + i eta) omega_k^2 - omega^2)
///
/// over all modes, u_k the displacement of the platform for a modal mass of 1 (natural_modes()),
/// and with what yields without a mass, as at rest (over 1 + i eta where damping is structural): at
/// 0 Hz and without damping it is the compliance of unloaded_stiffness(). A motion that no spring
/// resists has omega_k = 0, and its part at 0 Hz is infinite. Drives hold their commands. Source:
/// Ewins, Modal Testing, 2.4 and 2.5.
FrequencyResponse frequency_response(const SmallMotions& motions, const Damping& damping,
                                     const std::vector<double>& frequencies);

/// `count` frequencies from `least` to `most` [Hz], evenly spaced by their logarithms, and those of
/// `peaks` between them; ascending. Requires 0 < least < most, count >= 2.
std::vector<double> response_frequencies(double least, double most, int count,
                                         const std::vector<double>& peaks);

}  // namespace kinetostat::vjm
