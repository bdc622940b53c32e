#include "kinetostat/io/link_result_file.h"

#include <algorithm>

#include <Eigen/Cholesky>

#include "kinetostat/common/error.h"
#include "kinetostat/io/json.h"

namespace kinetostat::io {
namespace {

[[noreturn]] void fail_at(const std::filesystem::path& file, const char* key, const char* what) {
  throw common::InputError(
      {.file = file, .key = key, .what = what, .cure = "Write it with 'kinetostat identify'"});
}

void read_mass(const std::filesystem::path& file, const Json& json, IdentifiedLink& link) {
  const Json mass = json.value("mass", Json());
  if (mass.is_null()) return;
  if (!mass.is_number() || !(mass.get<double>() > 0))
    fail_at(file, "mass", "a number above zero, or null, is expected");
  const Json c = json.value("center_of_mass", Json());
  if (!c.is_array() || c.size() != 3 ||
      !std::all_of(c.begin(), c.end(), [](const Json& x) { return x.is_number(); }))
    fail_at(file, "center_of_mass", "three numbers are expected, since the link has a mass");
  link.mass = mass.get<double>();
  link.center_of_mass = {c[0].get<double>(), c[1].get<double>(), c[2].get<double>()};
}

spatial::Matrix6 matrix_of(const std::filesystem::path& file, const Json& rows, const char* key) {
  spatial::Matrix6 matrix;
  for (std::size_t i = 0; i < 6; ++i)
    for (std::size_t j = 0; j < 6; ++j) {
      if (!rows.is_array() || rows.size() != 6 || !rows[i].is_array() || rows[i].size() != 6 ||
          !rows[i][j].is_number())
        fail_at(file, key, "six rows of six numbers are expected");
      matrix(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) = rows[i][j].get<double>();
    }
  return 0.5 * (matrix + matrix.transpose());
}

void read_error(const std::filesystem::path& file, const Json& json, IdentifiedLink& link) {
  const Json error = json.value("error", Json());
  if (!error.is_object() || !error.contains("bar") || !error.contains("recovery")) return;
  link.error = {matrix_of(file, error["bar"], "error.bar"),
                matrix_of(file, error["recovery"], "error.recovery")};
}

void read_bracket(const std::filesystem::path& file, const Json& json, IdentifiedLink& link) {
  const Json given = json.value("bracket", Json());
  if (!given.is_object()) return;
  const LinkBracket bracket{
      matrix_of(file, given.value("rigid", Json()), "bracket.rigid"),
      matrix_of(file, given.value("distributing", Json()), "bracket.distributing")};
  if (Eigen::LLT<spatial::Matrix6>(bracket.rigid).info() != Eigen::Success)
    fail_at(file, "bracket.rigid", "the matrix is not positive definite");
  if (Eigen::LLT<spatial::Matrix6>(bracket.distributing).info() != Eigen::Success)
    fail_at(file, "bracket.distributing", "the matrix is not positive definite");
  for (int i = 0; i < 6; ++i)
    if (bracket.rigid(i, i) > (1 + 1e-6) * bracket.distributing(i, i))
      fail_at(file, "bracket", "the link yields more with rigid interfaces than without");
  link.bracket = bracket;
}

std::string mesh_hash(const Json& json) {
  const Json inputs = json.value("inputs", Json());
  if (!inputs.is_object()) return {};
  const Json hash = inputs.value("mesh_sha256", Json());
  return hash.is_string() ? hash.get<std::string>() : std::string();
}

}  // namespace

IdentifiedLink read_identified_link(const std::filesystem::path& file) {
  IdentifiedLink link{.compliance = read_compliance(file), .mass = {}};
  const Json json = read_json(file);
  read_mass(file, json, link);
  read_error(file, json, link);
  read_bracket(file, json, link);
  link.mesh_sha256 = mesh_hash(json);
  return link;
}

}  // namespace kinetostat::io
