// Is a beam enough? A link as one beam, as several and as many, beside its finite-element result.
#pragma once

#include <string>

#include "kinetostat/common/progress.h"
#include "kinetostat/fea/section/beam_model.h"
#include "kinetostat/fea/section/link_axis.h"
#include "kinetostat/spatial/stiffness.h"

namespace kinetostat::fea {

struct BeamOptions {
  int beams = 4;      // of the coarse chain, at least 2
  int stations = 24;  // sections along the axis, at least 4; the fine chain has one beam for each
};

/// A section along the axis with what it amounts to.
struct BeamStation {
  double arc;  // [m] along the axis
  spatial::Frame frame;
  Vector3 centroid;  // [m]
  SectionProperties properties;
};

struct BeamModel {
  std::string name;  // "1 beam", "4 beams"
  std::vector<BeamElement> beams;
  spatial::Compliance6 compliance;  // at the loaded interface's point, mesh axes
};

struct BeamStudy {
  Curve axis;
  std::vector<BeamStation> stations;
  /// One beam: straight from centroid to centroid of the interfaces, of the section half way. The
  /// chains follow the axis in equal steps; each beam has the section at its middle.
  std::vector<BeamModel> models;
  std::vector<std::string> warnings;
};

/// `point` is where the compliance is taken [m]. Throws SectionError when the link cannot be cut
/// into sections; Cancelled.
BeamStudy study_beams(const LinkBody& body, const Material& material, const Vector3& point,
                      const BeamOptions& options, common::Progress& progress);

/// One beam model beside FEA, both at the same point. An entry is significant when it couples at
/// least a twentieth of what its two diagonal entries could.
struct BeamComparison {
  std::string name;
  Matrix6 errors;  // of significant entries relative to FEA's, of others to the diagonal
  Eigen::Matrix<bool, 6, 6> significant;
  double worst;  // largest of the significant ones, absolute
  int worst_row, worst_column;
  /// Least and largest ratio of the model's compliance to FEA's under any wrench.
  double least_ratio, largest_ratio;
};
BeamComparison compare(const BeamModel& model, const spatial::Compliance6& fea);

/// When a beam is enough for errors up to `tolerance` (0.1 is 10 %), one sentence with figures.
std::string verdict(const std::vector<BeamComparison>& comparisons, double tolerance);

}  // namespace kinetostat::fea
