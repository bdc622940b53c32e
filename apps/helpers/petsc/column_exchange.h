// Loads and displacements between the first process, which has the files, and those that own the
// unknowns: one column at a time, so that none has them all.
#pragma once

#include <petscvec.h>
#include <utility>
#include <vector>

namespace kinetostat::petsc {

/// Blocks of three values, in the order of the files here and in that of the processes there.
class ColumnExchange {
 public:
  /// For processes other than the first.
  ColumnExchange() = default;
  /// For the first: the blocks of the files in the order of the processes' numbering, and the first
  /// block of each process in it, then the number of all.
  ColumnExchange(std::vector<int> blocks, std::vector<int> first)
      : blocks_(std::move(blocks)), first_(std::move(first)) {}

  /// A column of the file (not used in processes other than the first) as a vector of all.
  void scatter(const std::vector<double>& column, Vec to) const;
  /// The reverse; empty in processes other than the first.
  std::vector<double> gather(Vec from) const;

 private:
  std::vector<int> blocks_, first_;
};

}  // namespace kinetostat::petsc
