// kinetostat identify: from a link's mesh to its 6x6 compliance.
#include "kinetostat/fea/link/identify.h"

#include <cstdint>

#include <fmt/format.h>

#include "kinetostat/apps/cli/command.h"
#include "kinetostat/apps/cli/result_cache.h"
#include "kinetostat/apps/commands/commands.h"
#include "kinetostat/apps/commands/links/link_exports.h"
#include "kinetostat/fea/link/displacement_fields.h"
#include "kinetostat/report/links/link_picture.h"
#include "kinetostat/report/links/link_result.h"
#include "kinetostat/report/screen/link.h"
#include "kinetostat/report/screen/wording.h"

namespace kinetostat::apps {
namespace {

struct IdentifyRequest {
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

fea::SolverMethod method_of(const std::string& word) {
  for (const auto method :
       {fea::SolverMethod::direct, fea::SolverMethod::multigrid, fea::SolverMethod::petsc})
    if (word == name(method)) return method;
  return fea::SolverMethod::automatic;
}

fea::IdentifyOptions settings_of(const IdentifyRequest& options, int threads,
                                 const io::Cache& cache) {
  fea::IdentifyOptions settings;
  settings.meshing.cache = &cache;
  settings.meshing.time_limit = options.time_limit;
  settings.solver = {.method = method_of(options.solver),
                     .threads = threads,
                     .memory = static_cast<double>(options.memory),
                     .processes = options.processes,
                     .launcher = options.launcher};
  settings.refinement = options.refinement;
  if (options.bracket != "when_cheap")
    settings.bracket =
        options.bracket == "always" ? fea::BracketWanted::always : fea::BracketWanted::never;
  return settings;
}

fea::LinkResult identified(Run& run, const IdentifyRequest& options, const fea::LinkSpec& spec,
                           const io::Cache& cache) {
  try {
    const fea::LinkGeometry geometry = fea::read_geometry(spec, run.progress());
    return fea::identify(spec, geometry, settings_of(options, run.threads(), cache),
                         run.progress());
  } catch (const fea::SurfaceError& error) {
    if (!options.vtu.empty() && !error.facets().connectivity.empty())
      io::write_vtu(options.vtu, error.facets());
    throw;
  }
}

// Computes, and writes what needs the whole model.
ResultCache::Entry computed(Run& run, const IdentifyRequest& options, const fea::LinkSpec& spec,
                            const io::Cache& cache) {
  const fea::LinkResult result = identified(run, options, spec, cache);
  if (!result.accuracy.shortfall.empty())
    run.stop_short(fmt::format("{}: {}", spec.name, result.accuracy.shortfall));
  if (!options.vtu.empty()) io::write_vtu(options.vtu, fea::displacement_fields(result));
  options.exports.write(result);
  if (run.wants_page()) run.draw({{"surface", report::link_picture(result)}});
  return {.screen = report::first_screen(result, ""),
          .report = report::text(spec) + report::text(result),
          .result = report::to_json(result)};
}

io::Json identify(Run& run, const IdentifyRequest& options) {
  const fea::LinkSpec spec = fea::read_link(options.link);
  const io::Cache cache = options.no_cache ? io::Cache() : io::Cache::of_user();
  const ResultCache results(cache, run, spec);
  const bool needs_model = !options.vtu.empty() || options.exports.any() || run.wants_page();
  auto entry = needs_model ? std::nullopt : results.find();
  const bool is_kept = entry.has_value();
  if (!entry) {
    entry = computed(run, options, spec, cache);
    // A result that was stopped short depends on the time that there was.
    if (run.shortfall().empty()) results.keep(*entry);
  }
  run.print(entry->screen);
  const std::string link = report::quoted(options.link);
  run.print("\n" + (spec.bodies.empty()
                        ? report::next_step("kinetostat beam " + link, "would a beam have done?")
                        : report::next_step("kinetostat modes " + link, "how does it vibrate?")));
  run.print_more("\n" + entry->report);
  if (is_kept) run.print("from the cache: computed before from the same input\n");
  if (!is_kept && cache.hits() > 0) run.print("volume mesh from the cache\n");
  if (run.out()) io::write_json(*run.out(), entry->result);
  return entry->result;
}

}  // namespace

void add_identify(Program& program) {
  auto options = std::make_shared<IdentifyRequest>();
  OptionList app = program.add(
      {.name = "identify",
       .summary = "6x6 compliance of a link from its CAD mesh, by finite elements",
       .example = "kinetostat identify meshes/foot.yaml -o foot.link.json --vtu foot.vtu",
       .out = "Write the link result, for the robot file, to a JSON file"},
      [options](Run& run) { return identify(run, *options); });
  app.add_option("link", options->link, "Link file").required().type_name("LINK");
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
      .type_name("WHEN")
      .one_of({"when_cheap", "always", "never"})
      .show_default();
  app.add_flag("--no-cache", options->no_cache,
               "Compute all anew, and keep neither the volume mesh nor the result");
  app.add_option("--solver", options->solver,
                 "direct: Cholesky factors; multigrid: conjugate gradients, faster and smaller on "
                 "large models; petsc: the same without factors, on any number of processes, where "
                 "PETSc is installed; automatic: by size and memory")
      .type_name("SOLVER")
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
