// A robot of a few lines, effects that its file does not have, and readings of both.
#pragma once

#include <string>
#include <vector>

#include "kinetostat/calibration/campaign/campaign_file.h"
#include "kinetostat/calibration/diagnosis/diagnosis.h"
#include "kinetostat/calibration/regression/simulate.h"
#include "kinetostat/io/csv.h"
#include "kinetostat/io/text_file.h"
#include "kinetostat/report/diagnosis.h"
#include "kinetostat/report/diagnosis_file.h"
#include "kinetostat/vjm/io/effect_file.h"

#include "support/temporary_folder.h"

namespace kinetostat::calibration::test {

/// A robot and the readings that are taken of it, with the truth in it.
class Laboratory {
 public:
  explicit Laboratory(const std::string& robot)
      : robot_(vjm::read_robot(written(folder_.path() / "robot.yaml", robot))) {}

  const vjm::Robot& robot() const { return robot_; }

  void hide(const std::string& kind, const std::string& at, const std::string& size) {
    options_.hidden.push_back(vjm::effect_from_words(kind, at, size, robot_.kinds(),
                                                     robot_.without_effects(), robot_.units));
  }
  SimulationOptions& options() { return options_; }

  /// Takes the readings of a plan, beside those that were taken before; noise as in options().
  Campaign measure(const std::string& plan, const std::string& more = "") {
    io::write_atomically(folder_.path() / "plan.csv", plan);
    common::Progress silent;
    ++options_.seed;
    const SimulatedCampaign made =
        simulate(robot_, "robot.yaml", folder_.path() / "plan.csv", options_, silent);
    readings_ = readings_.empty() ? made.readings : joined(readings_, made.readings);
    io::write_atomically(folder_.path() / "readings.csv", readings_);
    io::write_atomically(folder_.path() / "campaign.yaml", made.yaml + more);
    return read_campaign(folder_.path() / "campaign.yaml", robot_.manipulator);
  }

  Diagnosis diagnose(const Campaign& campaign, const std::vector<std::string>& kinds) const {
    common::Progress silent;
    return calibration::diagnose(robot_, campaign, {.kinds = kinds, .draws = 199}, 2, silent);
  }
  io::Json json(const Campaign& campaign, const Diagnosis& diagnosis) const {
    return report::to_json(robot_, campaign, diagnosis);
  }
  /// As the file of a diagnosis says it.
  DiagnosisRecord recorded(const Campaign& campaign, const Diagnosis& diagnosis) const {
    return report::diagnosis_record(json(campaign, diagnosis), "d.json");
  }

 private:
  static std::filesystem::path written(const std::filesystem::path& file, const std::string& text) {
    io::write_atomically(file, text);
    return file;
  }

  // Two tables with the columns of both.
  static std::string joined(const std::string& a, const std::string& b) {
    const io::CsvTable first(a, "first"), second(b, "second");
    std::vector<std::string> columns = first.columns();
    for (const std::string& name : second.columns())
      if (!first.find(name)) columns.push_back(name);
    std::string text;
    for (const std::string& name : columns) text += (text.empty() ? "" : ",") + name;
    for (const io::CsvTable* table : {&first, &second})
      for (std::size_t row = 0; row < table->rows(); ++row) {
        text += "\n";
        for (std::size_t c = 0; c < columns.size(); ++c) {
          const auto found = table->find(columns[c]);
          // Loads that a table does not have are none.
          text += (c > 0 ? "," : "") + (found ? std::string(table->cell(row, *found))
                                        : columns[c][0] == 'f' ? "0"
                                                               : "");
        }
      }
    return text + "\n";
  }

  kinetostat::test::TemporaryFolder folder_;
  vjm::Robot robot_;
  SimulationOptions options_{.translation_noise = 5e-7,
                             .components = {false, false, true, false, false, false}};
  std::string readings_;
};

}  // namespace kinetostat::calibration::test
