// kinetostat mesh check: can this surface bound a solid, and if not, where not?
#include <fmt/format.h>

#include "kinetostat/apps/command.h"
#include "kinetostat/apps/commands.h"
#include "kinetostat/fea/surface_check.h"
#include "kinetostat/spatial/units.h"

namespace kinetostat::apps {
namespace {

struct Options {
  std::string mesh, unit, vtu, density;
};

using Lines = std::vector<std::string>;

files::Json defects_json(const fea::SurfaceReport& report) {
  files::Json list = files::Json::array();
  for (const fea::Defect& defect : report.defects) {
    files::Json facets = files::Json::array();
    for (const int f : defect.facets) facets.push_back(f + 1);
    list.push_back({{"defect", fea::name(defect.kind)},
                    {"count", defect.count},
                    {"facets", facets},
                    {"cure", fea::cure(defect.kind)}});
  }
  return list;
}

files::Json report_json(const fea::ImportedSurface& surface, const fea::SurfaceReport& report,
                        double density) {
  files::Json json{{"sound", report.sound()},
                   {"facets", report.facets},
                   {"points", report.points},
                   {"bodies", report.bodies()},
                   {"cavities", report.cavities()}};
  json["box"] = {{"min", files::to_json(spatial::Vector3(report.box.min()))},
                 {"max", files::to_json(spatial::Vector3(report.box.max()))}};
  json["area"] = report.area;
  json["volume"] = report.sound() ? files::Json(report.volume) : files::Json();
  json["mass"] =
      report.sound() && density > 0 ? files::Json(report.volume * density) : files::Json();
  json["units"] = {{"length", "m"}, {"mass", "kg"}};
  json["weld"] = {{"tolerance", surface.weld.tolerance},
                  {"points_before", surface.weld.points_before},
                  {"points_after", surface.weld.points_after},
                  {"collapsed_facets", surface.weld.collapsed.size()}};
  json["defects"] = defects_json(report);
  json["inputs"] = {{"mesh_sha256", surface.sha256}};
  return json;
}

double read_density(const std::string& text) {
  if (text.empty()) return 0;
  const char cure[] = "Steel has '7850 kg/m^3'";
  double density = 0;
  try {
    density = spatial::parse_quantity(text, spatial::dimension::density);
  } catch (const std::invalid_argument& error) {
    throw UsageError("--density", error.what(), cure);
  }
  if (!(density > 0))
    throw UsageError("--density", fmt::format("'{}' is not above zero", text), cure);
  return density;
}

// A missing unit is left to read_surface(), which shows the sizes to choose by.
void check_unit(const std::string& text) {
  if (text.empty()) return;
  try {
    spatial::parse_quantity("1 " + text, spatial::dimension::length);
  } catch (const std::invalid_argument& error) {
    throw UsageError("--unit", error.what(), "Use mm, m or inch");
  }
}

files::Json check(Run& run, const Options& options) {
  const double density = read_density(options.density);
  check_unit(options.unit);
  run.progress().report("reading", 0);
  const fea::ImportedSurface surface = fea::read_surface(options.mesh, options.unit);
  run.progress().report("checking", 0);
  const fea::SurfaceReport report = fea::check_surface(surface.mesh, surface.weld.tolerance);
  for (const std::string& line : fea::describe(report, options.unit, density))
    run.print(line + "\n");
  run.print(fmt::format("welded {} points into {} with tolerance {:.3g} m\n",
                        surface.weld.points_before, surface.weld.points_after,
                        surface.weld.tolerance));
  if (!options.vtu.empty()) {
    files::write_vtu(options.vtu, fea::offending_facets(surface.mesh, report));
    run.print(fmt::format("offending facets written to {}\n", options.vtu));
  }
  if (!report.sound())
    run.refuse({options.mesh, "the surface does not bound a solid, see above",
                "Mend it in the program it came from, then check again"});
  return report_json(surface, report, density);
}

}  // namespace

void add_mesh_check(Program& program) {
  auto options = std::make_shared<Options>();
  CLI::App& app =
      program.add({.name = "mesh check",
                   .summary = "Check that a surface mesh bounds a solid, and say where it does not",
                   .example = "kinetostat mesh check meshes/foot.stl --unit mm"},
                  [options](Run& run) { return check(run, *options); });
  app.add_option("mesh", options->mesh, "STL, OBJ or PLY file")->required()->type_name("FILE");
  app.add_option("--unit", options->unit, "Unit of length of the file: mm, m, inch")
      ->type_name("UNIT");
  app.add_option("--density", options->density, "Adds the mass: '2700 kg/m^3'")
      ->type_name("DENSITY");
  app.add_option("--vtu", options->vtu, "Write the offending facets for ParaView")
      ->type_name("FILE");
}

}  // namespace kinetostat::apps
