// Poses per second of the 3-PUU: unloaded stiffness, loaded equilibrium with stiffness and
// stability, postures. Laws in one joint of a six-axis arm, by condensation.
#include <chrono>

#include <benchmark/benchmark.h>

#include "kinetostat/vjm/batches/batches.h"
#include "kinetostat/vjm/effects/effect_model.h"
#include "kinetostat/vjm/io/robot_file.h"
#include "kinetostat/vjm/manipulator/posture.h"
#include "kinetostat/vjm/statics/equilibrium.h"
#include "kinetostat/vjm/statics/stiffness.h"
#include "kinetostat/vjm/workspace/workspace_map.h"

namespace kinetostat::vjm {
namespace {

const Robot& orthoglide() {
  static const Robot robot =
      read_robot(std::string(KINETOSTAT_SOURCE_DIR) + "/data/robots/orthoglide.yaml");
  return robot;
}

// A cube of postures inside the workspace.
const std::vector<Posture>& postures() {
  static const std::vector<Posture> all = [] {
    std::vector<Posture> result;
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j < 4; ++j)
        for (int k = 0; k < 4; ++k)
          result.push_back(posture_at(orthoglide().manipulator,
                                      spatial::Pose::translation(
                                          {-0.06 + 0.05 * i, -0.06 + 0.05 * j, -0.06 + 0.05 * k}))
                               .posture);
    return result;
  }();
  return all;
}

void unloaded(benchmark::State& state) {
  for (auto _ : state)
    for (const Posture& posture : postures())
      benchmark::DoNotOptimize(unloaded_stiffness_matrix(orthoglide().manipulator, posture));
  state.SetItemsProcessed(state.iterations() * static_cast<int64_t>(postures().size()));
}
BENCHMARK(unloaded)->Name("3-PUU unloaded 6x6, posture known");

void unloaded_of_many(benchmark::State& state) {
  for (auto _ : state)
    benchmark::DoNotOptimize(unloaded_stiffness_matrices(orthoglide().manipulator, postures()));
  state.SetItemsProcessed(state.iterations() * static_cast<int64_t>(postures().size()));
}
BENCHMARK(unloaded_of_many)->Name("3-PUU unloaded 6x6, postures known, 64 together");

void unloaded_report(benchmark::State& state) {
  for (auto _ : state)
    for (const Posture& posture : postures())
      benchmark::DoNotOptimize(unloaded_stiffness(orthoglide().manipulator, posture));
  state.SetItemsProcessed(state.iterations() * static_cast<int64_t>(postures().size()));
}
BENCHMARK(unloaded_report)->Name("3-PUU unloaded, with rank and free motions in words");

void loaded(benchmark::State& state) {
  const spatial::Vector6 shift{5e-4, 5e-4, 5e-4, 0, 0, 0};
  for (auto _ : state)
    for (const Posture& posture : postures())
      benchmark::DoNotOptimize(equilibrium_at_pose(orthoglide().manipulator, posture,
                                                   spatial::displaced(posture.platform, shift)));
  state.SetItemsProcessed(state.iterations() * static_cast<int64_t>(postures().size()));
}
BENCHMARK(loaded)->Name("3-PUU held 0.5 mm away: equilibrium, stiffness, stability");

void under_load(benchmark::State& state) {
  for (auto _ : state)
    for (const Posture& posture : postures())
      benchmark::DoNotOptimize(
          equilibrium_under_load(orthoglide().manipulator, posture, {{100, -50, 80}}));
  state.SetItemsProcessed(state.iterations() * static_cast<int64_t>(postures().size()));
}
BENCHMARK(under_load)->Name("3-PUU under a wrench: equilibrium, stiffness, stability");

void under_load_of_many(benchmark::State& state) {
  const std::vector<Load> loads(postures().size(), {{100, -50, 80}});
  for (auto _ : state)
    benchmark::DoNotOptimize(stable_equilibria(orthoglide().manipulator, postures(), loads));
  state.SetItemsProcessed(state.iterations() * static_cast<int64_t>(postures().size()));
}
BENCHMARK(under_load_of_many)->Name("3-PUU under a wrench, 64 together");

void inverse_kinematics(benchmark::State& state) {
  for (auto _ : state)
    for (const Posture& posture : postures())
      benchmark::DoNotOptimize(posture_at(orthoglide().manipulator, posture.platform));
  state.SetItemsProcessed(state.iterations() * static_cast<int64_t>(postures().size()));
}
BENCHMARK(inverse_kinematics)->Name("3-PUU posture from a pose");

void inverse_kinematics_of_many(benchmark::State& state) {
  std::vector<spatial::Pose> poses;
  for (const Posture& posture : postures()) poses.push_back(posture.platform);
  for (auto _ : state) benchmark::DoNotOptimize(postures_at(orthoglide().manipulator, poses));
  state.SetItemsProcessed(state.iterations() * static_cast<int64_t>(poses.size()));
}
BENCHMARK(inverse_kinematics_of_many)->Name("3-PUU postures from poses, 64 together");

// 100,000 poses of a cube, posture included; the argument is the number of threads.
void map(benchmark::State& state) {
  std::vector<TargetPose> targets;
  for (int i = 0; i < 50; ++i)
    for (int j = 0; j < 50; ++j)
      for (int k = 0; k < 40; ++k)
        targets.push_back({spatial::Pose::translation(
            {-0.06 + 0.003 * i, -0.06 + 0.003 * j, -0.06 + 0.0037 * k})});
  common::Progress progress;
  for (auto _ : state)
    benchmark::DoNotOptimize(workspace_map(orthoglide().manipulator, targets,
                                           {{.kind = MapIndex::Kind::weakest_translation}},
                                           static_cast<int>(state.range(0)), progress));
  state.SetItemsProcessed(state.iterations() * static_cast<int64_t>(targets.size()));
}
BENCHMARK(map)
    ->Name("3-PUU map of 100,000 poses, threads")
    ->Arg(1)
    ->Arg(2)
    ->UseRealTime()
    ->MeasureProcessCPUTime()
    ->Unit(benchmark::kSecond);

template <class Work>
double seconds(const Work& work) {
  const auto begin = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

// A clearance in joint q3 of the arm of a shipped campaign, with the derivative by its gap.
// `in_full`: what all equations take from the state without it, `condensing` what the three
// equilibria take that every law in this joint shares; both over the time of one that is condensed.
void law_of_joint(benchmark::State& state) {
  const Robot arm = read_robot(std::string(KINETOSTAT_SOURCE_DIR) +
                               "/data/measurements/six_axis_balancer/robot.yaml");
  const Manipulator& m = arm.without_effects();
  Effect gap{.kind = effect_kind("clearance"), .at = "arm.q3", .sites = {}, .values = {}};
  gap.sites = effect_sites(*gap.kind, m, gap.at);
  gap.values = Eigen::VectorXd::Constant(1, 1e-4);
  const Posture posture = posture_from_joints(m, {}).posture;
  const Load load{.force = {500, -300, -800}};
  const EffectModel without(m, {}), with(m, {gap});
  const std::vector<ModelParameter> parameters = {{{}, 0, 0}};
  const Response rest = with.at_rest(1);
  const SystemState near = without.respond(posture, load, {}, without.at_rest(0), {}, false).state;
  const std::vector<JointPlace> joints = {{0, m.chains()[0].index_of("q3")}};
  const auto condensed = without.condensed(posture, load, {}, joints, &near);
  constexpr int times = 2000;
  const double full = seconds([&] {
    for (int i = 0; i < times; ++i)
      benchmark::DoNotOptimize(with.respond(posture, load, {}, rest, parameters, true, &near));
  });
  const double shared = seconds([&] {
    for (int i = 0; i < times; ++i)
      benchmark::DoNotOptimize(without.condensed(posture, load, {}, joints, &near));
  });
  Response response;
  double all = 0;
  for (auto _ : state)
    all += seconds([&] {
      benchmark::DoNotOptimize(with.respond(*condensed, load, {}, rest, parameters, response));
    });
  const double one = all / static_cast<double>(state.iterations());
  state.counters["in_full"] = full / times / one;
  state.counters["condensing"] = shared / times / one;
}
BENCHMARK(law_of_joint)->Name("arm with a law in one joint, condensed");

}  // namespace
}  // namespace kinetostat::vjm

BENCHMARK_MAIN();
