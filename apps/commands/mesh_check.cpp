// kinetostat mesh check: can this surface bound a solid, and if not, where not and what repairs it?
#include <algorithm>
#include <cmath>
#include <sstream>

#include <Eigen/Eigenvalues>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "kinetostat/apps/cli/command.h"
#include "kinetostat/apps/commands/commands.h"
#include "kinetostat/fea/mesh/surface_import.h"
#include "kinetostat/fea/mesh/volume_mesh.h"
#include "kinetostat/fea/surface/surface_bodies.h"
#include "kinetostat/fea/surface/surface_check.h"
#include "kinetostat/fea/surface/surface_repair.h"
#include "kinetostat/io/text_file.h"
#include "kinetostat/report/text/text.h"
#include "kinetostat/spatial/units.h"

namespace kinetostat::apps {
namespace {

struct Options {
  std::string mesh, unit, vtu, density, body, repair, tolerance, limit;
};

// What the options say, checked.
struct Request {
  std::string unit;   // of the file and of what is printed
  double length = 1;  // [m] of one unit
  double density = 0;
  fea::RepairOptions repair;
};

io::Json defects_json(const fea::SurfaceReport& report) {
  io::Json list = io::Json::array();
  for (const fea::Defect& defect : report.defects) {
    io::Json facets = io::Json::array();
    for (const int f : defect.facets) facets.push_back(f + 1);
    list.push_back({{"defect", fea::name(defect.kind)},
                    {"count", defect.count},
                    {"facets", facets},
                    {"cure", fea::cure(defect.kind)}});
  }
  return list;
}

io::Json box_json(const fea::Box& box) {
  return {{"min", io::to_json(spatial::Vector3(box.min()))},
          {"max", io::to_json(spatial::Vector3(box.max()))}};
}

io::Json bodies_json(const std::vector<fea::Body>& bodies) {
  io::Json list = io::Json::array();
  for (const fea::Body& body : bodies)
    list.push_back(
        {{"name", body.name}, {"facets", body.facets.size()}, {"box", box_json(body.box)}});
  return list;
}

io::Json mass_json(const fea::MassProperties& properties, double density) {
  io::Json json{{"volume", properties.volume},
                {"center", io::to_json(properties.centroid)},
                {"mass", io::Json()},
                {"inertia", io::Json()}};
  if (!(density > 0)) return json;
  const spatial::Matrix3 inertia = fea::inertia(properties, density);
  json["mass"] = properties.volume * density;
  json["inertia"] = io::Json::array();
  for (int i = 0; i < 3; ++i)
    json["inertia"].push_back(io::to_json(spatial::Vector3(inertia.row(i).transpose())));
  return json;
}

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

Request read_request(const Options& options) {
  Request request;
  request.unit = options.unit.empty() ? fea::unit_of_format(options.mesh) : options.unit;
  request.length = read_unit(request.unit);
  request.density = read_positive("--density", options.density, spatial::dimension::density, "",
                                  "Steel has '7850 kg/m^3'");
  request.repair.steps = read_steps(options.repair);
  request.repair.unit = request.unit;
  request.repair.tolerance =
      read_positive("--tolerance", options.tolerance, spatial::dimension::length, request.unit,
                    "For example '0.1 mm'");
  if (!options.limit.empty())
    request.repair.limit =
        read_positive("--limit", options.limit, spatial::dimension::none, "", "For example '1 %'");
  return request;
}

void print_mass(Run& run, const fea::MassProperties& properties, const Request& request) {
  const auto text = [&](const spatial::Vector3& v, double unit) {
    return fmt::format("[{:.6g}, {:.6g}, {:.6g}]", v.x() / unit, v.y() / unit, v.z() / unit);
  };
  run.print(fmt::format("centre {} {}\n", text(properties.centroid, request.length), request.unit));
  if (!(request.density > 0)) return;
  const Eigen::SelfAdjointEigenSolver<spatial::Matrix3> principal(
      fea::inertia(properties, request.density));
  run.print(fmt::format("principal moments of inertia about the centre {} kg m^2\n",
                        text(principal.eigenvalues(), 1)));
  for (int k = 0; k < 3; ++k) {
    // A direction without its arbitrary sign: the largest component is positive.
    spatial::Vector3 axis = principal.eigenvectors().col(k);
    Eigen::Index largest = 0;
    axis.cwiseAbs().maxCoeff(&largest);
    axis *= axis[largest] < 0 ? -1 : 1;
    axis = (axis.array().abs() < 5e-7).select(0, axis);
    run.print(fmt::format("  axis {} {}\n", k + 1, text(axis, 1)));
  }
}

void pick_body(Run& run, const std::string& mesh, const std::string& name, const Request& request,
               fea::SurfaceMesh& surface) {
  if (name.empty()) return;
  const auto bodies =
      fea::find_bodies(surface, fea::nested_shells(surface, fea::edge_uses(surface)));
  const auto picked = std::find_if(bodies.begin(), bodies.end(),
                                   [&](const fea::Body& body) { return body.name == name; });
  if (picked == bodies.end())
    throw common::InputError(mesh, fmt::format("there is no body '{}'", name),
                             "The bodies are " + fea::list_bodies(bodies, request.unit));
  fea::keep_body(surface, *picked);
  run.print(fmt::format("body {} of {}\n", name, bodies.size()));
}

io::Json repair_json(const fea::RepairReport& report, const fea::RepairOptions& options) {
  io::Json actions = io::Json::array();
  for (const fea::RepairAction& action : report.actions)
    actions.push_back(
        {{"step", fea::name(action.step)}, {"done", action.done}, {"words", action.words}});
  io::Json json{{"actions", actions}, {"limit", options.limit}};
  json["volume_before"] = report.volume_before ? io::Json(*report.volume_before) : io::Json();
  json["volume_after"] = report.volume_after;
  json["distance"] = report.distance;
  json["patch_area"] = report.patch_area;
  return json;
}

io::Json surface_json(const fea::WeldReport& weld, const fea::SurfaceReport& report,
                      const fea::MassProperties& mass, const std::vector<fea::Body>& bodies,
                      double density) {
  io::Json json{
      {"sound", report.sound()},   {"facets", report.facets},       {"points", report.points},
      {"bodies", report.bodies()}, {"cavities", report.cavities()}, {"box", box_json(report.box)},
      {"area", report.area}};
  if (report.sound())
    json.update(mass_json(mass, density));
  else
    json.update({{"volume", io::Json()}, {"mass", io::Json()}});
  json["units"] = {{"length", "m"}, {"mass", "kg"}};
  json["weld"] = {{"tolerance", weld.tolerance},
                  {"points_before", weld.points_before},
                  {"points_after", weld.points_after},
                  {"collapsed_facets", weld.collapsed.size()}};
  json["named_bodies"] = bodies_json(bodies);
  json["defects"] = defects_json(report);
  return json;
}

io::Json check_surface(Run& run, const Options& options, const Request& request) {
  run.progress().report("reading", 0);
  fea::ImportedSurface surface = fea::read_surface(options.mesh, request.unit);
  run.print(fmt::format("welded {} points into {} with tolerance {:.3g} m\n",
                        surface.weld.points_before, surface.weld.points_after,
                        surface.weld.tolerance));
  pick_body(run, options.mesh, options.body, request, surface.mesh);
  fea::RepairReport repair;
  if (!request.repair.steps.empty()) {
    fea::RepairOptions options_of_repair = request.repair;
    if (run.out()) options_of_repair.stored_unit = request.length;
    repair = fea::repair(surface.mesh, options_of_repair, run.progress());
    for (const std::string& line : fea::describe(repair, request.repair)) run.print(line + "\n");
  }
  run.progress().report("checking", 0);
  const fea::SurfaceReport report = fea::check_surface(surface.mesh, surface.weld.tolerance);
  for (const std::string& line : fea::describe(report, request.unit, request.density))
    run.print(line + "\n");
  const fea::MassProperties mass = fea::mass_properties(surface.mesh);
  if (report.sound()) print_mass(run, mass, request);
  const std::vector<fea::Body> bodies = fea::find_bodies(surface.mesh, report.shells);
  if (bodies.size() > 1)
    run.print(fmt::format("bodies: {}\n", fea::list_bodies(bodies, request.unit)));
  if (!options.vtu.empty()) {
    io::write_vtu(options.vtu, fea::offending_facets(surface.mesh, report));
    run.print(fmt::format("offending facets written to {}\n", options.vtu));
  }
  if (run.out()) io::write_atomically(*run.out(), fea::stl_bytes(surface.mesh, request.length));
  if (!report.sound())
    run.refuse({options.mesh, "the surface does not bound a solid, see above",
                request.repair.steps.empty()
                    ? "Repair it in the program it came from, or with '--repair "
                      "weld,orient,fill,unite,drop,wrap', then check again"
                    : "Repair it in the program it came from, then check again"});
  io::Json json = surface_json(surface.weld, report, mass, bodies, request.density);
  if (!request.repair.steps.empty()) json["repair"] = repair_json(repair, request.repair);
  json["inputs"] = {{"mesh_sha256", surface.sha256}};
  return json;
}

// Not sound would be an error already.
io::Json check_volume(Run& run, const Options& options, const Request& request) {
  if (!options.body.empty() || !request.repair.steps.empty() || run.out())
    throw UsageError(options.body.empty() ? "--repair, --out" : "--body",
                     "these are for surfaces, the file is a volume mesh", "Leave them out");
  run.progress().report("reading", 0);
  const fea::ImportedVolume volume = fea::read_volume_mesh(options.mesh, request.unit);
  const fea::MeshQuality quality = fea::quality(volume.mesh);
  const fea::MassProperties mass = fea::mass_properties(volume.mesh);
  const double length = request.length;
  run.print(
      fmt::format("{} tetrahedra of {} nodes{}, {} nodes, {}\n", volume.mesh.element_count(),
                  volume.mesh.nodes_per_element(), volume.mesh.curved ? " with curved edges" : "",
                  volume.mesh.nodes.size(),
                  fea::count_pieces(volume.mesh) == 1 ? "in one piece" : "in several pieces"));
  run.print(fmt::format("smallest angle {:.3g} deg, median {:.3g} deg, largest edge ratio {:.3g}\n",
                        quality.least_dihedral, quality.median_dihedral,
                        quality.largest_edge_ratio));
  run.print(fmt::format("volume {:.6g} {}^3\n", mass.volume / std::pow(length, 3), request.unit));
  if (request.density > 0)
    run.print(fmt::format("mass {:.6g} kg\n", mass.volume * request.density));
  print_mass(run, mass, request);
  io::Json faces = io::Json::object(), elements = io::Json::object();
  for (const fea::FacetGroup& group : volume.surface.groups) {
    run.print(fmt::format("group of faces {}: {}\n", group.name, group.facets.size()));
    faces[group.name] = group.facets.size();
  }
  for (const fea::ElementGroup& group : volume.element_groups) {
    run.print(fmt::format("group of elements {}: {}\n", group.name, group.elements.size()));
    elements[group.name] = group.elements.size();
  }
  for (const std::string& warning : volume.warnings) run.print("warning: " + warning + "\n");
  io::Json json{{"sound", true},
                {"elements", volume.mesh.element_count()},
                {"nodes", volume.mesh.nodes.size()},
                {"order", volume.mesh.order},
                {"least_dihedral_deg", quality.least_dihedral},
                {"median_dihedral_deg", quality.median_dihedral},
                {"largest_edge_ratio", quality.largest_edge_ratio},
                {"face_groups", faces},
                {"element_groups", elements},
                {"warnings", volume.warnings}};
  json.update(mass_json(mass, request.density));
  json["units"] = {{"length", "m"}, {"mass", "kg"}};
  json["inputs"] = {{"mesh_sha256", volume.sha256}};
  return json;
}

io::Json check(Run& run, const Options& options) {
  const Request request = read_request(options);
  return fea::holds_volume_mesh(options.mesh) ? check_volume(run, options, request)
                                              : check_surface(run, options, request);
}

}  // namespace

void add_mesh_check(Program& program) {
  auto options = std::make_shared<Options>();
  OptionList app = program.add(
      {.name = "mesh check",
       .summary = "Check that a mesh bounds a solid, say where it does not, and repair it",
       .example = "kinetostat mesh check meshes/foot.stl --unit mm",
       .out = "Write the surface, repaired or not, as binary STL in its unit"},
      [options](Run& run) { return check(run, *options); });
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
  app.add_output("--vtu", options->vtu, "Write the offending facets for ParaView");
}

}  // namespace kinetostat::apps
