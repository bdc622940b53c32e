#include "kinetostat/fea/linear_algebra/rigid_aggregates.h"

#include <cmath>
#include <utility>

#include <Eigen/Eigenvalues>

#include "kinetostat/common/index.h"

namespace kinetostat::fea {
namespace {

using common::at;

// The groups of `rigid_aggregates`, one step after the other.
class Grouping {
 public:
  Grouping(const BlockMatrix& matrix, const RigidPoints& points)
      : matrix_(matrix),
        points_(points),
        whole_(matrix.pattern),
        group_(at(points.size()), -1),
        size_(at(points.size())) {
    for (int p = 0; p < points.size(); ++p)
      size_[at(p)] = matrix.block(matrix.pattern.begin(points.first_block(p))).norm();
  }

  std::vector<int> run() {
    for (const bool all_free : {true, false}) {
      for (int p = 0; p < points_.nodes(); ++p) begin_group(p, all_free);
      join_neighbours();
    }
    for (int b = 0; b < points_.bodies; ++b) group_[at(points_.nodes() + b)] = groups_++;
    return std::move(group_);
  }

 private:
  // Norm of a link beside those of its points; across a jump of the modulus it is small.
  static constexpr double strong = 0.02;

  // visit(other point, strength) for the strong neighbours of a point.
  template <class Visit>
  void for_neighbours(int p, const Visit& visit) const {
    const int row = points_.first_block(p);
    for (int k = whole_.begin(row); k < whole_.end(row); ++k) {
      const int column = whole_.column[at(k)];
      if (points_.turning && column % 2 != 0) continue;
      const int other = points_.turning ? column / 2 : column;
      if (other == p || other >= points_.nodes()) continue;
      const int place = whole_.place[at(k)];
      const double link = matrix_.block(WholeRows::stored(place)).norm() /
                          std::sqrt(size_[at(p)] * size_[at(other)]);
      if (link > strong) visit(other, link);
    }
  }

  // A group of the point and its neighbours that are in none; `all_free`: only when none is.
  void begin_group(int p, bool all_free) {
    if (group_[at(p)] >= 0) return;
    std::vector<int> members{p};
    bool free = true;
    for_neighbours(p, [&](int other, double) {
      if (group_[at(other)] < 0)
        members.push_back(other);
      else
        free = false;
    });
    if ((all_free && !free) || !move_when_turned(members)) return;
    for (const int member : members) group_[at(member)] = groups_;
    ++groups_;
  }

  // Points on a line do not notice a rotation about it: they cannot be a group.
  bool move_when_turned(const std::vector<int>& members) const {
    if (points_.turning) return true;
    Vector3 middle = Vector3::Zero();
    for (const int p : members) middle += points_.points[at(p)];
    middle /= static_cast<double>(members.size());
    Matrix3 spread = Matrix3::Zero();
    for (const int p : members) {
      const Vector3 arm = points_.points[at(p)] - middle;
      spread += arm * arm.transpose();
    }
    const Vector3 squares =
        Eigen::SelfAdjointEigenSolver<Matrix3>(spread, Eigen::EigenvaluesOnly).eigenvalues();
    return squares[1] > 1e-4 * squares[2];
  }

  // Each point left joins the group of its strongest neighbour.
  void join_neighbours() {
    const std::vector<int> before = group_;
    for (int p = 0; p < points_.nodes(); ++p) {
      if (before[at(p)] >= 0) continue;
      double strongest = 0;
      for_neighbours(p, [&](int other, double link) {
        if (const int group = before[at(other)]; group >= 0 && link > strongest) {
          strongest = link;
          group_[at(p)] = group;
        }
      });
    }
  }

  const BlockMatrix& matrix_;
  const RigidPoints& points_;
  WholeRows whole_;
  std::vector<int> group_;
  std::vector<double> size_;  // of the diagonal blocks
  int groups_ = 0;
};

}  // namespace

std::vector<int> rigid_aggregates(const BlockMatrix& matrix, const RigidPoints& points) {
  return Grouping(matrix, points).run();
}

}  // namespace kinetostat::fea
