#include "kinetostat/fea/rigid_aggregates.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include "kinetostat/fea/several_processors.h"

namespace kinetostat::fea {
namespace {

using Motion = Eigen::Matrix<double, 3, 6, Eigen::RowMajor>;

constexpr int rows_at_once = 2048, aggregates_at_once = 128;

// Both halves of a symmetric matrix row by row: columns, and where their blocks are; ~place where
// it is the transpose that is stored.
struct WholeRows {
  std::vector<int> start, column, place;

  explicit WholeRows(const BlockPattern& pattern)
      : start(static_cast<std::size_t>(pattern.blocks()) + 1, 0) {
    const auto for_each = [&pattern](const auto& visit) {
      for (int row = 0; row < pattern.blocks(); ++row)
        for (std::size_t k = pattern.begin(row); k < pattern.end(row); ++k)
          visit(row, pattern.partner[k], static_cast<int>(k));
    };
    for_each([this](int row, int column_, int) {
      ++start[static_cast<std::size_t>(row) + 1];
      if (column_ != row) ++start[static_cast<std::size_t>(column_) + 1];
    });
    for (std::size_t b = 1; b < start.size(); ++b) start[b] += start[b - 1];
    column.resize(static_cast<std::size_t>(start.back()));
    place.resize(column.size());
    std::vector<int> next(start.begin(), start.end() - 1);
    for_each([this, &next](int row, int other, int k) {
      put(next[static_cast<std::size_t>(row)]++, other, k);
      if (other != row) put(next[static_cast<std::size_t>(other)]++, row, ~k);
    });
  }
  int begin(int row) const { return start[static_cast<std::size_t>(row)]; }
  int end(int row) const { return begin(row + 1); }

 private:
  void put(int at, int other, int k) {
    column[static_cast<std::size_t>(at)] = other;
    place[static_cast<std::size_t>(at)] = k;
  }
};

// y += a x, or a' x, of 3x3 and 3x6.
inline void add_product(const double* a, bool transposed, const double* x, double* y) {
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k) {
      const double factor = transposed ? a[3 * k + i] : a[3 * i + k];
      for (int j = 0; j < 6; ++j) y[6 * i + j] += factor * x[6 * k + j];
    }
}

// c += p' y, of 3x6 and 3x6.
inline void add_transposed_product(const double* p, const double* y, double* c) {
  for (int k = 0; k < 3; ++k)
    for (int i = 0; i < 6; ++i)
      for (int j = 0; j < 6; ++j) c[6 * i + j] += p[6 * k + i] * y[6 * k + j];
}

void append(RigidRows& rows, const RigidRows& more) {
  const std::size_t before = rows.column.size();
  if (before + more.column.size() > static_cast<std::size_t>(std::numeric_limits<int>::max()))
    throw std::length_error("the coarse level has more than 2^31 blocks");
  rows.column.insert(rows.column.end(), more.column.begin(), more.column.end());
  rows.value.insert(rows.value.end(), more.value.begin(), more.value.end());
  for (std::size_t r = 1; r < more.start.size(); ++r)
    rows.start.push_back(more.start[r] + static_cast<int>(before));
}

// A X on some rows.
KINETOSTAT_FOR_SEVERAL_PROCESSORS
void multiply_rows(const BlockMatrix& a, const WholeRows& whole, const RigidRows& x, int first,
                   int end, std::vector<int>& slot, RigidRows& product) {
  for (int row = first; row < end; ++row) {
    const int begin = product.start.back();
    for (int k = whole.begin(row); k < whole.end(row); ++k) {
      const auto other = static_cast<std::size_t>(whole.column[static_cast<std::size_t>(k)]);
      const int place = whole.place[static_cast<std::size_t>(k)];
      const double* block =
          a.value.data() + 9 * static_cast<std::size_t>(place < 0 ? ~place : place);
      for (auto p = static_cast<std::size_t>(x.start[other]);
           p < static_cast<std::size_t>(x.start[other + 1]); ++p) {
        int& at = slot[static_cast<std::size_t>(x.column[p])];
        if (at < begin) {
          at = static_cast<int>(product.column.size());
          product.column.push_back(x.column[p]);
          product.value.resize(product.value.size() + RigidRows::entries, 0.0);
        }
        add_product(block, place < 0, x.value.data() + RigidRows::entries * p,
                    product.value.data() + RigidRows::entries * static_cast<std::size_t>(at));
      }
    }
    product.start.push_back(static_cast<int>(product.column.size()));
  }
}

RigidRows multiply(const BlockMatrix& a, const WholeRows& whole, const RigidRows& x, int columns,
                   Team& team) {
  std::vector<RigidRows> parts(
      static_cast<std::size_t>(Team::pieces(static_cast<std::size_t>(x.rows()), rows_at_once)));
  team.for_each(static_cast<int>(parts.size()), [&](int i) {
    std::vector<int> slot(static_cast<std::size_t>(columns), -1);
    const int first = i * rows_at_once;
    multiply_rows(a, whole, x, first, std::min(first + rows_at_once, x.rows()), slot,
                  parts[static_cast<std::size_t>(i)]);
  });
  RigidRows product;
  std::size_t blocks = 0;
  for (const RigidRows& part : parts) blocks += part.column.size();
  product.column.reserve(blocks);
  product.value.reserve(RigidRows::entries * blocks);
  for (RigidRows& part : parts) append(product, std::exchange(part, {}));
  return product;
}

// How the blocks of a point move with a rigid body at `centre` whose rotation counts in `length`.
std::array<Motion, 2> motions(const RigidPoints& points, int point, const Vector3& centre,
                              double length) {
  std::array<Motion, 2> motion{
      rigid_motion(points.points[static_cast<std::size_t>(point)] - centre), Motion::Zero()};
  motion[0].rightCols<3>() /= length;
  motion[1].rightCols<3>() = points.length / length * Matrix3::Identity();
  return motion;
}

// The middles of the aggregates, and their size as the length.
RigidPoints middles(const RigidPoints& points, const std::vector<int>& aggregate) {
  const int count = *std::max_element(aggregate.begin(), aggregate.end()) + 1;
  RigidPoints coarse{
      .points = std::vector<Vector3>(static_cast<std::size_t>(count), Vector3::Zero()),
      .bodies = points.bodies,
      .turning = true};
  std::vector<int> members(static_cast<std::size_t>(count), 0);
  const auto for_each = [&](const auto& visit) {
    for (std::size_t p = 0; p < aggregate.size(); ++p)
      if (aggregate[p] >= 0) visit(points.points[p], static_cast<std::size_t>(aggregate[p]));
  };
  for_each([&](const Vector3& p, std::size_t a) {
    coarse.points[a] += p;
    ++members[a];
  });
  for (std::size_t a = 0; a < members.size(); ++a) coarse.points[a] /= members[a];
  double squares = 0;
  for_each(
      [&](const Vector3& p, std::size_t a) { squares += (p - coarse.points[a]).squaredNorm(); });
  if (squares > 0) coarse.length = std::sqrt(squares / static_cast<double>(points.points.size()));
  return coarse;
}

RigidRows rigid_motions(const RigidPoints& points, const std::vector<int>& aggregate,
                        const RigidPoints& coarse) {
  RigidRows rows;
  for (int p = 0; p < points.size(); ++p) {
    const int a = aggregate[static_cast<std::size_t>(p)];
    const auto motion =
        motions(points, p, a < 0 ? Vector3(0, 0, 0) : coarse.points[static_cast<std::size_t>(a)],
                coarse.length);
    for (int b = 0; b < points.blocks_of(p); ++b) {
      if (a >= 0) {
        const Motion& m = motion[static_cast<std::size_t>(b)];
        rows.column.push_back(a);
        rows.value.insert(rows.value.end(), m.data(), m.data() + m.size());
      }
      rows.start.push_back(static_cast<int>(rows.column.size()));
    }
  }
  return rows;
}

// (I - weight D^-1 A) T, but T in the rows from `bodies` on.
RigidRows smoothed(const BlockMatrix& a, const WholeRows& whole, const RigidRows& rigid,
                   double weight, int columns, int bodies, Team& team) {
  RigidRows smooth = multiply(a, whole, rigid, columns, team);
  for (int row = 0; row < rigid.rows(); ++row) {
    const Matrix3 factor = row < bodies ? Matrix3(-weight * a.block(a.pattern.begin(row)).inverse())
                                        : Matrix3(Matrix3::Zero());
    const auto r = static_cast<std::size_t>(row);
    for (auto k = static_cast<std::size_t>(smooth.start[r]);
         k < static_cast<std::size_t>(smooth.start[r + 1]); ++k) {
      Eigen::Map<Motion> block(smooth.value.data() + RigidRows::entries * k);
      block = (factor * block).eval();
      const auto own = static_cast<std::size_t>(rigid.start[r]);
      if (own < static_cast<std::size_t>(rigid.start[r + 1]) &&
          rigid.column[own] == smooth.column[k])
        block += Eigen::Map<const Motion>(rigid.value.data() + RigidRows::entries * own);
    }
  }
  return smooth;
}

// Rows 2I and 2I + 1 of P'AP for some aggregates I.
struct GalerkinRows {
  const RigidRows& p;
  const RigidRows& ap;
  const std::vector<int>&row_start, &row, &place;

  BlockMatrix operator()(int first, int end, int aggregates) const {
    BlockMatrix rows;
    std::vector<int> slot(static_cast<std::size_t>(aggregates), -1), column;
    std::vector<double> value;
    for (int i = first; i < end; ++i) {
      column.clear();
      value.clear();
      sum_up(i, slot, column, value);
      append_row(i, column, value, rows);
      for (const int j : column) slot[static_cast<std::size_t>(j)] = -1;
    }
    return rows;
  }

 private:
  // Blocks 6x6 of aggregate i and later ones.
  void sum_up(int i, std::vector<int>& slot, std::vector<int>& column,
              std::vector<double>& value) const {
    for (auto k = static_cast<std::size_t>(row_start[static_cast<std::size_t>(i)]);
         k < static_cast<std::size_t>(row_start[static_cast<std::size_t>(i) + 1]); ++k) {
      const double* left = p.value.data() + RigidRows::entries * static_cast<std::size_t>(place[k]);
      const auto r = static_cast<std::size_t>(row[k]);
      for (auto q = static_cast<std::size_t>(ap.start[r]);
           q < static_cast<std::size_t>(ap.start[r + 1]); ++q) {
        if (ap.column[q] < i) continue;
        int& at = slot[static_cast<std::size_t>(ap.column[q])];
        if (at < 0) {
          at = static_cast<int>(column.size());
          column.push_back(ap.column[q]);
          value.resize(value.size() + 36, 0.0);
        }
        add_transposed_product(left, ap.value.data() + RigidRows::entries * q,
                               value.data() + 36 * at);
      }
    }
  }

  void append_row(int i, const std::vector<int>& column, const std::vector<double>& value,
                  BlockMatrix& rows) const {
    std::vector<int> order(column.size());
    for (std::size_t k = 0; k < order.size(); ++k) order[k] = static_cast<int>(k);
    std::sort(order.begin(), order.end(), [&column](int a, int b) {
      return column[static_cast<std::size_t>(a)] < column[static_cast<std::size_t>(b)];
    });
    for (int half = 0; half < 2; ++half) {
      for (const int k : order) {
        const int j = column[static_cast<std::size_t>(k)];
        for (int side = j == i ? half : 0; side < 2; ++side) {
          rows.pattern.partner.push_back(2 * j + side);
          for (int a = 0; a < 3; ++a)
            for (int b = 0; b < 3; ++b)
              rows.value.push_back(
                  value[static_cast<std::size_t>(36 * k + 6 * (3 * half + a) + 3 * side + b)]);
        }
      }
      rows.pattern.start.push_back(static_cast<int>(rows.pattern.partner.size()));
    }
  }
};

// The groups of `rigid_aggregates`, one step after the other.
class Grouping {
 public:
  Grouping(const BlockMatrix& matrix, const RigidPoints& points)
      : matrix_(matrix),
        points_(points),
        whole_(matrix.pattern),
        group_(static_cast<std::size_t>(points.size()), -1),
        size_(static_cast<std::size_t>(points.size())) {
    for (int p = 0; p < points.size(); ++p)
      size_[static_cast<std::size_t>(p)] =
          matrix.block(matrix.pattern.begin(points.first_block(p))).norm();
  }

  std::vector<int> run() {
    for (const bool all_free : {true, false}) {
      for (int p = 0; p < points_.nodes(); ++p) begin_group(p, all_free);
      join_neighbours();
    }
    for (int b = 0; b < points_.bodies; ++b)
      group_[static_cast<std::size_t>(points_.nodes() + b)] = groups_++;
    return std::move(group_);
  }

 private:
  // Norm of a link beside those of its points. Linear tetrahedra of good shape have 0.05 to 0.5;
  // across a jump of the modulus it is small beside one of the two.
  static constexpr double strong = 0.02;

  // visit(other point, strength) for the strong neighbours of a point.
  template <class Visit>
  void for_neighbours(int p, const Visit& visit) const {
    const int row = points_.first_block(p);
    for (int k = whole_.begin(row); k < whole_.end(row); ++k) {
      const int column = whole_.column[static_cast<std::size_t>(k)];
      if (points_.turning && column % 2 != 0) continue;
      const int other = points_.turning ? column / 2 : column;
      if (other == p || other >= points_.nodes()) continue;
      const int place = whole_.place[static_cast<std::size_t>(k)];
      const double link =
          matrix_.block(static_cast<std::size_t>(place < 0 ? ~place : place)).norm() /
          std::sqrt(size_[static_cast<std::size_t>(p)] * size_[static_cast<std::size_t>(other)]);
      if (link > strong) visit(other, link);
    }
  }

  // A group of the point and its neighbours that are in none; `all_free`: only when none is.
  void begin_group(int p, bool all_free) {
    if (group_[static_cast<std::size_t>(p)] >= 0) return;
    std::vector<int> members{p};
    bool free = true;
    for_neighbours(p, [&](int other, double) {
      if (group_[static_cast<std::size_t>(other)] < 0)
        members.push_back(other);
      else
        free = false;
    });
    if ((all_free && !free) || !move_when_turned(members)) return;
    for (const int member : members) group_[static_cast<std::size_t>(member)] = groups_;
    ++groups_;
  }

  // Points on a line do not notice a rotation about it: they cannot be a group.
  bool move_when_turned(const std::vector<int>& members) const {
    if (points_.turning) return true;
    Vector3 middle = Vector3::Zero();
    for (const int p : members) middle += points_.points[static_cast<std::size_t>(p)];
    middle /= static_cast<double>(members.size());
    Matrix3 spread = Matrix3::Zero();
    for (const int p : members) {
      const Vector3 arm = points_.points[static_cast<std::size_t>(p)] - middle;
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
      if (before[static_cast<std::size_t>(p)] >= 0) continue;
      double strongest = 0;
      for_neighbours(p, [&](int other, double link) {
        if (const int group = before[static_cast<std::size_t>(other)];
            group >= 0 && link > strongest) {
          strongest = link;
          group_[static_cast<std::size_t>(p)] = group;
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

using Register = double __attribute__((vector_size(sizeof(Lanes)), may_alias));

// Some blocks of fine = P coarse.
KINETOSTAT_FOR_SEVERAL_PROCESSORS
void prolong_rows(const RigidRows& rows, int first, int end, const Lanes* coarse_lanes,
                  Lanes* fine_lanes) {
  const auto* coarse = reinterpret_cast<const Register*>(coarse_lanes);
  auto* fine = reinterpret_cast<Register*>(fine_lanes);
  for (int row = first; row < end; ++row) {
    Register y0{}, y1{}, y2{};
    for (int k = rows.start[static_cast<std::size_t>(row)];
         k < rows.start[static_cast<std::size_t>(row) + 1]; ++k) {
      const double* p = rows.value.data() + RigidRows::entries * static_cast<std::size_t>(k);
      const Register* x = coarse + 6 * rows.column[static_cast<std::size_t>(k)];
      for (int j = 0; j < 6; ++j) {
        y0 += p[j] * x[j];
        y1 += p[6 + j] * x[j];
        y2 += p[12 + j] * x[j];
      }
    }
    fine[3 * row] = y0;
    fine[3 * row + 1] = y1;
    fine[3 * row + 2] = y2;
  }
}

// coarse = P' fine for one aggregate.
KINETOSTAT_FOR_SEVERAL_PROCESSORS
void restrict_rows(const double* values, const int* row, const int* place, int count,
                   const Lanes* fine_lanes, Lanes* coarse_lanes) {
  const auto* fine = reinterpret_cast<const Register*>(fine_lanes);
  auto* coarse = reinterpret_cast<Register*>(coarse_lanes);
  Register sum[6] = {};
  for (int k = 0; k < count; ++k) {
    const double* p = values + RigidRows::entries * static_cast<std::size_t>(place[k]);
    const Register* x = fine + 3 * row[k];
    for (int j = 0; j < 6; ++j) sum[j] += p[j] * x[0] + p[6 + j] * x[1] + p[12 + j] * x[2];
  }
  for (int j = 0; j < 6; ++j) coarse[j] = sum[j];
}

}  // namespace

RigidPoints rigid_points(const TetMesh& mesh, const Unknowns& unknowns) {
  RigidPoints points{
      .points = std::vector<Vector3>(static_cast<std::size_t>(unknowns.node_blocks())),
      .bodies = static_cast<int>(unknowns.bodies().size())};
  for (std::size_t n = 0; n < mesh.nodes.size(); ++n)
    if (const int block = unknowns.block_of(static_cast<int>(n)); block >= 0)
      points.points[static_cast<std::size_t>(block)] = mesh.nodes[n];
  for (const ReferenceBody& body : unknowns.bodies()) points.points.push_back(body.point);
  return points;
}

std::vector<int> rigid_aggregates(const BlockMatrix& matrix, const RigidPoints& points) {
  return Grouping(matrix, points).run();
}

AggregateLevel::AggregateLevel(const BlockMatrix& matrix, const RigidPoints& points,
                               double largest_eigenvalue, Team& team)
    : team_(team) {
  const std::vector<int> aggregate = rigid_aggregates(matrix, points);
  points_ = middles(points, aggregate);
  const WholeRows whole(matrix.pattern);
  prolongation_ = smoothed(matrix, whole, rigid_motions(points, aggregate, points_),
                           4 / (3 * largest_eigenvalue), points_.size(),
                           points.first_block(points.nodes()), team);
  row_start_.assign(static_cast<std::size_t>(points_.size()) + 1, 0);
  for (const int column : prolongation_.column) ++row_start_[static_cast<std::size_t>(column) + 1];
  for (std::size_t a = 1; a < row_start_.size(); ++a) row_start_[a] += row_start_[a - 1];
  row_.resize(prolongation_.column.size());
  place_.resize(row_.size());
  std::vector<int> next(row_start_.begin(), row_start_.end() - 1);
  for (int row = 0; row < prolongation_.rows(); ++row)
    for (int k = prolongation_.start[static_cast<std::size_t>(row)];
         k < prolongation_.start[static_cast<std::size_t>(row) + 1]; ++k) {
      const int at =
          next[static_cast<std::size_t>(prolongation_.column[static_cast<std::size_t>(k)])]++;
      row_[static_cast<std::size_t>(at)] = row;
      place_[static_cast<std::size_t>(at)] = k;
    }
  const RigidRows product = multiply(matrix, whole, prolongation_, points_.size(), team);
  const GalerkinRows galerkin{prolongation_, product, row_start_, row_, place_};
  std::vector<BlockMatrix> parts(
      static_cast<std::size_t>(Team::pieces(points_.points.size(), aggregates_at_once)));
  team.for_each(static_cast<int>(parts.size()), [&](int i) {
    const int first = i * aggregates_at_once;
    parts[static_cast<std::size_t>(i)] =
        galerkin(first, std::min(first + aggregates_at_once, points_.size()), points_.size());
  });
  for (BlockMatrix& part : parts) {
    const std::size_t before = matrix_.pattern.partner.size();
    matrix_.pattern.partner.insert(matrix_.pattern.partner.end(), part.pattern.partner.begin(),
                                   part.pattern.partner.end());
    for (std::size_t b = 1; b < part.pattern.start.size(); ++b)
      matrix_.pattern.start.push_back(part.pattern.start[b] + static_cast<int>(before));
    matrix_.value.insert(matrix_.value.end(), part.value.begin(), part.value.end());
    part = {};
  }
}

std::size_t AggregateLevel::bytes() const {
  return prolongation_.bytes() + sizeof(int) * (row_start_.size() + row_.size() + place_.size());
}

void AggregateLevel::prolong(const LaneVector& coarse, LaneVector& fine) const {
  team_.for_each_piece(static_cast<std::size_t>(prolongation_.rows()), rows_at_once,
                       [&](int, std::size_t begin, std::size_t end) {
                         prolong_rows(prolongation_, static_cast<int>(begin), static_cast<int>(end),
                                      coarse.data(), fine.data());
                       });
}

void AggregateLevel::restrict(const LaneVector& fine, LaneVector& coarse) const {
  team_.for_each_piece(
      points_.points.size(), aggregates_at_once, [&](int, std::size_t begin, std::size_t end) {
        for (std::size_t a = begin; a < end; ++a)
          restrict_rows(prolongation_.value.data(), row_.data() + row_start_[a],
                        place_.data() + row_start_[a], row_start_[a + 1] - row_start_[a],
                        fine.data(), coarse.data() + 6 * a);
      });
}

}  // namespace kinetostat::fea
