#include "kinetostat/fea/linear_algebra/factorisation.h"

#include <chrono>
#include <limits>
#include <metis.h>
#include <new>
#include <suitesparse/cholmod.h>
#include <utility>

#include <fmt/format.h>

#include "kinetostat/common/index.h"
#include "kinetostat/fea/linear_algebra/blas.h"

namespace kinetostat::fea {
namespace {

using common::at;

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

// Both directions of every link between the first `blocks` blocks, as METIS wants them.
struct Graph {
  std::vector<idx_t> start, neighbour;
};

Graph graph_of(const BlockPattern& pattern, int blocks) {
  Graph graph{std::vector<idx_t>(at(blocks) + 1, 0), {}};
  const auto for_each_link = [&pattern, blocks](auto visit) {
    for (int b = 0; b < blocks; ++b)
      for (int k = pattern.start[at(b)] + 1; k < pattern.start[at(b) + 1]; ++k)
        if (const int partner = pattern.partner[at(k)]; partner < blocks) visit(at(b), at(partner));
  };
  for_each_link([&graph](std::size_t a, std::size_t b) {
    ++graph.start[a + 1];
    ++graph.start[b + 1];
  });
  for (std::size_t b = 1; b < graph.start.size(); ++b) graph.start[b] += graph.start[b - 1];
  graph.neighbour.resize(at(graph.start.back()));
  std::vector<idx_t> next(graph.start.begin(), graph.start.end() - 1);
  for_each_link([&](std::size_t a, std::size_t b) {
    graph.neighbour[at(next[a]++)] = static_cast<idx_t>(b);
    graph.neighbour[at(next[b]++)] = static_cast<idx_t>(a);
  });
  return graph;
}

// Unknowns in the order of elimination.
std::vector<int> elimination_order(const BlockPattern& pattern, int bodies) {
  idx_t blocks = pattern.blocks() - 2 * bodies;
  std::vector<idx_t> order(at(blocks)), place(order.size());
  if (blocks > 0) {
    Graph graph = graph_of(pattern, blocks);
    idx_t options[METIS_NOPTIONS];
    METIS_SetDefaultOptions(options);
    options[METIS_OPTION_SEED] = 1;
    if (METIS_NodeND(&blocks, graph.start.data(), graph.neighbour.data(), nullptr, options,
                     order.data(), place.data()) != METIS_OK)
      throw std::bad_alloc();
  }
  std::vector<int> unknowns;
  unknowns.reserve(3 * at(pattern.blocks()));
  for (const idx_t block : order)
    for (int a = 0; a < 3; ++a) unknowns.push_back(3 * static_cast<int>(block) + a);
  for (int u = 3 * blocks; u < 3 * pattern.blocks(); ++u) unknowns.push_back(u);
  return unknowns;
}

// The lower triangle by columns, as CHOLMOD wants it: column 3b + a has the rows a to 2 of the
// diagonal block, then three rows per partner.
class LowerTriangle {
 public:
  explicit LowerTriangle(const BlockMatrix& matrix) : LowerTriangle(matrix.pattern) {
    value_.reserve(row_.size());
    for (int b = 0; b < matrix.pattern.blocks(); ++b)
      for (int a = 0; a < 3; ++a)
        for (std::size_t k = matrix.pattern.begin(b); k < matrix.pattern.end(b); ++k)
          for (int i = matrix.pattern.partner[k] == b ? a : 0; i < 3; ++i)
            value_.push_back(matrix.block(k)(a, i));
  }
  // Without values.
  explicit LowerTriangle(const BlockPattern& pattern) {
    const std::size_t entries = 9 * pattern.partner.size();
    if (entries > at(std::numeric_limits<int>::max()))
      throw std::length_error("the stiffness matrix has more than 2^31 entries");
    row_.reserve(entries);
    column_start_.reserve(3 * at(pattern.blocks()) + 1);
    for (int b = 0; b < pattern.blocks(); ++b)
      for (int a = 0; a < 3; ++a) {
        for (std::size_t k = pattern.begin(b); k < pattern.end(b); ++k)
          for (int i = pattern.partner[k] == b ? a : 0; i < 3; ++i)
            row_.push_back(3 * pattern.partner[k] + i);
        column_start_.push_back(static_cast<int>(row_.size()));
      }
  }

  // CHOLMOD does not write to it.
  cholmod_sparse view() const {
    cholmod_sparse a{};
    a.nrow = a.ncol = column_start_.size() - 1;
    a.nzmax = row_.size();
    a.p = const_cast<int*>(column_start_.data());
    a.i = const_cast<int*>(row_.data());
    a.x = const_cast<double*>(value_.data());
    a.stype = -1;  // the lower triangle
    a.itype = CHOLMOD_INT;
    a.xtype = value_.empty() ? CHOLMOD_PATTERN : CHOLMOD_REAL;
    a.dtype = CHOLMOD_DOUBLE;
    a.sorted = 1;
    a.packed = 1;
    return a;
  }

 private:
  std::vector<int> column_start_ = {0}, row_;
  std::vector<double> value_;
};

cholmod_dense view(const Eigen::MatrixXd& matrix) {
  cholmod_dense b{};
  b.nrow = at(matrix.rows());
  b.ncol = at(matrix.cols());
  b.d = b.nrow;
  b.nzmax = b.nrow * b.ncol;
  b.x = const_cast<double*>(matrix.data());
  b.xtype = CHOLMOD_REAL;
  b.dtype = CHOLMOD_DOUBLE;
  return b;
}

}  // namespace

struct Factorisation::Impl {
  cholmod_common common{};
  cholmod_factor* factor = nullptr;
  FactorisationStats stats;

  Impl() {
    cholmod_start(&common);
    common.print = 0;
    common.supernodal = CHOLMOD_SUPERNODAL;
    common.nmethods = 1;
    common.method[0].ordering = CHOLMOD_GIVEN;
    common.postorder = 1;
  }
  ~Impl() {
    cholmod_free_factor(&factor, &common);
    cholmod_finish(&common);
  }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  void check(const char* step) const {
    if (common.status == CHOLMOD_OUT_OF_MEMORY || common.status == CHOLMOD_TOO_LARGE)
      throw std::bad_alloc();
    if (common.status < CHOLMOD_OK)
      throw std::runtime_error(fmt::format("CHOLMOD failed in {} ({})", step, common.status));
  }
};

Factorisation::Factorisation(const BlockPattern& pattern, int bodies)
    : impl_(std::make_unique<Impl>()) {
  cholmod_common& common = impl_->common;
  const auto start = std::chrono::steady_clock::now();
  std::vector<int> order = elimination_order(pattern, bodies);
  const LowerTriangle triangle(pattern);
  cholmod_sparse a = triangle.view();
  impl_->factor = cholmod_analyze_p(&a, order.data(), nullptr, 0, &common);
  impl_->check("the analysis");
  FactorisationStats& stats = impl_->stats;
  stats.ordering_seconds = seconds_since(start);
  stats.entries = common.lnz;
  stats.operations = common.fl;
  // The factor and its row numbers; its largest update, and the matrix twice, here and permuted.
  const auto entries = static_cast<double>(a.nzmax);
  stats.factor_bytes = 8.0 * static_cast<double>(impl_->factor->xsize) +
                       4.0 * static_cast<double>(impl_->factor->ssize);
  stats.bytes =
      stats.factor_bytes + 8.0 * static_cast<double>(impl_->factor->maxcsize) + 2 * 12 * entries;
}

Factorisation::Factorisation(const BlockMatrix& stiffness, int bodies)
    : Factorisation(stiffness.pattern, bodies) {
  factorise(stiffness);
}

void Factorisation::factorise(const BlockMatrix& stiffness) {
  const OneBlasThread same_digits_everywhere;
  cholmod_common& common = impl_->common;
  const auto start = std::chrono::steady_clock::now();
  const LowerTriangle triangle(stiffness);
  cholmod_sparse a = triangle.view();
  cholmod_factorize(&a, impl_->factor, &common);
  impl_->check("the factorisation");
  impl_->stats.factor_seconds = seconds_since(start);
  impl_->stats.reciprocal_condition =
      common.status == CHOLMOD_NOT_POSDEF ? 0 : cholmod_rcond(impl_->factor, &common);
  constexpr double smallest = 1e-15;  // a mechanism leaves a pivot of the order of the rounding
  if (!(impl_->stats.reciprocal_condition > smallest))
    throw SingularStiffness(
        "the stiffness matrix is not positive definite: a part of the body can move without "
        "resistance");
}

Factorisation::~Factorisation() = default;

Eigen::MatrixXd Factorisation::solve(const Eigen::MatrixXd& right_hand_sides) const {
  const OneBlasThread same_digits_everywhere;
  cholmod_dense b = view(right_hand_sides);
  cholmod_dense* x = cholmod_solve(CHOLMOD_A, impl_->factor, &b, &impl_->common);
  impl_->check("the solution");
  Eigen::MatrixXd result = Eigen::Map<const Eigen::MatrixXd>(
      static_cast<const double*>(x->x), right_hand_sides.rows(), right_hand_sides.cols());
  cholmod_free_dense(&x, &impl_->common);
  return result;
}

MultiVector Factorisation::solve(const MultiVector& right_hand_sides, int columns) const {
  Eigen::MatrixXd values(static_cast<Eigen::Index>(right_hand_sides.size()), columns);
  from_multi_vector(right_hand_sides, values);
  return to_multi_vector(solve(values));
}

const FactorisationStats& Factorisation::stats() const { return impl_->stats; }

}  // namespace kinetostat::fea
