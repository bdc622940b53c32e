#include "kinetostat/vjm/statics/newton_method.h"

#include <cmath>

namespace kinetostat::vjm {
namespace {

class Newton {
 public:
  Newton(const EquilibriumSystem& system, const SystemState& start, const Load& load,
         const NewtonTask& task)
      : system_(system),
        task_(task),
        at_(system, start, load),
        matrix_(at_, task.platform_held),
        reach_(system.scale().length),
        enough_(task.options.tolerance * reach_),
        kinks_(task.damping == NewtonTask::Damping::none ? task.options.max_kinks : 0) {
    result_.state = start;
    result_.corrections.reserve(static_cast<std::size_t>(task.options.max_iterations));
    at_.newton_right_hand_side(task.platform_held, right_);
  }

  // At the start of every round the residuals stand at the state.
  NewtonResult run() {
    for (int i = 0; i < task_.options.max_iterations; ++i) {
      if (i > 0) matrix_.renew(at_);
      const bool balanced = matrix_.solve(right_, correction_);
      if (i == 0) {
        result_.consistent = balanced;
        forces_ = right_.norm();
      }
      size_ = correction_.norm();
      result_.corrections.push_back(size_ / reach_);
      if (!std::isfinite(size_) || size_ > 1e6 * reach_) break;
      if (goes_over_kink()) continue;
      if (!step()) break;
      if (task_.matrix == NewtonTask::Matrix::kept_when_close && factor_ == 1) go_on_with_matrix();
      if (!is_close()) continue;
      finish();
      break;
    }
    return std::move(result_);
  }

  NewtonEquations equations() && { return {std::move(at_), std::move(matrix_)}; }

 private:
  void go_to(const SystemState& state) {
    at_.move_to(state);
    at_.newton_right_hand_side(task_.platform_held, right_);
  }

  // The whole correction, untested, where it leads over a bend of some law.
  bool goes_over_kink() {
    system_.moved(result_.state, correction_, 1, next_);
    if (kinks_ >= task_.options.max_kinks || !system_.kinks(result_.state, next_)) return false;
    ++kinks_;
    go_to(next_);
    result_.state = next_;
    return true;
  }

  // As much of the correction as makes the next one smaller; false when hardly any does.
  bool step() {
    factor_ = 1;
    while (true) {
      go_to(next_);
      consistent_ = matrix_.solve(right_, again_);
      simplified_ = again_.norm();
      // Once corrections are down at rounding they cannot be asked to fall further.
      if (simplified_ <= (1 - factor_ / 4) * size_ || size_ <= enough_ ||
          task_.damping == NewtonTask::Damping::none)
        break;
      factor_ /= 2;
      if (factor_ < 1.0 / 1024) return false;
      system_.moved(result_.state, correction_, factor_, next_);
    }
    result_.state = next_;
    return true;
  }

  void go_on_with_matrix() {
    constexpr double close = 1e-2;  // what a correction leaves of the one before
    while (simplified_ > enough_ && simplified_ <= close * size_) {
      system_.moved(result_.state, again_, 1, next_);
      go_to(next_);
      result_.state = next_;
      consistent_ = matrix_.solve(right_, again_);
      size_ = simplified_;
      simplified_ = again_.norm();
    }
  }

  bool is_close() const {
    const bool at_rounding = size_ <= 1e-7 * reach_ && simplified_ <= 1e-2 * size_;
    return factor_ == 1 &&
           (simplified_ <= enough_ || (at_rounding && simplified_ <= 1e3 * enough_));
  }

  // The correction seen from the last state is known and costs nothing more: with it the state is
  // exact to rounding, not to a tolerance that a small reading of a large robot would feel.
  void finish() {
    // What a free motion may leave: a share of the forces, or the rounding of the stiffest spring.
    constexpr double unbalanced = 1e-8, rounding = 1e-12;
    system_.moved(result_.state, again_, 1, next_);
    result_.state = next_;
    const double left = right_.norm();
    result_.converged = consistent_ ||
                        left <= unbalanced * std::max(forces_, system_.wrench_norm(next_)) ||
                        (result_.consistent && left <= rounding * reach_);
  }

  const EquilibriumSystem& system_;
  const NewtonTask& task_;
  EquilibriumResiduals at_;
  NewtonMatrix matrix_;
  double reach_, enough_;
  int kinks_;
  NewtonResult result_;
  SystemVector right_, correction_, again_;  // again: the correction seen from the end of a step
  SystemState next_;
  double forces_ = 0, size_ = 0, simplified_ = 0, factor_ = 1;
  bool consistent_ = true;  // of the last solution
};

}  // namespace

NewtonResult newton(const EquilibriumSystem& system, const SystemState& start, const Load& load,
                    const NewtonTask& task, NewtonEquations* left) {
  Newton method(system, start, load, task);
  NewtonResult result = method.run();
  if (left != nullptr) *left = std::move(method).equations();
  return result;
}

}  // namespace kinetostat::vjm
