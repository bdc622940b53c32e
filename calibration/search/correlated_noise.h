// Errors of readings that are not independent: the noise of a datum that many readings share, where
// drives stop, errors that last from one reading to the next.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "kinetostat/calibration/regression/base_fit.h"
#include "kinetostat/calibration/statistics/residual_space.h"

namespace kinetostat::calibration {

/// Ways in which the noise of readings may be correlated, and how probable each is beside
/// independent noise. Effects, unmodelled smooth errors and noise must be distinguished: correlated
/// noise that is taken for independent looks like an effect.
///
/// Differences: a reading of the unloaded state that all of a load cycle (without cycles: of a
/// configuration in a session) is counted from, as noisy as the best of the others. Poses: where
/// the drives stop, which readings share that follow each other in one configuration, half to four
/// times as noisy. All readings whose time is known: errors of which 0.3, 0.6 or 0.85 last from one
/// reading of a session to the next.
class CorrelatedNoise {
 public:
  /// `values`: of the campaign, in use.
  CorrelatedNoise(const Campaign& campaign, const std::vector<Value>& values, const Noise& noise);

  std::size_t size() const { return ways_.size(); }
  /// Part of a sentence: "readings of one cycle are off together, as ...".
  const std::string& what(std::size_t way) const { return ways_.at(way).what; }

  /// Whitened columns, one row a value, times the inverse of a root of the covariance: afterwards
  /// such noise is independent and of unit variance.
  Eigen::MatrixXd decorrelated(std::size_t way, const Eigen::MatrixXd& columns) const;

  /// Log evidence of each such noise over independent noise, under a model with flat priors for all
  /// that it fits (restricted likelihood: Harville, J. Am. Stat. Assoc. 72, 1977), linear about its
  /// fit. Whatever the scale of the noise, which may be stated wrong.
  std::vector<double> log_evidences(const BaseFit& fit) const;

  /// Gain of the log evidence of a model when its noise may be independent or, as likely, one of
  /// these. The noise of datums is believed as far as it is seen without the load cycle that speaks
  /// most for it: one that is off by itself is no noise.
  double gain(const BaseFit& fit) const;

  /// How much of the misfit of a model another one leaves, (S_with - m) / (S_without - m) of their
  /// squared residuals with m degrees of freedom, both under the noise that the other seems to
  /// have: what readings share by their datum is no misfit, however many they are.
  double share_left(const BaseFit& without, const BaseFit& with) const;

  /// Squared residuals where noise is shared in such a way (nullopt: in none). Errors that only
  /// last are as large as others.
  double squared_error_where_shared(const BaseFit& fit, std::optional<std::size_t> way) const;

  /// The most probable one, where independent noise is out of question beside it.
  std::optional<std::size_t> prevailing(const BaseFit& fit) const;

 private:
  double squared_error(const BaseFit& fit, std::optional<std::size_t> way) const;
  std::vector<double> believed(const BaseFit& fit, std::vector<double> logs) const;
  using Rows = std::vector<Eigen::Index>;
  // Values of one block: either they share a datum, with the covariance 1 + zero zero', or each is
  // `fading` times the one before it and something new.
  struct Block {
    Rows rows;
    Eigen::VectorXd zero = {};
    std::size_t datum = 0;  // number of that
  };
  struct Way {
    std::string what;
    double fading = 0;
    double share = 1;  // of the prior, beside that of each other way
    std::vector<Block> blocks = {};
    double log_determinant = 0;  // of the covariance
  };
  static Eigen::MatrixXd decorrelated(const Way& way, const Eigen::MatrixXd& columns);
  static double log_evidence(const Way& way, const ResidualSpace& space);
  static std::optional<double> log_without_worst(const Way& way, const BaseFit& fit);
  void add_zeros(const Campaign& campaign, const std::vector<Value>& values, const Noise& noise);
  void add_approaches(const Campaign& campaign, const std::vector<Value>& values,
                      const Noise& noise);
  void add_shared(Way way, const std::vector<std::size_t>& datums, double times,
                  const std::vector<Value>& values, const Noise& noise);
  void add_fading(const Campaign& campaign, const std::vector<Value>& values);

  std::vector<Way> ways_;
};

}  // namespace kinetostat::calibration
