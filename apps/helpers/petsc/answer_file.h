// The answer as the first process writes it: each displacement as soon as it is known.
#pragma once

#include <cstdint>
#include <fstream>
#include <vector>

#include "kinetostat/fea/elasticity/petsc_protocol.h"

namespace kinetostat::petsc {

/// As petsc_protocol.h has it.
class AnswerFile {
 public:
  /// Without a path for processes that have no file.
  AnswerFile() = default;
  /// `values` are those of all columns together.
  AnswerFile(const char* path, std::uint64_t values) : file_(path, std::ios::binary) {
    write(&values, sizeof values);
  }

  void append(const std::vector<double>& column) {
    write(column.data(), sizeof(double) * column.size());
  }
  /// Behind the last column; false when something could not be written.
  bool finish(const fea::petsc::Figures& figures) {
    const std::uint64_t one = 1;
    write(&one, sizeof one);
    write(&figures, sizeof figures);
    return static_cast<bool>(file_.flush());
  }

 private:
  void write(const void* bytes, std::size_t count) {
    file_.write(static_cast<const char*>(bytes), static_cast<std::streamsize>(count));
  }

  std::ofstream file_;
};

}  // namespace kinetostat::petsc
