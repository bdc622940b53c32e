#include "kinetostat/io/link_result_file.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <fmt/format.h>

#include "kinetostat/common/error.h"
#include "kinetostat/io/json.h"
#include "kinetostat/spatial/free_stiffness.h"

namespace kinetostat::io {
namespace {

[[noreturn]] void fail_at(const std::filesystem::path& file, const char* key,
                          const std::string& what) {
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

Eigen::MatrixXd matrix_of(const std::filesystem::path& file, const Json& rows, const char* key,
                          std::size_t size = 6) {
  const auto refuse = [&] {
    fail_at(file, key,
            size == 6 ? "six rows of six numbers are expected"
                      : fmt::format("{0} rows of {0} numbers are expected", size));
  };
  if (!rows.is_array() || rows.size() != size) refuse();
  Eigen::MatrixXd matrix(size, size);
  for (std::size_t i = 0; i < size; ++i) {
    if (!rows[i].is_array() || rows[i].size() != size) refuse();
    for (std::size_t j = 0; j < size; ++j) {
      if (!rows[i][j].is_number()) refuse();
      matrix(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) = rows[i][j].get<double>();
    }
  }
  return 0.5 * (matrix + matrix.transpose());
}

template <class Link>
void read_error(const std::filesystem::path& file, const Json& json, Link& link,
                std::size_t size = 6) {
  const Json error = json.value("error", Json());
  if (!error.is_object() || !error.contains("bar") || !error.contains("recovery")) return;
  link.error = {matrix_of(file, error["bar"], "error.bar", size),
                matrix_of(file, error["recovery"], "error.recovery", size)};
}

template <class Link>
void read_bracket(const std::filesystem::path& file, const Json& json, Link& link,
                  std::size_t size = 6) {
  const Json given = json.value("bracket", Json());
  if (!given.is_object()) return;
  const LinkBracket bracket{
      matrix_of(file, given.value("rigid", Json()), "bracket.rigid", size),
      matrix_of(file, given.value("distributing", Json()), "bracket.distributing", size)};
  if (Eigen::LLT<Eigen::MatrixXd>(bracket.rigid).info() != Eigen::Success)
    fail_at(file, "bracket.rigid", "the matrix is not positive definite");
  if (Eigen::LLT<Eigen::MatrixXd>(bracket.distributing).info() != Eigen::Success)
    fail_at(file, "bracket.distributing", "the matrix is not positive definite");
  for (Eigen::Index i = 0; i < bracket.rigid.rows(); ++i)
    if (bracket.rigid(i, i) > (1 + 1e-6) * bracket.distributing(i, i))
      fail_at(file, "bracket", "the link yields more with rigid interfaces than without");
  link.bracket = bracket;
}

// Of the modulus of its material, in parts of it; of an assembly, the largest of its bodies.
double young_deviation(const std::filesystem::path& file, const Json& json) {
  if (const Json bodies = json.value("bodies", Json()); bodies.is_array()) {
    double most = 0;
    for (const Json& body : bodies)
      if (body.is_object()) most = std::max(most, young_deviation(file, body));
    return most;
  }
  const Json material = json.value("material", Json());
  if (!material.is_object() || !material.contains("E_sd")) return 0;
  const Json young = material.value("E", Json());
  const Json& deviation = material["E_sd"];
  if (!young.is_number() || !deviation.is_number() || !(deviation.get<double>() >= 0) ||
      !(deviation.get<double>() < young.get<double>()))
    fail_at(file, "material.E_sd", "a number from zero to material.E is expected");
  return deviation.get<double>() / young.get<double>();
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
  link.young_deviation = young_deviation(file, json);
  link.mesh_sha256 = mesh_hash(json);
  return link;
}

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr const char* of_reduced = "reduced.degrees_of_freedom";

// One row of the matrices: interface, motion, point and units as `identify` writes them.
void read_freedom(const std::filesystem::path& file, const Json& row, std::size_t number,
                  ReducedLink& link) {
  static constexpr std::array motions{"tx", "ty", "tz", "rx", "ry", "rz"};
  const std::size_t k = number % 6;
  const auto is = [&row](const char* key, const char* word) {
    return row.contains(key) && row[key] == word;
  };
  if (!row.is_object() || !row.contains("interface") || !row["interface"].is_string() ||
      !is("motion", motions[k]))
    fail_at(file, of_reduced,
            fmt::format("row {} must be the motion '{}' of an interface", number + 1, motions[k]));
  if (!is("motion_unit", k < 3 ? "m" : "rad") || !is("load_unit", k < 3 ? "N" : "N m"))
    fail_at(file, of_reduced, "the units m, rad, N and N m are expected");
  const auto name = row["interface"].get<std::string>();
  if (k > 0 && name == link.interfaces.back()) return;
  if (name.empty() ||
      std::any_of(name.begin(), name.end(), [](unsigned char c) { return std::iscntrl(c) != 0; }))
    fail_at(file, of_reduced, "the name of an interface is one line of text");
  const Json p = row.value("point", Json());
  if (k > 0 || std::count(link.interfaces.begin(), link.interfaces.end(), name) > 0)
    fail_at(file, of_reduced, fmt::format("the six rows of '{}' must follow each other", name));
  if (!p.is_array() || p.size() != 3 ||
      !std::all_of(p.begin(), p.end(), [](const Json& x) { return x.is_number(); }))
    fail_at(file, of_reduced, "the point of an interface is three numbers");
  link.interfaces.push_back(name);
  link.points.emplace_back(p[0].get<double>(), p[1].get<double>(), p[2].get<double>());
}

// Motions of all interfaces by those of a rigid body at a point.
MatrixXd rigid_motions(const std::vector<spatial::Vector3>& points, const spatial::Vector3& at) {
  MatrixXd motions(6 * static_cast<Index>(points.size()), 6);
  for (std::size_t i = 0; i < points.size(); ++i) {
    auto six = motions.middleRows<6>(6 * static_cast<Index>(i));
    six.setIdentity();
    six.topRightCorner<3, 3>() = -spatial::skew(points[i] - at);
  }
  return motions;
}

void check_symmetry(const std::filesystem::path& file, const Json& rows, const char* key,
                    const MatrixXd& symmetric) {
  const VectorXd size = symmetric.diagonal().cwiseAbs().cwiseSqrt();
  for (Index i = 0; i < symmetric.rows(); ++i)
    for (Index j = 0; j < i; ++j) {
      const double given = rows[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)];
      if (std::abs(given - symmetric(i, j)) > 0.5e-6 * size[i] * size[j])
        fail_at(file, key, "the matrix is not symmetric");
    }
}

// Against lengths and angles that differ by orders of magnitude: with a diagonal of ones.
void check_stiffness(const std::filesystem::path& file, const ReducedLink& link) {
  constexpr const char* key = "reduced.stiffness";
  constexpr double resisted = 1e-6, rounding = 1e-13;
  if (!(link.stiffness.diagonal().minCoeff() > 0))
    fail_at(file, key, "the matrix is not positive semi-definite with six rigid motions");
  const MatrixXd rigid = rigid_motions(link.points, link.points[0]);
  const MatrixXd left = link.stiffness * rigid,
                 terms = link.stiffness.cwiseAbs() * rigid.cwiseAbs();
  if (!((left.array().abs() <= resisted * terms.array().max(1e-300)).all()))
    fail_at(file, key, "the matrix resists rigid motions: it is not that of a free body");
  const Index size = link.stiffness.rows() - 6;
  const MatrixXd held = link.stiffness.bottomRightCorner(size, size);
  const VectorXd scale = held.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(
      scale.asDiagonal() * held * scale.asDiagonal(), Eigen::EigenvaluesOnly);
  const double least = eigen.eigenvalues()[0], largest = eigen.eigenvalues()[size - 1];
  if (least < -1e3 * rounding * largest)
    fail_at(file, key, "the matrix is not positive semi-definite");
  if (least < rounding * largest)
    fail_at(file, key, "the matrix leaves a motion free beside the six rigid ones");
}

void check_inertia(const std::filesystem::path& file, const MatrixXd& inertia) {
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(inertia, Eigen::EigenvaluesOnly);
  const VectorXd& found = eigen.eigenvalues();
  if (!(inertia.diagonal().minCoeff() > 0) || found[0] < -1e-9 * found[found.size() - 1])
    fail_at(file, "reduced.mass", "the matrix is not positive semi-definite");
}

// What is known of its error, in the rows and columns of the flexibility.
void read_spread(const std::filesystem::path& file, const Json& json, const Json& reduced,
                 ReducedLink& link) {
  const Json fixed = reduced.value("fixed", Json()), rows = reduced.value("flexibility", Json());
  if (fixed.is_null() || rows.is_null()) return;
  const auto found = std::find(link.interfaces.begin(), link.interfaces.end(), fixed);
  if (found == link.interfaces.end())
    fail_at(file, "reduced.fixed", "the name of an interface is expected");
  link.fixed = static_cast<std::size_t>(found - link.interfaces.begin());
  const std::size_t size = 6 * (link.interfaces.size() - 1);
  link.flexibility = matrix_of(file, rows, "reduced.flexibility", size);
  if (Eigen::LLT<MatrixXd>(link.flexibility).info() != Eigen::Success)
    fail_at(file, "reduced.flexibility", "the matrix is not positive definite");
  read_error(file, json, link, size);
  read_bracket(file, json, link, size);
}

}  // namespace

ReducedLink read_reduced_link(const std::filesystem::path& file) {
  const Json json = read_json(file);
  const Json reduced = json.is_object() ? json.value("reduced", Json()) : Json();
  if (!reduced.is_object())
    fail_at(file, "reduced", "the file has no stiffness between all interfaces of a link");
  const Json freedoms = reduced.value("degrees_of_freedom", Json());
  if (!freedoms.is_array() || freedoms.size() < 12 || freedoms.size() % 6 != 0)
    fail_at(file, of_reduced, "six rows of each of two or more interfaces are expected");
  ReducedLink link;
  for (std::size_t k = 0; k < freedoms.size(); ++k) read_freedom(file, freedoms[k], k, link);
  const Json stiffness = reduced.value("stiffness", Json()), mass = reduced.value("mass", Json());
  link.stiffness = matrix_of(file, stiffness, "reduced.stiffness", freedoms.size());
  check_symmetry(file, stiffness, "reduced.stiffness", link.stiffness);
  check_stiffness(file, link);
  if (!mass.is_null()) {
    link.inertia = matrix_of(file, mass, "reduced.mass", freedoms.size());
    check_inertia(file, link.inertia);
  }
  read_spread(file, json, reduced, link);
  link.young_deviation = young_deviation(file, json);
  return link;
}

MatrixXd free_stiffness(const ReducedLink& link, const MatrixXd& flexibility) {
  return spatial::free_stiffness(flexibility, link.points, link.fixed);
}

}  // namespace kinetostat::io
