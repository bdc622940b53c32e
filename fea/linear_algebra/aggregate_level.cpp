#include "kinetostat/fea/linear_algebra/aggregate_level.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <stdexcept>
#include <utility>

#include <Eigen/LU>

#include "kinetostat/common/index.h"
#include "kinetostat/common/several_processors.h"

namespace kinetostat::fea {
namespace {

using common::at;

using Motion = Eigen::Matrix<double, 3, 6, Eigen::RowMajor>;

constexpr int rows_at_once = 2048, aggregates_at_once = 128;

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

// Adds the rows of `more` from `first` on.
void append(RigidRows& rows, const RigidRows& more, int first = 0) {
  const int begin = more.start[at(first)];
  const std::size_t blocks = rows.column.size() + more.column.size() - at(begin);
  if (blocks > at(std::numeric_limits<int>::max()))
    throw std::length_error("the coarse level has more than 2^31 blocks");
  const int shift = static_cast<int>(rows.column.size()) - begin;
  rows.column.insert(rows.column.end(), more.column.begin() + begin, more.column.end());
  rows.value.insert(rows.value.end(), more.block(begin), more.block(more.start.back()));
  for (auto r = at(first) + 1; r < more.start.size(); ++r)
    rows.start.push_back(more.start[r] + shift);
}

// A X on some rows. `slot`: one for each column, below 0 at first.
KINETOSTAT_FOR_SEVERAL_PROCESSORS
void multiply_rows(const BlockMatrix& a, const WholeRows& whole, const RigidRows& x, int first,
                   int end, std::vector<int>& slot, RigidRows& product) {
  for (int row = first; row < end; ++row) {
    const int begin = product.start.back();
    for (int k = whole.begin(row); k < whole.end(row); ++k) {
      const auto other = at(whole.column[at(k)]);
      const int place = whole.place[at(k)];
      const double* block = a.block(WholeRows::stored(place)).data();
      for (int p = x.start[other]; p < x.start[other + 1]; ++p) {
        int& seat = slot[at(x.column_of(p))];
        if (seat < begin) {
          seat = static_cast<int>(product.column.size());
          product.column.push_back(x.column_of(p));
          product.value.resize(product.value.size() + RigidRows::entries, 0.0);
        }
        add_product(block, place < 0, x.block(p), product.block(seat));
      }
    }
    product.start.push_back(static_cast<int>(product.column.size()));
  }
}

// The first rows of A X.
RigidRows multiply(const BlockMatrix& a, const WholeRows& whole, const RigidRows& x, int rows,
                   int columns, common::ThreadPool& pool) {
  std::vector<RigidRows> parts(at(common::ThreadPool::pieces(at(rows), rows_at_once)));
  pool.for_each(static_cast<int>(parts.size()), [&](int i) {
    std::vector<int> slot(at(columns), -1);
    const int first = i * rows_at_once;
    multiply_rows(a, whole, x, first, std::min(first + rows_at_once, rows), slot, parts[at(i)]);
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
  std::array<Motion, 2> motion{spatial::rigid_motion(points.points[at(point)] - centre),
                               Motion::Zero()};
  motion[0].rightCols<3>() /= length;
  motion[1].rightCols<3>() = points.length / length * Matrix3::Identity();
  return motion;
}

// The middles of the aggregates, and their size as the length.
RigidPoints middles(const RigidPoints& points, const std::vector<int>& aggregate) {
  const int count = *std::max_element(aggregate.begin(), aggregate.end()) + 1;
  RigidPoints coarse{.points = std::vector<Vector3>(at(count), Vector3::Zero()),
                     .bodies = points.bodies,
                     .turning = true};
  std::vector<int> members(at(count), 0);
  const auto for_each = [&](const auto& visit) {
    for (std::size_t p = 0; p < aggregate.size(); ++p)
      if (aggregate[p] >= 0) visit(points.points[p], at(aggregate[p]));
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
    const int a = aggregate[at(p)];
    const auto motion =
        motions(points, p, a < 0 ? Vector3(0, 0, 0) : coarse.points[at(a)], coarse.length);
    for (int b = 0; b < points.blocks_of(p); ++b) {
      if (a >= 0) {
        const Motion& m = motion[at(b)];
        rows.column.push_back(a);
        rows.value.insert(rows.value.end(), m.data(), m.data() + m.size());
      }
      rows.start.push_back(static_cast<int>(rows.column.size()));
    }
  }
  return rows;
}

// (I - weight D^-1 A) T, but T itself in the rows from `bodies` on.
RigidRows smoothed(const BlockMatrix& a, const WholeRows& whole, const RigidRows& rigid,
                   double weight, int columns, int bodies, common::ThreadPool& pool) {
  RigidRows smooth = multiply(a, whole, rigid, bodies, columns, pool);
  const auto smooth_row = [&](std::size_t row) {
    const Matrix3 factor = -weight * a.block(a.pattern.begin(static_cast<int>(row))).inverse();
    for (int k = smooth.start[row]; k < smooth.start[row + 1]; ++k) {
      Eigen::Map<Motion> block(smooth.block(k));
      block = (factor * block).eval();
      if (const int own = rigid.start[row];
          own < rigid.start[row + 1] && rigid.column_of(own) == smooth.column_of(k))
        block += Eigen::Map<const Motion>(rigid.block(own));
    }
  };
  pool.for_each_piece(at(bodies), rows_at_once, [&](int, std::size_t begin, std::size_t end) {
    for (std::size_t row = begin; row < end; ++row) smooth_row(row);
  });
  append(smooth, rigid, bodies);
  return smooth;
}

// P'AP, whose columns are those of P with three unknowns each twice.
class GalerkinProduct {
 public:
  GalerkinProduct(const RigidRows& p, const RigidColumns& columns, const RigidRows& ap)
      : p_(p), columns_(columns), ap_(ap), count_(static_cast<int>(columns.start.size()) - 1) {}

  BlockMatrix compute(common::ThreadPool& pool) const {
    std::vector<BlockMatrix> parts(at(common::ThreadPool::pieces(at(count_), aggregates_at_once)));
    pool.for_each(static_cast<int>(parts.size()), [&](int i) {
      const int first = i * aggregates_at_once;
      parts[at(i)] = rows(first, std::min(first + aggregates_at_once, count_));
    });
    BlockMatrix whole;
    for (BlockMatrix& part : parts) {
      append(whole.pattern, part.pattern);
      whole.value.insert(whole.value.end(), part.value.begin(), part.value.end());
      part = {};
    }
    return whole;
  }

 private:
  static constexpr std::size_t square = 36;  // entries of a pair of aggregates, row by row

  // The rows of some aggregates.
  BlockMatrix rows(int first, int end) const {
    BlockMatrix rows;
    std::vector<int> slot(at(count_), -1), partner;
    std::vector<double> value;
    for (int i = first; i < end; ++i) {
      partner.clear();
      value.clear();
      sum_up(i, slot, partner, value);
      append_rows(i, partner, slot, value, rows);
      for (const int j : partner) slot[at(j)] = -1;
    }
    return rows;
  }

  // Squares of aggregate i with itself and later ones, in the order in which they turn up.
  void sum_up(int i, std::vector<int>& slot, std::vector<int>& partner,
              std::vector<double>& value) const {
    for (std::size_t k = columns_.begin(i); k < columns_.end(i); ++k) {
      const double* left = p_.block(columns_.place[k]);
      const auto row = at(columns_.row[k]);
      for (int q = ap_.start[row]; q < ap_.start[row + 1]; ++q) {
        const int j = ap_.column_of(q);
        if (j < i) continue;
        int& place = slot[at(j)];
        if (place < 0) {
          place = static_cast<int>(partner.size());
          partner.push_back(j);
          value.resize(value.size() + square, 0.0);
        }
        add_transposed_product(left, ap_.block(q), value.data() + square * at(place));
      }
    }
  }

  // Two rows of blocks.
  static void append_rows(int i, std::vector<int>& partner, const std::vector<int>& slot,
                          const std::vector<double>& value, BlockMatrix& rows) {
    std::sort(partner.begin(), partner.end());
    for (int half = 0; half < 2; ++half) {
      for (const int j : partner)
        for (int side = j == i ? half : 0; side < 2; ++side) {
          rows.pattern.partner.push_back(2 * j + side);
          const double* block =
              value.data() + square * at(slot[at(j)]) + 18 * at(half) + 3 * at(side);
          for (std::size_t a = 0; a < 3; ++a)
            rows.value.insert(rows.value.end(), block + 6 * a, block + 6 * a + 3);
        }
      rows.pattern.start.push_back(static_cast<int>(rows.pattern.partner.size()));
    }
  }

  const RigidRows& p_;
  const RigidColumns& columns_;
  const RigidRows& ap_;
  int count_;
};

using Register = double __attribute__((vector_size(sizeof(Lanes)), may_alias));

// Some blocks of fine = P coarse.
KINETOSTAT_FOR_SEVERAL_PROCESSORS
void prolong_rows(const RigidRows& rows, int first, int end, const Lanes* coarse_lanes,
                  Lanes* fine_lanes) {
  const auto* coarse = reinterpret_cast<const Register*>(coarse_lanes);
  auto* fine = reinterpret_cast<Register*>(fine_lanes);
  for (std::ptrdiff_t row = first; row < end; ++row) {
    Register y0{}, y1{}, y2{};
    for (int k = rows.start[at(row)]; k < rows.start[at(row) + 1]; ++k) {
      const double* p = rows.block(k);
      const Register* x = coarse + std::ptrdiff_t{6} * rows.column_of(k);
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

// coarse = P' fine for some aggregates.
KINETOSTAT_FOR_SEVERAL_PROCESSORS
void restrict_columns(const RigidRows& rows, const RigidColumns& columns, int first, int end,
                      const Lanes* fine_lanes, Lanes* coarse_lanes) {
  const auto* fine = reinterpret_cast<const Register*>(fine_lanes);
  auto* coarse = reinterpret_cast<Register*>(coarse_lanes);
  for (int column = first; column < end; ++column) {
    Register sum[6] = {};
    for (std::size_t k = columns.begin(column); k < columns.end(column); ++k) {
      const double* p = rows.block(columns.place[k]);
      const Register* x = fine + std::ptrdiff_t{3} * columns.row[k];
      for (int j = 0; j < 6; ++j) sum[j] += p[j] * x[0] + p[6 + j] * x[1] + p[12 + j] * x[2];
    }
    for (int j = 0; j < 6; ++j) coarse[6 * column + j] = sum[j];
  }
}

}  // namespace

RigidColumns::RigidColumns(const RigidRows& rows, int columns)
    : start(at(columns) + 1, 0), row(rows.column.size()), place(rows.column.size()) {
  for (const int c : rows.column) ++start[at(c) + 1];
  for (std::size_t c = 1; c < start.size(); ++c) start[c] += start[c - 1];
  std::vector<int> next(start.begin(), start.end() - 1);
  for (int r = 0; r < rows.rows(); ++r)
    for (int k = rows.start[at(r)]; k < rows.start[at(r) + 1]; ++k) {
      const auto free = at(next[at(rows.column_of(k))]++);
      row[free] = r;
      place[free] = k;
    }
}

AggregateLevel::AggregateLevel(const BlockMatrix& matrix, const RigidPoints& points,
                               double largest_eigenvalue, common::ThreadPool& pool)
    : pool_(pool) {
  const std::vector<int> aggregate = rigid_aggregates(matrix, points);
  points_ = middles(points, aggregate);
  const int columns = points_.size();
  const WholeRows whole(matrix.pattern);
  prolongation_ =
      smoothed(matrix, whole, rigid_motions(points, aggregate, points_),
               4 / (3 * largest_eigenvalue), columns, points.first_block(points.nodes()), pool);
  columns_ = RigidColumns(prolongation_, columns);
  const RigidRows product =
      multiply(matrix, whole, prolongation_, prolongation_.rows(), columns, pool);
  matrix_ = GalerkinProduct(prolongation_, columns_, product).compute(pool);
}

std::size_t AggregateLevel::bytes() const {
  return prolongation_.bytes() +
         sizeof(int) * (columns_.start.size() + columns_.row.size() + columns_.place.size());
}

void AggregateLevel::prolong(const MultiVector& coarse, MultiVector& fine) const {
  pool_.for_each_piece(at(prolongation_.rows()), rows_at_once,
                       [&](int, std::size_t begin, std::size_t end) {
                         prolong_rows(prolongation_, static_cast<int>(begin), static_cast<int>(end),
                                      coarse.data(), fine.data());
                       });
}

void AggregateLevel::restrict(const MultiVector& fine, MultiVector& coarse) const {
  pool_.for_each_piece(points_.points.size(), aggregates_at_once,
                       [&](int, std::size_t begin, std::size_t end) {
                         restrict_columns(prolongation_, columns_, static_cast<int>(begin),
                                          static_cast<int>(end), fine.data(), coarse.data());
                       });
}

}  // namespace kinetostat::fea
