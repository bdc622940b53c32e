#include "kinetostat/calibration/diagnosis/profile.h"

#include <algorithm>
#include <cmath>

#include "kinetostat/calibration/regression/evidence.h"
#include "kinetostat/common/error.h"

namespace kinetostat::calibration {
namespace {

constexpr double step = 0.5;  // standard deviations
constexpr int steps = 6;
constexpr double chi_square_95 = 3.841459;  // one degree of freedom

// Between two points the square root of the rise is taken as a straight line, which it is for a
// linear model.
double crossing(const ProfilePoint& inner, const ProfilePoint& outer) {
  const double a = std::sqrt(std::max(0.0, inner.rise)), b = std::sqrt(outer.rise);
  return inner.value + (std::sqrt(chi_square_95) - a) / (b - a) * (outer.value - inner.value);
}

class Profiler {
 public:
  Profiler(const CandidateFitter& fitter, const std::vector<Candidate>& added, const BaseFit& best,
           common::Progress& progress)
      : fitter_(fitter), added_(added), best_(best), progress_(progress) {}

  Profile of(std::size_t parameter) const {
    Profile profile;
    profile.estimate = best_.parameters[parameter];
    if (profile.estimate.hit != BoundHit::none) {
      profile.ended = "a bound holds it";
      return profile;
    }
    for (const int side : {-1, 1}) walk(parameter, side, profile);
    profile.points.push_back({profile.estimate.value, 0});
    std::sort(profile.points.begin(), profile.points.end(),
              [](const ProfilePoint& a, const ProfilePoint& b) { return a.value < b.value; });
    return profile;
  }

 private:
  // Outwards on one side, each fit from the one before.
  void walk(std::size_t parameter, int side, Profile& profile) const {
    const ParameterEstimate& e = profile.estimate;
    const double bound = side < 0 ? e.parameter.lower : e.parameter.upper;
    ProfilePoint inner{e.value, 0};
    BaseFit near = best_;
    for (int k = 1; k <= steps && inner.value != bound; ++k) {
      double value = e.value + side * k * step * e.standard_error;
      if (side * (value - bound) >= 0) {
        value = bound;
        profile.ended = "its range ends";
      }
      try {
        near = fitter_.fit_held(added_, near, parameter, value, progress_);
      } catch (const common::Cancelled&) {
        throw;
      } catch (const std::runtime_error& error) {
        profile.ended = error.what();
        return;
      }
      const ProfilePoint outer{value, penalised_error(near) - penalised_error(best_)};
      auto& end = profile.interval[side < 0 ? 0 : 1];
      if (!end && outer.rise >= chi_square_95) end = crossing(inner, outer);
      profile.points.push_back(outer);
      inner = outer;
    }
  }

  const CandidateFitter& fitter_;
  const std::vector<Candidate>& added_;
  const BaseFit& best_;
  common::Progress& progress_;
};

}  // namespace

std::vector<Profile> profiles(const CandidateFitter& fitter, const std::vector<Candidate>& added,
                              const BaseFit& best, std::size_t most, common::Progress& progress) {
  std::size_t base = best.parameters.size();
  for (const Candidate& c : added) base -= static_cast<std::size_t>(c.effect.values.size());
  std::vector<std::size_t> order;
  for (std::size_t k = base; k < best.parameters.size(); ++k) order.push_back(k);
  for (std::size_t k = 0; k < base; ++k) order.push_back(k);
  order.resize(std::min(order.size(), most));
  const Profiler profiler(fitter, added, best, progress);
  std::vector<Profile> result;
  for (const std::size_t k : order) {
    result.push_back(profiler.of(k));
    progress.report("likelihood profiles",
                    static_cast<double>(result.size()) / static_cast<double>(order.size()));
  }
  return result;
}

}  // namespace kinetostat::calibration
