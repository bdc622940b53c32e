#include "kinetostat/calibration/comparison/unit_error.h"

#include <cmath>
#include <map>
#include <utility>

#include <fmt/format.h>

#include "kinetostat/calibration/regression/base_fit.h"

namespace kinetostat::calibration {
namespace {

constexpr double same_pattern = 0.9;  // correlation
constexpr double no_stiffness = 8;    // so wrong is none that somebody wrote down
constexpr int fewest = 4;             // values beyond the means

// Sums over readings (m) and predictions (p), means taken out.
struct Sums {
  int count = 0;
  double m = 0, p = 0, mm = 0, mp = 0, pp = 0;

  void add(double measured, double predicted) {
    ++count;
    m += measured;
    p += predicted;
    mm += measured * measured;
    mp += measured * predicted;
    pp += predicted * predicted;
  }
  void add(const Sums& group) {
    count += group.count - 1;
    mm += group.mm - group.m * group.m / group.count;
    mp += group.mp - group.m * group.p / group.count;
    pp += group.pp - group.p * group.p / group.count;
  }
};

Sums sums_of(const Campaign& campaign, const std::vector<Eigen::VectorXd>& predicted,
             bool rotations) {
  std::map<std::pair<std::size_t, Eigen::Index>, Sums> groups;  // of session and component
  for (const Value& value : values_in_use(campaign)) {
    if (campaign.component(value.component).dimension !=
        (rotations ? spatial::dimension::angle : spatial::dimension::length))
      continue;
    const Reading& reading = campaign.readings[value.reading];
    groups[{reading.session, value.component}].add(reading.displacement[value.component],
                                                   predicted[value.reading][value.component]);
  }
  Sums all;
  for (const auto& [key, group] : groups) all.add(group);
  return all;
}

// Unit errors by which readings become so many times too large.
std::string unit_error_of(double factor, bool rotations) {
  struct Known {
    double factor;
    bool of_rotations;
    const char* slip;
  };
  constexpr Known all[] = {
      {180 / M_PI, true, "deg taken for rad"},
      {M_PI / 180, true, "rad taken for deg"},
      {25.4, false, "mm taken for inch"},
      {1 / 25.4, false, "inch taken for mm"},
      {1e3, false, "um taken for mm, or wrenches in kN for N"},
      {1e-3, false, "mm taken for um or m for mm, or wrenches in N for kN"},
      {1e3, true, "mrad taken for rad, or wrenches in kN m for N m"},
      {1e-3, true, "rad taken for mrad, or wrenches in N mm for N m"},
  };
  for (const Known& known : all)
    if (known.of_rotations == rotations && std::abs(std::log(factor / known.factor)) < 0.35)
      return fmt::format("as of {}", known.slip);
  return {};
}

}  // namespace

std::string unit_error(const Campaign& campaign, const std::vector<Eigen::VectorXd>& predicted) {
  for (const bool rotations : {false, true}) {
    const Sums sums = sums_of(campaign, predicted, rotations);
    if (sums.count < fewest || !(sums.mm > 0 && sums.pp > 0)) continue;
    const double correlation = sums.mp / std::sqrt(sums.mm * sums.pp);
    const double factor = sums.mp / sums.pp;
    if (std::abs(correlation) < same_pattern) continue;
    const char* what = rotations ? "rotations" : "translations";
    if (factor < 0)
      return fmt::format(
          "The measured {} are against the predicted ones (correlation {:.2f}): a wrench is what "
          "acts on the robot, a displacement is where it is under load less where it was. Check "
          "the signs of the readings and the axes of 'frames'.",
          what, correlation);
    if (factor > 1 / no_stiffness && factor < no_stiffness) continue;
    const std::string slip = unit_error_of(factor, rotations);
    return fmt::format(
        "The measured {} are {:.3g} times the predicted ones, in the same pattern (correlation "
        "{:.2f}){}{}. Check the units of the readings and of their wrenches, and the stiffnesses "
        "of the robot file.",
        what, factor, correlation, slip.empty() ? "" : ", ", slip);
  }
  return {};
}

std::string unit_error(const Campaign& campaign, const Predictor& nominal,
                       common::Progress& progress) {
  const Predictions predictions = nominal.predict({}, {}, false, progress);
  return predictions.failure ? std::string() : unit_error(campaign, predictions.displacement);
}

}  // namespace kinetostat::calibration
