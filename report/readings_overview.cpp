#include "kinetostat/report/readings_overview.h"

namespace kinetostat::report {

using calibration::ColumnOverview;

io::Json readings_json(const calibration::ReadingsOverview& overview) {
  io::Json json{{"readings", overview.table.filename().string()},
                {"rows", overview.rows},
                {"header_line", overview.header_line}};
  json["columns"] = io::Json::array();
  for (const ColumnOverview& column : overview.columns) {
    io::Json item{{"column", column.header},
                  {"meaning", column.meaning.empty() ? "covariate" : column.meaning},
                  {"unit", column.unit},
                  {"negative", column.negative},
                  {"values", column.values},
                  {"missing", column.missing}};
    if (column.range) item["range"] = {(*column.range)[0], (*column.range)[1]};
    if (!column.meant.empty()) item["looks_like"] = column.meant;
    json["columns"].push_back(item);
  }
  for (const calibration::ProposedSensor& sensor : overview.sensors)
    json["proposed_sensors"].push_back(
        {{"name", sensor.name}, {"kind", sensor.kind}, {"columns", sensor.columns}});
  json["notes"] = overview.notes;
  json["mistakes"] = io::Json::array();
  for (const common::InputError::Details& mistake : overview.mistakes)
    json["mistakes"].push_back({{"line", mistake.line},
                                {"column", mistake.column},
                                {"key", mistake.key},
                                {"what", mistake.what},
                                {"cure", mistake.cure}});
  return json;
}

}  // namespace kinetostat::report
