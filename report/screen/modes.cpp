#include "kinetostat/report/screen/modes.h"

#include <algorithm>

#include <fmt/format.h>

#include "kinetostat/report/links/modes.h"
#include "kinetostat/report/screen/wording.h"
#include "kinetostat/report/text/text.h"

namespace kinetostat::report {
namespace modes_screen {
namespace {

using fea::ModalResult;
using fea::Support;

constexpr std::size_t most_shown = 14, most_warnings = 3;

std::string support_in_words(const ModalResult& result) {
  switch (result.support) {
    case Support::none:
      return "free";
    case Support::all_interfaces:
      return "held at every interface";
    default:
      return "clamped at " + result.interfaces.front().name;
  }
}

std::string accuracy_in_words(const ModalResult& result) {
  const fea::Accuracy& accuracy = result.accuracy;
  if (accuracy.asked && !accuracy.converged)
    return fmt::format("NOT within the {} that were asked for: {}", percent(*accuracy.asked),
                       accuracy.shortfall);
  return fmt::format("{} within {}",
                     result.modes.size() == 1
                         ? "it is known"
                         : fmt::format("each of {} is known", result.modes.size()),
                     percent(result.error()));
}

}  // namespace
}  // namespace modes_screen

std::string headline(const fea::ModalResult& result) {
  using namespace modes_screen;
  if (result.modes.empty()) return result.name + ": the mesh is too coarse for any mode.";
  return fmt::format("{}, {}: first natural frequency {} Hz; {}.", result.name,
                     support_in_words(result), number(result.modes.front().frequency, 4),
                     accuracy_in_words(result));
}

std::string first_screen(const fea::ModalResult& result) {
  using namespace modes_screen;
  const std::size_t shown = std::min(result.modes.size(), most_shown);
  std::string out = wrapped(headline(result)) + "\n" + mode_table(result, 0, shown) +
                    "  x, y, z: percent of the motion along the axes of the mesh, by its energy\n";
  if (shown < result.modes.size())
    out += fmt::format("  {} more with --verbose\n", result.modes.size() - shown);
  out += fmt::format("\n{} kg, {} tetrahedra of {} nodes, {} unknowns.\n", number(result.mass, 4),
                     result.mesh.element_count(), result.mesh.nodes_per_element(),
                     result.shapes.unknowns);
  for (std::size_t i = 0; i < std::min(result.warnings.size(), most_warnings); ++i)
    out += wrapped("warning: " + result.warnings[i], 0, 2);
  return out;
}

}  // namespace kinetostat::report
