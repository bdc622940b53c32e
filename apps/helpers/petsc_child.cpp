// Solves a model that kinetostat hands over by PETSc, on one process or several under MPI.
//
// Conjugate gradients with two-level p-multigrid: Chebyshev smoothing with 3x3 block Jacobi on the
// quadratic elements, and on the linear ones smoothed aggregation (GAMG) that knows the six rigid
// motions. Every process has the whole mesh and its own rows of the matrices.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <new>
#include <petscksp.h>
#include <stdexcept>
#include <sys/resource.h>

#include "kinetostat/fea/elasticity/p1_coarse_space.h"
#include "kinetostat/fea/elasticity/petsc_protocol.h"
#include "kinetostat/fea/linear_algebra/blas.h"

namespace {

using namespace kinetostat;
using namespace kinetostat::fea;

constexpr int most_iterations = 200;

void check(PetscErrorCode code) {
  if (code == 0) return;
  if (code == PETSC_ERR_MEM) throw std::bad_alloc();
  const char* text = nullptr;
  PetscErrorMessage(code, &text, nullptr);
  throw std::runtime_error(text == nullptr ? "unknown error" : text);
}

int rank() {
  int number = 0;
  MPI_Comm_rank(PETSC_COMM_WORLD, &number);
  return number;
}

int processes() {
  int number = 1;
  MPI_Comm_size(PETSC_COMM_WORLD, &number);
  return number;
}

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

// The bytes of a file that the first process reads, in all of them.
std::string read_everywhere(const char* path) {
  std::string bytes;
  if (rank() == 0) {
    std::ifstream file(path, std::ios::binary);
    bytes.assign(std::istreambuf_iterator<char>(file), {});
  }
  unsigned long long size = bytes.size();
  MPI_Bcast(&size, 1, MPI_UNSIGNED_LONG_LONG, 0, PETSC_COMM_WORLD);
  bytes.resize(size);
  constexpr unsigned long long at_once = 1 << 30;
  for (unsigned long long at = 0; at < size; at += at_once)
    MPI_Bcast(bytes.data() + at, static_cast<int>(std::min(at_once, size - at)), MPI_BYTE, 0,
              PETSC_COMM_WORLD);
  return bytes;
}

// The model of a request.
struct Model {
  TetMesh mesh;
  std::vector<Material> materials;
  DofMap unknowns;
};

std::vector<ReferenceBody> bodies_of(const petsc::Request& request) {
  std::vector<ReferenceBody> bodies;
  std::size_t at = 0;
  for (std::size_t b = 0; b < request.body_sizes.size(); ++b) {
    const auto size = static_cast<std::size_t>(request.body_sizes[b]);
    bodies.push_back({Vector3(request.body_points.data() + 3 * b),
                      {request.body_nodes.begin() + static_cast<std::ptrdiff_t>(at),
                       request.body_nodes.begin() + static_cast<std::ptrdiff_t>(at + size)}});
    at += size;
  }
  return bodies;
}

Model model_of(const petsc::Request& request) {
  TetMesh mesh{.order = request.shape.at(0),
               .connectivity = {request.connectivity.begin(), request.connectivity.end()},
               .materials = {request.element_materials.begin(), request.element_materials.end()},
               .curved = request.shape.at(1) != 0};
  for (std::size_t n = 0; n + 2 < request.nodes.size(); n += 3)
    mesh.nodes.emplace_back(request.nodes.data() + n);
  std::vector<Material> materials;
  for (std::size_t m = 0; m + 1 < request.materials.size(); m += 2)
    materials.emplace_back(request.materials[m], request.materials[m + 1]);
  DofMap unknowns(mesh, {request.fixed.begin(), request.fixed.end()}, bodies_of(request));
  std::vector<GroundSpring> springs;
  for (std::size_t s = 0; s < request.spring_nodes.size(); ++s)
    springs.push_back(
        {request.spring_nodes[s], kinetostat::fea::Matrix3(request.springs.data() + 9 * s)});
  unknowns.set_springs(std::move(springs));
  return {std::move(mesh), std::move(materials), std::move(unknowns)};
}

// The blocks of unknowns that this process holds: first to end - 1.
struct Share {
  int first, end;
  explicit Share(int blocks) {
    const auto bound = [&](int r) {
      return static_cast<int>(static_cast<long long>(blocks) * r / processes());
    };
    first = bound(rank());
    end = bound(rank() + 1);
  }
  int blocks() const { return end - first; }
};

// An empty matrix of 3x3 blocks with space for these entries in each of the own block rows.
Mat make_matrix(MatType type, int own_rows, int own_columns, const std::vector<PetscInt>& within,
                const std::vector<PetscInt>& beyond) {
  Mat matrix = nullptr;
  check(MatCreate(PETSC_COMM_WORLD, &matrix));
  check(MatSetSizes(matrix, 3 * own_rows, 3 * own_columns, PETSC_DETERMINE, PETSC_DETERMINE));
  check(MatSetType(matrix, type));
  check(MatSetBlockSizes(matrix, 3, 3));
  check(MatXAIJSetPreallocation(matrix, 3, within.data(), beyond.data(), nullptr, nullptr));
  return matrix;
}

void finish(Mat matrix) {
  check(MatAssemblyBegin(matrix, MAT_FINAL_ASSEMBLY));
  check(MatAssemblyEnd(matrix, MAT_FINAL_ASSEMBLY));
}

// Calls work(first, end) for parts of the own rows, so that little of the matrix is held twice.
template <class Work>
void in_parts(const Share& own, const Work& work) {
  constexpr int at_once = 30000;
  for (int first = own.first; first < own.end; first += at_once)
    work(first, std::min(first + at_once, own.end));
}

// The stiffness matrix; every process computes its own rows.
Mat stiffness_of(const TetMesh& mesh, const std::vector<Material>& materials,
                 const DofMap& unknowns, MatType type) {
  common::Progress silent;
  common::ThreadPool alone(1);
  const Share own(unknowns.blocks());
  std::vector<PetscInt> within, beyond;
  in_parts(own, [&](int first, int end) {
    const BlockPattern rows = find_rows(mesh, unknowns, first, end, alone);
    for (int r = 0; r < rows.blocks(); ++r) {
      within.push_back(0);
      for (std::size_t k = rows.begin(r); k < rows.end(r); ++k)
        if (rows.partner[k] >= own.first && rows.partner[k] < own.end) ++within.back();
      beyond.push_back(static_cast<PetscInt>(rows.end(r) - rows.begin(r)) - within.back());
    }
  });
  Mat matrix = make_matrix(type, own.blocks(), own.blocks(), within, beyond);
  in_parts(own, [&](int first, int end) {
    const BlockMatrix rows = assemble_rows(mesh, materials, unknowns, first, end, alone, silent);
    for (int r = 0; r < rows.pattern.blocks(); ++r)
      for (std::size_t k = rows.pattern.begin(r); k < rows.pattern.end(r); ++k) {
        const PetscInt row = first + r, column = rows.pattern.partner[k];
        check(MatSetValuesBlocked(matrix, 1, &row, 1, &column, rows.value.data() + 9 * k,
                                  INSERT_VALUES));
      }
  });
  finish(matrix);
  check(MatSetOption(matrix, MAT_SYMMETRIC, PETSC_TRUE));
  return matrix;
}

// The displacements of the corners as those of all nodes.
Mat prolongation_of(const TetMesh& mesh, const DofMap& fine, const DofMap& coarse) {
  const Share rows(fine.blocks()), columns(coarse.blocks());
  const Prolongation parts(mesh, fine, coarse);
  std::vector<PetscInt> within(static_cast<std::size_t>(rows.blocks()), 0), beyond(within);
  const auto for_own = [&](const auto& work) {
    parts.visit_parts([&](int row, int column, const Matrix3& factor) {
      if (row >= rows.first && row < rows.end) work(row, column, factor);
    });
  };
  for_own([&](int row, int column, const Matrix3&) {
    const bool inside = column >= columns.first && column < columns.end;
    ++(inside ? within : beyond)[static_cast<std::size_t>(row - rows.first)];
  });
  Mat matrix = make_matrix(MATAIJ, rows.blocks(), columns.blocks(), within, beyond);
  for_own([&](int row, int column, const Matrix3& factor) {
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        if (factor(i, j) != 0)
          check(MatSetValue(matrix, 3 * row + i, 3 * column + j, factor(i, j), ADD_VALUES));
  });
  finish(matrix);
  return matrix;
}

// The six motions of the whole model as a rigid body, about its middle: those of the nodes, and of
// the bodies.
void know_rigid_motions(Mat matrix, const TetMesh& mesh, const DofMap& unknowns) {
  const Share own(unknowns.blocks());
  const Vector3 middle = bounding_box(mesh.nodes).center();
  Vec modes[6];
  for (Vec& mode : modes) check(MatCreateVecs(matrix, &mode, nullptr));
  const auto set = [&](int block, const Eigen::Matrix<double, 3, 6>& motion) {
    if (block < own.first || block >= own.end) return;
    for (int k = 0; k < 6; ++k)
      for (int i = 0; i < 3; ++i)
        check(VecSetValue(modes[k], 3 * block + i, motion(i, k), INSERT_VALUES));
  };
  for (std::size_t n = 0; n < mesh.nodes.size(); ++n)
    set(unknowns.block_of(static_cast<int>(n)), spatial::rigid_motion(mesh.nodes[n] - middle));
  for (std::size_t b = 0; b < unknowns.bodies().size(); ++b) {
    Eigen::Matrix<double, 3, 6> rotation = Eigen::Matrix<double, 3, 6>::Zero();
    rotation.rightCols<3>().setIdentity();
    set(unknowns.body_block(b), spatial::rigid_motion(unknowns.bodies()[b].point - middle));
    set(unknowns.body_block(b) + 1, rotation);
  }
  for (int k = 0; k < 6; ++k) {
    check(VecAssemblyBegin(modes[k]));
    check(VecAssemblyEnd(modes[k]));
    for (int before = 0; before < k; ++before) {
      PetscScalar share = 0;
      check(VecDot(modes[k], modes[before], &share));
      check(VecAXPY(modes[k], -share, modes[before]));
    }
    check(VecNormalize(modes[k], nullptr));
  }
  MatNullSpace space = nullptr;
  check(MatNullSpaceCreate(PETSC_COMM_WORLD, PETSC_FALSE, 6, modes, &space));
  check(MatSetNearNullSpace(matrix, space));
  check(MatNullSpaceDestroy(&space));
  for (Vec& mode : modes) check(VecDestroy(&mode));
}

KSP make_solver(Mat fine, Mat coarse, Mat prolongation, double tolerance) {
  constexpr const char* options =
      "-mg_levels_ksp_type chebyshev -mg_levels_pc_type pbjacobi -mg_levels_ksp_max_it 3 "
      "-mg_coarse_ksp_type preonly -mg_coarse_pc_type gamg "
      "-mg_coarse_mg_levels_ksp_type chebyshev -mg_coarse_mg_levels_pc_type jacobi "
      "-mg_coarse_mg_levels_ksp_max_it 3";
  check(PetscOptionsInsertString(nullptr, options));
  KSP solver = nullptr;
  PC multigrid = nullptr;
  check(KSPCreate(PETSC_COMM_WORLD, &solver));
  check(KSPSetOperators(solver, fine, fine));
  check(KSPSetType(solver, KSPCG));
  check(KSPSetNormType(
      solver, KSP_NORM_NATURAL));  // the energy of the error, as the preconditioner sees it
  check(KSPSetTolerances(solver, tolerance, 0, PETSC_DEFAULT, most_iterations));
  check(KSPGetPC(solver, &multigrid));
  check(PCSetType(multigrid, PCMG));
  check(PCMGSetLevels(multigrid, 2, nullptr));
  check(PCMGSetInterpolation(multigrid, 1, prolongation));
  KSP below = nullptr;
  check(PCMGGetCoarseSolve(multigrid, &below));
  check(KSPSetOperators(below, coarse, coarse));
  check(KSPSetFromOptions(solver));
  check(KSPSetUp(solver));
  return solver;
}

// All values of a vector on the first process, none on the others.
class Gather {
 public:
  explicit Gather(Vec like) { check(VecScatterCreateToZero(like, &scatter_, &here_)); }
  ~Gather() {
    VecScatterDestroy(&scatter_);
    VecDestroy(&here_);
  }
  Gather(const Gather&) = delete;
  Gather& operator=(const Gather&) = delete;

  void append(Vec from, std::vector<double>& values) {
    check(VecScatterBegin(scatter_, from, here_, INSERT_VALUES, SCATTER_FORWARD));
    check(VecScatterEnd(scatter_, from, here_, INSERT_VALUES, SCATTER_FORWARD));
    PetscInt size = 0;
    const PetscScalar* data = nullptr;
    check(VecGetLocalSize(here_, &size));
    check(VecGetArrayRead(here_, &data));
    values.insert(values.end(), data, data + size);
    check(VecRestoreArrayRead(here_, &data));
  }

 private:
  VecScatter scatter_ = nullptr;
  Vec here_ = nullptr;
};

double peak_of_all() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  double own = 1024.0 * static_cast<double>(usage.ru_maxrss), all = 0;
  MPI_Allreduce(&own, &all, 1, MPI_DOUBLE, MPI_SUM, PETSC_COMM_WORLD);
  return all;
}

// Solves for all loads, one after the other; false when one does not converge.
bool solve(KSP solver, Mat matrix, const std::vector<double>& loads, petsc::Answer& answer,
           double& worst, int& most) {
  Vec load = nullptr, x = nullptr;
  check(MatCreateVecs(matrix, &x, &load));
  PetscInt size = 0, first = 0, end = 0;
  check(VecGetSize(x, &size));
  check(VecGetOwnershipRange(x, &first, &end));
  Gather gather(x);
  bool converged = true;
  for (std::size_t at = 0; at + static_cast<std::size_t>(size) <= loads.size();
       at += static_cast<std::size_t>(size)) {
    PetscScalar* data = nullptr;
    check(VecGetArray(load, &data));
    std::copy(loads.begin() + static_cast<std::ptrdiff_t>(at) + first,
              loads.begin() + static_cast<std::ptrdiff_t>(at) + end, data);
    check(VecRestoreArray(load, &data));
    check(KSPSetResidualHistory(solver, nullptr, most_iterations + 1, PETSC_TRUE));
    check(KSPSolve(solver, load, x));
    KSPConvergedReason reason = KSP_CONVERGED_ITERATING;
    PetscInt iterations = 0;
    const PetscReal* history = nullptr;
    check(KSPGetConvergedReason(solver, &reason));
    check(KSPGetResidualHistory(solver, &history, &iterations));
    converged = converged && reason > 0;
    most = std::max(most, static_cast<int>(iterations) - 1);
    if (iterations > 0 && history[0] > 0)
      worst = std::max(worst, history[iterations - 1] / history[0]);
    gather.append(x, answer.x);
  }
  check(VecDestroy(&load));
  check(VecDestroy(&x));
  return converged;
}

int run(const char* input, const char* output, double tolerance) {
  petsc::Request request;
  if (!decode(read_everywhere(input), request)) return petsc::exit_bad_request;
  const auto start = std::chrono::steady_clock::now();
  const Model model = model_of(request);
  const std::vector<double> loads = std::move(request.loads);
  request = {};
  const P1CoarseSpace corners = p1_coarse_space(model.mesh, model.unknowns);
  Mat prolongation = prolongation_of(model.mesh, model.unknowns, corners.unknowns);
  Mat coarse = stiffness_of(corners.mesh, model.materials, corners.unknowns, MATAIJ);
  check(MatSetOption(coarse, MAT_SPD, PETSC_TRUE));
  know_rigid_motions(coarse, corners.mesh, corners.unknowns);
  Mat fine = stiffness_of(model.mesh, model.materials, model.unknowns, MATBAIJ);
  KSP solver = make_solver(fine, coarse, prolongation, tolerance);
  const double setup = seconds_since(start);
  petsc::Answer answer;
  double worst = 0;
  int most = 0;
  const bool converged = solve(solver, fine, loads, answer, worst, most);
  answer.numbers = {static_cast<double>(most),       worst,
                    3.0 * corners.unknowns.blocks(), setup,
                    seconds_since(start) - setup,    peak_of_all()};
  check(KSPDestroy(&solver));
  for (Mat* matrix : {&fine, &coarse, &prolongation}) check(MatDestroy(matrix));
  if (!converged) return petsc::exit_not_converged;
  if (rank() != 0) return petsc::exit_done;
  const std::string bytes = encode(answer);
  std::ofstream file(output, std::ios::binary);
  file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  file.flush();
  return file ? petsc::exit_done : EXIT_FAILURE;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc == 2 && std::string(argv[1]) == "--version") {
    std::printf("kinetostat-petsc %s with PETSc %d.%d, BSD-2-Clause\n", KINETOSTAT_VERSION,
                PETSC_VERSION_MAJOR, PETSC_VERSION_MINOR);
    return 0;
  }
  if (argc != 4) return petsc::exit_bad_request;
  int none = 1;
  if (PetscInitialize(&none, &argv, nullptr, nullptr) != 0) return EXIT_FAILURE;
  PetscPushErrorHandler(PetscReturnErrorHandler, nullptr);
  int code = EXIT_FAILURE;
  try {
    const OneBlasThread beside_the_other_processes;
    code = run(argv[1], argv[2], std::strtod(argv[3], nullptr));
  } catch (const std::bad_alloc&) {
    MPI_Abort(PETSC_COMM_WORLD, petsc::exit_out_of_memory);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    MPI_Abort(PETSC_COMM_WORLD, code);
  }
  PetscFinalize();
  return code;
}
