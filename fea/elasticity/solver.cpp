#include "kinetostat/fea/elasticity/solver.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "kinetostat/common/index.h"
#include "kinetostat/common/memory.h"
#include "kinetostat/fea/elasticity/p_multigrid.h"
#include "kinetostat/fea/linear_algebra/conjugate_gradients.h"

namespace kinetostat::fea {
namespace {

using common::at;

using Clock = std::chrono::steady_clock;
double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

// Below, the factorisation takes a second at most and has no tolerance.
constexpr int small_model = 8000;  // blocks of three unknowns

// For forecasts of time: floating-point operations of a factorisation per second; unknowns that
// multigrid solves per second and thread for a batch of loads.
constexpr double factorisation_rate = 20e9, multigrid_rate = 1e5;
constexpr int usual_iterations = 13;  // that such a batch takes
// Unknowns times loads that a process of PETSc solves per second.
constexpr double petsc_rate = 5e4;

constexpr int most_refinement_steps = 4;

double change(const Eigen::MatrixXd& correction, const Eigen::MatrixXd& solution) {
  const double smallest = std::numeric_limits<double>::min();  // a load of zero moves nothing
  return (correction.colwise().norm().array() / solution.colwise().norm().array().max(smallest))
      .maxCoeff();
}

// Each step multiplies the error by about the same factor, which the last two corrections show.
int refine(const BlockMatrix& stiffness, const Factorisation& factorisation,
           const Eigen::MatrixXd& loads, Eigen::MatrixXd& x) {
  int steps = 0;
  double last = 1, expected = 1;
  while (expected > 1e-14 && steps < most_refinement_steps) {
    const Eigen::MatrixXd correction = factorisation.solve(stiffness.residual(loads, x));
    const double now = change(correction, x);
    if (now > 0.5 * last) break;
    x += correction;
    ++steps;
    expected = now * (now / last);
    last = now;
  }
  return steps;
}

// One model, one method after another.
class Task {
 public:
  Task(const TetMesh& mesh, const std::vector<Material>& materials, const DofMap& unknowns,
       const Eigen::MatrixXd& loads, const SolverOptions& options, common::Progress& progress)
      : mesh_(mesh),
        materials_(materials),
        unknowns_(unknowns),
        loads_(loads),
        options_(options),
        progress_(progress),
        pool_(std::max(options.threads, 1)),
        limit_(options.memory > 0 ? options.memory : common::memory_share()) {
    stats_.unknowns = 3 * at(unknowns.blocks());
    stats_.levels = {stats_.unknowns};
    stats_.bytes_before = common::resident_memory();
  }

  Solution run() {
    const bool first_order = mesh_.order == 1, small = unknowns_.blocks() <= small_model;
    const bool asked = options_.method != SolverMethod::automatic;
    std::optional<Eigen::MatrixXd> x;
    if (options_.method == SolverMethod::direct || (!asked && small)) {
      stats_.reason = asked ? "as asked for" : "small model";
    } else if (first_order) {
      stats_.reason = "elements of first order have no coarser ones";
    } else {
      stats_.reason = asked ? "as asked for" : "faster and smaller than the factors of the matrix";
      x = options_.method == SolverMethod::petsc ? solve_by_petsc() : try_multigrid();
    }
    if (!x) x = solve_directly();
    stats_.peak_bytes = common::peak_memory();
    return {std::move(*x), std::move(stats_)};
  }

 private:
  const BlockMatrix& stiffness() {
    if (!stiffness_) {
      const auto start = Clock::now();
      stiffness_ = assemble(mesh_, materials_, unknowns_, pool_, progress_);
      stats_.assembly_seconds = seconds_since(start);
    }
    return *stiffness_;
  }

  void require(SolverMethod method, const SolverForecast& forecast) const {
    const double needed = stats_.bytes_before + forecast.bytes;
    if (needed > limit_) throw MemoryLimit(method, needed, limit_);
  }

  // In other processes, which share this machine unless the launcher says otherwise. The error of
  // an entry off the diagonal is of the order of the tolerance: a tenth of it makes up for what the
  // algebraic coarse level adds.
  Eigen::MatrixXd solve_by_petsc() {
    stats_.method = SolverMethod::petsc;
    if (!has_petsc())
      throw PetscFailure(
          "the helper program kinetostat-petsc is not installed; it is built where PETSc is "
          "(Debian: libpetsc-real-dev)");
    if (!mesh_.contacts.empty())
      throw PetscFailure("joints between bodies are not solved by PETSc");
    forecast_petsc();
    if (options_.processes == 1) require(SolverMethod::petsc, stats_.petsc);
    PetscSolution solution = solve_with_petsc(mesh_, materials_, unknowns_, loads_,
                                              {.processes = options_.processes,
                                               .launcher = options_.launcher,
                                               .tolerance = 0.1 * options_.tolerance},
                                              progress_);
    count(solution);
    return std::move(solution.x);
  }

  void count(const PetscSolution& solution) {
    stats_.iterations = solution.iterations;
    stats_.residual = solution.residual;
    stats_.levels.push_back(solution.coarse_unknowns);
    stats_.setup_seconds = solution.setup_seconds;
    stats_.solve_seconds = solution.solve_seconds;
    stats_.helper_bytes = solution.bytes;
    stats_.largest_helper_bytes = solution.largest_bytes;
    stats_.most_elements = solution.most_elements;
  }

  void forecast_petsc() {
    stats_.petsc = {.bytes = petsc_bytes(stats_.unknowns, at(loads_.cols()), options_.processes),
                    .seconds = static_cast<double>(stats_.unknowns) *
                               static_cast<double>(loads_.cols()) /
                               (petsc_rate * options_.processes)};
  }

  Eigen::MatrixXd solve_directly() {
    stats_.method = SolverMethod::direct;
    stats_.levels = {stats_.unknowns};
    stiffness();
    auto start = Clock::now();
    progress_.report("ordering", 0);
    Factorisation factorisation(stiffness().pattern, bodies());
    stats_.direct = {.bytes = static_cast<double>(stiffness().bytes()) +
                              factorisation.stats().bytes +
                              sizeof(double) * static_cast<double>(loads_.size()),
                     .seconds = factorisation.stats().operations / factorisation_rate};
    require(SolverMethod::direct, stats_.direct);
    progress_.report("factorisation", 0);
    factorisation.factorise(stiffness());
    stats_.factor = factorisation.stats();
    stats_.setup_seconds += seconds_since(start);
    progress_.report("solution", 0);
    start = Clock::now();
    Eigen::MatrixXd x = factorisation.solve(loads_);
    stats_.iterations = refine(stiffness(), factorisation, loads_, x);
    stats_.solve_seconds += seconds_since(start);
    return x;
  }

  // Nothing when another method has to follow; the reason says why.
  std::optional<Eigen::MatrixXd> try_multigrid() {
    stats_.method = SolverMethod::multigrid;
    const auto start = Clock::now();
    CoarseLevel coarse(mesh_, materials_, unknowns_, pool_, progress_);
    const double before = seconds_since(start);
    stiffness();
    const auto setup = Clock::now();
    MultiVectorProduct product(stiffness(), pool_);
    choose_coarse_solver(coarse);
    forecast_multigrid(coarse, product);
    require(SolverMethod::multigrid, stats_.multigrid);
    try {
      progress_.report("coarse factorisation", 0);
      coarse.begin_factorisation();
      PMultigrid multigrid(product, coarse, columns(), progress_);
      coarse.finish_factorisation();
      stats_.factor = coarse.stats();
      stats_.setup_seconds = before + seconds_since(setup);
      return iterate(product, multigrid);
    } catch (const SingularStiffness&) {
      stats_.reason = "the corners alone are not supported";
    }
    return {};
  }

  // By the operations of the corners' factors alone, so that the result does not depend on the
  // memory that happens to be free.
  void choose_coarse_solver(CoarseLevel& coarse) {
    const FactorisationStats corners = coarse.analyse();
    forecast_direct(corners, coarse.unknowns().front());
    if (corners.operations > options_.most_coarse_operations) {
      coarse.aggregate(options_.most_coarse_operations, progress_);
      stats_.reason += "; the corners by rigid aggregates, faster and smaller than their factors";
    }
    const std::vector<std::size_t> levels = coarse.unknowns();
    stats_.levels.insert(stats_.levels.end(), levels.begin(), levels.end());
  }

  // Iterations of a batch that take as long as the direct method would; without end where that has
  // no room, or where multigrid was asked for. On one thread, so that the result is that of any
  // number of them.
  double most_left() const {
    constexpr double fewest = 10;
    const bool has_room = stats_.bytes_before + stats_.direct.bytes <= limit_;
    if (!has_room || options_.method != SolverMethod::automatic)
      return std::numeric_limits<double>::infinity();
    const double iteration =
        static_cast<double>(stats_.unknowns) / (multigrid_rate * usual_iterations);
    return std::max(fewest, stats_.direct.seconds / (iteration * static_cast<double>(batches())));
  }

  std::string unconverged(const ConjugateGradientResult& result) const {
    return fmt::format(
        "multigrid reached {:.1e} of {:.0e} in {} iterations: badly shaped elements or a "
        "Poisson's ratio near 0.5",
        result.residual, options_.tolerance, result.iterations);
  }

  std::optional<Eigen::MatrixXd> iterate(MultiVectorProduct& product, PMultigrid& multigrid) {
    const auto start = Clock::now();
    Eigen::MatrixXd x(loads_.rows(), loads_.cols());
    for (Eigen::Index first = 0; first < loads_.cols(); first += columns()) {
      const Eigen::Index count = std::min<Eigen::Index>(columns(), loads_.cols() - first);
      MultiVector b = to_multi_vector(loads_.middleCols(first, count));
      const ConjugateGradientResult result = conjugate_gradients(
          product, b, std::ref(multigrid),
          {.tolerance = options_.tolerance, .most_left = most_left()}, progress_);
      stats_.iterations = std::max(stats_.iterations, result.iterations);
      stats_.residual = std::max(stats_.residual, result.residual);
      if (!result.converged) {
        stats_.reason = unconverged(result);
        return {};
      }
      from_multi_vector(result.x, x.middleCols(first, count));
    }
    stats_.solve_seconds = seconds_since(start);
    return x;
  }

  // The factors of the corners' matrix say how those of the whole would grow: in a solid the
  // entries go with the power 4/3 of the unknowns and the operations with their square (George's
  // nested dissection). `rows_fuller` was found on solid blocks of 20,000 to 150,000 unknowns.
  void forecast_direct(const FactorisationStats& corners, std::size_t corner_unknowns) {
    constexpr double rows_fuller = 1.25;
    const double ratio = static_cast<double>(stats_.unknowns) /
                         static_cast<double>(std::max<std::size_t>(corner_unknowns, 1));
    stats_.direct = {.bytes = rows_fuller * std::pow(ratio, 4.0 / 3) * corners.bytes,
                     .seconds = ratio * ratio * corners.operations / factorisation_rate};
  }

  // Vectors of all lanes: five while the largest eigenvalue is looked for beside the factorisation,
  // eight while conjugate gradients run.
  void forecast_multigrid(const CoarseLevel& coarse, const MultiVectorProduct& product) {
    const auto unknowns = static_cast<double>(stats_.unknowns);
    const double inverse_diagonal = 3.0 * sizeof(double);
    const double solution = sizeof(double) * static_cast<double>(loads_.cols());
    stats_.multigrid = {
        .bytes = static_cast<double>(stiffness().bytes() + product.bytes()) +
                 inverse_diagonal * unknowns +
                 std::max(5.0 * sizeof(Lanes) * unknowns + coarse.working_bytes(),
                          (8.0 * sizeof(Lanes) + solution) * unknowns + coarse.bytes()),
        .seconds = unknowns * static_cast<double>(batches()) / (multigrid_rate * pool_.threads()) +
                   coarse.stats().operations / factorisation_rate};
  }

  int bodies() const { return static_cast<int>(unknowns_.bodies().size()); }
  Eigen::Index batches() const { return (loads_.cols() + lane_count - 1) / lane_count; }
  // Of a batch: even shares.
  int columns() const {
    return static_cast<int>((loads_.cols() + batches() - 1) / std::max<Eigen::Index>(batches(), 1));
  }

  const TetMesh& mesh_;
  const std::vector<Material>& materials_;
  const DofMap& unknowns_;
  const Eigen::MatrixXd& loads_;
  const SolverOptions& options_;
  common::Progress& progress_;
  common::ThreadPool pool_;
  double limit_;
  std::optional<BlockMatrix> stiffness_;
  SolverStats stats_;
};

double gibibytes(double bytes) { return bytes / (1 << 30); }

}  // namespace

const char* name(SolverMethod method) {
  switch (method) {
    case SolverMethod::direct:
      return "direct";
    case SolverMethod::multigrid:
      return "multigrid";
    case SolverMethod::petsc:
      return "petsc";
    default:
      return "automatic";
  }
}

MemoryLimit::MemoryLimit(SolverMethod method, double needed, double limit)
    : text_(fmt::format("the {} solver needs {:.3g} GiB of memory, and {:.3g} GiB are allowed",
                        name(method), gibibytes(needed), gibibytes(limit))) {}

Solution solve(const TetMesh& mesh, const std::vector<Material>& materials, const DofMap& unknowns,
               const Eigen::MatrixXd& loads, const SolverOptions& options,
               common::Progress& progress) {
  return Task(mesh, materials, unknowns, loads, options, progress).run();
}

}  // namespace kinetostat::fea
