#include "kinetostat/calibration/comparison/column_error.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <numbers>
#include <optional>
#include <set>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "kinetostat/calibration/comparison/unit_error.h"
#include "kinetostat/calibration/regression/predict.h"
#include "kinetostat/calibration/regression/session_frame.h"
#include "kinetostat/common/error.h"
#include "kinetostat/spatial/rotation.h"

namespace kinetostat::calibration {
namespace {

using Eigen::Index;
using spatial::Matrix3;
using spatial::Vector3;

constexpr double most_left = 0.2;           // of the variation, by a slip that is believed
constexpr double better = 1. / 3;           // so much is left at most of what was left without it
constexpr double least_of_a_column = 0.03;  // of the variation, to be believed
constexpr std::size_t fewest_readings = 6;
constexpr std::array axis_names = {'x', 'y', 'z'};

// What is read and predicted of the platform's position, by session, about the means.
struct Translations {
  std::vector<Vector3> measured, predicted;
  std::vector<std::size_t> sessions;
  std::array<bool, 3> is_read{};

  Translations(const Campaign& campaign, const std::vector<Eigen::VectorXd>& all) {
    for (const Reading& reading : campaign.readings)
      for (Index k = 0; k < 3; ++k) is_read[static_cast<std::size_t>(k)] |= reading.uses(k);
    for (std::size_t i = 0; i < campaign.readings.size(); ++i) {
      const Reading& reading = campaign.readings[i];
      Vector3 m = Vector3::Zero(), p = Vector3::Zero();
      bool whole = true;
      for (Index k = 0; k < 3; ++k) {
        if (!is_read[static_cast<std::size_t>(k)]) continue;
        whole = whole && reading.uses(k);
        m[k] = reading.displacement[k];
        p[k] = all[i][k];
      }
      if (!whole) continue;
      measured.push_back(m);
      predicted.push_back(p);
      sessions.push_back(reading.session);
    }
    center(measured);
    center(predicted);
  }

  std::size_t axes() const {
    return static_cast<std::size_t>(std::count(is_read.begin(), is_read.end(), true));
  }

 private:
  void center(std::vector<Vector3>& values) const {
    const std::size_t count =
        sessions.empty() ? 0 : *std::max_element(sessions.begin(), sessions.end()) + 1;
    std::vector<std::pair<Vector3, double>> sums(count, {Vector3::Zero(), 0});
    for (std::size_t i = 0; i < values.size(); ++i) {
      sums[sessions[i]].first += values[i];
      ++sums[sessions[i]].second;
    }
    for (std::size_t i = 0; i < values.size(); ++i)
      values[i] -= sums[sessions[i]].first / sums[sessions[i]].second;
  }
};

// Sum of m p' over the readings.
Matrix3 moments(const std::vector<Vector3>& m, const std::vector<Vector3>& p) {
  Matrix3 sum = Matrix3::Zero();
  for (std::size_t i = 0; i < m.size(); ++i) sum += m[i] * p[i].transpose();
  return sum;
}

// Share of the variation that the predictions leave beside a common factor.
double left(double product, double measured, double predicted) {
  if (!(product > 0)) return 1;
  return 1 - product * product / (measured * predicted);
}

// Of one session: the squared error beside the frame that fits best, and of what is read.
std::pair<double, double> squares_beside_frame(const Translations& t, std::size_t session) {
  std::vector<Vector3> predicted, measured;
  for (std::size_t i = 0; i < t.sessions.size(); ++i) {
    if (t.sessions[i] != session) continue;
    predicted.push_back(t.predicted[i]);
    measured.push_back(t.measured[i]);
  }
  const spatial::Vector6 frame = frame_between(predicted, measured);
  const Matrix3 turn = spatial::exp_rotation(frame.tail<3>());
  double rest = 0, all = 0;
  for (std::size_t i = 0; i < predicted.size(); ++i) {
    rest += (measured[i] - frame.head<3>() - turn * predicted[i]).squaredNorm();
    all += measured[i].squaredNorm();
  }
  return {rest, all};
}

// The same where each session has a frame of its own.
double left_beside_frames(const Translations& t) {
  double rest = 0, all = 0;
  for (const std::size_t session : std::set(t.sessions.begin(), t.sessions.end())) {
    const auto [of_rest, of_all] = squares_beside_frame(t, session);
    rest += of_rest;
    all += of_all;
  }
  return all > 0 ? rest / all : 1;
}

double left(const Campaign& campaign, const Translations& t) {
  if (campaign.session_frame == SessionFrame::estimated) return left_beside_frames(t);
  return left(moments(t.measured, t.predicted).trace(), moments(t.measured, t.measured).trace(),
              moments(t.predicted, t.predicted).trace());
}

// To two digits.
std::string percent(double share) {
  constexpr double two_digits = 0.0995;
  return share < two_digits ? fmt::format("{:.2g} %", 100 * share)
                            : fmt::format("{:.0f} %", 100 * share);
}

struct Slip {
  std::string phrase;
  double left = std::numeric_limits<double>::infinity();
};

void take_better(Slip slip, Slip& best) {
  if (slip.left < best.left) best = std::move(slip);
}

// "'dx' is '-dy'" for an axis j of readings that is axis `of` of the predictions.
struct SignedAxes {
  std::array<Index, 3> of = {0, 1, 2};
  std::array<double, 3> sign = {1, 1, 1};

  bool moves(Index j) const {
    return of[static_cast<std::size_t>(j)] != j || sign[static_cast<std::size_t>(j)] < 0;
  }
  int moved() const { return int{moves(0)} + int{moves(1)} + int{moves(2)}; }
  std::string phrase(const char* prefix) const {
    std::vector<std::string> parts;
    for (Index j = 0; j < 3; ++j) {
      if (!moves(j)) continue;
      const auto k = static_cast<std::size_t>(j);
      parts.push_back(fmt::format("'{0}{1}' is {2}{0}{3}", prefix, axis_names[k],
                                  sign[k] < 0 ? "-" : "",
                                  axis_names[static_cast<std::size_t>(of[k])]));
    }
    return fmt::format("{}", fmt::join(parts, " and "));
  }
};

// All orders and signs of the axes that are read, those that move the fewest first; but for all as
// they are, and all reversed, which unit_error() is about.
std::vector<SignedAxes> signed_axes(const std::array<bool, 3>& is_read) {
  std::vector<SignedAxes> all;
  SignedAxes one;
  do {
    for (int signs = 0; signs < 8; ++signs) {
      bool possible = true;
      for (std::size_t j = 0; j < 3; ++j) {
        one.sign[j] = (signs >> j & 1) != 0 ? -1 : 1;
        possible = possible && (is_read[j] || !one.moves(static_cast<Index>(j)));
      }
      const bool reversed = one.of == SignedAxes().of &&
                            std::equal(one.sign.begin(), one.sign.end(), is_read.begin(),
                                       [](double sign, bool read) { return (sign < 0) == read; });
      if (possible && !reversed && one.moved() > 0) all.push_back(one);
    }
  } while (std::next_permutation(one.of.begin(), one.of.end()));
  std::stable_sort(all.begin(), all.end(),
                   [](const SignedAxes& a, const SignedAxes& b) { return a.moved() < b.moved(); });
  return all;
}

// How the axes that are read go with those that are predicted.
struct AxisMoments {
  Matrix3 mp, mm, pp;  // measured, predicted

  explicit AxisMoments(const Translations& t)
      : mp(moments(t.measured, t.predicted)),
        mm(moments(t.measured, t.measured)),
        pp(moments(t.predicted, t.predicted)) {}

  static bool follows(double product, double a, double b) {
    constexpr double same = 0.9;
    return a > 0 && b > 0 && product > same * std::sqrt(a * b);
  }
  // An axis is believed to be another one where it makes up some of what is read and predicted,
  // follows that pattern, and no other axis has that pattern.
  bool believes(const SignedAxes& axes, Index j) const {
    const auto n = static_cast<std::size_t>(j);
    const Index k = axes.of[n];
    if (mm(j, j) < least_of_a_column * mm.trace() || pp(k, k) < least_of_a_column * pp.trace())
      return false;
    for (Index other = 0; other < 3; ++other)
      if (other != k && follows(std::abs(pp(k, other)), pp(k, k), pp(other, other))) return false;
    return follows(axes.sign[n] * mp(j, k), mm(j, j), pp(k, k));
  }
};

// Columns of the displacement.
void try_readings(const Translations& t, Slip& best) {
  const AxisMoments of(t);
  for (const SignedAxes& axes : signed_axes(t.is_read)) {
    double product = 0;
    bool believed = true;
    for (Index j = 0; j < 3; ++j) {
      const auto n = static_cast<std::size_t>(j);
      product += axes.sign[n] * of.mp(j, axes.of[n]);
      believed = believed && (!axes.moves(j) || of.believes(axes, j));
    }
    if (believed)
      take_better({axes.phrase("d"), left(product, of.mm.trace(), of.pp.trace())}, best);
  }
}

// One column of the displacement in another unit than the others.
void try_units_of_readings(const Translations& t, Slip& best) {
  constexpr double alike = 1.25;   // its slope and that of the others, either way
  constexpr double follows = 0.7;  // correlation: noise counts for more of what is read too small
  const AxisMoments of(t);
  for (Index j = 0; j < 3; ++j) {
    const double product = of.mp.trace() - of.mp(j, j), predicted = of.pp.trace() - of.pp(j, j);
    const bool is_seen = of.pp(j, j) > least_of_a_column * of.pp.trace() ||
                         of.mm(j, j) > least_of_a_column * of.mm.trace();
    if (!is_seen || !(product > 0) ||
        !(of.mp(j, j) > follows * std::sqrt(of.mm(j, j) * of.pp(j, j))))
      continue;
    for (const double factor : {1000., 100., 25.4, 10., 1 / 10., 1 / 25.4, 1 / 100., 1 / 1000.}) {
      const double slope = factor * of.mp(j, j) / of.pp(j, j) / (product / predicted);
      if (slope > alike || slope < 1 / alike) continue;
      const double measured = of.mm.trace() + (factor * factor - 1) * of.mm(j, j);
      take_better({fmt::format("'d{}' is in a unit {} times as {} as it says",
                               axis_names[static_cast<std::size_t>(j)],
                               std::max(factor, 1 / factor), factor > 1 ? "large" : "small"),
                   left(product + factor * of.mp(j, j), measured, of.pp.trace())},
                  best);
    }
  }
}

// Left-handed axes, which no frame makes up for.
void try_mirrored(const Translations& t, Slip& best) {
  if (t.axes() < 3) return;
  Translations mirrored = t;
  for (Vector3& m : mirrored.measured) m.z() = -m.z();
  take_better({"the axes of the instrument are left-handed: one of 'dx', 'dy' and 'dz' has the "
               "wrong sign, or two are exchanged",
               left_beside_frames(mirrored)},
              best);
}

// Some of its readings, and the postures that these need: as evenly as multiples of the golden
// ratio are, so that no step of a cycle is left out.
Campaign thinned(const Campaign& campaign, std::size_t enough) {
  const std::size_t all = campaign.readings.size();
  std::set<std::size_t> kept;
  for (std::size_t i = 0; i < enough && i < all; ++i) {
    const double part = std::fmod(static_cast<double>(i) * std::numbers::phi, 1.0);
    kept.insert(all <= enough ? i : static_cast<std::size_t>(part * static_cast<double>(all)));
  }
  Campaign thin = campaign;
  thin.readings.clear();
  thin.configurations.clear();
  std::map<std::size_t, std::size_t> numbers;  // of configurations, by those that they had
  for (const std::size_t i : kept) {
    Reading& reading = thin.readings.emplace_back(campaign.readings[i]);
    const auto [at, is_new] = numbers.emplace(reading.configuration, thin.configurations.size());
    if (is_new) thin.configurations.push_back(campaign.configurations[reading.configuration]);
    reading.configuration = at->second;
  }
  return thin;
}

// Some readings of a campaign that are changed, and what is left of them beside predictions of
// their own: over what the same predictions leave of them as they are, in which a target or a zero
// was not fitted either.
class SomeReadings {
 public:
  // Of the campaign, and the postures of the readings as they are.
  using Change = std::function<void(Campaign&, const Predictor&)>;

  SomeReadings(const vjm::Robot& robot, Campaign readings, double before, int threads,
               common::Progress& progress)
      : robot_(robot),
        campaign_(std::move(readings)),
        threads_(threads),
        progress_(progress),
        as_it_is_(predictor_of(campaign_)) {
    const std::optional<double> as_it_is = left_of(as_it_is_, campaign_);
    scale_ =
        as_it_is && *as_it_is > 0 ? before / *as_it_is : std::numeric_limits<double>::infinity();
  }

  SomeReadings(const SomeReadings&) = delete;
  SomeReadings& operator=(const SomeReadings&) = delete;

  // None where the model fails, or a posture cannot be reached: it is not that.
  std::optional<double> left_after(const Change& change) const {
    Campaign changed = campaign_;
    change(changed, as_it_is_);
    try {
      const std::optional<double> rest = left_of(predictor_of(changed), changed);
      return rest ? std::optional(scale_ * *rest) : std::nullopt;
    } catch (const common::InputError&) {
      return std::nullopt;
    }
  }

 private:
  Predictor predictor_of(const Campaign& campaign) const {
    return {robot_.without_effects(), robot_.effects, campaign, threads_, progress_};
  }
  // None where the model fails.
  std::optional<double> left_of(const Predictor& predictor, const Campaign& campaign) const {
    const Predictions predictions = predictor.predict({}, {}, false, progress_);
    if (predictions.failure) return std::nullopt;
    return left(campaign, {campaign, predictions.displacement});
  }

  const vjm::Robot& robot_;
  Campaign campaign_;
  int threads_;
  common::Progress& progress_;
  Predictor as_it_is_;
  double scale_ = 1;
};

// Changes that are tried on a few readings, and on many where these give hope.
class Trial {
 public:
  Trial(const vjm::Robot& robot, const Campaign& campaign, double before, int threads,
        common::Progress& progress)
      : before_(before),
        few_(robot, thinned(campaign, 40), before, threads, progress),
        many_(robot, thinned(campaign, 400), before, threads, progress) {}

  void run(std::string phrase, const SomeReadings::Change& change, Slip& best) const {
    constexpr double slack = 3;  // of what few readings say
    const std::optional<double> roughly = few_.left_after(change);
    if (!roughly || *roughly > slack * std::min(most_left, better * before_)) return;
    if (const std::optional<double> rest = many_.left_after(change))
      take_better({std::move(phrase), *rest}, best);
  }

 private:
  double before_;
  SomeReadings few_, many_;
};

// By weights, which hang down whatever the columns say.
bool has_known_loads(const Campaign& campaign) {
  return std::any_of(campaign.readings.begin(), campaign.readings.end(),
                     [](const Reading& reading) { return reading.known_load; });
}

bool has_axes_of_the_cell(const Campaign& campaign) {
  return std::any_of(campaign.readings.begin(), campaign.readings.end(),
                     [](const Reading& reading) { return !reading.load.cell.isIdentity(0); });
}

// The force as the load cell reads it, in its own axes.
Vector3 force_read(const vjm::Load& load) { return load.cell.transpose() * load.force; }

// The same numbers of a load cell with these axes.
void read_in(const Matrix3& axes, vjm::Load& load) {
  load.force = (axes * load.cell.transpose() * load.force).eval();
  load.moment = (axes * load.cell.transpose() * load.moment).eval();
  load.cell = axes;
}

// Wrenches and displacements that are in the axes of the platform, or wrenches in base axes, and
// not those stated.
void try_platform_axes(const Trial& trial, const Campaign& campaign, Slip& best) {
  const auto with = [&](const char* phrase, const auto& turn) {
    trial.run(
        phrase,
        [&](Campaign& changed, const Predictor& as_it_is) {
          for (std::size_t i = 0; i < changed.readings.size(); ++i)
            turn(as_it_is.posture_of(i).platform.rotation(), changed.readings[i]);
        },
        best);
  };
  if (!has_known_loads(campaign)) {
    with("the wrenches are in axes of the platform ('wrench_frame: platform')",
         [](const Matrix3& turn, Reading& reading) { read_in(turn, reading.load); });
    if (has_axes_of_the_cell(campaign))
      with("the wrenches are in base axes ('wrench_frame: base')",
           [](const Matrix3&, Reading& reading) { read_in(Matrix3::Identity(), reading.load); });
  }
  if (campaign.observation.platform_axes) return;
  const Matrix3 to_frame = campaign.observation.frame.rotation().transpose();
  with("the displacements are in axes of the platform ('displacement_frame: platform')",
       [&](const Matrix3& turn, Reading& reading) {
         reading.displacement.head<3>() = (to_frame * turn * reading.displacement.head<3>()).eval();
       });
}

void try_forces(const Trial& trial, const Campaign& campaign, Slip& best) {
  if (has_known_loads(campaign)) return;
  std::array<bool, 3> acts{};
  constexpr double rounding = 1e-9;
  for (const Reading& reading : campaign.readings) {
    const Vector3 read = force_read(reading.load);
    for (std::size_t k = 0; k < 3; ++k)
      acts[k] = acts[k] || std::abs(read[static_cast<Index>(k)]) > rounding * read.norm();
  }
  if (std::count(acts.begin(), acts.end(), true) < 2) return;
  for (const SignedAxes& axes : signed_axes(acts)) {
    if (axes.moved() > 2) continue;
    trial.run(
        axes.phrase("f"),
        [&axes](Campaign& changed, const Predictor&) {
          for (Reading& reading : changed.readings) {
            const Vector3 read = force_read(reading.load);
            Vector3 meant;
            for (std::size_t j = 0; j < 3; ++j)
              meant[axes.of[j]] = axes.sign[j] * read[static_cast<Index>(j)];
            reading.load.force = reading.load.cell * meant;
          }
        },
        best);
  }
}

void change_joint(Campaign& campaign, const std::string& joint,
                  const std::function<double(double)>& change) {
  for (Configuration& configuration : campaign.configurations)
    if (const auto found = configuration.joints.find(joint); found != configuration.joints.end())
      found->second = change(found->second);
}

void exchange_joints(Campaign& campaign, const std::string& a, const std::string& b) {
  for (Configuration& configuration : campaign.configurations)
    if (configuration.joints.contains(a) && configuration.joints.contains(b))
      std::swap(configuration.joints.at(a), configuration.joints.at(b));
}

// Angles in the other unit.
constexpr std::pair<double, const char*> other_units[] = {{180 / M_PI, "rad"}, {M_PI / 180, "deg"}};

// Counts the other way, from elsewhere, or in another unit.
void try_joint(const Trial& trial, const std::string& joint, const JointInTable& in_table,
               Slip& best) {
  const auto with = [&](const std::string& phrase, const std::function<double(double)>& change) {
    trial.run(
        phrase, [&](Campaign& changed, const Predictor&) { change_joint(changed, joint, change); },
        best);
  };
  with(fmt::format("'{}' counts the other way", in_table.column), [](double q) { return -q; });
  for (const int zero : {90, -90, 180})
    if (in_table.turns)
      with(fmt::format("'{}' has its zero {} deg elsewhere", in_table.column, std::abs(zero)),
           [zero](double q) { return q + zero * M_PI / 180; });
  for (const auto& [factor, unit] : other_units)
    if (in_table.turns)
      with(fmt::format("'{}' is in {}", in_table.column, unit),
           [factor = factor](double q) { return factor * q; });
}

void try_exchanged_joints(const Trial& trial, const Campaign& campaign,
                          const std::vector<std::string>& turning, Slip& best) {
  const auto column = [&](std::size_t j) { return campaign.joint_columns.at(turning[j]).column; };
  for (std::size_t a = 0; a < turning.size(); ++a)
    for (std::size_t b = 0; b < a; ++b)
      trial.run(
          fmt::format("'{}' and '{}' are exchanged", column(b), column(a)),
          [&](Campaign& changed, const Predictor&) {
            exchange_joints(changed, turning[a], turning[b]);
          },
          best);
}

void try_units_of_joints(const Trial& trial, const std::vector<std::string>& turning, Slip& best) {
  if (turning.empty()) return;
  for (const auto& [factor, unit] : other_units)
    trial.run(
        fmt::format("the joints are in {}", unit),
        [&turning, factor = factor](Campaign& changed, const Predictor&) {
          for (const std::string& joint : turning)
            change_joint(changed, joint, [factor](double q) { return factor * q; });
        },
        best);
}

// In a few postures another one may do as well by chance.
void try_joints(const Trial& trial, const Campaign& campaign, Slip& best) {
  constexpr std::size_t fewest_postures = 5;
  if (campaign.configurations.size() < fewest_postures) return;
  std::vector<std::string> turning;
  for (const auto& [joint, in_table] : campaign.joint_columns) {
    try_joint(trial, joint, in_table, best);
    if (in_table.turns) turning.push_back(joint);
  }
  try_exchanged_joints(trial, campaign, turning, best);
  try_units_of_joints(trial, turning, best);
}

}  // namespace

std::string column_error(const vjm::Robot& robot, const Campaign& campaign,
                         const std::vector<Eigen::VectorXd>& predicted, int threads,
                         common::Progress& progress) {
  if (!campaign.reads_platform() || campaign.control) return {};
  if (std::string rotations = rotation_unit_error(campaign, predicted); !rotations.empty())
    return rotations;
  const Translations as_given(campaign, predicted);
  if (as_given.measured.size() < fewest_readings) return {};
  const double before = left(campaign, as_given);
  // A posture that is another one shows even where little is left of long ways.
  constexpr double nothing_to_explain = 1e-4;
  if (before < nothing_to_explain) return {};
  Slip best;
  if (campaign.session_frame == SessionFrame::estimated) {
    try_mirrored(as_given, best);
  } else {
    try_readings(as_given, best);
    try_units_of_readings(as_given, best);
  }
  const bool is_absolute = campaign.displacement == DisplacementKind::absolute;
  constexpr double worth_a_trial = 0.02;
  if (is_absolute || before > worth_a_trial) {
    const Trial trial(robot, campaign, before, threads, progress);
    if (!is_absolute) {
      try_forces(trial, campaign, best);
      try_platform_axes(trial, campaign, best);
    }
    try_joints(trial, campaign, best);
  }
  if (best.left > most_left || best.left > better * before) return {};
  return fmt::format(
      "The readings lie as predicted if {}: that leaves {} of what they vary by, the files as they "
      "are {}. Check the order, signs and units of the columns, and the axes of the "
      "robot and of 'frames'.",
      best.phrase, percent(best.left), percent(before));
}

}  // namespace kinetostat::calibration
