// Comparison of a 3-PUU with many readings, and reading them.
#include <filesystem>

#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include "kinetostat/calibration/compare.h"
#include "kinetostat/calibration/simulate.h"
#include "kinetostat/files/text_file.h"

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

std::filesystem::path campaign(int readings) {
  const auto folder = std::filesystem::temp_directory_path() /
                      fmt::format("kinetostat_calibration_bench_{}", readings);
  files::Progress silent;
  files::write_atomically(folder / "plan.csv", plan(readings));
  const SimulatedCampaign made =
      simulate(orthoglide(), orthoglide().file.string(), folder / "plan.csv",
               {.translation_noise = 5e-6, .rotation_noise = 2e-5}, silent);
  files::write_atomically(folder / "readings.csv", made.readings);
  files::write_atomically(folder / "campaign.yaml", made.yaml);
  return folder / "campaign.yaml";
}

void compare_readings(benchmark::State& state) {
  const auto file = campaign(static_cast<int>(state.range(0)));
  const Campaign read = read_campaign(file, orthoglide().manipulator);
  files::Progress silent;
  for (auto _ : state) benchmark::DoNotOptimize(compare(orthoglide(), read, 1, silent));
  state.SetItemsProcessed(state.iterations() * state.range(0));
}
BENCHMARK(compare_readings)
    ->Name("3-PUU compared with readings, one thread")
    ->Arg(10000)
    ->Unit(benchmark::kSecond);

}  // namespace
}  // namespace kinetostat::calibration

BENCHMARK_MAIN();
