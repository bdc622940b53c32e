// kinetostat mesh check: can this surface bound a solid, and if not, where not and what repairs it?
#include "kinetostat/fea/mesh/mesh_check.h"

#include <sstream>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "kinetostat/apps/cli/command.h"
#include "kinetostat/apps/commands/commands.h"
#include "kinetostat/io/text_file.h"
#include "kinetostat/report/links/link_picture.h"
#include "kinetostat/report/links/mesh_check.h"
#include "kinetostat/report/links/mesh_faces.h"
#include "kinetostat/report/screen/link.h"
#include "kinetostat/report/screen/wording.h"
#include "kinetostat/spatial/units.h"

namespace kinetostat::apps {
namespace {

struct MeshOptions {
  std::string mesh, unit, vtu, density, body, repair, tolerance, limit;
  bool faces = false;
};

// What the options say, checked.
struct MeshRequest {
  report::MeshCheckUnits shown;  // the unit is that of the file, too
  fea::RepairOptions repair;
};

double read_positive(const char* option, const std::string& text,
                     const spatial::Dimension& dimension, const std::string& bare_unit,
                     const char* cure) {
  if (text.empty()) return 0;
  double value = 0;
  try {
    value = spatial::parse_quantity(text, dimension, bare_unit);
  } catch (const std::invalid_argument& error) {
    throw UsageError(option, error.what(), cure);
  }
  if (!(value > 0)) throw UsageError(option, fmt::format("'{}' is not above zero", text), cure);
  return value;
}

// A missing unit is left to read_surface(), which shows the sizes to choose by.
double read_unit(const std::string& text) {
  if (text.empty()) return 1;
  try {
    return spatial::parse_quantity("1 " + text, spatial::dimension::length);
  } catch (const std::invalid_argument& error) {
    throw UsageError("--unit", error.what(), "Use mm, m or inch");
  }
}

std::vector<fea::RepairStep> read_steps(const std::string& list) {
  std::vector<fea::RepairStep> steps;
  std::istringstream words(list);
  for (std::string word; std::getline(words, word, ',');) try {
      steps.push_back(fea::repair_step(word));
    } catch (const std::invalid_argument& error) {
      throw UsageError("--repair", error.what(),
                       fmt::format("Separate steps by commas; they are {}",
                                   fmt::join(fea::repair_steps(), ", ")));
    }
  return steps;
}

MeshRequest read_mesh_request(const MeshOptions& options) {
  MeshRequest request;
  request.shown.unit = options.unit.empty() ? fea::unit_of_format(options.mesh) : options.unit;
  request.shown.length = read_unit(request.shown.unit);
  request.shown.density = read_positive("--density", options.density, spatial::dimension::density,
                                        "", "Steel has '7850 kg/m^3'");
  request.repair.steps = read_steps(options.repair);
  request.repair.unit = request.shown.unit;
  request.repair.tolerance =
      read_positive("--tolerance", options.tolerance, spatial::dimension::length,
                    request.shown.unit, "For example '0.1 mm'");
  if (!options.limit.empty())
    request.repair.limit =
        read_positive("--limit", options.limit, spatial::dimension::none, "", "For example '1 %'");
  return request;
}

io::Json check_surface(Run& run, const MeshOptions& options, const MeshRequest& request) {
  fea::RepairOptions repair = request.repair;
  if (run.out()) repair.stored_unit = request.shown.length;
  const fea::SurfaceCheck check = fea::check_surface_file(
      options.mesh, {.unit = request.shown.unit, .body = options.body, .repair = repair},
      run.progress());
  run.print(report::wrapped(report::headline(check, request.shown)));
  run.print(report::text(check, repair, request.shown));
  const fea::SurfaceMesh& surface = check.surface.mesh;
  if (options.faces) run.print("\n" + report::faces_text(surface, request.shown));
  if (!options.vtu.empty()) {
    io::write_vtu(options.vtu, fea::offending_facets(surface, check.report));
    run.print(fmt::format("offending facets written to {}\n", options.vtu));
  }
  if (run.wants_page())
    run.draw({{"surface", report::surface_picture(surface, check.report, request.shown)}});
  if (run.out()) io::write_atomically(*run.out(), fea::stl_bytes(surface, request.shown.length));
  if (!check.report.sound())
    run.refuse({options.mesh, "the surface does not bound a solid, see above",
                repair.steps.empty() ? "Repair it in the program it came from, or with '--repair "
                                       "weld,orient,fill,unite,drop,wrap', then check again"
                                     : "Repair it in the program it came from, then check again"});
  io::Json json{{"headline", report::headline(check, request.shown)}};
  json.update(report::to_json(check, repair, request.shown.density));
  if (options.faces) json["faces"] = report::faces_json(surface, request.shown);
  return json;
}

io::Json check_volume(Run& run, const MeshOptions& options, const MeshRequest& request) {
  if (!options.body.empty() || !request.repair.steps.empty() || run.out() || options.faces)
    throw UsageError(options.body.empty() ? "--repair, --out, --faces" : "--body",
                     "these are for surfaces, the file is a volume mesh", "Leave them out");
  const fea::VolumeCheck check =
      fea::check_volume_file(options.mesh, request.shown.unit, run.progress());
  run.print(report::text(check, request.shown));
  return report::to_json(check, request.shown.density);
}

io::Json check_mesh(Run& run, const MeshOptions& options) {
  const MeshRequest request = read_mesh_request(options);
  return fea::holds_volume_mesh(options.mesh) ? check_volume(run, options, request)
                                              : check_surface(run, options, request);
}

}  // namespace

void add_mesh_check(Program& program) {
  auto options = std::make_shared<MeshOptions>();
  OptionList app = program.add(
      {.name = "mesh check",
       .summary = "Check that a mesh bounds a solid, say where it does not, and repair it",
       .example = "kinetostat mesh check meshes/foot.stl --unit mm",
       .out = "Write the surface, repaired or not, as binary STL in its unit"},
      [options](Run& run) { return check_mesh(run, *options); });
  app.add_option("mesh", options->mesh, "STL, OBJ, PLY, STEP, Gmsh .msh or Abaqus .inp file")
      .required()
      .type_name("FILE");
  app.add_option("--unit", options->unit, "Unit of length of the file: mm, m, inch")
      .type_name("UNIT");
  app.add_option("--density", options->density, "Adds mass and inertia: '2700 kg/m^3'")
      .type_name("DENSITY");
  app.add_option("--body", options->body, "Check only this one of several bodies")
      .type_name("NAME");
  app.add_option(
         "--repair", options->repair,
         "Repair it: any of weld,orient,fill,unite,drop,wrap, taken in that order where needed")
      .type_name("STEPS");
  app.add_option("--tolerance", options->tolerance,
                 "Distance within which weld joins; 1e-4 of the diagonal by default")
      .type_name("LENGTH");
  app.add_option("--limit", options->limit,
                 "Give up repairs that change the volume, or move the surface in parts of the "
                 "diagonal, by more than this; '1 %' by default")
      .type_name("FRACTION");
  app.add_flag("--faces", options->faces,
               "List the faces, each with a selector to paste into a link file");
  app.add_output("--vtu", options->vtu, "Write the offending facets for ParaView");
}

}  // namespace kinetostat::apps
