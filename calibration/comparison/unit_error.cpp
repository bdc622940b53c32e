#include "kinetostat/calibration/comparison/unit_error.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include <fmt/format.h>

#include "kinetostat/calibration/regression/base_fit.h"
#include "kinetostat/calibration/regression/session_frame.h"
#include "kinetostat/spatial/rotation.h"

namespace kinetostat::calibration {
namespace {

constexpr double same_pattern = 0.9;  // correlation
constexpr double no_stiffness = 8;    // so wrong is none that somebody wrote down
constexpr int fewest = 4;             // values beyond the means

// Sums over readings (m) and predictions (p), means taken out.
struct Sums {
  int count = 0;
  double m = 0, p = 0, mm = 0, mp = 0, pp = 0;
  double noise = 0;  // variance that readings have beside what moves the robot

  void add(double measured, double predicted, double deviation) {
    ++count;
    noise += deviation * deviation;
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
    noise += group.noise;
  }
  double correlation() const { return mp / std::sqrt(mm * pp); }
  // Of what noise leaves of the readings, where there is no doubt that something is left.
  bool follow() const {
    constexpr double no_doubt = 5;  // standard deviations from no correlation
    const double plain = std::abs(correlation());
    if (plain >= same_pattern) return true;
    const double most_noise = 0.75 * mm;
    return plain * std::sqrt(count) > no_doubt &&
           plain >= same_pattern * std::sqrt(1 - std::min(noise, most_noise) / mm);
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
    groups[{reading.session, value.component}].add(
        reading.displacement[value.component], predicted[value.reading][value.component],
        campaign.noise_stated ? reading.sigma[value.component] : 0);
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
      {9.80665, false, "wrenches in kgf for N"},
      {1 / 9.80665, false, "wrenches in N for kgf"},
      {9.80665, true, "wrenches in kgf m for N m"},
      {1 / 9.80665, true, "wrenches in N m for kgf m"},
      {1e3, true, "mrad taken for rad, or wrenches in kN m for N m"},
      {1e-3, true, "rad taken for mrad, or wrenches in N mm for N m"},
  };
  for (const Known& known : all)
    if (known.of_rotations == rotations && std::abs(std::log(factor / known.factor)) < 0.35)
      return fmt::format("as of {}", known.slip);
  return {};
}

// Absolute positions of the platform, predicted and measured.
struct Positions {
  std::vector<spatial::Vector3> predicted, measured;

  Positions(const Campaign& campaign, const std::vector<Eigen::VectorXd>& all) {
    for (std::size_t i = 0; i < campaign.readings.size(); ++i) {
      const Reading& reading = campaign.readings[i];
      if (!reading.uses(0) || !reading.uses(1) || !reading.uses(2)) continue;
      predicted.push_back(all[i].head<3>());
      measured.push_back(reading.displacement.head<3>());
    }
  }
  // Root mean square of the error [m] where predictions are moved by a frame.
  double error(const spatial::Vector6& frame) const {
    const spatial::Matrix3 turn = spatial::exp_rotation(frame.tail<3>());
    double sum = 0;
    for (std::size_t i = 0; i < predicted.size(); ++i)
      sum += (measured[i] - frame.head<3>() - turn * predicted[i]).squaredNorm();
    return std::sqrt(sum / static_cast<double>(predicted.size()));
  }
};

// Of positions in left-handed axes.
double mirrored_error(Positions positions) {
  for (spatial::Vector3& m : positions.measured) m.z() = -m.z();
  return positions.error(frame_between(positions.predicted, positions.measured));
}

// Positions that lie as predicted, but in another frame: of an instrument that stands elsewhere.
std::string frame_error(const Campaign& campaign, const std::vector<Eigen::VectorXd>& predicted) {
  constexpr double rest = 0.1;  // of the error, at most
  constexpr double far = 0.01;  // [m]
  constexpr std::size_t fewest_places = 5;
  if (campaign.displacement != DisplacementKind::absolute || !campaign.reads_platform() ||
      campaign.session_frame == SessionFrame::estimated)
    return {};
  const Positions positions(campaign, predicted);
  if (positions.predicted.size() < fewest_places) return {};
  const double before = positions.error(spatial::Vector6::Zero());
  const double after = positions.error(frame_between(positions.predicted, positions.measured));
  if (!(before > far)) return {};
  if (mirrored_error(positions) < rest * std::min(before, after))
    return "The measured positions lie as predicted in left-handed axes of the instrument: one of "
           "the columns of the position has the wrong sign, or two are exchanged. Check the order "
           "and signs of the columns.";
  if (!(after < rest * before)) return {};
  return fmt::format(
      "The measured positions are off by {:.3g} m, and a frame of their own takes {:.3g} % of "
      "that: "
      "the instrument does not stand where the base of the robot is. Say 'session_frame: estimate' "
      "in the campaign file, or where it stands: 'displacement_frame'.",
      before, 100 * (1 - after / before));
}

// Of readings of one dimension that follow the predictions.
std::string slope_error(const Sums& sums, bool rotations) {
  const double correlation = sums.correlation(), factor = sums.mp / sums.pp;
  const char* what = rotations ? "rotations" : "translations";
  if (factor < 0)
    return fmt::format(
        "The measured {} are against the predicted ones (correlation {:.2f}): a wrench is what "
        "acts on the robot, a displacement is where it is under load less where it was. Check "
        "the signs of the readings and the axes of 'frames'.",
        what, correlation);
  if (factor > 1 / no_stiffness && factor < no_stiffness) return {};
  const std::string slip = unit_error_of(factor, rotations);
  return fmt::format(
      "The measured {} are {:.3g} times the predicted ones, in the same pattern (correlation "
      "{:.2f}){}{}. Check the units of the readings and of their wrenches, and the stiffnesses "
      "of the robot file.",
      what, factor, correlation, slip.empty() ? "" : ", ", slip);
}

}  // namespace

std::string unit_error(const Campaign& campaign, const std::vector<Eigen::VectorXd>& predicted) {
  if (std::string frame = frame_error(campaign, predicted); !frame.empty()) return frame;
  for (const bool rotations : {false, true}) {
    const Sums sums = sums_of(campaign, predicted, rotations);
    if (sums.count < fewest || !(sums.mm > 0 && sums.pp > 0) || !sums.follow()) continue;
    if (std::string error = slope_error(sums, rotations); !error.empty()) return error;
  }
  return {};
}

std::string rotation_unit_error(const Campaign& campaign,
                                const std::vector<Eigen::VectorXd>& predicted) {
  constexpr double arc_second = 4.848;      // urad
  constexpr double right = 1.25, as = 1.1;  // either way
  constexpr double same = 0.95;             // correlation
  const Sums translations = sums_of(campaign, predicted, false);
  const Sums rotations = sums_of(campaign, predicted, true);
  if (translations.count < fewest || rotations.count < fewest ||
      !(translations.correlation() > same && rotations.correlation() > same))
    return {};
  const double slope = translations.mp / translations.pp;
  const double factor = rotations.mp / rotations.pp / slope;
  if (slope > right || slope < 1 / right) return {};
  for (const bool larger : {false, true})
    if (std::abs(std::log(factor / (larger ? arc_second : 1 / arc_second))) < std::log(as))
      return fmt::format(
          "The measured rotations are {:.3g} times the predicted ones, in the same pattern "
          "(correlation {:.2f}), as of {}, while the translations are as predicted. Check the unit "
          "of the rotations.",
          factor * slope, rotations.correlation(),
          larger ? "urad taken for arcsec" : "arcsec taken for urad");
  return {};
}

std::string unit_error(const Campaign& campaign, const Predictor& nominal,
                       common::Progress& progress) {
  const Predictions predictions = nominal.predict({}, {}, false, progress);
  return predictions.failure ? std::string() : unit_error(campaign, predictions.displacement);
}

}  // namespace kinetostat::calibration
