#include "kinetostat/apps/helpers/petsc/matrices.h"

#include <algorithm>

#include "kinetostat/apps/helpers/petsc/processes.h"
#include "kinetostat/common/index.h"
#include "kinetostat/fea/elasticity/p1_coarse_space.h"

namespace kinetostat::petsc {
namespace {

using common::at;
using fea::BlockNumbers;
using fea::DofMap;
using fea::Matrix3;
using fea::TetMesh;
using fea::Vector3;

// Blocks of a part's DofMap that follow one another: first to end - 1.
struct BlockRange {
  int first, end;
};

// The own ones in the order of their numbers.
std::vector<BlockRange> own_blocks(const DofMap& unknowns, const BlockNumbers& numbers) {
  const int nodes = numbers.first_of_bodies - numbers.first;
  std::vector<BlockRange> own{{numbers.first_block(), numbers.first_block() + nodes}};
  for (std::size_t b = 0; b < numbers.of_bodies.size(); ++b)
    if (numbers.is_own(numbers.of_bodies[b]))
      own.push_back({unknowns.body_block(b), unknowns.body_block(b) + 2});
  return own;
}

// The number of blocks in each own row: in columns of this process, and of the others.
struct RowSizes {
  std::vector<PetscInt> within, beyond;
};

// An empty matrix of 3x3 blocks with space for these. No process adds to the rows of another.
Mat make_matrix(MatType type, int own_columns, const RowSizes& sizes) {
  Mat matrix = nullptr;
  const int own_rows = static_cast<int>(sizes.within.size());
  check(MatCreate(PETSC_COMM_WORLD, &matrix));
  check(MatSetSizes(matrix, 3 * own_rows, 3 * own_columns, PETSC_DETERMINE, PETSC_DETERMINE));
  check(MatSetType(matrix, type));
  check(MatSetBlockSizes(matrix, 3, 3));
  check(MatXAIJSetPreallocation(matrix, 3, sizes.within.data(), sizes.beyond.data(), nullptr,
                                nullptr));
  check(MatSetOption(matrix, MAT_NO_OFF_PROC_ENTRIES, PETSC_TRUE));
  return matrix;
}

void finish(Mat matrix) {
  check(MatAssemblyBegin(matrix, MAT_FINAL_ASSEMBLY));
  check(MatAssemblyEnd(matrix, MAT_FINAL_ASSEMBLY));
}

RowSizes row_sizes(const TetMesh& mesh, const DofMap& unknowns, const BlockNumbers& numbers) {
  common::ThreadPool alone(1);
  RowSizes sizes;
  for (const auto& [first, end] : own_blocks(unknowns, numbers)) {
    const fea::BlockPattern rows = find_rows(mesh, unknowns, first, end, alone);
    for (int r = 0; r < rows.blocks(); ++r) {
      const auto within = std::count_if(
          rows.partner.begin() + rows.start[at(r)], rows.partner.begin() + rows.start[at(r) + 1],
          [&numbers](int block) { return numbers.is_own(numbers.of_block(block)); });
      sizes.within.push_back(static_cast<PetscInt>(within));
      sizes.beyond.push_back(static_cast<PetscInt>(rows.end(r) - rows.begin(r)) -
                             sizes.within.back());
    }
  }
  return sizes;
}

// work(range) for parts of the own rows, so that little of the matrix is held twice.
template <class Work>
void in_parts(const std::vector<BlockRange>& own, const Work& work) {
  constexpr int at_once = 30000;
  for (const auto& [begin, end] : own)
    for (int first = begin; first < end; first += at_once)
      work(BlockRange{first, std::min(first + at_once, end)});
}

// The middle of the nodes of all processes.
Vector3 middle_of_all(const TetMesh& mesh) {
  const fea::Box own = fea::bounding_box(mesh.nodes);  // without nodes it spans nothing
  Vector3 middle;
  for (int k = 0; k < 3; ++k)
    middle[k] = 0.5 * (least_of_all(own.min()[k]) + largest_of_all(own.max()[k]));
  return middle;
}

// Makes the vectors an orthonormal basis of what they span.
void make_orthonormal(Vec (&modes)[6]) {
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
}

// Takes them.
MatNullSpace space_of(Vec (&modes)[6]) {
  MatNullSpace space = nullptr;
  check(MatNullSpaceCreate(PETSC_COMM_WORLD, PETSC_FALSE, 6, modes, &space));
  for (Vec& mode : modes) check(VecDestroy(&mode));
  return space;
}

}  // namespace

Mat stiffness_of(const TetMesh& mesh, const std::vector<fea::Material>& materials,
                 const DofMap& unknowns, const BlockNumbers& numbers, MatType type) {
  common::Progress silent;
  common::ThreadPool alone(1);
  Mat matrix = make_matrix(type, numbers.own(), row_sizes(mesh, unknowns, numbers));
  in_parts(own_blocks(unknowns, numbers), [&](const BlockRange& range) {
    const fea::BlockMatrix rows =
        assemble_rows(mesh, materials, unknowns, range.first, range.end, alone, silent);
    for (int r = 0; r < rows.pattern.blocks(); ++r)
      for (std::size_t k = rows.pattern.begin(r); k < rows.pattern.end(r); ++k) {
        const PetscInt row = numbers.of_block(range.first + r);
        const PetscInt column = numbers.of_block(rows.pattern.partner[k]);
        check(MatSetValuesBlocked(matrix, 1, &row, 1, &column, rows.value.data() + 9 * k,
                                  INSERT_VALUES));
      }
  });
  finish(matrix);
  check(MatSetOption(matrix, MAT_SYMMETRIC, PETSC_TRUE));
  return matrix;
}

Mat prolongation_of(const fea::ModelPart& part, const DofMap& corners) {
  const fea::Prolongation parts(part.mesh, part.unknowns, corners);
  const auto for_own = [&](const auto& work) {
    parts.visit_parts([&](int block, int corner, const Matrix3& factor) {
      const int row = part.fine.of_block(block);
      if (part.fine.is_own(row)) work(row, part.corners.of_block(corner), factor);
    });
  };
  RowSizes sizes{std::vector<PetscInt>(at(part.fine.own()), 0), {}};
  sizes.beyond = sizes.within;
  for_own([&](int row, int column, const Matrix3&) {
    ++(part.corners.is_own(column) ? sizes.within : sizes.beyond)[at(row - part.fine.first)];
  });
  Mat matrix = make_matrix(MATAIJ, part.corners.own(), sizes);
  for_own([&](int row, int column, const Matrix3& factor) {
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        if (factor(i, j) != 0)
          check(MatSetValue(matrix, 3 * row + i, 3 * column + j, factor(i, j), ADD_VALUES));
  });
  finish(matrix);
  return matrix;
}

void know_rigid_motions(Mat matrix, const TetMesh& mesh, const DofMap& unknowns,
                        const BlockNumbers& numbers) {
  const Vector3 middle = middle_of_all(mesh);
  Vec modes[6];
  for (Vec& mode : modes) check(MatCreateVecs(matrix, &mode, nullptr));
  const auto set = [&](int block, const Eigen::Matrix<double, 3, 6>& motion) {
    if (block < 0 || !numbers.is_own(numbers.of_block(block))) return;
    for (int k = 0; k < 6; ++k)
      for (int i = 0; i < 3; ++i)
        check(VecSetValue(modes[k], 3 * numbers.of_block(block) + i, motion(i, k), INSERT_VALUES));
  };
  for (std::size_t n = 0; n < mesh.nodes.size(); ++n)
    set(unknowns.block_of(static_cast<int>(n)), spatial::rigid_motion(mesh.nodes[n] - middle));
  for (std::size_t b = 0; b < unknowns.bodies().size(); ++b) {
    Eigen::Matrix<double, 3, 6> rotation = Eigen::Matrix<double, 3, 6>::Zero();
    rotation.rightCols<3>().setIdentity();
    set(unknowns.body_block(b), spatial::rigid_motion(unknowns.bodies()[b].point - middle));
    set(unknowns.body_block(b) + 1, rotation);
  }
  make_orthonormal(modes);
  MatNullSpace space = space_of(modes);
  check(MatSetNearNullSpace(matrix, space));
  check(MatNullSpaceDestroy(&space));
}

RowsOfBodies rows_of_bodies(Mat matrix, const BlockNumbers& numbers) {
  std::vector<PetscInt> of_bodies;
  for (const int block : numbers.of_bodies)
    for (int i = 0; i < 6 && numbers.is_own(block); ++i) of_bodies.push_back(3 * block + i);
  PetscInt first = 0, end = 0;
  check(MatGetOwnershipRange(matrix, &first, &end));
  RowsOfBodies rows;
  check(ISCreateGeneral(PETSC_COMM_WORLD, static_cast<PetscInt>(of_bodies.size()), of_bodies.data(),
                        PETSC_COPY_VALUES, &rows.bodies));
  check(ISComplement(rows.bodies, first, end, &rows.nodes));
  for (IS some : {rows.bodies, rows.nodes}) check(ISSetBlockSize(some, 3));
  MatNullSpace all = nullptr;
  const Vec* motions = nullptr;
  check(MatGetNearNullSpace(matrix, &all));
  check(MatNullSpaceGetVecs(all, nullptr, nullptr, &motions));
  Vec modes[6];
  for (int k = 0; k < 6; ++k) {
    Vec some = nullptr;
    check(VecGetSubVector(motions[k], rows.nodes, &some));
    check(VecDuplicate(some, &modes[k]));
    check(VecCopy(some, modes[k]));
    check(VecRestoreSubVector(motions[k], rows.nodes, &some));
  }
  make_orthonormal(modes);
  MatNullSpace space = space_of(modes);
  check(PetscObjectCompose(reinterpret_cast<PetscObject>(rows.nodes), "nearnullspace",
                           reinterpret_cast<PetscObject>(space)));
  check(MatNullSpaceDestroy(&space));
  return rows;
}

}  // namespace kinetostat::petsc
