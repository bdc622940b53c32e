#include "kinetostat/report/links/accuracy.h"

#include <cmath>

#include <fmt/format.h>

#include "kinetostat/report/text/text.h"

namespace kinetostat::report {
namespace {

using fea::Accuracy;
using fea::ErrorBars;
using io::Json;

// In a hundredth of the elements: of a smooth error, they have a few hundredths.
constexpr double concentrated_share = 0.3;

// Of the entry where it is significant, else, in brackets, of the root of the two diagonal ones.
std::string bar_cell(const Accuracy& accuracy, Eigen::Index i, Eigen::Index j) {
  const Eigen::MatrixXd& c = accuracy.meshes.back().flexibility;
  const double bar = 100 * accuracy.bars.bar(i, j);
  if (accuracy.bars.significant(i, j)) return number(bar / std::abs(c(i, j)), 2);
  return fmt::format("[{}]", number(bar / std::sqrt(c(i, i) * c(j, j)), 2));
}

// The motions of the k-th loaded interface under the wrenches at it.
std::string bar_table(const Accuracy& accuracy, Eigen::Index k) {
  static constexpr const char* names[] = {"Fx", "Fy", "Fz", "Mx", "My", "Mz"};
  static constexpr const char* motions[] = {"dx", "dy", "dz", "rx", "ry", "rz"};
  Table table({"+- %", names[0], names[1], names[2], names[3], names[4], names[5]});
  for (Eigen::Index i = 0; i < 6; ++i) {
    std::vector<std::string> row{motions[i]};
    for (Eigen::Index j = 0; j < 6; ++j) row.push_back(bar_cell(accuracy, 6 * k + i, 6 * k + j));
    table.add_row(row);
  }
  return table.text();
}

std::string bar_tables(const fea::LinkResult& result) {
  std::string text =
      "error bars, of the entry; in brackets, of the root of both diagonal entries where the entry "
      "is below 5 % of that:\n";
  const std::size_t loaded = result.interfaces.size() - 1;
  for (std::size_t k = 0; k < loaded; ++k) {
    if (loaded > 1) text += fmt::format("at {}:\n", result.interfaces[k + 1].name);
    text += bar_table(result.accuracy, static_cast<Eigen::Index>(k));
  }
  if (loaded > 1)
    text += "those of the entries between interfaces are in the result file (error.bar)\n";
  return text;
}

std::string mesh_table(const Accuracy& accuracy) {
  Table table({"mesh", "tetrahedra", "unknowns", "largest bar of an entry, %"});
  for (std::size_t k = 0; k < accuracy.meshes.size(); ++k)
    table.add_row({std::to_string(k + 1), std::to_string(accuracy.meshes[k].elements),
                   std::to_string(accuracy.meshes[k].unknowns),
                   number(100 * accuracy.meshes[k].relative_error, 3)});
  return table.text();
}

std::string verdict(const Accuracy& accuracy) {
  const double reached = 100 * accuracy.bars.relative_error;
  if (!accuracy.asked)
    return fmt::format(
        "accuracy: every significant entry within {:.2g} % by the recovered stresses of this one "
        "mesh, which no second one confirms\n",
        reached);
  if (!accuracy.converged) return fmt::format("accuracy: NOT CONVERGED: {}\n", accuracy.shortfall);
  return fmt::format("accuracy: every significant entry within {:.2g} %, {:.2g} % was asked for\n",
                     reached, 100 * *accuracy.asked);
}

std::string convergence(const Accuracy& accuracy, double length, const std::string& unit) {
  const ErrorBars& bars = accuracy.bars;
  std::string text;
  if (bars.agreement)
    text += fmt::format("extrapolation finds {:.2g} times the error that the stresses show\n",
                        *bars.agreement);
  if (bars.observed_rate)
    text += fmt::format("the error falls as unknowns^-{:.2f}; {:.2f} where stresses are smooth\n",
                        *bars.observed_rate, bars.best_rate);
  const bool is_short = accuracy.asked && !accuracy.converged;
  if (bars.convergence_is_slow() ||
      (is_short && accuracy.concentration.share > concentrated_share)) {
    const spatial::Vector3 p = accuracy.concentration.place / length;
    text += fmt::format(
        "{}, as at the edge of a held face or a re-entrant edge: one hundredth of the elements has "
        "{:.0f} % of the error, most near [{}, {}, {}] {}\n",
        bars.convergence_is_slow() ? "a stress singularity slows it"
                                   : "the error sits where stresses are singular or nearly so",
        100 * accuracy.concentration.share, number(p.x(), 3), number(p.y(), 3), number(p.z(), 3),
        unit);
  }
  return text;
}

// Nothing where nothing was estimated.
template <class Matrix>
Json rows(const Matrix& matrix) {
  return matrix.size() == 0 ? Json() : io::rows(matrix);
}

Json optional(const std::optional<double>& value) { return value ? Json(*value) : Json(); }

Json mesh_json(const fea::MeshOutcome& mesh) {
  return {{"unknowns", mesh.unknowns},
          {"elements", mesh.elements},
          {"relative_error", mesh.relative_error},
          {"flexibility", rows(mesh.flexibility)},
          {"recovery", rows(mesh.recovery_error)}};
}

}  // namespace

std::string accuracy_text(const fea::LinkResult& result) {
  const Accuracy& accuracy = result.accuracy;
  const double length = spatial::parse_quantity("1 " + result.unit, spatial::dimension::length);
  std::string text = bar_tables(result) + verdict(accuracy);
  if (accuracy.meshes.size() > 1) text += mesh_table(accuracy);
  return text + convergence(accuracy, length, result.unit);
}

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
  if (bars.geometry.size() > 0) json["geometry"] = rows(bars.geometry);
  json["concentration"] = {{"share", accuracy.concentration.share},
                           {"place", io::to_json(accuracy.concentration.place)}};
  json["meshes"] = Json::array();
  for (const fea::MeshOutcome& mesh : accuracy.meshes) json["meshes"].push_back(mesh_json(mesh));
  return json;
}

}  // namespace kinetostat::report
