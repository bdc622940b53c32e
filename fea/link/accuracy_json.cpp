#include "kinetostat/fea/link/accuracy_json.h"

namespace kinetostat::fea {
namespace {

using io::Json;

// Nothing where nothing was estimated.
template <class Matrix>
Json rows(const Matrix& matrix) {
  return matrix.size() == 0 ? Json() : io::rows(matrix);
}

Json optional(const std::optional<double>& value) { return value ? Json(*value) : Json(); }

Json mesh_json(const MeshOutcome& mesh) {
  return {{"unknowns", mesh.unknowns},
          {"elements", mesh.elements},
          {"relative_error", mesh.relative_error},
          {"flexibility", rows(mesh.flexibility)},
          {"recovery", rows(mesh.recovery_error)}};
}

}  // namespace

Json to_json(const Accuracy& accuracy) {
  const ErrorBars& bars = accuracy.bars;
  Json json{{"bar", rows(bars.bar)},
            {"significant", rows(bars.significant)},
            {"relative", bars.relative_error},
            {"recovery", rows(bars.recovery)},
            {"extrapolation", rows(bars.extrapolation)},
            {"agreement", optional(bars.agreement)},
            {"calibration", optional(bars.calibration)},
            {"observed_rate", optional(bars.observed_rate)},
            {"best_rate", bars.best_rate},
            {"asked", optional(accuracy.asked)}};
  json["converged"] = accuracy.asked ? Json(accuracy.converged) : Json();
  json["shortfall"] = accuracy.shortfall;
  json["concentration"] = {{"share", accuracy.concentration.share},
                           {"place", io::to_json(accuracy.concentration.place)}};
  json["meshes"] = Json::array();
  for (const MeshOutcome& mesh : accuracy.meshes) json["meshes"].push_back(mesh_json(mesh));
  return json;
}

}  // namespace kinetostat::fea
