// Solves a model that kinetostat hands over by PETSc, on one process or several under MPI.
//
// The first process reads the model, divides it and sends each process the elements that touch its
// unknowns. Each makes its own rows of the matrices; loads and displacements pass one by one.
#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <new>
#include <stdexcept>
#include <string>

#include "kinetostat/apps/helpers/petsc/answer_file.h"
#include "kinetostat/apps/helpers/petsc/multigrid.h"
#include "kinetostat/apps/helpers/petsc/processes.h"
#include "kinetostat/common/memory.h"
#include "kinetostat/fea/linear_algebra/blas.h"

namespace {

using namespace kinetostat;
using namespace kinetostat::petsc;

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

// Solves for all loads, one after the other: the most iterations and the worst residual.
Multigrid::Result solve_all(Multigrid& multigrid, const ColumnExchange& columns,
                            RequestFile& request, AnswerFile& answer, int count) {
  Multigrid::Result all{.converged = true};
  Vec load = multigrid.make_vector(), x = multigrid.make_vector();
  for (int column = 0; column < count; ++column) {
    columns.scatter(rank() == 0 ? request.next_column() : std::vector<double>(), load);
    const Multigrid::Result result = multigrid.solve(load, x);
    all.converged = all.converged && result.converged;
    all.iterations = std::max(all.iterations, result.iterations);
    all.residual = std::max(all.residual, result.residual);
    answer.append(columns.gather(x));
  }
  check(VecDestroy(&load));
  check(VecDestroy(&x));
  return all;
}

int run(const char* input, const char* output, double tolerance) {
  const bool first = rank() == 0;
  RequestFile request = first ? RequestFile(input) : RequestFile();
  const auto start = std::chrono::steady_clock::now();
  ModelShare share = share_model(request);
  const int count = from_first(request.columns());
  const double most_elements = largest_of_all(static_cast<double>(share.part.mesh.element_count()));
  Multigrid multigrid(share, tolerance);
  const double setup = seconds_since(start);
  AnswerFile answer = first ? AnswerFile(output, static_cast<std::uint64_t>(share.unknowns) *
                                                     static_cast<std::uint64_t>(count))
                            : AnswerFile();
  const auto result = solve_all(multigrid, share.columns, request, answer, count);
  const double peak = common::peak_memory();
  const fea::petsc::Figures figures{.iterations = static_cast<double>(result.iterations),
                                    .residual = result.residual,
                                    .coarse_unknowns = static_cast<double>(share.corner_unknowns),
                                    .setup_seconds = setup,
                                    .solve_seconds = seconds_since(start) - setup,
                                    .bytes = sum_of_all(peak),
                                    .largest_bytes = largest_of_all(peak),
                                    .most_elements = most_elements};
  if (!result.converged) return fea::petsc::exit_not_converged;
  return !first || answer.finish(figures) ? fea::petsc::exit_done : EXIT_FAILURE;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc == 2 && std::string(argv[1]) == "--version") {
    std::printf("kinetostat-petsc %s with PETSc %d.%d, BSD-2-Clause\n", KINETOSTAT_VERSION,
                PETSC_VERSION_MAJOR, PETSC_VERSION_MINOR);
    return 0;
  }
  if (argc != 4) return fea::petsc::exit_bad_request;
  int none = 1;
  if (PetscInitialize(&none, &argv, nullptr, nullptr) != 0) return EXIT_FAILURE;
  keep_what_is_said();
  int code = EXIT_FAILURE;
  try {
    const fea::OneBlasThread beside_the_other_processes;
    code = run(argv[1], argv[2], std::strtod(argv[3], nullptr));
  } catch (const std::bad_alloc&) {
    MPI_Abort(PETSC_COMM_WORLD, fea::petsc::exit_out_of_memory);
  } catch (const BadRequest&) {
    MPI_Abort(PETSC_COMM_WORLD, fea::petsc::exit_bad_request);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    MPI_Abort(PETSC_COMM_WORLD, code);
  }
  PetscFinalize();
  return code;
}
