// The request as the first process reads it, and no other: the model at once, the loads one by one.
#pragma once

#include <cstdint>
#include <fstream>
#include <stdexcept>
#include <vector>

#include "kinetostat/fea/elasticity/assembly.h"

namespace kinetostat::petsc {

/// The file is not what petsc_protocol.h says.
class BadRequest : public std::runtime_error {
 public:
  BadRequest() : std::runtime_error("the request is not what petsc_protocol.h says") {}
};

struct WholeModel {
  fea::TetMesh mesh;
  std::vector<fea::Material> materials;
  fea::DofMap unknowns;
};

/// As petsc_protocol.h has it.
class RequestFile {
 public:
  /// Without a path for processes that have no file.
  RequestFile() = default;
  explicit RequestFile(const char* path) : file_(path, std::ios::binary) {}

  /// Once, before the loads. Throws BadRequest.
  WholeModel model();
  /// Number of loads.
  int columns() const { return columns_; }
  /// The next load: forces [N] and moments [N m] on the unknowns of model(). Throws BadRequest.
  std::vector<double> next_column();

 private:
  std::ifstream file_;
  std::size_t unknowns_ = 0;
  int columns_ = 0;
};

}  // namespace kinetostat::petsc
