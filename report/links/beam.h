// A link as beams beside its finite elements, for people and for programs.
#pragma once

#include <string>
#include <vector>

#include "kinetostat/fea/link/link_file.h"
#include "kinetostat/fea/section/beam_study.h"
#include "kinetostat/io/json.h"

namespace kinetostat::report {

struct BeamResult {
  const fea::LinkSpec& link;
  const spatial::Compliance6& compliance;  // of finite elements, what the beams are compared with
  std::string source;                      // where that comes from, in words
  std::vector<std::string> warnings;       // about it
  const fea::BeamStudy& study;
  std::vector<fea::BeamComparison> comparisons;  // of every model of the study
  std::string verdict;
};

/// The sections, every significant entry beside that of finite elements, and when a beam is enough.
std::string text(const BeamResult& result);
/// In SI units.
io::Json to_json(const BeamResult& result);

}  // namespace kinetostat::report
