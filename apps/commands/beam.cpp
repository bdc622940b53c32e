// kinetostat beam: is a beam enough for this link, or does it need finite elements?
#include <cmath>

#include <fmt/format.h>

#include "kinetostat/apps/cli/command.h"
#include "kinetostat/apps/commands/commands.h"
#include "kinetostat/fea/link/identify.h"
#include "kinetostat/fea/section/beam_study.h"
#include "kinetostat/report/text/text.h"
#include "kinetostat/spatial/units.h"

namespace kinetostat::apps {
namespace {

struct Options {
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

Reference identified(Run& run, const fea::LinkSpec& spec, std::size_t loaded,
                     const io::Cache& cache) {
  fea::IdentifyOptions settings;
  settings.meshing.cache = &cache;
  settings.solver.threads = run.threads();
  fea::LinkResult result = fea::identify(spec, settings, run.progress());
  const auto first = 6 * static_cast<Eigen::Index>(loaded - 1);
  const spatial::Matrix6 block = result.response.flexibility.block<6, 6>(first, first);
  return {.mesh = std::move(result.mesh),
          .interfaces = result.interfaces,
          .compliance = spatial::Compliance6(0.5 * (block + block.transpose()),
                                             {.point = result.interfaces[loaded].point}),
          .source = "finite elements, computed now",
          .warnings = result.warnings};
}

Reference from_file(Run& run, const fea::LinkSpec& spec, const fea::LinkGeometry& geometry,
                    const std::string& file, std::size_t loaded, const io::Cache& cache) {
  if (loaded != 1)
    throw UsageError("--fea",
                     "the compliance in a link result is that of the first loaded "
                     "interface",
                     "Leave --interface or --fea out");
  const spatial::Compliance6 compliance = io::read_compliance(file);
  fea::LinkSpec coarse = spec;
  coarse.order = 1;
  fea::TetrahedralizeOptions meshing;
  meshing.edge_length = fea::default_size(geometry.report);
  meshing.cache = &cache;
  fea::SolidMesher mesher(geometry.imported.mesh, geometry.tags);
  Reference reference{.mesh = fea::fill(coarse, geometry, mesher, meshing, run.progress()),
                      .interfaces = {},
                      .compliance = compliance,
                      .source = file,
                      .warnings = {}};
  reference.interfaces = fea::interfaces_on(spec, reference.mesh);
  const io::Json json = io::read_json(file);
  const auto inputs = json.find("inputs");
  if (inputs != json.end() && inputs->value("mesh_sha256", "") != geometry.imported.sha256)
    reference.warnings.push_back(
        fmt::format("{} was identified from another mesh than {}", file, spec.mesh_name));
  return reference;
}

std::string section_table(const fea::BeamStudy& study, const std::string& unit) {
  const double mm = spatial::parse_quantity("1 " + unit, spatial::dimension::length);
  report::Table table({"along [" + unit + "]", "area [" + unit + "^2]", "I1 [" + unit + "^4]",
                       "I2 [" + unit + "^4]", "J [" + unit + "^4]", "kappa1", "kappa2", "pieces",
                       "holes"});
  for (const fea::BeamStation& station : study.stations) {
    const fea::SectionProperties& s = station.properties;
    const auto principal = s.principal();
    const double mm4 = std::pow(mm, 4);
    table.add_row({report::number(station.arc / mm), report::number(s.area / (mm * mm)),
                   report::number(principal.moments[0] / mm4),
                   report::number(principal.moments[1] / mm4),
                   report::number(s.torsion_constant / mm4),
                   report::number(principal.shear_coefficients[0], 3),
                   report::number(principal.shear_coefficients[1], 3), std::to_string(s.pieces),
                   std::to_string(s.holes)});
  }
  return table.text();
}

// One row for every significant entry of the upper triangle, in SI units.
std::string entry_table(const spatial::Compliance6& fea,
                        const std::vector<fea::BeamComparison>& comparisons) {
  static constexpr const char* rows[] = {"x", "y", "z", "rx", "ry", "rz"};
  static constexpr const char* columns[] = {"Fx", "Fy", "Fz", "Mx", "My", "Mz"};
  std::vector<std::string> header{"entry", "FEA"};
  for (const fea::BeamComparison& c : comparisons) header.push_back(c.name);
  report::Table table(header);
  for (int i = 0; i < 6; ++i)
    for (int j = i; j < 6; ++j) {
      if (!comparisons.front().significant(i, j)) continue;
      std::vector<std::string> row{fmt::format("{} / {}", rows[i], columns[j]),
                                   fmt::format("{:.4e}", fea.matrix()(i, j))};
      for (const fea::BeamComparison& c : comparisons)
        row.push_back(fmt::format("{:+.1f} %", 100 * c.errors(i, j)));
      table.add_row(row);
    }
  return table.text();
}

void print(Run& run, const fea::LinkSpec& spec, const Reference& reference,
           const fea::BeamStudy& study, const std::vector<fea::BeamComparison>& comparisons,
           const std::string& verdict) {
  const double length = spatial::parse_quantity("1 " + spec.unit, spatial::dimension::length);
  run.print(fmt::format("link {}: axis {} {} long, {} sections\n\n", spec.name,
                        report::number(study.axis.length() / length), spec.unit,
                        study.stations.size()));
  run.print(section_table(study, spec.unit));
  run.print(
      fmt::format("\nsignificant entries of the compliance [m, rad per N, N m] at the loaded "
                  "point, and what the beams differ by\nfrom FEA ({}):\n\n",
                  reference.source));
  run.print(entry_table(reference.compliance, comparisons));
  run.print("\n");
  for (const fea::BeamComparison& c : comparisons)
    run.print(fmt::format("{}: {:.3g} to {:.3g} times the compliance of FEA, in any direction\n",
                          c.name, c.least_ratio, c.largest_ratio));
  for (const auto* list : {&reference.warnings, &study.warnings})
    for (const std::string& warning : *list) run.print(fmt::format("warning: {}\n", warning));
  run.print("\n" + verdict + "\n");
}

io::Json json_of(const fea::LinkSpec& spec, const Reference& reference, const fea::BeamStudy& study,
                 const std::vector<fea::BeamComparison>& comparisons, const std::string& verdict) {
  io::Json json{{"link", spec.name}};
  json.update(fea::to_json(study));
  json["fea"] = io::to_json(reference.compliance);
  json["comparison"] = io::Json::array();
  for (const fea::BeamComparison& c : comparisons) json["comparison"].push_back(fea::to_json(c));
  json["verdict"] = verdict;
  return json;
}

io::Json compare_beams(Run& run, const Options& options) {
  const fea::LinkSpec spec = fea::read_link(options.link);
  const std::size_t loaded = loaded_number(spec, options.interface);
  const io::Cache cache = options.no_cache ? io::Cache() : io::Cache::of_user();
  const fea::LinkGeometry geometry = fea::read_geometry(spec, run.progress());
  const Reference reference = options.fea.empty()
                                  ? identified(run, spec, loaded, cache)
                                  : from_file(run, spec, geometry, options.fea, loaded, cache);
  const fea::LinkBody body{.surface = geometry.imported.mesh,
                           .mesh = reference.mesh,
                           .fixed = reference.interfaces.front().geometry,
                           .loaded = reference.interfaces[loaded].geometry};
  try {
    const fea::BeamStudy study = fea::study_beams(
        body, spec.material, reference.compliance.frame().point, options.model, run.progress());
    std::vector<fea::BeamComparison> comparisons;
    for (const fea::BeamModel& model : study.models)
      comparisons.push_back(fea::compare(model, reference.compliance));
    const std::string verdict = fea::verdict(comparisons, options.tolerance / 100);
    print(run, spec, reference, study, comparisons, verdict);
    return json_of(spec, reference, study, comparisons, verdict);
  } catch (const fea::SectionError& error) {
    throw common::InputError(options.link, error.what(), "Take the compliance of 'identify'");
  }
}

}  // namespace

void add_beam(Program& program) {
  auto options = std::make_shared<Options>();
  OptionList app = program.add(
      {.name = "beam",
       .summary = "A link as one beam and as a chain of beams, compared with finite elements",
       .example = "kinetostat beam meshes/foot.yaml --fea data/links/foot.link.json"},
      [options](Run& run) { return compare_beams(run, *options); });
  app.add_option("link", options->link, "Link file").required().type_name("FILE");
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
