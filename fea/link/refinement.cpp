#include "kinetostat/fea/link/refinement.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <new>
#include <utility>

#include <fmt/format.h>

#include "kinetostat/common/error.h"
#include "kinetostat/common/index.h"
#include "kinetostat/common/out_of_memory.h"
#include "kinetostat/fea/elasticity/error_estimate.h"
#include "kinetostat/fea/mesh/tetrahedralize.h"

namespace kinetostat::fea {
namespace {

using common::at;

// Of the error: a step must change the result enough to be seen, and not be guided too far by the
// indicators of a coarse mesh.
constexpr double most_share = 0.5, least_share = 0.08;
constexpr double least_growth = 1.5, most_growth = 8;  // of the number of elements
constexpr double least_room = 1.25;                    // for a last mesh before the limit
constexpr double aim = 0.7;                            // at this part of what is asked for
constexpr double room_used = 0.8;  // of the unknowns allowed: meshes come out larger than planned
// Indicators of a mesh do not guide one that is much finer, so the limit is approached in steps.
constexpr double last_growth = 4;

// The bars' errors, element by element: those of all significant entries, beside the entry, and the
// more important the worse the entry is known.
std::vector<double> indicators(const ErrorEstimate& estimate, const Eigen::MatrixXd& flexibility,
                               const ErrorBars& bars) {
  Eigen::VectorXd weights(estimate.by_element.rows());
  Eigen::Index entry = 0;
  for (Eigen::Index j = 0; j < flexibility.cols(); ++j)
    for (Eigen::Index i = 0; i <= j; ++i) {
      const double size = std::abs(flexibility(i, j));
      weights[entry++] = bars.significant(i, j) ? bars.bar(i, j) / (size * size) : 0;
    }
  const Eigen::VectorXd error = estimate.by_element.cwiseAbs().transpose() * weights;
  const double sum = error.sum();
  std::vector<double> shares(at(error.size()), 0.0);
  if (sum > 0)
    for (std::size_t e = 0; e < shares.size(); ++e)
      shares[e] = error[static_cast<Eigen::Index>(e)] / sum;
  return shares;
}

Concentration concentration_of(const std::vector<double>& indicator, const TetMesh& mesh) {
  std::vector<double> sorted = indicator;
  std::sort(sorted.begin(), sorted.end(), std::greater<>());
  Concentration found;
  const std::size_t few = std::max<std::size_t>(1, sorted.size() / 100);
  for (std::size_t i = 0; i < few; ++i) found.share += sorted[i];
  const auto worst = at(std::max_element(indicator.begin(), indicator.end()) - indicator.begin());
  for (const Vector3& corner : mesh.corners(worst)) found.place += corner / 4;
  return found;
}

// Adds the outcome on this mesh and judges the sequence again.
void assess(const LinkModel& model, int threads, Accuracy& accuracy) {
  common::ThreadPool pool(threads);
  const ErrorEstimate estimate =
      estimate_error(model.mesh, model.materials, model.response.fields, pool);
  const Eigen::MatrixXd& raw = model.response.flexibility;
  accuracy.meshes.push_back({.unknowns = model.response.solver.unknowns,
                             .elements = model.mesh.element_count(),
                             .flexibility = 0.5 * (raw + raw.transpose()),
                             .recovery_error = estimate.total,
                             .geometry_error = estimate.geometry});
  accuracy.bars = error_bars(accuracy.meshes, model.mesh.order);
  accuracy.meshes.back().relative_error = accuracy.bars.relative_error;
  accuracy.indicator = indicators(estimate, accuracy.meshes.back().flexibility, accuracy.bars);
  accuracy.concentration = concentration_of(accuracy.indicator, model.mesh);
}

// How many times as many elements it takes to leave this share of the error, if it goes on falling
// as it did from the mesh before to the last one.
double growth_for(double share, const Accuracy& accuracy) {
  const std::size_t count = accuracy.meshes.size();
  if (count < 2) return least_growth;
  const MeshOutcome &before = accuracy.meshes[count - 2], &last = accuracy.meshes[count - 1];
  const double rate =
      std::log(before.relative_error / last.relative_error) /
      std::log(static_cast<double>(last.unknowns) / static_cast<double>(before.unknowns));
  if (!std::isfinite(rate)) return least_growth;
  return std::pow(share, -1 / std::clamp(rate, ErrorBars::slowest_rate, accuracy.bars.best_rate));
}

std::string percent(double fraction) { return fmt::format("{:.2g} %", 100 * fraction); }

// Why the sequence is not good enough yet; empty when it is.
std::string lacking(const Accuracy& accuracy, const RefinementOptions& options) {
  const double reached = accuracy.bars.relative_error / options.power;
  if (!(reached <= options.accuracy))
    return fmt::format("the error bars reach {} of {}, {} was asked for", percent(reached),
                       options.quantity, percent(options.accuracy));
  if (!accuracy.bars.agreement) return "there is no second mesh to confirm the error estimate";
  if (*accuracy.bars.agreement <= 0) return "the error did not fall from the mesh before";
  if (!accuracy.bars.estimates_are_comparable())
    return fmt::format(
        "the two estimates of the error differ by a factor of {:.2g}, more than {:g}",
        accuracy.bars.difference(), ErrorBars::most_difference);
  return {};
}

class Refinement {
 public:
  Refinement(const Solve& solve, const RefinementOptions& options, common::Progress& progress)
      : solve_(solve), options_(options), progress_(progress) {}

  RefinedModel run(const SizeField& sizes) {
    RefinedModel best{.model = solve_(sizes), .accuracy = {}};
    best.accuracy.asked = options_.accuracy;
    assess(best.model, options_.threads, best.accuracy);
    while (true) {
      const std::string lack = lacking(best.accuracy, options_);
      best.accuracy.converged = lack.empty();
      if (lack.empty()) return best;
      const std::string obstacle = step(best);
      if (obstacle.empty()) continue;
      best.accuracy.shortfall = fmt::format("{}; {}", lack, obstacle);
      return best;
    }
  }

 private:
  // One mesh more. Returns why there cannot be one, and then leaves `best` alone.
  std::string step(RefinedModel& best) {
    const MeshOutcome& last = best.accuracy.meshes.back();
    if (best.accuracy.meshes.size() >= options_.most_meshes)
      return fmt::format("{} meshes are the limit", options_.most_meshes);
    if (options_.time_limit > 0 && elapsed() > options_.time_limit)
      return fmt::format("the time limit of {:g} s is reached", options_.time_limit);
    const double room = room_used * static_cast<double>(options_.most_unknowns) /
                        static_cast<double>(last.unknowns);
    if (room < least_room)
      return fmt::format("{} unknowns are the limit (--unknowns)", options_.most_unknowns);
    const double share =
        std::clamp(aim * options_.power * options_.accuracy / best.accuracy.bars.relative_error,
                   least_share, most_share);
    const bool is_last = room < last_growth && growth_for(share, best.accuracy) > room;
    const double least = std::min(is_last ? room : least_growth, room);
    try {
      progress_.report("size field", 0);
      LinkModel model = solve_(size_from_error(
          best.model.mesh, best.accuracy.indicator,
          {.share = share, .least_growth = least, .most_growth = std::min(room, most_growth)}));
      Accuracy accuracy = best.accuracy;
      assess(model, options_.threads, accuracy);
      best.model = std::move(model);
      best.accuracy = std::move(accuracy);
      return {};
    } catch (const common::Cancelled&) {
      return "it was stopped before the next mesh was done";
    } catch (const common::OutOfMemory& error) {
      return fmt::format("a finer mesh failed: {}", error.reason());
    } catch (const std::bad_alloc&) {
      return "a finer mesh needs more memory than there is";
    } catch (const common::InputError& error) {
      return "a finer mesh failed: " + error.details().what;
    }
  }

  double elapsed() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  }

  const Solve& solve_;
  const RefinementOptions& options_;
  common::Progress& progress_;
  const std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

}  // namespace

Accuracy accuracy_of(const LinkModel& model, int threads) {
  Accuracy accuracy;
  assess(model, threads, accuracy);
  return accuracy;
}

RefinedModel refine(const Solve& solve, const SizeField& first, const RefinementOptions& options,
                    common::Progress& progress) {
  return Refinement(solve, options, progress).run(first);
}

}  // namespace kinetostat::fea
