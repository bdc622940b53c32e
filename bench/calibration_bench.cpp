// Comparison of a 3-PUU with many readings, and reading them; diagnosis of a six-axis arm.
#include <array>
#include <chrono>
#include <filesystem>

#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include "kinetostat/calibration/campaign/campaign_check.h"
#include "kinetostat/calibration/campaign/campaign_file.h"
#include "kinetostat/calibration/campaign/noise_estimate.h"
#include "kinetostat/calibration/comparison/compare.h"
#include "kinetostat/calibration/diagnosis/diagnosis.h"
#include "kinetostat/calibration/regression/simulate.h"
#include "kinetostat/io/text_file.h"
#include "kinetostat/spatial/products.h"

namespace kinetostat::calibration {
namespace {

const vjm::Robot& orthoglide() {
  static const vjm::Robot robot =
      vjm::read_robot(std::string(KINETOSTAT_SOURCE_DIR) + "/data/robots/orthoglide.yaml");
  return robot;
}

// A cube of postures, each under 80 different forces.
std::string plan(int readings) {
  std::string csv = "x,y,z,fx,fy,fz\n";
  for (int i = 0; i < readings; ++i) {
    const int posture = i / 80, load = i % 80;
    csv +=
        fmt::format("{},{},{},{},{},{}\n", -50 + 20 * (posture % 5), -50 + 20 * (posture / 5 % 5),
                    -50 + 20 * (posture / 25 % 5), 10 * load - 400, 7 * load, 300 - 5 * load);
  }
  return csv;
}

std::filesystem::path campaign(int readings, const std::array<bool, 6>& components = {
                                                 true, true, true, true, true, true}) {
  const auto folder = std::filesystem::temp_directory_path() /
                      fmt::format("kinetostat_calibration_bench_{}", readings);
  common::Progress silent;
  io::write_atomically(folder / "plan.csv", plan(readings));
  const SimulatedCampaign made = simulate(
      orthoglide(), orthoglide().file.string(), folder / "plan.csv",
      {.translation_noise = 5e-6, .rotation_noise = 2e-5, .components = components}, silent);
  io::write_atomically(folder / "readings.csv", made.readings);
  io::write_atomically(folder / "campaign.yaml", made.yaml);
  return folder / "campaign.yaml";
}

void compare_readings(benchmark::State& state) {
  const auto file = campaign(static_cast<int>(state.range(0)));
  const Campaign read = read_campaign(file, orthoglide().manipulator);
  common::Progress silent;
  for (auto _ : state) benchmark::DoNotOptimize(compare(orthoglide(), read, 1, silent));
  state.SetItemsProcessed(state.iterations() * state.range(0));
}
BENCHMARK(compare_readings)
    ->Name("3-PUU compared with readings, one thread")
    ->Arg(10000)
    ->Unit(benchmark::kSecond);

// Actuators, feet and legs of every chain, nine stiffnesses that are 20 % off, and the zero offsets
// of three axes: twelve unknowns.
vjm::Robot uncertain_orthoglide() {
  vjm::Robot robot = orthoglide();
  for (std::size_t c = 0; c < 3; ++c)
    for (const char* spring : {"rho", "foot", "leg"}) {
      const vjm::UncertainStiffness stiffness{
          .name = robot.manipulator.chains()[c].name() + "." + spring, .springs = {{c, spring}}};
      robot.manipulator = vjm::with_scaled(robot.manipulator, stiffness, c == 1 ? 0.8 : 1.25);
      robot.uncertain.push_back(stiffness);
    }
  return robot;
}

void fit_readings(benchmark::State& state) {
  const auto file = campaign(static_cast<int>(state.range(0)), {true, true, true});
  io::write_atomically(file, io::read_text(file) + "zero: estimate\n");
  const vjm::Robot robot = uncertain_orthoglide();
  const Campaign read = read_campaign(file, robot.manipulator);
  const Noise noise = noise_of(read, {});
  common::Progress silent;
  int evaluations = 0;
  for (auto _ : state) {
    const Predictor predictor(robot.manipulator, read, 1, silent);
    const BaseFit fit = fit_base(predictor, read, noise, uncertain_parameters(robot), silent);
    evaluations = fit.iterations;
  }
  state.counters["evaluations"] = evaluations;
}
BENCHMARK(fit_readings)
    ->Name("base fit of 12 unknowns, 3-PUU, one thread")
    ->Arg(1000)
    ->Unit(benchmark::kSecond);

template <class Work>
double seconds(const Work& work) {
  const auto begin = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

// The whole catalogue against a shipped campaign of a six-axis arm, 144 readings. `worth`: the time
// over that of one prediction of all readings by the nominal model.
void diagnose_arm(benchmark::State& state) {
  const std::string folder =
      std::string(KINETOSTAT_SOURCE_DIR) + "/data/measurements/six_axis_balancer";
  const vjm::Robot robot = vjm::read_robot(folder + "/robot.yaml");
  const Campaign read = read_campaign(folder + "/campaign.yaml", robot.without_effects());
  common::Progress silent;
  double all = 0;
  for (auto _ : state)
    all += seconds([&] { benchmark::DoNotOptimize(diagnose(robot, read, {}, 1, silent)); });
  const Predictor predictor(robot.without_effects(), read, 1, silent);
  constexpr int times = 20;
  const double one = seconds([&] {
    for (int i = 0; i < times; ++i)
      benchmark::DoNotOptimize(predictor.predict({}, {}, false, silent));
  });
  state.counters["worth"] = all / static_cast<double>(state.iterations()) / (one / times);
}
BENCHMARK(diagnose_arm)->Name("diagnosis, six-axis arm, one thread")->Unit(benchmark::kSecond);

// What a fit leaves of the draws of a test against noise, 300 readings. `eigen`: the time that
// Eigen takes for the same, over ours.
void project_noise(benchmark::State& state) {
  const Eigen::MatrixXd basis = Eigen::MatrixXd::Random(900, 40),
                        noise = Eigen::MatrixXd::Random(900, 64);
  double ours = 0, eigen = 0;
  for (auto _ : state) {
    ours += seconds([&] {
      Eigen::MatrixXd along = Eigen::MatrixXd::Zero(900, 64);
      spatial::add_product(basis, spatial::transposed_product(basis, noise), along);
      benchmark::DoNotOptimize(along);
    });
    eigen += seconds(
        [&] { benchmark::DoNotOptimize((basis * (basis.transpose() * noise).eval()).eval()); });
  }
  state.counters["eigen"] = eigen / ours;
}
BENCHMARK(project_noise)->Name("projection of 64 draws")->Unit(benchmark::kMillisecond);

// As `measure check` does.
void read_rows(benchmark::State& state) {
  const auto file = campaign(static_cast<int>(state.range(0)));
  for (auto _ : state)
    benchmark::DoNotOptimize(
        check_campaign(read_campaign(file, orthoglide().manipulator), orthoglide()));
}
BENCHMARK(read_rows)->Name("rows read and checked")->Arg(100000)->Unit(benchmark::kSecond);

}  // namespace
}  // namespace kinetostat::calibration

BENCHMARK_MAIN();
