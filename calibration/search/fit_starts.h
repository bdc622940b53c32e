// Where the fits of a candidate start.
#pragma once

#include <vector>

#include "kinetostat/calibration/search/candidate_fitter.h"

namespace kinetostat::calibration {

inline constexpr std::size_t most_starts = 4;  // of one fit

/// The candidate with the values that say how large it is `size` times as far from nothing, within
/// their range, and by a factor from -20 to 20 (0.002 to 20 for what can only grow).
Candidate resized(Candidate start, double size);

/// Starts of one candidate beside a fitted model, of which `space` is the residual space. Gaps,
/// breakaway forces, corners and phases have several minima. Keeps references.
class FitStarts {
 public:
  FitStarts(const Candidate& candidate, const ResidualSpace& space, const vjm::Manipulator& bare);

  /// A signature, at which size of the candidate it was looked at, and how much of the squared
  /// residual it explains. Where the candidate has a phase, only the effect itself counts, in its
  /// own direction: a signature with all its shapes would explain as much from wherever it is
  /// looked at.
  void add(const Candidate& as_it_is, const Signature& signature, double explained);
  /// The candidate turned by a quarter, a half and three quarters, where it has a phase.
  void add_other_phases(const CandidateFitter& fitter, const FittedModel& beside,
                        common::Progress& progress);

  /// How much of the squared residual a fit should explain, to first order: what the best signature
  /// does. What can only grow does not explain its opposite, and how it acts is not farther from
  /// what is usual than the readings are worth.
  double promised() const { return promised_; }
  /// At most so many, those first whose signatures explain most, at the size that each asks for,
  /// then as they are; none that is near another.
  std::vector<Candidate> best(std::size_t most = most_starts);

 private:
  struct Look {
    double explained = 0;  // of the squared residual
    Candidate as_it_is, resized;
  };

  const ResidualSpace& space_;
  const vjm::Manipulator& bare_;
  std::vector<Candidate> turned_;
  std::vector<Look> looks_;
  double promised_ = 0;
};

}  // namespace kinetostat::calibration
