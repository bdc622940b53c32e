#include "kinetostat/report/screen/kinematics.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "kinetostat/report/kinematics.h"
#include "kinetostat/report/screen/comparison.h"
#include "kinetostat/report/screen/wording.h"
#include "kinetostat/report/text/text.h"

namespace kinetostat::report {
namespace {

using calibration::CalibratedGeometry;
using calibration::Campaign;
using calibration::KinematicCalibration;
using calibration::KinematicStage;
using calibration::LeftOut;
using calibration::LeftOutGeometry;
using calibration::PoseError;

const PoseError& judged(const KinematicStage& stage) {
  return stage.held_out ? *stage.held_out : stage.at_fitted;
}

// An error as people take it: of positions, else of angles, else in units of the noise.
struct Shown {
  double value = 0;
  std::string unit;
};

Shown shown(const SmallUnits& units, const PoseError& e, bool largest = false) {
  if (std::isfinite(e.translation))
    return {units.length_in(largest ? e.worst_translation : e.translation), units.length};
  if (std::isfinite(e.rotation))
    return {units.angle_in(largest ? e.worst_rotation : e.rotation), units.angle};
  return {e.whitened, "times the noise"};
}

// Two digits of the smaller one: "0.45 -> 0.23 mm".
std::string fall_in_words(const SmallUnits& units, const PoseError& before,
                          const PoseError& after) {
  const Shown from = shown(units, before), to = shown(units, after);
  const double smaller = std::min(from.value, to.value);
  if (!(smaller > 1e-4) || !(smaller < 1e4))
    return fmt::format("{} -> {} {}", number(from.value, 2), number(to.value, 2), to.unit);
  const int decimals = std::max(0, 1 - static_cast<int>(std::floor(std::log10(smaller))));
  return fmt::format("{:.{}f} -> {:.{}f} {}", from.value, decimals, to.value, decimals, to.unit);
}

Eigen::Index not_determined(const KinematicCalibration& c) {
  return c.count(LeftOut::confounded) + c.count(LeftOut::unseen) + c.count(LeftOut::too_many);
}

std::string counts_in_words(const KinematicCalibration& c) {
  const Eigen::Index left = not_determined(c);
  const auto fitted = std::ssize(c.geometry);
  if (left == 0) return fmt::format("{} parameters", fitted);
  return fmt::format("{} of {} parameters; these poses do not determine the other{}", fitted,
                     fitted + left, left == 1 ? "" : fmt::format(" {}", left));
}

std::string stages_text(const Campaign& campaign, const KinematicCalibration& c) {
  const SmallUnits units(campaign.units);
  Table table({"error", "parameters", "held out", "largest", "fitted", "unit", ""});
  for (std::size_t s = 0; s < c.stages.size(); ++s) {
    const KinematicStage& stage = c.stages[s];
    const auto held_out = [&](bool largest) {
      return stage.held_out ? figure(shown(units, *stage.held_out, largest).value) : "-";
    };
    table.add_row({(s > 0 ? "+ " : "") + stage.name, std::to_string(stage.fitted), held_out(false),
                   held_out(true), figure(shown(units, stage.at_fitted).value),
                   shown(units, stage.at_fitted).unit,
                   s == c.taken && s + 1 < c.stages.size() ? "taken" : ""});
  }
  return table.text();
}

// The largest corrections over their tolerances.
std::string corrections_text(const Campaign& campaign, const KinematicCalibration& c) {
  constexpr std::size_t most = 4;
  const SmallUnits units(campaign.units);
  std::vector<CalibratedGeometry> sorted = c.geometry;
  std::stable_sort(sorted.begin(), sorted.end(), [](const auto& a, const auto& b) {
    const auto size = [](const CalibratedGeometry& g) {
      return std::abs(g.value - g.before) / g.what.tolerance * (g.is_significant() ? 1 : 1e-6);
    };
    return size(a) > size(b);
  });
  std::string text;
  for (std::size_t k = 0; k < std::min(most, sorted.size()); ++k) {
    const CalibratedGeometry& g = sorted[k];
    text += fmt::format("  {:<46} {} {}{}\n", g.what.phrase().substr(4),
                        with_error(units.in(g.what, g.value), units.in(g.what, g.deviation)),
                        units.of(g.what), g.is_significant() ? "" : "  (within its error)");
  }
  if (sorted.size() <= most) return text;
  const auto within = std::count_if(sorted.begin() + most, sorted.end(),
                                    [](const auto& g) { return !g.is_significant(); });
  return text + fmt::format("  and {} smaller ones{}: --verbose\n", sorted.size() - most,
                            within == 0 ? "" : fmt::format(", {} within their error", within));
}

std::string others_in_words(const vjm::Robot& robot, const KinematicCalibration& c) {
  if (c.others.empty()) return {};
  calibration::BaseFit fit;
  fit.parameters = c.others;
  return labelled("  beside it:", 14, fitted_in_words(robot, fit));
}

// The first of each reason, and what it is like; the rest is for --verbose.
std::string left_out_text(const KinematicCalibration& c) {
  std::vector<std::string> words;
  for (const LeftOut why :
       {LeftOut::confounded, LeftOut::unseen, LeftOut::too_many, LeftOut::unneeded}) {
    const Eigen::Index all = c.count(why);
    if (all == 0) continue;
    const auto first = std::find_if(c.left_out.begin(), c.left_out.end(),
                                    [&](const LeftOutGeometry& out) { return out.why == why; });
    words.push_back(fmt::format("{} ({}{}{})", in_words(why), first->what.phrase(),
                                first->like.empty() ? "" : ", like " + first->like.front(),
                                all == 1 ? "" : fmt::format(", and {} more", all - 1)));
  }
  if (const Eigen::Index redundant = c.count(LeftOut::redundant); redundant > 0)
    words.push_back(fmt::format("{} redundant by the kinematics", redundant));
  if (words.empty()) return {};
  std::string text;
  for (std::size_t k = 0; k < words.size(); ++k) text += (k == 0 ? "" : "; ") + words[k];
  return wrapped("Left at their values: " + text + ". --verbose has all.", 2, 4);
}

std::string confirmed_text(const Campaign& campaign, const KinematicCalibration& c) {
  if (!c.confirmed) return {};
  return wrapped(
      fmt::format("Readings kept to confirm: {} rms.",
                  fall_in_words(SmallUnits(campaign.units), *c.confirmed_before, *c.confirmed)),
      2, 4);
}

constexpr double clearly = 1.5;  // times the noise: more than that is left

bool leaves_more_than_noise(const KinematicCalibration& c) {
  return c.noise_source != calibration::NoiseSource::unknown && c.residual_ratio > clearly;
}

std::string trust_text(const KinematicCalibration& c) {
  std::string sentences = fmt::format("{} poses, {} (condition number {}).", c.poses,
                                      conditioning_in_words(c.observability.condition()),
                                      figure(c.observability.condition(), 2));
  if (leaves_more_than_noise(c))
    sentences += fmt::format(
        " What is left is {} times the noise; standard deviations count it as noise. A few bad "
        "readings would do that, too: --robust gives them little weight.",
        times(c.residual_ratio));
  std::string text = wrapped(sentences, 2, 4);
  constexpr double small = 0.8;
  if (judged(c.after()).whitened > small * judged(c.before()).whitened)
    text += wrapped(
        "The error falls little: another effect may look like geometry here; 'kinetostat diagnose' "
        "says which.",
        2, 4);
  return text;
}

}  // namespace

std::string headline(const Campaign& campaign, const KinematicCalibration& c) {
  const SmallUnits units(campaign.units);
  const std::string where = c.is_judged ? "at poses that were held out" : "at the fitted poses";
  constexpr Eigen::Index few = 20;  // as many as a geometry of six joints has parameters
  if (c.geometry.empty() && leaves_more_than_noise(c) && c.poses < few)
    return fmt::format(
        "Nothing was calibrated, though the error is {} times the noise ({} {} rms): from {} poses "
        "no error of the geometry predicts those that were held out better. Read more poses; if "
        "that does not help, it is no geometry.",
        times(c.residual_ratio), figure(shown(units, judged(c.after())).value),
        shown(units, judged(c.after())).unit, c.poses);
  if (c.geometry.empty())
    return fmt::format(
        "Nothing to calibrate: no error of the geometry predicts poses that were held out better "
        "than the robot file does ({} {} rms).",
        figure(shown(units, judged(c.after())).value), shown(units, judged(c.after())).unit);
  return fmt::format("Kinematics calibrated: {} rms {} ({}).",
                     fall_in_words(units, judged(c.before()), judged(c.after())), where,
                     counts_in_words(c));
}

std::string first_screen(const vjm::Robot& robot, const Campaign& campaign,
                         const KinematicCalibration& c, const std::string& next) {
  std::string text = wrapped(headline(campaign, c));
  text += "\n" + stages_text(campaign, c);
  if (!c.geometry.empty())
    text += "\n" + corrections_text(campaign, c) + others_in_words(robot, c) + left_out_text(c) +
            confirmed_text(campaign, c) + trust_text(c);
  return text + (next.empty() ? "" : "\n" + next);
}

}  // namespace kinetostat::report
