// kinetostat beam: is a beam enough for this link, or does it need finite elements?
#include "kinetostat/report/links/beam.h"

#include <fmt/format.h>

#include "kinetostat/apps/cli/command.h"
#include "kinetostat/apps/commands/commands.h"
#include "kinetostat/fea/link/identify.h"
#include "kinetostat/io/link_result_file.h"
#include "kinetostat/report/screen/link.h"

namespace kinetostat::apps {
namespace {

struct BeamRequest {
  std::string link, fea, interface;
  fea::BeamOptions model;
  double tolerance = 10;  // [%]
  bool no_cache = false;
};

// What the beams are compared with, and a mesh to find the axis in.
struct Reference {
  fea::TetMesh mesh;
  std::vector<fea::CoupledInterface> interfaces;
  spatial::Compliance6 compliance;
  std::string source;
  std::vector<std::string> warnings;
};

// The number of the loaded interface that is asked for.
std::size_t loaded_number(const fea::LinkSpec& spec, const std::string& name) {
  if (name.empty()) return 1;
  std::string known;
  for (std::size_t i = 1; i < spec.interfaces.size(); ++i) {
    if (spec.interfaces[i].name == name) return i;
    known += (i > 1 ? ", " : "") + spec.interfaces[i].name;
  }
  throw UsageError("--interface", fmt::format("'{}' is no loaded interface of the link", name),
                   "There is " + known);
}

Reference finite_element_reference(Run& run, const fea::LinkSpec& spec,
                                   const fea::LinkGeometry& geometry, std::size_t loaded,
                                   const io::Cache& cache) {
  fea::IdentifyOptions settings;
  settings.meshing.cache = &cache;
  settings.solver.threads = run.threads();
  fea::LinkResult result = fea::identify(spec, geometry, settings, run.progress());
  return {.mesh = std::move(result.mesh),
          .interfaces = result.interfaces,
          .compliance = fea::compliance_of(result.response.flexibility, result.interfaces, loaded),
          .source = "finite elements, computed now",
          .warnings = result.warnings};
}

Reference from_file(Run& run, const fea::LinkSpec& spec, const fea::LinkGeometry& geometry,
                    std::size_t loaded, const io::Cache& cache, const std::string& file) {
  if (loaded != 1)
    throw UsageError("--fea",
                     "the compliance in a link result is that of the first loaded interface",
                     "Leave --interface or --fea out");
  const io::IdentifiedLink link = io::read_identified_link(file);
  fea::LinkSpec coarse = spec;
  coarse.order = 1;
  fea::TetrahedralizeOptions meshing;
  meshing.edge_length = fea::default_size(geometry.report);
  meshing.cache = &cache;
  fea::LinkMesher mesher(geometry);
  Reference reference{.mesh = fea::fill(coarse, geometry, mesher, meshing, run.progress()),
                      .interfaces = {},
                      .compliance = link.compliance,
                      .source = file,
                      .warnings = {}};
  reference.interfaces = fea::interfaces_on(spec, reference.mesh);
  if (!link.mesh_sha256.empty() && link.mesh_sha256 != geometry.imported.sha256)
    reference.warnings.push_back(
        fmt::format("{} was identified from another mesh than {}", file, spec.mesh_name));
  return reference;
}

fea::BeamStudy studied(Run& run, const BeamRequest& options, const fea::LinkSpec& spec,
                       const fea::LinkGeometry& geometry, const Reference& reference,
                       std::size_t loaded) {
  const fea::LinkBody body{.surface = geometry.imported.mesh,
                           .mesh = reference.mesh,
                           .fixed = reference.interfaces.front().geometry,
                           .loaded = reference.interfaces[loaded].geometry};
  try {
    return fea::study_beams(body, spec.material, reference.compliance.frame().point, options.model,
                            run.progress());
  } catch (const fea::SectionError& error) {
    throw common::InputError(options.link, error.what(), "Take the compliance of 'identify'");
  }
}

io::Json compare_beams(Run& run, const BeamRequest& options) {
  const fea::LinkSpec spec = fea::read_link(options.link);
  if (!spec.bodies.empty())
    throw common::InputError(
        options.link, "an assembly of bodies is no beam",
        "Name the link file of one body, or take the compliance of 'identify'");
  const std::size_t loaded = loaded_number(spec, options.interface);
  const io::Cache cache = options.no_cache ? io::Cache() : io::Cache::of_user();
  const fea::LinkGeometry geometry = fea::read_geometry(spec, run.progress());
  const Reference reference = options.fea.empty()
                                  ? finite_element_reference(run, spec, geometry, loaded, cache)
                                  : from_file(run, spec, geometry, loaded, cache, options.fea);
  const fea::BeamStudy study = studied(run, options, spec, geometry, reference, loaded);
  report::BeamResult result{.link = spec,
                            .compliance = reference.compliance,
                            .source = reference.source,
                            .warnings = reference.warnings,
                            .study = study,
                            .comparisons = {},
                            .verdict = {}};
  for (const fea::BeamModel& model : study.models)
    result.comparisons.push_back(fea::compare(model, reference.compliance));
  result.verdict = fea::verdict(result.comparisons, options.tolerance / 100);
  run.print(report::first_screen(result));
  run.print_more("\n" + report::text(result));
  return report::to_json(result);
}

}  // namespace

void add_beam(Program& program) {
  auto options = std::make_shared<BeamRequest>();
  OptionList app = program.add(
      {.name = "beam",
       .summary = "A link as one beam and as a chain of beams, compared with finite elements",
       .example = "kinetostat beam meshes/foot.yaml --fea data/links/foot.link.json"},
      [options](Run& run) { return compare_beams(run, *options); });
  app.add_option("link", options->link, "Link file").required().type_name("LINK");
  app.add_option("--fea", options->fea,
                 "Link result to compare with; without it the link is identified first")
      .type_name("FILE");
  app.add_option("--interface", options->interface,
                 "Loaded interface at which the beam ends; the first unless given")
      .type_name("NAME");
  app.add_option("--beams", options->model.beams, "Beams of the coarse chain")
      .type_name("N")
      .between(2, 1000);
  app.add_option("--sections", options->model.stations,
                 "Sections along the axis, and beams of the fine chain")
      .type_name("N")
      .between(4, 1000);
  app.add_flag("--no-cache", options->no_cache, "Make the volume mesh anew, and do not keep it");
  app.add_option("--tolerance", options->tolerance,
                 "Percent that a beam may differ from FEA to be called enough")
      .type_name("P")
      .positive();
}

}  // namespace kinetostat::apps
