// kinetostat identify: from a link's mesh to its 6x6 compliance.
#include "kinetostat/fea/link/identify.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <malloc.h>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "kinetostat/apps/cli/command.h"
#include "kinetostat/apps/cli/result_cache.h"
#include "kinetostat/apps/commands/accuracy_text.h"
#include "kinetostat/apps/commands/commands.h"
#include "kinetostat/apps/commands/link_exports.h"
#include "kinetostat/common/error.h"
#include "kinetostat/fea/link/link_picture.h"
#include "kinetostat/report/text/text.h"

namespace kinetostat::apps {
namespace {

struct Options {
  std::string link, vtu, bracket = "when_cheap";
  LinkExports exports;
  bool no_cache = false;
  double time_limit = fea::TetrahedralizeOptions{}.time_limit;
  fea::RefinementOptions refinement;
  std::string solver = name(fea::SolverMethod::automatic);
  std::uint64_t memory = 0;  // [bytes]; 0: a share of what is free
  int processes = fea::SolverOptions{}.processes;
  std::string launcher = fea::SolverOptions{}.launcher;
};

// Components that are rounding beside the largest, or below a nanometre, are shown as 0.
std::string text(const spatial::Vector3& v, double unit) {
  const double noise = std::max(1e-9 * v.cwiseAbs().maxCoeff(), 1e-12);
  const auto shown = [&](double x) { return report::number(std::abs(x) < noise ? 0 : x / unit); };
  return fmt::format("[{}, {}, {}]", shown(v.x()), shown(v.y()), shown(v.z()));
}

std::string interface_line(const fea::CoupledInterface& coupled, double length,
                           const std::string& unit) {
  const fea::Interface& interface = coupled.geometry;
  return fmt::format(
      "  {:<7} {}, area {} {}^2, centroid {} {}, {} nodes, radii of gyration {} {}\n", coupled.name,
      name(coupled.coupling), report::number(interface.area / (length * length)), unit,
      text(interface.centroid, length), unit, interface.nodes.size(),
      text(interface.gyration, length), unit);
}

spatial::Compliance6 of_interface(const Eigen::MatrixXd& flexibility,
                                  const std::vector<fea::CoupledInterface>& interfaces,
                                  std::size_t i) {
  const auto first = 6 * static_cast<Eigen::Index>(i - 1);
  const spatial::Matrix6 block = flexibility.block<6, 6>(first, first);
  return spatial::Compliance6(0.5 * (block + block.transpose()), {.point = interfaces[i].point});
}

// How much softer the distributing couplings make each coordinate [%].
std::string spread(const spatial::Compliance6& rigid, const spatial::Compliance6& distributing) {
  static constexpr const char* names[] = {"tx", "ty", "tz", "rx", "ry", "rz"};
  std::string text;
  for (int j = 0; j < 6; ++j)
    text += fmt::format("{}{} {:.2g} %", j == 0 ? "" : ", ", names[j],
                        100 * (distributing.matrix()(j, j) / rigid.matrix()(j, j) - 1));
  return text;
}

void print_bracket(Run& run, const fea::LinkResult& result, const spatial::UnitSystem& units) {
  if (!result.bracket) {
    run.print("\nbracket between rigid and distributing couplings: not computed (--bracket)\n");
    return;
  }
  for (std::size_t i = 1; i < result.interfaces.size(); ++i) {
    const auto rigid = of_interface(result.bracket->rigid, result.interfaces, i);
    const auto distributing = of_interface(result.bracket->distributing, result.interfaces, i);
    run.print(fmt::format("\n{} with all interfaces rigid, the lower bound:\n{}\n",
                          result.interfaces[i].name, report::text(rigid, units)));
    run.print(fmt::format("{} with all interfaces distributing, the upper bound:\n{}",
                          result.interfaces[i].name, report::text(distributing, units)));
    run.print(fmt::format("bracket of {}: softer by {}\n", result.interfaces[i].name,
                          spread(rigid, distributing)));
  }
}

void print_compliance(Run& run, const fea::LinkResult& result, const spatial::UnitSystem& units) {
  for (std::size_t i = 1; i < result.interfaces.size(); ++i) {
    const auto compliance = of_interface(result.response.flexibility, result.interfaces, i);
    if (result.interfaces.size() > 2) run.print("\nat " + result.interfaces[i].name + ":");
    run.print("\n" + report::text(compliance, units));
    const spatial::EigenStiffness eigen = spatial::eigen_stiffness(compliance);
    run.print(fmt::format("eigen-stiffness: {} N/m, {} N m/rad\n", text(eigen.translation, 1),
                          text(eigen.rotation, 1)));
  }
  run.print(fmt::format("symmetry defect {:.1e}\n", result.symmetry_defect));
  for (std::size_t i = 0; i < result.interfaces.size(); ++i)
    if (result.interfaces[i].coupling != fea::Coupling::rigid)
      run.print(fmt::format("fit residual of {}: {:.2g}\n", result.interfaces[i].name,
                            result.response.fit_residuals[i]));
}

void print_preload(Run& run, const fea::LinkResult& result, const spatial::UnitSystem& units) {
  if (!result.geometric_stiffness) return;
  const fea::GeometricStiffness& geometric = *result.geometric_stiffness;
  const spatial::Vector6& wrench = *result.preload;
  const auto factor = [](double value) {
    return std::isfinite(value) ? report::number(value) + " times the preload" : "never";
  };
  run.print(fmt::format(
      "\nunder the preload {} N, {} N m:\n{}", text(wrench.head<3>(), 1), text(wrench.tail<3>(), 1),
      report::text(spatial::Stiffness6(geometric.stiffness, result.compliance.frame()), units)));
  run.print(fmt::format("buckles, loaded interface free: {}; held: {}\n",
                        factor(geometric.buckling_free), factor(geometric.buckling_held)));
}

void print_solver(Run& run, const fea::SolverStats& solver) {
  const auto forecast = [](fea::SolverMethod method, const fea::SolverForecast& cost) {
    return fmt::format("{} about {:.2g} GB and {:.2g} s", name(method), cost.bytes / 1e9,
                       cost.seconds);
  };
  std::string line = fmt::format("solver: {} ({}), {} unknowns, {} iterations", name(solver.method),
                                 solver.reason, fmt::join(solver.levels, " > "), solver.iterations);
  if (solver.residual > 0) line += fmt::format(", energy of the residual {:.1e}", solver.residual);
  std::vector<std::string> costs;
  if (solver.multigrid.bytes > 0)
    costs.push_back(forecast(fea::SolverMethod::multigrid, solver.multigrid));
  if (solver.petsc.bytes > 0) costs.push_back(forecast(fea::SolverMethod::petsc, solver.petsc));
  if (solver.direct.bytes > 0) costs.push_back(forecast(fea::SolverMethod::direct, solver.direct));
  run.print(fmt::format("{}; forecast: {}\n", line, fmt::join(costs, ", ")));
}

void print_inputs(Run& run, const fea::LinkSpec& spec) {
  run.print(fmt::format("link {}: {} in {}, E = {} Pa, nu = {}\n", spec.name, spec.mesh_name,
                        spec.unit, report::number(spec.material.young()),
                        report::number(spec.material.poisson())));
}

void print_result(Run& run, const fea::LinkResult& result) {
  const double length = spatial::parse_quantity("1 " + result.unit, spatial::dimension::length);
  const std::string size =
      result.element_size > 0
          ? fmt::format(" (size {} {})", report::number(result.element_size / length), result.unit)
          : "";
  run.print(fmt::format("mesh: {} tetrahedra of {} nodes{}, {} nodes, {} unknowns\n",
                        result.mesh.element_count(), result.mesh.nodes_per_element(), size,
                        result.mesh.nodes.size(), result.response.solver.unknowns));
  print_solver(run, result.response.solver);
  if (const std::string warning = result.blas.warning(); !warning.empty())
    run.print(fmt::format("warning: {} ({})\n", warning, result.blas.name));
  run.print("interfaces:\n");
  for (const fea::CoupledInterface& interface : result.interfaces)
    run.print(interface_line(interface, length, result.unit));
  if (result.mass)
    run.print(fmt::format("mass {} kg, centre of mass {} {}\n", report::number(*result.mass),
                          text(result.center_of_mass, length), result.unit));
  const spatial::UnitSystem units{.length = result.unit, .force = "N"};
  print_compliance(run, result, units);
  run.print("\n" + accuracy_text(result));
  print_bracket(run, result, units);
  print_preload(run, result, units);
  for (const std::string& warning : result.warnings)
    run.print(fmt::format("warning: {}\n", warning));
}

fea::SolverMethod method_of(const std::string& word) {
  for (const auto method :
       {fea::SolverMethod::direct, fea::SolverMethod::multigrid, fea::SolverMethod::petsc})
    if (word == name(method)) return method;
  return fea::SolverMethod::automatic;
}

// All threads share one heap, so that what one frees another uses: the forecast of memory counts on
// it. The solvers allocate little inside parallel loops.
void share_one_heap() {
#ifdef M_ARENA_MAX
  mallopt(M_ARENA_MAX, 1);
#endif
}

fea::LinkResult identified(Run& run, const Options& options, const fea::LinkSpec& spec,
                           const io::Cache& cache) {
  share_one_heap();
  fea::IdentifyOptions settings;
  settings.meshing.cache = &cache;
  settings.meshing.time_limit = options.time_limit;
  settings.solver = {.method = method_of(options.solver),
                     .threads = run.threads(),
                     .memory = static_cast<double>(options.memory),
                     .processes = options.processes,
                     .launcher = options.launcher};
  settings.refinement = options.refinement;
  if (options.bracket != "when_cheap")
    settings.bracket =
        options.bracket == "always" ? fea::BracketWanted::always : fea::BracketWanted::never;
  try {
    return fea::identify(spec, settings, run.progress());
  } catch (const fea::SurfaceError& error) {
    if (!options.vtu.empty() && !error.facets().connectivity.empty())
      io::write_vtu(options.vtu, error.facets());
    throw;
  }
}

// Computes, and writes what needs the whole model.
io::Json computed(Run& run, const Options& options, const fea::LinkSpec& spec,
                  const io::Cache& cache) {
  print_inputs(run, spec);
  const fea::LinkResult result = identified(run, options, spec, cache);
  print_result(run, result);
  if (!result.accuracy.shortfall.empty())
    run.stop_short(fmt::format("{}: {}", spec.name, result.accuracy.shortfall));
  if (!options.vtu.empty()) io::write_vtu(options.vtu, fea::displacement_fields(result));
  options.exports.write(result);
  if (run.wants_page()) run.draw({{"surface", fea::link_picture(result)}});
  return fea::to_json(result);
}

io::Json identify(Run& run, const Options& options) {
  const fea::LinkSpec spec = fea::read_link(options.link);
  const io::Cache cache = options.no_cache ? io::Cache() : io::Cache::of_user();
  const ResultCache results(cache, run, spec);
  const bool needs_model = !options.vtu.empty() || options.exports.any() || run.wants_page();
  auto entry = needs_model ? std::nullopt : results.find();
  if (entry) {
    run.print(entry->report + "from the cache: computed before from the same input\n");
  } else {
    entry = ResultCache::Entry{.report = {}, .result = computed(run, options, spec, cache)};
    entry->report = run.report();
    // A result that was stopped short depends on the time that there was.
    if (run.shortfall().empty()) results.keep(*entry);
    if (cache.hits() > 0) run.print("volume mesh from the cache\n");
  }
  if (run.out()) io::write_json(*run.out(), entry->result);
  return entry->result;
}

}  // namespace

void add_identify(Program& program) {
  auto options = std::make_shared<Options>();
  OptionList app = program.add(
      {.name = "identify",
       .summary = "6x6 compliance of a link from its CAD mesh, by finite elements",
       .example = "kinetostat identify meshes/foot.yaml -o foot.link.json --vtu foot.vtu",
       .out = "Write the link result, for the robot file, to a JSON file"},
      [options](Run& run) { return identify(run, *options); });
  app.add_option("link", options->link, "Link file").required().type_name("FILE");
  app.add_output("--vtu", options->vtu,
                 "Write the six displacement fields for ParaView; the offending facets when the "
                 "surface is refused");
  options->exports.add_options(app);
  app.add_option("--time", options->refinement.time_limit,
                 "Start no finer mesh after so many seconds; the best result so far is given")
      .type_name("S")
      .positive();
  app.add_option("--unknowns", options->refinement.most_unknowns,
                 "Plan no finer mesh with more unknowns than this")
      .type_name("N")
      .positive();
  app.add_option(
         "--bracket", options->bracket,
         "Solve with rigid and with distributing couplings too, for the bracket of every entry: "
         "when_cheap, always, never")
      .one_of({"when_cheap", "always", "never"})
      .show_default();
  app.add_flag("--no-cache", options->no_cache,
               "Compute all anew, and keep neither the volume mesh nor the result");
  app.add_option("--solver", options->solver,
                 "direct: Cholesky factors; multigrid: conjugate gradients, faster and smaller on "
                 "large models; petsc: the same without factors, on any number of processes, where "
                 "PETSc is installed; automatic: by size and memory")
      .one_of({"automatic", "direct", "multigrid", "petsc"});
  app.add_option("--processes", options->processes, "Processes of --solver petsc, under MPI")
      .type_name("N")
      .positive();
  app.add_option("--launcher", options->launcher,
                 "Command that starts them, as 'mpirun --hostfile hosts'; '-n N' follows")
      .type_name("COMMAND");
  app.add_option("--memory", options->memory,
                 "Memory that the program may have, as 8GB; nine tenths of what is free unless "
                 "given. A model that needs more is refused, never swapped")
      .type_name("SIZE")
      .size_in_bytes();
  app.add_option("--mesh-time", options->time_limit, "Seconds that all meshing may take together")
      .type_name("S")
      .positive();
}

}  // namespace kinetostat::apps
