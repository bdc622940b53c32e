// The whole model, which the first process has, as one share for each process.
#pragma once

#include <vector>

#include "kinetostat/apps/helpers/petsc/column_exchange.h"
#include "kinetostat/apps/helpers/petsc/request_file.h"
#include "kinetostat/fea/distribution/model_parts.h"

namespace kinetostat::petsc {

struct ModelShare {
  fea::ModelPart part;
  std::vector<fea::Material> materials;
  ColumnExchange columns;
  int unknowns = 0, corner_unknowns = 0;  // of all processes
};

/// Reads the model, divides it and sends every process its part; for processes other than the first
/// `request` is not used. When this returns, no process has the whole model any more. Throws
/// BadRequest.
ModelShare share_model(RequestFile& request);

}  // namespace kinetostat::petsc
