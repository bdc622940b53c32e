// Experimental design: the batch of readings that best distinguishes candidate models, or, with one
// model left, that makes it sharper where it is used.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "kinetostat/calibration/design/plan_options.h"
#include "kinetostat/calibration/design/plan_question.h"

namespace kinetostat::calibration {

/// Two models, and how well they will be distinguished.
struct PlannedSplit {
  std::string a, b;
  double separation = 0;  // d' of the batch
  double most = 0;        // of everything that could be measured, together
  double nats = 0;        // expected difference of log evidence, d'^2 / 2
  /// Log evidence of `a` less that of `b`, from the readings so far.
  std::optional<double> so_far;
  std::string advice;  // what would distinguish them, where no batch of this kind does
};

/// A number that the model has, and how well it is known.
struct PlannedSharpening {
  std::string name, unit;
  double before = 0, after = 0;  // standard deviation [SI, or of a logarithm]
};

struct Plan {
  DisplacementKind displacement = DisplacementKind::difference;
  bool asks_for_absolute = false;  // not observable in differences, which the campaign measures
  bool asks_for_weights = false;   // not observable with the load cell of the campaign
  std::vector<PlanBlock> blocks;   // in order
  std::vector<std::string> why;    // of each
  Campaign readings;
  double minutes = 0;
  std::vector<PlannedSplit> splits;  // worst first
  std::vector<PlannedSharpening> sharpened;
  /// Rms of what is not known of displacements where the model is used [m], before and after; with
  /// the largest loads along each axis. NaN where nothing was to be sharpened.
  double work_before = 0, work_after = 0;
  bool has_replicates = false;
  std::vector<std::string> notes;  // what was left out, what cannot be had
};

/// Postures, directions and histories are chosen one after the other, each time those that reduce
/// the chance of a wrong name most per minute: sum of p_a p_b exp(-d'^2/8) (the bound of
/// Bhattacharyya 1943 for Gaussian laws of one covariance); with one model left, the variance of
/// its predictions where it is used. Deterministic. Throws common::NotIdentifiable where nothing
/// can be planned, with the reason.
Plan plan(const vjm::Robot& robot, const Campaign& campaign, const PlanQuestion& question,
          const PlanOptions& options, int threads, common::Progress& progress);

}  // namespace kinetostat::calibration
