#include "kinetostat/report/screen/link.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "kinetostat/report/screen/manipulator.h"
#include "kinetostat/report/screen/wording.h"
#include "kinetostat/report/text/text.h"

namespace kinetostat::report {
namespace {

constexpr std::size_t most_warnings = 3;
constexpr double micrometre = 1e-6;

std::string accuracy_in_words(const fea::Accuracy& accuracy) {
  const double within = accuracy.bars.relative_error;
  if (accuracy.asked && !accuracy.converged)
    return fmt::format("NOT within the {} that were asked for: {}", percent(*accuracy.asked),
                       accuracy.shortfall);
  return fmt::format("every entry within {}", percent(within));
}

// How much softer the first loaded interface is when it is held evenly instead of rigidly.
std::string clamping_sentence(const fea::LinkResult& result) {
  if (!result.bracket) return {};
  const auto rigid = compliance_of(result.bracket->rigid, result.interfaces, 1);
  const auto distributing = compliance_of(result.bracket->distributing, result.interfaces, 1);
  double least = 1e300, most = 0;
  for (int k = 0; k < 6; ++k) {
    const double softer = distributing.matrix()(k, k) / rigid.matrix()(k, k) - 1;
    least = std::min(least, softer);
    most = std::max(most, softer);
  }
  return fmt::format(
      "Clamping: with its interfaces held evenly instead of rigidly it is {:.0f} to "
      "{:.0f} % softer.",
      100 * least, 100 * most);
}

std::string with_commas(std::size_t count) {
  std::string digits = std::to_string(count);
  for (std::size_t at = digits.size(); at > 3; at -= 3) digits.insert(at - 3, ",");
  return digits;
}

}  // namespace

std::string headline(const fea::LinkResult& result) {
  const SoftestDirection softest = softest_direction(result.compliance);
  return fmt::format(
      "{}: softest along {}, {} um/N; {}.", result.name, direction_in_words(softest.direction),
      number(softest.compliance / micrometre, 3), accuracy_in_words(result.accuracy));
}

std::string first_screen(const fea::LinkResult& result, const std::string& next) {
  const spatial::UnitSystem units{.length = result.unit, .force = "N"};
  std::string out = wrapped(headline(result)) + wrapped(clamping_sentence(result)) + "\n" +
                    text(result.compliance, units);
  if (result.interfaces.size() > 2)
    out += fmt::format("  of interface {}; {} more with --verbose\n", result.interfaces[1].name,
                       result.interfaces.size() - 2);
  out += fmt::format("\n{}{} tetrahedra of {} nodes, {} unknowns.\n",
                     result.mass ? number(*result.mass, 4) + " kg, " : "",
                     with_commas(result.mesh.element_count()), result.mesh.nodes_per_element(),
                     with_commas(static_cast<std::size_t>(result.response.solver.unknowns)));
  for (std::size_t i = 0; i < std::min(result.warnings.size(), most_warnings); ++i)
    out += wrapped("warning: " + result.warnings[i], 0, 2);
  return out + (next.empty() ? "" : "\n" + next);
}

std::string first_screen(const BeamResult& result) {
  static constexpr const char* displacements[] = {"x", "y", "z", "rx", "ry", "rz"};
  static constexpr const char* loads[] = {"Fx", "Fy", "Fz", "Mx", "My", "Mz"};
  std::string out = wrapped(fmt::format("{}: {}", result.link.name, result.verdict)) + "\n";
  Table table({"model", "largest error", "of entry", "compliance over FEA, any direction"});
  for (const fea::BeamComparison& c : result.comparisons)
    table.add_row({c.name, fmt::format("{:.1f} %", 100 * c.worst),
                   fmt::format("{} / {}", displacements[c.worst_row], loads[c.worst_column]),
                   fmt::format("{:.3g} to {:.3g}", c.least_ratio, c.largest_ratio)});
  out += table.text() +
         fmt::format("  against {}; sections and every entry: --verbose\n", result.source);
  std::size_t shown = 0;
  for (const auto* list : {&result.warnings, &result.study.warnings})
    for (const std::string& warning : *list)
      if (shown++ < most_warnings) out += wrapped("warning: " + warning, 0, 2);
  return out;
}

std::string headline(const fea::SurfaceCheck& check, const MeshCheckUnits& units) {
  const fea::SurfaceReport& report = check.report;
  if (report.sound())
    return fmt::format("The mesh bounds a solid of {} {}^3: {} facets, {} bod{}.",
                       figure(check.mass.volume / std::pow(units.length, 3), 4), units.unit,
                       with_commas(static_cast<std::size_t>(report.facets)), report.bodies(),
                       report.bodies() == 1 ? "y" : "ies");
  std::vector<std::string> defects;
  for (const fea::Defect& defect : report.defects)
    defects.push_back(fmt::format("{} ({})", fea::name(defect.kind), defect.count));
  return fmt::format("The mesh does not bound a solid: {}.", listed(defects, "and"));
}

}  // namespace kinetostat::report
