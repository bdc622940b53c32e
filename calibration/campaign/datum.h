// Errors that readings share: of the reading of the unloaded state that differences are counted
// from, of where the drives stopped in a pose.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "kinetostat/calibration/campaign/campaign.h"
#include "kinetostat/calibration/campaign/noise.h"

namespace kinetostat::calibration {

/// Share of one reading's variance that a datum has where its noise is not stated: readings without
/// load are often averaged, yet seldom by many. Less where readings refute it (datum_noise.h).
inline constexpr double usual_datum_variance = 0.5;

/// Of each reading whether it is a datum itself, which measures nothing: of differences the first
/// of its cycle at a configuration, without load and exactly 0.
std::vector<bool> are_datums(const Campaign& campaign);

/// Of each reading, which approach to a posture it is of: those that follow each other in one
/// configuration, in one cycle in the order of its steps, or without a cycle in that of the rows.
std::vector<std::size_t> approaches_of(const Campaign& campaign);

/// Of poses where `repeatability` is stated, one for each approach. Else the datums of differences
/// whose unloaded state was read: one for each cycle (without cycles: for each configuration in a
/// session) of which two readings or more are in use, or one, where the noise of datums is stated;
/// rows that are the datum itself (without load, exactly 0) are not counted from it. Noise of the
/// datum: as stated, else usual_datum_variance of the best reading's. `sigma`: of each reading and
/// component.
std::vector<Datum> datums_of(const Campaign& campaign, const std::vector<Eigen::VectorXd>& sigma);

/// Whitens rows, which stand for `values`, reading by reading (Noise::whiten). Values of a reading
/// follow each other.
void whiten_singly(const Noise& noise, const std::vector<Value>& values,
                   Eigen::Ref<Eigen::MatrixXd> rows);

/// What readings share by their datums, after each was whitened by itself (Noise::whiten): the
/// covariance is then
///
///   C = I + Z Z',   Z = W E s
///
/// for the values of one datum: E has a column for each component, with 1 where a value is of it; s
/// is the datum's standard deviation of each component; W whitens single readings. At most one
/// rank a datum and component.
class SharedNoise {
 public:
  /// `values`: which rows stand for, readings in their order.
  SharedNoise(const Noise& noise, const std::vector<Value>& values);

  /// Multiplies by the symmetric C^-1/2: afterwards all values are independent and of unit
  /// variance.
  void whiten(Eigen::Ref<Eigen::MatrixXd> rows) const;
  /// Multiplies by C^1/2, which takes that back.
  void restore(Eigen::Ref<Eigen::MatrixXd> rows) const;
  /// Root of the diagonal of C, for so many rows: 1 where nothing is shared.
  Eigen::VectorXd deviations(Eigen::Index rows) const;
  /// ln det C.
  double log_determinant() const;

 private:
  // Rows that share a datum; C^(-1/2) = I - U diag(less) U' and C^(1/2) = I + U diag(more) U'.
  struct Block {
    std::vector<Eigen::Index> rows;
    Eigen::MatrixXd u;
    Eigen::VectorXd less, more;
  };
  void add(const Datum& datum, const Noise& noise, const std::vector<Value>& values,
           std::vector<Eigen::Index> rows);

  std::vector<Block> blocks_;
};

}  // namespace kinetostat::calibration
