#include "kinetostat/io/link_result_file.h"

#include <algorithm>

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
  link.mesh_sha256 = mesh_hash(json);
  return link;
}

}  // namespace kinetostat::io
