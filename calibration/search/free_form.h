// Unmodelled smooth error (a Gaussian-process model discrepancy): is there anything smooth in a
// residual, whatever it is? It shows that something is missing and on what that depends, never what
// it is.
#pragma once

#include <deque>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "kinetostat/calibration/regression/base_fit.h"
#include "kinetostat/calibration/statistics/residual_space.h"

namespace kinetostat::calibration {

/// What an unmodelled smooth error changes with, as far as that distinguishes effects.
enum class SmoothOver { other, time, temperature, earlier_loads, column };

struct FreeFormEvidence {
  /// Logarithm of the evidence of an unmodelled smooth error over that of noise alone. Averaged
  /// over processes whose priors are fixed beforehand, it is a bet against the noise: with nothing
  /// missing its exponential is above 1/p with a probability of at most p (Ville 1939; Gruenwald et
  /// al., J. R. Stat. Soc. B 86, 2024).
  double log = 0;
  std::string depends_on;  // the most probable process: "posture, as a force on the platform does"
  std::string drive;       // whose law that is: "x.rho"; empty for other processes
  SmoothOver over = SmoothOver::other;  // what it changes with
  /// Processes of one drive, or over the same, and which share of the evidence is theirs; none: all
  /// of it is the most probable one's.
  struct Part {
    SmoothOver over = SmoothOver::other;
    std::string drive = {};
    double share = 1;
  };
  std::vector<Part> shared = {};

  double p_value() const;
  std::vector<Part> parts() const;
};

/// Ways in which an unmodelled smooth error may act: changes of the whitened values, one row each.
/// Each may be empty.
struct FreeFormWays {
  Eigen::MatrixXd force;      // with a force on the platform, three columns
  Eigen::MatrixXd uncertain;  // with what every fit changes
  struct Drive {
    std::string name;              // chain and joint: "x.rho"
    Eigen::VectorXd deflection;    // one entry a reading
    Eigen::VectorXd by_stiffness;  // with the logarithm of its stiffness
  };
  std::vector<Drive> drives;
};

/// Gaussian processes over what is known of each reading: an unknown function of posture, load,
/// both, the time, the time in a cycle (and load), the temperature or a further column of the
/// table, smooth or straight, that acts on the displacements themselves, as a force on the
/// platform, or as a change of what is uncertain; a memory of earlier loads by what is uncertain,
/// that fades with time; or a drive whose stiffness is an unknown function of its own deflection.
/// The amplitude of each has a log-uniform prior; the processes are equally likely, but for further
/// columns, which are 0.02 of all.
class FreeForm {
 public:
  FreeForm(const Campaign& campaign, const std::vector<Value>& values, const FreeFormWays& ways);

  /// Evidence in a residual beside everything that the space's fit can produce, with flat priors
  /// for that (restricted likelihood). `exponent`: as in evidence(). Of the spaces that were asked
  /// for last it remembers all but the exponent.
  FreeFormEvidence evidence(const ResidualSpace& space, double exponent) const;

 private:
  // An unknown function of `of_reading` (one row a reading) that acts through `columns` (one row a
  // value, one column for each function of its own).
  struct Process {
    std::string depends_on;
    SmoothOver over;
    std::shared_ptr<const Eigen::MatrixXd> of_reading, columns;  // many processes share them
    double length;           // over which it changes; 0: it is straight
    std::string drive = {};  // whose law it is
    double log_prior = 0;    // all that are known are as likely, and columns of the table less so
  };
  void share_prior();
  void add(const std::string& depends_on, SmoothOver over, Eigen::MatrixXd of_reading,
           const std::shared_ptr<const Eigen::MatrixXd>& columns,
           std::initializer_list<double> lengths);
  void add_memory(const Campaign& campaign, const std::vector<Value>& values,
                  const Eigen::MatrixXd& uncertain);
  void add_law(const FreeFormWays::Drive& drive);
  Eigen::MatrixXd root_of_kernel(const Process& process) const;
  // A process beside a fit: the eigenvalues of its kernel, and the residual along its vectors.
  struct Spectrum {
    Eigen::VectorXd values, seen;
  };
  struct Known {
    ResidualSpace space;
    std::vector<Spectrum> spectra;  // of the processes
  };
  static Spectrum spectrum(const Eigen::MatrixXd& root, const ResidualSpace& space);
  static double log_evidence(const Spectrum& spectrum, double exponent);
  const std::vector<Spectrum>& spectra_in(const ResidualSpace& space) const;

  std::vector<Process> processes_;
  std::vector<Eigen::Index> reading_;  // of each value
  mutable std::mutex known_in_use_;
  mutable std::deque<Known> known_;
};

}  // namespace kinetostat::calibration
