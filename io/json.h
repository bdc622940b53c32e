// Results as JSON: ordered keys, shortest numbers that read back the same.
#pragma once

#include <filesystem>

#include <nlohmann/json.hpp>

#include "kinetostat/spatial/stiffness.h"
#include "kinetostat/spatial/wrench_twist.h"

namespace kinetostat::io {

using Json = nlohmann::ordered_json;

/// Throws InputError with line and column when the file is missing or not JSON.
Json read_json(const std::filesystem::path& file);

/// Indented, arrays of numbers on one line, written atomically.
void write_json(const std::filesystem::path& file, const Json& json);
std::string to_text(const Json& json);

/// Every 6x6 is stored with `order`, `point`, `axes` and `units`; the rows as a list of lists. Axes
/// are the three axis directions, one row each.
Json to_json(const spatial::Compliance6& compliance);
Json to_json(const spatial::Stiffness6& stiffness);
Json to_json(const spatial::Wrench& wrench);
Json to_json(const spatial::Twist& twist);
Json to_json(const spatial::Vector3& vector);
/// A list; null where there is no number (NaN).
Json numbers(const Eigen::Ref<const Eigen::VectorXd>& values);
/// A matrix of any size and without a frame: a list of its rows.
template <class Derived>
Json rows(const Eigen::MatrixBase<Derived>& matrix) {
  Json list = Json::array();
  for (Eigen::Index i = 0; i < matrix.rows(); ++i) {
    Json row = Json::array();
    for (Eigen::Index j = 0; j < matrix.cols(); ++j) row.push_back(matrix(i, j));
    list.push_back(std::move(row));
  }
  return list;
}

/// Reads what to_json(Compliance6) wrote, or a link result that has the same keys. Throws
/// InputError naming the key that is missing or malformed, when order or units are others than
/// to_json writes, and when the matrix is not symmetric to 1e-6 or not positive definite.
spatial::Compliance6 read_compliance(const std::filesystem::path& file);

}  // namespace kinetostat::io
