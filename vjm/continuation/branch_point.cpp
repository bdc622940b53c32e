#include "kinetostat/vjm/continuation/branch_point.h"

#include <algorithm>

#include "kinetostat/spatial/decomposition.h"

namespace kinetostat::vjm {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Ascending.
VectorXd singular_values_at(Continuation& continuation, const Station& station) {
  return spatial::singular_values(continuation.derivative(station)).reverse();
}

int count_zero(const VectorXd& ascending) {
  if (ascending.size() == 0) return 0;
  const double zero = 1e-13 * ascending[ascending.size() - 1];
  return static_cast<int>((ascending.array() <= zero).count());
}

// Right singular vectors of the smallest singular values, the null vector included.
MatrixXd smallest_directions(Continuation& continuation, const Station& station, Index count) {
  const MatrixXd v = spatial::right_singular_vectors(continuation.derivative(station)).v;
  return v.rightCols(std::min(count, v.cols()));
}

}  // namespace

int idle_directions(Continuation& continuation, const Station& station) {
  return count_zero(singular_values_at(continuation, station));
}

double distance_to_branch_point(Continuation& continuation, const Station& station, int idle) {
  const VectorXd values = singular_values_at(continuation, station);
  return idle < values.size() ? values[idle] : 0;
}

std::vector<VectorXd> leaving_directions(Continuation& continuation, const Station& beside,
                                         const Station& at, int idle, int count) {
  const MatrixXd here = smallest_directions(continuation, at, idle + 1 + count);
  const MatrixXd path = smallest_directions(continuation, beside, idle + 1);
  const MatrixXd common = spatial::right_singular_vectors(path.transpose() * here).v;
  const MatrixXd rest = here * common.rightCols(here.cols() - path.cols());
  std::vector<VectorXd> directions;
  for (Index j = 0; j < rest.cols(); ++j) directions.push_back(rest.col(j).normalized());
  return directions;
}

}  // namespace kinetostat::vjm
