#include "kinetostat/calibration/comparison/load_loops.h"

#include <algorithm>
#include <cmath>

#include "kinetostat/calibration/campaign/load_history.h"
#include "kinetostat/calibration/statistics/goodness_of_fit.h"

namespace kinetostat::calibration {
namespace {

using Eigen::Index;
using spatial::Vector6;

class LoopFinder {
 public:
  LoopFinder(const Campaign& campaign, const std::vector<Eigen::VectorXd>& residual,
             const std::vector<Vector6>& work, const Noise& noise)
      : campaign_(campaign),
        changing_(changing_loads(campaign)),
        residual_(residual),
        work_(work),
        noise_(noise) {}

  LoadLoops find() {
    LoadLoops result;
    for (const Cycle& cycle : load_cycles(campaign_)) {
      if (!is_closed(cycle)) continue;
      Loop loop{.session = campaign_.sessions[reading(cycle[0]).session],
                .cycle = reading(cycle[0]).cycle};
      add_area(cycle, loop);
      add_return(cycle, loop);
      result.each.push_back(std::move(loop));
    }
    result.area = test_of(area_);
    result.return_to_zero = test_of(return_);
    return result;
  }

 private:
  // A sum of squares in units of the noise.
  struct Squares {
    double sum = 0;
    Index count = 0;
  };

  const Reading& reading(std::size_t i) const { return campaign_.readings[i]; }

  bool is_closed(const Cycle& cycle) const {
    if (cycle.size() < 3) return false;
    double size = 0;
    for (const std::size_t i : cycle) {
      if (reading(i).configuration != reading(cycle[0]).configuration) return false;
      size = std::max(size, level_of(changing_[i]));
    }
    // Predictions follow the same loads, so that a gap between both ends hardly matters.
    const vjm::Load &first = reading(cycle.front()).load, &last = reading(cycle.back()).load;
    const vjm::Load gap{.force = first.force - last.force, .moment = first.moment - last.moment};
    return size > 0 && level_of(gap) <= same_load * size;
  }

  // Trapezoidal rule of the integral of the load over the displacement, in measured components.
  // It is linear in the readings, so their noise carries over with the coefficients.
  void add_area(const Cycle& cycle, Loop& loop) {
    double variance = 0;
    for (Index k = 0; k < campaign_.size(); ++k) {
      // The load does work on what is read of the platform alone.
      if (!campaign_.is_of_platform(k)) continue;
      const Index axis = campaign_.component(k).axis;
      if (!std::all_of(cycle.begin(), cycle.end(),
                       [&](std::size_t i) { return reading(i).uses(k); }))
        continue;
      const auto load = [&](std::size_t n) { return work_[cycle[n]][axis]; };
      for (std::size_t n = 0; n < cycle.size(); ++n) {
        const std::size_t i = cycle[n];
        const double before = n > 0 ? load(n - 1) + load(n) : 0;
        const double after = n + 1 < cycle.size() ? load(n) + load(n + 1) : 0;
        const double coefficient = (before - after) / 2;
        loop.measured += coefficient * reading(i).displacement[k];
        loop.predicted += coefficient * (reading(i).displacement[k] - residual_[i][k]);
        variance += std::pow(coefficient * noise_.sigma[i][k], 2);
      }
    }
    if (noise_.source == NoiseSource::unknown) return;
    loop.noise = std::sqrt(variance);
    if (variance > 0) {
      area_.sum += std::pow(loop.measured - loop.predicted, 2) / variance;
      ++area_.count;
    }
  }

  void add_return(const Cycle& cycle, Loop& loop) {
    std::optional<std::size_t> first, last;
    double size = 0;
    for (const std::size_t i : cycle) size = std::max(size, level_of(changing_[i]));
    for (const std::size_t i : cycle)
      if (level_of(changing_[i]) <= same_load * size) (first ? last : first) = i;
    if (!last) return;
    loop.return_to_zero = residual_[*last] - residual_[*first];
    if (noise_.source == NoiseSource::unknown) return;
    for (Index k = 0; k < campaign_.size(); ++k) {
      if (!reading(*first).uses(k) || !reading(*last).uses(k)) continue;
      return_.sum += std::pow((*loop.return_to_zero)[k], 2) /
                     (std::pow(noise_.sigma[*first][k], 2) + std::pow(noise_.sigma[*last][k], 2));
      ++return_.count;
    }
  }

  std::optional<LoopTest> test_of(const Squares& squares) const {
    if (squares.count == 0) return std::nullopt;
    LoopTest test{.statistic = squares.sum,
                  .degrees_of_freedom = squares.count,
                  .degrees_of_freedom_noise = noise_.degrees_of_freedom};
    const auto n = static_cast<double>(squares.count);
    test.p_value =
        noise_.degrees_of_freedom > 0
            ? chance_of_larger_f(squares.sum / n, n, static_cast<double>(noise_.degrees_of_freedom))
            : chance_of_larger_chi_square(squares.sum, n);
    return test;
  }

  const Campaign& campaign_;
  std::vector<vjm::Load> changing_;
  const std::vector<Eigen::VectorXd>& residual_;
  const std::vector<Vector6>& work_;
  const Noise& noise_;
  Squares area_, return_;
};

}  // namespace

LoadLoops find_loops(const Campaign& campaign, const std::vector<Eigen::VectorXd>& residual,
                     const std::vector<Vector6>& work, const Noise& noise) {
  return LoopFinder(campaign, residual, work, noise).find();
}

}  // namespace kinetostat::calibration
