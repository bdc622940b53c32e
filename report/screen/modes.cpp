#include "kinetostat/report/screen/modes.h"

#include <algorithm>
#include <complex>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "kinetostat/report/links/modes.h"
#include "kinetostat/report/manipulators/uncertainty.h"
#include "kinetostat/report/screen/manipulator.h"
#include "kinetostat/report/screen/uncertainty.h"
#include "kinetostat/report/screen/wording.h"
#include "kinetostat/report/text/text.h"

namespace kinetostat::report {
namespace modes_screen {
namespace {

using fea::ModalResult;
using fea::Support;

constexpr std::size_t most_shown = 14, most_beside_response = 8, most_warnings = 3;

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

// Places with a tenth of the energy of the springs, three at most.
std::vector<std::string> yielding(const vjm::Robot& robot, const vjm::ManipulatorMode& mode) {
  std::vector<std::string> words;
  for (const auto& [place, share] : by_place(robot, mode.springs))
    if (words.size() < 3 && share >= 0.1)
      words.push_back(fmt::format("{} {}", short_percent(share), place));
  return words;
}

// Where the reference point goes; about which axis the platform turns where it stays.
std::string motion_in_words(const vjm::ManipulatorMode& mode) {
  const spatial::Vector3 moved = mode.platform.head<3>(), turned = mode.platform.tail<3>();
  constexpr double in_place = 1e-3;  // [m/rad]
  if (moved.norm() > in_place * turned.norm())
    return "along " + direction_in_words(moved.normalized());
  if (turned.norm() > 0) return "turns about " + direction_in_words(turned.normalized());
  return "stays";
}

std::string damping_in_words(const vjm::Damping& damping) {
  return damping.kind == vjm::Damping::Kind::modal
             ? fmt::format("damping ratio {} of every mode", number(damping.value, 3))
             : fmt::format("loss factor {} of all springs", number(damping.value, 3));
}

// Where the platform answers most to a force along each of its axes.
std::string response_text(const RobotModes& modes) {
  const vjm::FrequencyResponse& response = *modes.response;
  Table table({"force and motion", "at Hz", "um/N",
               "times that at " + number(response.frequencies[0], 3) + " Hz"});
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    std::size_t most = 0;
    const auto size = [&](std::size_t k) { return std::abs(response.receptance[k](axis, axis)); };
    for (std::size_t k = 1; k < response.receptance.size(); ++k)
      if (size(k) > size(most)) most = k;
    table.add_row({fmt::format("along {}", "xyz"[axis]), number(response.frequencies[most], 3),
                   number(1e6 * size(most), 3),
                   size(0) > 0 ? number(size(most) / size(0), 3) : "-"});
  }
  return fmt::format("\nLargest response of the platform, {}\n{}", damping_in_words(modes.damping),
                     table.text());
}

io::Json response_json(const RobotModes& modes) {
  const bool is_modal = modes.damping.kind == vjm::Damping::Kind::modal;
  io::Json list = io::Json::array();
  for (const vjm::Receptance& receptance : modes.response->receptance) {
    io::Json real = io::Json::array(), imaginary = io::Json::array();
    for (Eigen::Index i = 0; i < 6; ++i) {
      const Eigen::Matrix<std::complex<double>, 1, 6> row = receptance.row(i);
      const spatial::Vector6 re = row.real(), im = row.imag();
      real.push_back(std::vector<double>(re.begin(), re.end()));
      imaginary.push_back(std::vector<double>(im.begin(), im.end()));
    }
    list.push_back({{"real", real}, {"imaginary", imaginary}});
  }
  return {
      {"damping", {{"kind", is_modal ? "modal" : "structural"}, {"value", modes.damping.value}}},
      {"point", "reference point of the platform"},
      {"axes", "base"},
      {"order", {"dx", "dy", "dz", "rx", "ry", "rz"}},
      {"frequencies", modes.response->frequencies},
      {"receptance", list}};
}

io::Json uncertainty_json(const vjm::Uncertainty& uncertainty) {
  io::Json json = settings_json(uncertainty), frequencies = io::Json::array();
  for (Eigen::Index k = 0; k < uncertainty.first_order.value.size(); ++k)
    frequencies.push_back(number_json(uncertainty, k));
  json["frequencies"] = std::move(frequencies);
  json["budget"] = budget_json(uncertainty, 0);
  return json;
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

std::string headline(const vjm::Robot& robot, const RobotModes& modes) {
  if (modes.found.modes.empty()) return "Nothing that has a mass is held by a spring.";
  const vjm::ManipulatorMode& first = modes.found.modes.front();
  const std::vector<std::string> places = modes_screen::yielding(robot, first);
  return fmt::format("First natural frequency {} Hz{}{}.{}", number(first.frequency, 3),
                     modes.uncertainty ? spread_in_words(*modes.uncertainty, 0) : "",
                     places.empty() ? "" : ": of what yields, " + listed(places),
                     modes.uncertainty ? blame_sentence(*modes.uncertainty, 0) : "");
}

std::string first_screen(const vjm::Robot& robot, const RobotModes& modes) {
  using namespace modes_screen;
  std::string out = wrapped(headline(robot, modes)) + "\n";
  Table table({"mode", "Hz", "platform", "what yields"});
  const std::size_t shown =
      std::min(modes.found.modes.size(), modes.response ? most_beside_response : most_shown);
  for (std::size_t k = 0; k < shown; ++k) {
    const vjm::ManipulatorMode& mode = modes.found.modes[k];
    const std::string spread =
        modes.uncertainty ? spread_in_words(*modes.uncertainty, static_cast<Eigen::Index>(k)) : "";
    table.add_row({std::to_string(k + 1), number(mode.frequency, 3) + spread, motion_in_words(mode),
                   fmt::format("{}", fmt::join(yielding(robot, mode), ", "))});
  }
  out += table.text();
  if (shown < modes.found.modes.size())
    out += fmt::format("  {} more in the result (--json)\n", modes.found.modes.size() - shown);
  out += fmt::format("\n{} kg; drives hold their commands, {}.\n", number(modes.found.mass, 4),
                     modes.is_loaded ? "about the equilibrium under load and weight" : "no load");
  if (modes.found.free_motions > 0)
    out += fmt::format("{} motion{} that nothing resists {} left out.\n", modes.found.free_motions,
                       modes.found.free_motions == 1 ? "" : "s",
                       modes.found.free_motions == 1 ? "is" : "are");
  if (modes.lumping_error)
    out += fmt::format("With beams in twice as many segments a frequency changes by up to {}.\n",
                       percent(*modes.lumping_error));
  if (modes.uncertainty)
    out += budget_text(*modes.uncertainty, 0, {.what = "first frequency", .unit = "Hz"});
  if (modes.response) out += response_text(modes);
  return out;
}

io::Json to_json(const vjm::Robot& robot, const RobotModes& modes) {
  io::Json list = io::Json::array();
  for (const vjm::ManipulatorMode& mode : modes.found.modes)
    list.push_back({{"frequency", mode.frequency},
                    {"platform", std::vector<double>(mode.platform.begin(), mode.platform.end())},
                    {"yields", to_json(robot, mode.springs)}});
  io::Json response = modes.response ? modes_screen::response_json(modes) : io::Json();
  io::Json json{
      {"modes", list},
      {"response", std::move(response)},
      {"mass", modes.found.mass},
      {"loaded", modes.is_loaded},
      {"free_motions", modes.found.free_motions},
      {"lumping_error", modes.lumping_error ? io::Json(*modes.lumping_error) : io::Json()}};
  if (modes.uncertainty) json["uncertainty"] = modes_screen::uncertainty_json(*modes.uncertainty);
  return json;
}

}  // namespace kinetostat::report
