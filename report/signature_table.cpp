#include "kinetostat/report/signature_table.h"

#include <fmt/format.h>

#include "kinetostat/io/csv.h"

namespace kinetostat::report {

namespace {

std::string head_of(const calibration::SignatureTable& table) {
  std::string text = "reading,component,residual";
  for (const std::string& name : table.fitted) text += "," + io::csv_cell("fit: " + name);
  int direction = 1;
  for (std::size_t c = 0; c < table.candidates.size(); ++c) {
    const std::string& name = table.candidates[c];
    direction = c > 0 && table.candidates[c - 1] == name ? direction + 1 : 1;
    text += "," + io::csv_cell(direction == 1 ? name : fmt::format("{} ({})", name, direction));
  }
  return text + "\n";
}

}  // namespace

std::string signature_csv(const calibration::Campaign& campaign,
                          const calibration::SignatureTable& table) {
  std::string text = io::csv_comment(
                         "residual and signatures in units of the noise, about the fit without any "
                         "effect") +
                     head_of(table);
  for (std::size_t v = 0; v < table.values.size(); ++v) {
    const auto row = static_cast<Eigen::Index>(v);
    const auto& [reading, component] = table.values[v];
    text += io::csv_cell(campaign.readings[reading].id) + "," +
            io::csv_cell(campaign.components[static_cast<std::size_t>(component)].name) +
            fmt::format(",{:.9g}", table.residual[row]);
    for (const double value : table.by_fitted.row(row)) text += fmt::format(",{:.9g}", value);
    for (const double value : table.by_candidates.row(row)) text += fmt::format(",{:.9g}", value);
    text += "\n";
  }
  return text;
}

}  // namespace kinetostat::report
