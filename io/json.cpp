#include "kinetostat/io/json.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <fmt/format.h>

#include "kinetostat/common/error.h"
#include "kinetostat/common/printable.h"
#include "kinetostat/io/file_kind.h"
#include "kinetostat/io/json_size.h"
#include "kinetostat/io/text_file.h"
#include "kinetostat/spatial/rotation.h"

namespace kinetostat::io {
namespace {

using spatial::Matrix6;
using spatial::Vector3;

void add_frame(Json& json, const spatial::Frame& frame) {
  json["point"] = to_json(frame.point);
  json["axes"] = rows(frame.axes.transpose());
}

Json coordinate_order() { return {"tx", "ty", "tz", "rx", "ry", "rz"}; }
Json si_units() { return {{"length", "m"}, {"force", "N"}, {"angle", "rad"}}; }

Json matrix_json(const char* name, const Matrix6& matrix, const spatial::Frame& frame) {
  Json json;
  json[name] = rows(matrix);
  json["order"] = coordinate_order();
  add_frame(json, frame);
  json["units"] = si_units();
  return json;
}

bool is_flat(const Json& list) {
  return std::none_of(list.begin(), list.end(), [](const Json& v) { return v.is_structured(); });
}

// The control characters that JSON need not escape, U+007F to U+009F: a terminal obeys them.
std::string without_controls(const std::string& text) {
  std::string result;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto c = static_cast<unsigned char>(text[i]);
    const auto next = i + 1 < text.size() ? static_cast<unsigned char>(text[i + 1]) : 0U;
    if (c == 0x7f) {
      result += "\\u007f";
    } else if (c == 0xc2 && next < 0xa0) {
      result += fmt::format("\\u{:04x}", next);
      ++i;
    } else {
      result += text[i];
    }
  }
  return result;
}

// Names and file names are whatever bytes the user's system has; JSON holds UTF-8 only. Bytes that
// are not UTF-8 become the replacement character instead of losing the result.
std::string scalar(const Json& value) {
  std::string text = value.dump(-1, ' ', false, Json::error_handler_t::replace);
  return common::has_control_characters(text) ? without_controls(text) : text;
}

void write_value(std::string& out, const Json& json, std::size_t indent) {
  const auto new_line = [&out](std::size_t depth) { out += "\n" + std::string(2 * depth, ' '); };
  if (json.is_object() && !json.empty()) {
    out += "{";
    const char* separator = "";
    for (const auto& [key, value] : json.items()) {
      out += separator;
      new_line(indent + 1);
      out += scalar(key) + ": ";
      write_value(out, value, indent + 1);
      separator = ",";
    }
    new_line(indent);
    out += "}";
  } else if (json.is_array() && !json.empty() && !is_flat(json)) {
    out += "[";
    const char* separator = "";
    for (const Json& value : json) {
      out += separator;
      new_line(indent + 1);
      write_value(out, value, indent + 1);
      separator = ",";
    }
    new_line(indent);
    out += "]";
  } else if (json.is_array()) {
    out += "[";
    for (std::size_t i = 0; i < json.size(); ++i) out += (i ? ", " : "") + scalar(json[i]);
    out += "]";
  } else {
    out += scalar(json);
  }
}

// Reads the pieces of a 6x6 from JSON, naming the key that is wrong.
class MatrixReader {
 public:
  MatrixReader(const std::filesystem::path& file, const Json& json) : file_(file), json_(json) {}

  template <int Rows, int Columns>
  Eigen::Matrix<double, Rows, Columns> matrix(const char* key) const {
    const Json& list = at(key);
    Eigen::Matrix<double, Rows, Columns> result;
    if (!list.is_array() || list.size() != Rows)
      fail(key, fmt::format("{} rows are expected", Rows));
    for (int i = 0; i < Rows; ++i) {
      const Json& row = list[static_cast<std::size_t>(i)];
      if (!row.is_array() || row.size() != Columns)
        fail(key, fmt::format("row {} must have {} numbers", i + 1, Columns));
      for (int j = 0; j < Columns; ++j)
        result(i, j) = number(key, row[static_cast<std::size_t>(j)]);
    }
    return result;
  }

  Vector3 vector(const char* key) const {
    const Json& list = at(key);
    if (!list.is_array() || list.size() != 3) fail(key, "three numbers are expected");
    return {number(key, list[0]), number(key, list[1]), number(key, list[2])};
  }

  // A matrix in other units or another order would be misread without a word.
  void require(const char* key, const Json& value) const {
    if (at(key) != value) fail(key, fmt::format("{} is expected", value.dump()));
  }

  [[noreturn]] void fail(const char* key, const std::string& what) const {
    throw common::InputError({.file = file_,
                              .key = key,
                              .what = what,
                              .cure = "Write this file with 'kinetostat identify'"});
  }

 private:
  const Json& at(const char* key) const {
    if (!json_.is_object() || !json_.contains(key)) fail(key, "this key is missing");
    return json_.at(key);
  }
  double number(const char* key, const Json& value) const {
    if (!value.is_number()) fail(key, fmt::format("'{}' is not a number", value.dump()));
    return value.get<double>();
  }

  const std::filesystem::path& file_;
  const Json& json_;
};

// A link result with more interfaces has a larger matrix instead.
void require_two_interfaces(const std::filesystem::path& file, const Json& json) {
  if (!json.is_object() || json.contains("compliance") || !json.contains("interfaces")) return;
  const Json& interfaces = json["interfaces"];
  if (!interfaces.is_object() || interfaces.size() <= 2) return;
  std::string names;
  for (const auto& [name, value] : interfaces.items()) names += (names.empty() ? "" : ", ") + name;
  throw common::InputError(
      {.file = file,
       .key = "interfaces",
       .what = "a link with " + std::to_string(interfaces.size()) + " interfaces (" + names +
               ") is not a spring between two ends, which is all that a link of a chain is",
       .cure =
           "Make it an elastic body of the manipulator, 'bodies: [{name: ..., elastic: FILE}]', "
           "between whose interfaces chains run"});
}

}  // namespace

namespace {

[[noreturn]] void refuse_syntax(const std::filesystem::path& file, const std::string& text,
                                std::size_t byte) {
  const auto end = text.begin() + static_cast<std::ptrdiff_t>(std::min(byte, text.size()));
  throw common::InputError({.file = file,
                            .line = 1 + static_cast<int>(std::count(text.begin(), end, '\n')),
                            .what = "not valid JSON",
                            .cure = "Write this file with kinetostat rather than by hand"});
}

}  // namespace

Json read_json(const std::filesystem::path& file) {
  const std::string text = read_text(file);
  refuse_other_kinds(file, text, "a result of this program (JSON)",
                     "Give the file that '--json FILE' wrote");
  if (is_nested_too_deeply(text))
    throw common::InputError(file, "is nested too deeply", "Write this file with kinetostat");
  if (is_too_large(text))
    throw common::InputError(file, "holds more values than any result of this program",
                             "Write this file with kinetostat");
  try {
    return Json::parse(text);
  } catch (const Json::parse_error& error) {
    refuse_syntax(file, text, error.byte);
  } catch (const Json::out_of_range&) {
    throw common::InputError(file, "a number is too large", "Numbers must lie within +-1.8e308");
  }
}

std::string to_text(const Json& json) {
  std::string text;
  write_value(text, json, 0);
  return text + "\n";
}

void write_json(const std::filesystem::path& file, const Json& json) {
  write_atomically(file, to_text(json));
}

Json numbers(const Eigen::Ref<const Eigen::VectorXd>& values) {
  Json list = Json::array();
  for (const double x : values) list.push_back(std::isnan(x) ? Json() : Json(x));
  return list;
}

Json to_json(const Vector3& vector) { return {vector.x(), vector.y(), vector.z()}; }

Json to_json(const spatial::Compliance6& compliance) {
  return matrix_json("compliance", compliance.matrix(), compliance.frame());
}

Json to_json(const spatial::Stiffness6& stiffness) {
  return matrix_json("stiffness", stiffness.matrix(), stiffness.frame());
}

Json to_json(const spatial::Wrench& wrench) {
  Json json{{"force", to_json(wrench.force)}, {"moment", to_json(wrench.moment)}};
  add_frame(json, wrench.frame);
  return json;
}

Json to_json(const spatial::Twist& twist) {
  Json json{{"translation", to_json(twist.translation)}, {"rotation", to_json(twist.rotation)}};
  add_frame(json, twist.frame);
  return json;
}

spatial::Compliance6 read_compliance(const std::filesystem::path& file) {
  const Json json = read_json(file);
  const MatrixReader reader(file, json);
  require_two_interfaces(file, json);
  reader.require("order", coordinate_order());
  reader.require("units", si_units());
  const Matrix6 matrix = reader.matrix<6, 6>("compliance");
  const spatial::Frame frame{reader.vector("point"), reader.matrix<3, 3>("axes").transpose()};
  if (!spatial::is_rotation(frame.axes, 1e-6))
    reader.fail("axes", "the three axes are not orthonormal and right-handed");
  if (spatial::symmetry_defect(matrix) > 1e-6)
    reader.fail("compliance", "the matrix is not symmetric");
  const Vector3 scale_t = matrix.diagonal().head<3>(), scale_r = matrix.diagonal().tail<3>();
  if (!(scale_t.minCoeff() > 0) || !(scale_r.minCoeff() > 0) ||
      Eigen::LLT<Matrix6>(matrix).info() != Eigen::Success)
    reader.fail("compliance", "the matrix is not positive definite");
  return spatial::Compliance6(0.5 * (matrix + matrix.transpose()), frame);
}

}  // namespace kinetostat::io
