#include "kinetostat/apps/helpers/petsc/column_exchange.h"

#include <algorithm>

#include "kinetostat/apps/helpers/petsc/processes.h"
#include "kinetostat/common/index.h"

namespace kinetostat::petsc {
namespace {

using common::at;

int values_of(const std::vector<int>& first, int process) {
  return 3 * (first[at(process) + 1] - first[at(process)]);
}

}  // namespace

void ColumnExchange::scatter(const std::vector<double>& column, Vec to) const {
  PetscInt size = 0;
  PetscScalar* own = nullptr;
  check(VecGetLocalSize(to, &size));
  check(VecGetArray(to, &own));
  if (rank() != 0) {
    MPI_Recv(own, size, MPI_DOUBLE, 0, 0, PETSC_COMM_WORLD, MPI_STATUS_IGNORE);
  } else {
    const auto copy = [&](int process, double* values) {
      for (int number = first_[at(process)]; number < first_[at(process) + 1]; ++number)
        values = std::copy_n(column.data() + 3 * at(blocks_[at(number)]), 3, values);
    };
    copy(0, own);
    std::vector<double> values;
    for (int process = 1; process < processes(); ++process) {
      values.resize(at(values_of(first_, process)));
      copy(process, values.data());
      MPI_Send(values.data(), values_of(first_, process), MPI_DOUBLE, process, 0, PETSC_COMM_WORLD);
    }
  }
  check(VecRestoreArray(to, &own));
}

std::vector<double> ColumnExchange::gather(Vec from) const {
  PetscInt size = 0;
  const PetscScalar* own = nullptr;
  std::vector<double> column(3 * blocks_.size());
  check(VecGetLocalSize(from, &size));
  check(VecGetArrayRead(from, &own));
  if (rank() != 0) {
    MPI_Send(own, size, MPI_DOUBLE, 0, 0, PETSC_COMM_WORLD);
  } else {
    const auto copy = [&](int process, const double* values) {
      for (int number = first_[at(process)]; number < first_[at(process) + 1];
           ++number, values += 3)
        std::copy_n(values, 3, column.data() + 3 * at(blocks_[at(number)]));
    };
    copy(0, own);
    std::vector<double> values;
    for (int process = 1; process < processes(); ++process) {
      values.resize(at(values_of(first_, process)));
      MPI_Recv(values.data(), values_of(first_, process), MPI_DOUBLE, process, 0, PETSC_COMM_WORLD,
               MPI_STATUS_IGNORE);
      copy(process, values.data());
    }
  }
  check(VecRestoreArrayRead(from, &own));
  return column;
}

}  // namespace kinetostat::petsc
