#include "kinetostat/apps/helpers/petsc/processes.h"

#include <algorithm>
#include <new>
#include <stdexcept>

namespace kinetostat::petsc {
namespace {

constexpr unsigned long long at_once = 1 << 30;  // MPI counts in int

// work(first, count) for pieces that MPI can count.
template <class Work>
void in_pieces(unsigned long long size, const Work& work) {
  for (unsigned long long first = 0; first < size; first += at_once)
    work(first, static_cast<int>(std::min(at_once, size - first)));
}

// What PETSc said where an error started.
std::string& said_of_error() {
  static std::string said;
  return said;
}

double reduced(double value, MPI_Op operation) {
  double result = 0;
  MPI_Allreduce(&value, &result, 1, MPI_DOUBLE, operation, PETSC_COMM_WORLD);
  return result;
}

}  // namespace

void keep_what_is_said() {
  PetscPushErrorHandler(
      [](MPI_Comm, int, const char* function, const char*, PetscErrorCode code, PetscErrorType type,
         const char* text, void*) {
        if (type == PETSC_ERROR_INITIAL)
          said_of_error() = std::string(function) + ": " + (text == nullptr ? "" : text);
        return code;
      },
      nullptr);
}

void check(PetscErrorCode code) {
  if (code == 0) return;
  if (code == PETSC_ERR_MEM) throw std::bad_alloc();
  const char* text = nullptr;
  PetscErrorMessage(code, &text, nullptr);
  const std::string kind = text == nullptr ? "error " + std::to_string(code) : text;
  throw std::runtime_error(kind + (said_of_error().empty() ? "" : ", " + said_of_error()));
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

void send(const std::string& bytes, int to) {
  const unsigned long long size = bytes.size();
  MPI_Send(&size, 1, MPI_UNSIGNED_LONG_LONG, to, 0, PETSC_COMM_WORLD);
  in_pieces(size, [&](unsigned long long first, int count) {
    MPI_Send(bytes.data() + first, count, MPI_BYTE, to, 0, PETSC_COMM_WORLD);
  });
}

std::string receive(int from) {
  unsigned long long size = 0;
  MPI_Recv(&size, 1, MPI_UNSIGNED_LONG_LONG, from, 0, PETSC_COMM_WORLD, MPI_STATUS_IGNORE);
  std::string bytes(size, '\0');
  in_pieces(size, [&](unsigned long long first, int count) {
    MPI_Recv(bytes.data() + first, count, MPI_BYTE, from, 0, PETSC_COMM_WORLD, MPI_STATUS_IGNORE);
  });
  return bytes;
}

int from_first(int value) {
  MPI_Bcast(&value, 1, MPI_INT, 0, PETSC_COMM_WORLD);
  return value;
}

double sum_of_all(double value) { return reduced(value, MPI_SUM); }
double largest_of_all(double value) { return reduced(value, MPI_MAX); }
double least_of_all(double value) { return reduced(value, MPI_MIN); }

}  // namespace kinetostat::petsc
