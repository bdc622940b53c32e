#include "kinetostat/report/links/modes.h"

#include <fmt/format.h>

#include "kinetostat/report/links/accuracy.h"
#include "kinetostat/report/text/text.h"

namespace kinetostat::report {
namespace modes_of_link {
namespace {

using fea::ModalResult;
using fea::NaturalMode;

// [%]
std::string share(double value) { return fmt::format("{:.0f}", 100 * value); }

std::vector<std::string> row(std::size_t number_of_mode, const NaturalMode& mode,
                             const spatial::Vector3& shares) {
  return {std::to_string(number_of_mode),
          number(mode.frequency, 4),
          number(100 * mode.error, 2),
          share(shares.x()),
          share(shares.y()),
          share(shares.z())};
}

std::string table_of_masses(const ModalResult& result) {
  Table table({"mode", "Hz", "+- %", "x", "y", "z"});
  spatial::Vector3 sum = spatial::Vector3::Zero();
  for (std::size_t k = 0; k < result.modes.size(); ++k) {
    table.add_row(row(k + 1, result.modes[k], result.modes[k].effective_mass));
    sum += result.modes[k].effective_mass;
  }
  table.add_row({"sum", "", "", share(sum.x()), share(sum.y()), share(sum.z())});
  return "x, y, z: percent of the mass that takes part when the support shakes along an axis\n" +
         table.text();
}

std::string table_of_meshes(const fea::Accuracy& accuracy) {
  Table table({"mesh", "tetrahedra", "unknowns", "largest bar of a frequency, %"});
  for (std::size_t k = 0; k < accuracy.meshes.size(); ++k)
    table.add_row({std::to_string(k + 1), std::to_string(accuracy.meshes[k].elements),
                   std::to_string(accuracy.meshes[k].unknowns),
                   number(50 * accuracy.meshes[k].relative_error, 3)});
  return table.text();
}

io::Json mode_json(const ModalResult& result, std::size_t k) {
  const NaturalMode& mode = result.modes[k];
  return {{"frequency", mode.frequency},
          {"error", mode.error * mode.frequency},
          {"omega_squared", result.shapes.omega_squared[static_cast<Eigen::Index>(k)]},
          {"motion", io::to_json(mode.motion)},
          {"effective_mass", io::to_json(spatial::Vector3(result.mass * mode.effective_mass))}};
}

io::Json interfaces_json(const ModalResult& result) {
  io::Json json;
  for (const fea::CoupledInterface& interface : result.interfaces)
    json[interface.name] = {{"coupling", fea::name(interface.coupling)},
                            {"point", io::to_json(interface.point)}};
  return json;
}

}  // namespace
}  // namespace modes_of_link

std::string mode_table(const fea::ModalResult& result, std::size_t first, std::size_t end) {
  Table table({"mode", "Hz", "+- %", "x", "y", "z"});
  for (std::size_t k = first; k < end; ++k)
    table.add_row(modes_of_link::row(k + 1, result.modes[k], result.modes[k].motion));
  return table.text();
}

std::string text(const fea::ModalResult& result) {
  using namespace modes_of_link;
  return mode_table(result, 0, result.modes.size()) +
         (result.support == fea::Support::none ? "" : "\n" + table_of_masses(result)) + "\n" +
         table_of_meshes(result.accuracy);
}

io::Json to_json(const fea::ModalResult& result) {
  using namespace modes_of_link;
  io::Json json{{"kinetostat", 1},
                {"link", result.name},
                {"support", fea::name(result.support)},
                {"modes", io::Json::array()}};
  for (std::size_t k = 0; k < result.modes.size(); ++k)
    json["modes"].push_back(mode_json(result, k));
  json["accuracy"] = to_json(result.accuracy);
  json["mass"] = result.mass;
  json["center_of_mass"] = io::to_json(result.center_of_mass);
  json["inertia"] = io::rows(result.inertia);
  json["interfaces"] = interfaces_json(result);
  json["mesh"] = {{"order", result.mesh.order},
                  {"elements", result.mesh.element_count()},
                  {"nodes", result.mesh.nodes.size()},
                  {"unknowns", result.shapes.unknowns}};
  json["warnings"] = result.warnings;
  json["inputs"] = {{"link_sha256", result.link_sha256},
                    {"mesh_file", result.mesh_file},
                    {"mesh_sha256", result.mesh_sha256},
                    {"mesh_unit", result.unit}};
  return json;
}

}  // namespace kinetostat::report
