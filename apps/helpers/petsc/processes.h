// The processes of the helper, and what they send each other.
#pragma once

#include <petscsys.h>
#include <string>

namespace kinetostat::petsc {

/// From now on PETSc's errors are returned, and what it says where one starts is kept for check().
void keep_what_is_said();
/// Throws std::bad_alloc, or std::runtime_error with PETSc's words.
void check(PetscErrorCode code);

/// Number of this process, and of all.
int rank();
int processes();

/// Bytes of any number, to and from another process.
void send(const std::string& bytes, int to);
std::string receive(int from);

/// The first process's value, in all of them.
int from_first(int value);
double sum_of_all(double value);
double largest_of_all(double value);
double least_of_all(double value);

}  // namespace kinetostat::petsc
