// Accuracy on demand: meshes refined where it matters, until every significant entry of the
// flexibility is known well enough.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "kinetostat/common/progress.h"
#include "kinetostat/fea/link/error_bars.h"
#include "kinetostat/fea/link/link_response.h"
#include "kinetostat/fea/mesh/size_field.h"

namespace kinetostat::fea {

/// A link on one mesh.
struct LinkModel {
  TetMesh mesh = {};
  std::vector<Material> materials = {};
  std::vector<CoupledInterface> interfaces = {};
  LinkResponse response = {};
};

/// Makes the mesh for a size field and solves on it.
using Solve = std::function<LinkModel(const SizeField&)>;

struct RefinementOptions {
  double accuracy = 0.01;  // of every significant entry, or what it is a power of, error beside it
  /// An entry goes with this power of what is asked for, up to its sign: 1 for the entry itself, 2
  /// for frequencies, whose flexibility goes with their square.
  int power = 1;
  std::string quantity = "an entry";    // what is asked for, in words
  std::size_t most_meshes = 8;          // >= 1
  std::size_t most_unknowns = 3000000;  // no mesh beyond is started
  double time_limit = 0;                // [s] after which no further mesh is started; 0: none
  int threads = 1;                      // of the error estimate; no digit depends on it
};

/// Where the error sits.
struct Concentration {
  double share = 0;                 // of the error, in the hundredth of the elements with the most
  Vector3 place = Vector3::Zero();  // [m] centroid of the element with the most
};

/// Error estimate of a model.
struct Accuracy {
  std::vector<MeshOutcome> meshes;  // the last one is the model's
  ErrorBars bars;
  std::vector<double> indicator;  // per element of the model: share of the error, sums to 1
  Concentration concentration;
  std::optional<double> asked;  // as a fraction; none when the user chose the size
  bool converged = false;       // only when accuracy was asked for: reached, and confirmed
  std::string shortfall;        // why not, in words
};

struct RefinedModel {
  LinkModel model;
  Accuracy accuracy;
};

/// Error bars of one model, for a mesh that the user chose.
Accuracy accuracy_of(const LinkModel& model, int threads);

/// Refines, at least once, until the accuracy is reached and the two estimates of the error agree.
/// When a mesh after the first cannot be finished, or the user cancels then, the last good one is
/// returned, not converged, and says why. Errors with the first mesh are thrown on.
RefinedModel refine(const Solve& solve, const SizeField& first, const RefinementOptions& options,
                    common::Progress& progress);

}  // namespace kinetostat::fea
