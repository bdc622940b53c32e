// A session of the studio: effects are switched on, fitted with everything that is uncertain,
// saved.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "kinetostat/calibration/search/candidate_fitter.h"
#include "kinetostat/report/page.h"
#include "kinetostat/vjm/io/robot_file.h"

namespace kinetostat::apps {

/// A robot and a campaign. Not for several threads at once. Mistakes of the other side end in
/// common::InputError.
class StudioSession {
 public:
  /// Throws what the comparison throws, and common::InputError when nobody knows the noise.
  StudioSession(vjm::Robot robot, calibration::Campaign campaign, std::filesystem::path folder,
                int threads, common::Progress& progress);
  StudioSession(const StudioSession&) = delete;
  StudioSession& operator=(const StudioSession&) = delete;

  /// The comparison, with the names of all that can be switched on.
  const report::PageResult& opening() const { return opening_; }
  std::string title() const { return report::title_of(opening_.result); }

  /// {"effects": ["clearance at x.rho"]} -> the residuals with these effects at their best values,
  /// and those values. Throws common::Cancelled when `progress` says so.
  io::Json fit(const io::Json& request, common::Progress& progress);
  /// {"file": "better.yaml"}: what was fitted last, into a robot file in the folder. A name is a
  /// plain file name that ends with .yaml; a file that is there already and is not of this session
  /// is left alone.
  io::Json save(const io::Json& request);

 private:
  std::vector<calibration::Candidate> chosen(const io::Json& request) const;
  calibration::BaseFit best_fit(std::vector<calibration::Candidate>& effects,
                                common::Progress& progress) const;

  vjm::Robot robot_;
  calibration::Campaign campaign_, fitted_;  // all readings, and those to fit by
  calibration::Noise noise_;
  std::filesystem::path folder_;
  int threads_;
  std::vector<calibration::Candidate> candidates_;
  report::PageResult opening_;
  std::vector<calibration::Candidate> last_;  // with the values and deviations of the last fit
  std::vector<calibration::ParameterEstimate> fitted_beside_;  // what is uncertain, in that fit
  std::vector<std::string> saved_;
};

}  // namespace kinetostat::apps
