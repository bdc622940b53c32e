// The unit of length that a mesh file does not state.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "kinetostat/common/error.h"
#include "kinetostat/spatial/linear_algebra.h"

namespace kinetostat::fea {

/// The unit of a mesh is not stated. Whoever knows where it should have been stated adds that.
class MissingUnit : public common::InputError {
 public:
  using InputError::InputError;
};

/// Metres in one `unit` of length. Throws MissingUnit when it is empty, with the box around
/// `points` in mm, m and inch to choose by; InputError when it is no unit of length.
double metres_per_unit(const std::filesystem::path& file, const std::string& unit,
                       const std::vector<spatial::Vector3>& points);

}  // namespace kinetostat::fea
