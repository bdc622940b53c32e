// Rates of the finite element module: elements, assembly, factorisation.
#include <benchmark/benchmark.h>

#include "kinetostat/fea/elasticity/assembly.h"
#include "kinetostat/fea/linear_algebra/factorisation.h"
#include "kinetostat/fea/mesh/tet_mesh.h"

namespace {

using namespace kinetostat;
using namespace kinetostat::fea;

const Material steel(210e9, 0.3);

// A cantilever of n x n x 4n cells of six tetrahedra, held at x = 0.
struct Cantilever {
  TetMesh mesh;
  std::vector<int> root;

  explicit Cantilever(int n) {
    TetMesh linear;
    const int nx = 4 * n;
    const auto number = [&](int i, int j, int k) { return i + (nx + 1) * (j + (n + 1) * k); };
    for (int k = 0; k <= n; ++k)
      for (int j = 0; j <= n; ++j)
        for (int i = 0; i <= nx; ++i)
          linear.nodes.emplace_back(0.1 * i / n, 0.1 * j / n, 0.1 * k / n);
    const int paths[6][3] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
    for (int k = 0; k < n; ++k)
      for (int j = 0; j < n; ++j)
        for (int i = 0; i < nx; ++i)
          for (int p = 0; p < 6; ++p) {
            std::array<int, 3> at{i, j, k};
            std::array<int, 4> tet{number(i, j, k), 0, 0, 0};
            for (std::size_t step = 0; step < 3; ++step) {
              ++at[static_cast<std::size_t>(paths[p][step])];
              tet[step + 1] = number(at[0], at[1], at[2]);
            }
            if (p == 1 || p == 2 || p == 5) std::swap(tet[2], tet[3]);  // odd permutations
            linear.connectivity.insert(linear.connectivity.end(), tet.begin(), tet.end());
          }
    mesh = with_mid_nodes(reordered(linear));
    for (std::size_t i = 0; i < mesh.nodes.size(); ++i)
      if (mesh.nodes[i].x() == 0) root.push_back(static_cast<int>(i));
  }
};

void element_stiffness(benchmark::State& state) {
  const std::array<Vector3, 4> corners{Vector3(0, 0, 0), Vector3(1, 0.1, 0), Vector3(0.2, 1, 0),
                                       Vector3(0.1, 0.3, 1)};
  for (auto _ : state) benchmark::DoNotOptimize(stiffness_tet10(corners, steel));
  state.SetItemsProcessed(state.iterations());
}
BENCHMARK(element_stiffness);

void assembly(benchmark::State& state) {
  const Cantilever beam(static_cast<int>(state.range(0)));
  const DofMap unknowns(beam.mesh, beam.root, {});
  common::Progress silent;
  common::ThreadPool pool(2);
  for (auto _ : state)
    benchmark::DoNotOptimize(assemble(beam.mesh, {steel}, unknowns, pool, silent));
  state.SetItemsProcessed(state.iterations() *
                          static_cast<std::int64_t>(beam.mesh.element_count()));
  state.counters["unknowns"] = 3.0 * unknowns.blocks();
}
BENCHMARK(assembly)->Arg(6)->Arg(11)->Unit(benchmark::kMillisecond);

void factorisation(benchmark::State& state) {
  const Cantilever beam(static_cast<int>(state.range(0)));
  const DofMap unknowns(beam.mesh, beam.root, {});
  common::Progress silent;
  common::ThreadPool pool(2);
  const BlockMatrix equations = assemble(beam.mesh, {steel}, unknowns, pool, silent);
  double operations = 0;
  for (auto _ : state) {
    const Factorisation factor(equations, 0);
    operations += factor.stats().operations;
    state.counters["ordering_s"] = factor.stats().ordering_seconds;
  }
  state.counters["unknowns"] = 3.0 * unknowns.blocks();
  state.counters["flops"] = benchmark::Counter(operations, benchmark::Counter::kIsRate);
}
BENCHMARK(factorisation)->Arg(6)->Arg(11)->Unit(benchmark::kMillisecond);

}  // namespace

BENCHMARK_MAIN();
