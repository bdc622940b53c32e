#include "kinetostat/report/links/beam.h"

#include <cmath>

#include <fmt/format.h>

#include "kinetostat/report/text/text.h"
#include "kinetostat/spatial/units.h"

namespace kinetostat::report {
namespace {

using fea::BeamComparison;
using fea::BeamModel;
using fea::BeamStation;
using io::Json;
using spatial::Vector3;

constexpr const char* displacements[] = {"x", "y", "z", "rx", "ry", "rz"};
constexpr const char* loads[] = {"Fx", "Fy", "Fz", "Mx", "My", "Mz"};

std::string section_table(const fea::BeamStudy& study, const std::string& unit) {
  const double length = spatial::parse_unit(unit).factor, area = length * length,
               moment = std::pow(length, 4);
  Table table({"along [" + unit + "]", "area [" + unit + "^2]", "I1 [" + unit + "^4]",
               "I2 [" + unit + "^4]", "J [" + unit + "^4]", "kappa1", "kappa2", "pieces", "holes"});
  for (const BeamStation& station : study.stations) {
    const fea::SectionProperties& s = station.properties;
    const auto principal = s.principal();
    table.add_row({number(station.arc / length), number(s.area / area),
                   number(principal.moments[0] / moment), number(principal.moments[1] / moment),
                   number(s.torsion_constant / moment), number(principal.shear_coefficients[0], 3),
                   number(principal.shear_coefficients[1], 3), std::to_string(s.pieces),
                   std::to_string(s.holes)});
  }
  return table.text();
}

// One row for every significant entry of the upper triangle, in SI units.
std::string entry_table(const BeamResult& result) {
  std::vector<std::string> header{"entry", "FEA"};
  for (const BeamComparison& c : result.comparisons) header.push_back(c.name);
  Table table(header);
  for (int i = 0; i < 6; ++i)
    for (int j = i; j < 6; ++j) {
      if (!result.comparisons.front().significant(i, j)) continue;
      std::vector<std::string> row{fmt::format("{} / {}", displacements[i], loads[j]),
                                   fmt::format("{:.4e}", result.compliance.matrix()(i, j))};
      for (const BeamComparison& c : result.comparisons)
        row.push_back(fmt::format("{:+.1f} %", 100 * c.errors(i, j)));
      table.add_row(row);
    }
  return table.text();
}

Json pair_json(const fea::Vector2& v) { return {v.x(), v.y()}; }

Json principal_axes_json(const spatial::Matrix3& axes,
                         const fea::SectionProperties::Principal& principal) {
  Json directions = Json::array();
  for (Eigen::Index k = 0; k < 2; ++k)
    directions.push_back(io::to_json(Vector3(axes.rightCols<2>() * principal.axes.col(k))));
  return directions;
}

Json station_json(const BeamStation& station) {
  const fea::SectionProperties& s = station.properties;
  const fea::SectionProperties::Principal principal = s.principal();
  const spatial::Matrix3 axes = station.frame.axes;
  const fea::Vector2 centre = s.shear_centre;
  return {
      {"arc", station.arc},
      {"centroid", io::to_json(station.centroid)},
      {"tangent", io::to_json(Vector3(axes.col(0)))},
      {"area", s.area},
      {"second_moments", pair_json(principal.moments)},
      {"principal_axes", principal_axes_json(axes, principal)},
      {"torsion_constant", s.torsion_constant},
      {"shear_coefficients", pair_json(principal.shear_coefficients)},
      {"shear_centre", io::to_json(Vector3(station.frame.point + axes.rightCols<2>() * centre))},
      {"pieces", s.pieces},
      {"holes", s.holes}};
}

Json model_json(const BeamModel& model) {
  Json json{{"name", model.name}, {"beams", model.beams.size()}};
  json.update(io::to_json(model.compliance));
  return json;
}

Json comparison_json(const BeamComparison& c) {
  return {{"model", c.name},
          {"errors", io::rows(c.errors)},
          {"worst_error", c.worst},
          {"worst_entry", {displacements[c.worst_row], loads[c.worst_column]}},
          {"least_compliance_ratio", c.least_ratio},
          {"largest_compliance_ratio", c.largest_ratio}};
}

}  // namespace

std::string text(const BeamResult& result) {
  const std::string& unit = result.link.unit;
  std::string out =
      fmt::format("link {}: axis {} {} long, {} sections\n\n", result.link.name,
                  number(result.study.axis.length() / spatial::parse_unit(unit).factor), unit,
                  result.study.stations.size());
  out += section_table(result.study, unit);
  out += fmt::format(
      "\nsignificant entries of the compliance [m, rad per N, N m] at the loaded point, and what "
      "the beams differ by\nfrom FEA ({}):\n\n",
      result.source);
  out += entry_table(result) + "\n";
  for (const BeamComparison& c : result.comparisons)
    out += fmt::format("{}: {:.3g} to {:.3g} times the compliance of FEA, in any direction\n",
                       c.name, c.least_ratio, c.largest_ratio);
  for (const auto* list : {&result.warnings, &result.study.warnings})
    for (const std::string& warning : *list) out += fmt::format("warning: {}\n", warning);
  return out + "\n" + result.verdict + "\n";
}

Json to_json(const BeamResult& result) {
  Json json{{"link", result.link.name}, {"axis_length", result.study.axis.length()}};
  for (const char* list : {"sections", "models"}) json[list] = Json::array();
  for (const BeamStation& station : result.study.stations)
    json["sections"].push_back(station_json(station));
  for (const BeamModel& model : result.study.models) json["models"].push_back(model_json(model));
  json["warnings"] = result.study.warnings;
  json["fea"] = io::to_json(result.compliance);
  json["comparison"] = Json::array();
  for (const BeamComparison& c : result.comparisons)
    json["comparison"].push_back(comparison_json(c));
  json["verdict"] = result.verdict;
  return json;
}

}  // namespace kinetostat::report
