// Stewart-Gough platforms of IROS11 section VI: printed matrices beside ours.
#include <cmath>

#include <fmt/format.h>

#include "kinetostat/vjm/manipulator/posture.h"
#include "kinetostat/vjm/statics/stiffness.h"

#include "tables.h"

namespace kinetostat::theory {
namespace {

using spatial::Matrix6;
using spatial::Vector3;
using spatial::Vector6;

constexpr double R = 0.5, r = 0.3, h = 0.6, K11 = 1e8;  // of the shipped robots

// Entry of (27) or (28) as printed, without the factor 3 K11/L^2.
double printed(char platform, int i, int j) {
  const double da = R - r, db = R / 2 - r;
  const double d = platform == 'A' ? da : db;
  if (i == j) {
    if (i < 2) return da * da + (platform == 'A' ? 0 : R * r);
    if (i == 2) return 2 * h * h;
    if (i < 5) return r * r * h * h;
    return platform == 'A' ? 0 : 1.5 * r * r * R * R;
  }
  if (i == 0 && j == 4) return r * h * d;
  return i == 1 && j == 3 ? -r * h * d : 0;
}

// (25)-(26) as printed: arm v = -r (cos, sin, 0), wrench [u; v x u].
Matrix6 by_printed_arm(char platform, double length) {
  Matrix6 sum = Matrix6::Zero();
  const double base_a[] = {0, 60, 120, 180, 240, 300}, base_b[] = {0, 120, 120, 240, 240, 360};
  const double top_b[] = {60, 60, 180, 180, 300, 300};
  for (int i = 0; i < 6; ++i) {
    const double phi = (platform == 'A' ? base_a : base_b)[i] * M_PI / 180;
    const double psi = (platform == 'A' ? base_a : top_b)[i] * M_PI / 180;
    const Vector3 u =
        Vector3(r * std::cos(psi) - R * std::cos(phi), r * std::sin(psi) - R * std::sin(phi), h) /
        length;
    const Vector3 v(-r * std::cos(psi), -r * std::sin(psi), 0);
    Vector6 w;
    w << u, v.cross(u);
    sum += K11 * w * w.transpose();
  }
  return sum;
}

}  // namespace

std::string iros11_platforms() {
  std::vector<std::vector<std::string>> rows;
  static constexpr int entries[][2] = {{0, 0}, {2, 2}, {3, 3}, {5, 5}, {0, 4}, {1, 3}};
  for (const char platform : {'A', 'B'}) {
    const vjm::Robot robot =
        shipped(platform == 'A' ? "stewart_gough_a.yaml" : "stewart_gough_b.yaml");
    const vjm::Posture posture =
        posture_at(robot.manipulator, spatial::Pose::translation({0, 0, h})).posture;
    const vjm::UnloadedStiffness u = unloaded_stiffness(robot.manipulator, posture);
    const double squared =
        platform == 'A' ? (R - r) * (R - r) + h * h : R * R + r * r - R * r + h * h;
    const double factor = 3 * K11 / squared;
    const Matrix6 arm = by_printed_arm(platform, std::sqrt(squared));
    for (const auto& [i, j] : entries) {
      const auto shown = [](double value) {
        return fmt::format("{:.5f}", std::abs(value) < 1e-9 ? 0 : value);
      };
      rows.push_back({fmt::format("{} ({}, {})", platform, i + 1, j + 1),
                      shown(printed(platform, i, j)), shown(u.stiffness->matrix()(i, j) / factor),
                      shown(arm(i, j) / factor)});
    }
    rows.push_back({fmt::format("{} rank", platform), "", fmt::format("{}", u.free.rank), ""});
  }
  return markdown(
      {"entry, times L^2/(3 K11) [SI]", "(27), (28) as printed", "ours", "(25)-(26) as printed"},
      rows);
}

}  // namespace kinetostat::theory
