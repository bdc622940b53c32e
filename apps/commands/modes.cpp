// kinetostat modes: natural frequencies of a link from its CAD mesh, or of a robot in a posture.
#include "kinetostat/report/links/modes.h"

#include <cstdint>
#include <memory>

#include <fmt/format.h>

#include "kinetostat/apps/cli/command.h"
#include "kinetostat/apps/commands/commands.h"
#include "kinetostat/apps/results/robot_modes.h"
#include "kinetostat/fea/link/displacement_fields.h"
#include "kinetostat/fea/link/matrix_export.h"
#include "kinetostat/fea/link/modal_study.h"
#include "kinetostat/io/cache.h"
#include "kinetostat/io/document_kind.h"
#include "kinetostat/io/text_file.h"
#include "kinetostat/report/manipulators/manipulator.h"
#include "kinetostat/report/manipulators/skeleton.h"
#include "kinetostat/report/screen/modes.h"
#include "kinetostat/report/screen/wording.h"

namespace kinetostat::apps {
namespace {

// Of a robot, whose file may be a link file, and of a link.
struct ModesRequest : RobotModesRequest {
  std::string vtu;
  std::vector<std::string> reduced;
  bool free = false, held = false, no_cache = false;
  std::uint64_t memory = 0;  // [bytes]; 0: a share of what is free
  fea::RefinementOptions refinement{.most_unknowns = 300'000};
};

fea::Support support_of(const ModesRequest& request) {
  if (request.free) return fea::Support::none;
  return request.held ? fea::Support::all_interfaces : fea::Support::first_interface;
}

// By the extension of the file.
auto writer_of(const std::string& file)
    -> std::string (*)(const fea::ModalResult&, const fea::ReducedModel&) {
  const std::string extension = std::filesystem::path(file).extension().string();
  if (extension == ".m") return fea::reduced_matlab;
  if (extension == ".mat") return fea::reduced_mat;
  if (extension == ".py") return fea::reduced_exudyn;
  if (extension == ".inp") return fea::reduced_deck;
  if (extension == ".fem") return fea::reduced_mbdyn;
  if (extension == ".hpp") return fea::reduced_chrono;
  throw UsageError("--reduced", "'" + extension + "' does not say the format",
                   "End it with .m or .mat (MATLAB, Simscape), .py (EXUDYN), .inp (CalculiX, "
                   "Abaqus), .fem (MBDyn) or .hpp (Chrono)");
}

// Computes, and writes what needs the whole model.
fea::ModalResult study_link(Run& run, const ModesRequest& request, const fea::LinkSpec& spec) {
  const io::Cache cache = request.no_cache ? io::Cache() : io::Cache::of_user();
  fea::ModalOptions options{
      .support = support_of(request),
      .modes = request.modes,
      .solver = {.threads = run.threads(), .memory = static_cast<double>(request.memory)},
      .refinement = request.refinement};
  options.meshing.cache = &cache;
  const fea::LinkGeometry geometry = fea::read_geometry(spec, run.progress());
  fea::ModalResult result = fea::modal_study(spec, geometry, options, run.progress());
  if (!request.vtu.empty()) io::write_vtu(request.vtu, fea::mode_shapes(result));
  if (request.reduced.empty()) return result;
  const fea::ReducedModel reduced = fea::reduced_link(spec, result, options, run.progress());
  for (const std::string& written : request.reduced)
    io::write_atomically(written, writer_of(written)(result, reduced));
  return result;
}

io::Json modes_of_link(Run& run, const ModesRequest& request) {
  const std::string& file = request.robot.robot_file;
  for (const std::string& written : request.reduced) (void)writer_of(written);
  if (!request.robot.at.empty() || !request.robot.joints.empty())
    throw UsageError(request.robot.at.empty() ? "--joints" : "--at", "a link has no posture",
                     "Leave it out, or name a robot file");
  for (const auto& [given, name] : {std::pair{!request.response.empty(), "--response"},
                                    {!request.load.wrench.empty(), "--wrench"},
                                    {!request.load.node_loads.empty(), "--node-load"},
                                    {request.uncertainty.draws > 0, "--draws"},
                                    {request.uncertainty.none, "--no-uncertainty"},
                                    {request.weight, "--weight"}})
    if (given)
      throw UsageError(name, "this is about a robot", "Leave it out, or name a robot file");
  const fea::LinkSpec spec = fea::read_link(file);
  const fea::ModalResult result = study_link(run, request, spec);
  if (!result.accuracy.shortfall.empty())
    run.stop_short(spec.name + ": " + result.accuracy.shortfall);
  run.print(report::first_screen(result));
  run.print("\n" + report::next_step("kinetostat identify " + report::quoted(file),
                                     "how stiff is it at rest?"));
  run.print_more("\n" + report::text(result));
  io::Json json = report::to_json(result);
  json["headline"] = report::headline(result);
  return json;
}

// Options that are about links alone.
void refuse_options_of_links(const ModesRequest& request) {
  for (const auto& [given, name] : {std::pair{request.free, "--free"},
                                    {request.held, "--held"},
                                    {!request.vtu.empty(), "--vtu"},
                                    {!request.reduced.empty(), "--reduced"}})
    if (given)
      throw UsageError(name, "this is about a link, and the file is a robot file",
                       "Leave it out, or name a link file");
}

io::Json modes_of_robot(Run& run, const ModesRequest& request) {
  refuse_options_of_links(request);
  const RobotModesResult result = modes_of_robot(request, run);
  const vjm::NaturalModes& found = result.modes.found;
  run.print(report::first_screen(result.robot, result.modes));
  run.print_more("\n" + report::text(result.robot, result.posture));
  run.draw(report::picture(result.robot.manipulator.without_errors(), found.posture, found.modes));
  return to_json(result);
}

io::Json find_modes(Run& run, const ModesRequest& request) {
  const bool is_robot = io::document_kind(request.robot.robot_file) == io::DocumentKind::robot;
  io::Json json = is_robot ? modes_of_robot(run, request) : modes_of_link(run, request);
  if (run.out()) io::write_json(*run.out(), json);
  return json;
}

}  // namespace

void add_modes(Program& program) {
  auto request = std::make_shared<ModesRequest>();
  OptionList app =
      program.add({.name = "modes",
                   .summary = "Natural frequencies and modes of a link, or of a robot in a posture",
                   .example = "kinetostat modes meshes/tapered_arm.yaml --free --vtu modes.vtu",
                   .out = "Write the frequencies to a JSON file"},
                  [request](Run& run) { return find_modes(run, *request); });
  app.add_option("file", request->robot.robot_file,
                 "Link file with a density, or robot file with masses")
      .required()
      .type_name("FILE");
  request->robot.add_posture_options(app);
  app.add_flag(
      "--weight", request->weight,
      "Of a robot: about the equilibrium under its own weight, which adds to the stiffness "
      "or takes off it; with a load below it acts as well");
  request->load.add_load_options(app);
  request->uncertainty.add_options(app);
  app.add_option("--modes", request->modes, "How many, from the lowest on")
      .type_name("N")
      .between(1, 200)
      .show_default();
  app.add_option("--response", request->response,
                 "Of a robot: how the platform answers a force of these frequencies [Hz]")
      .type_name("FROM:TO[:STEPS]");
  Option damping = app.add_option("--damping", request->damping,
                                  "For --response: damping ratio of every mode, as 0.02")
                       .between(0, 1);
  app.add_option("--loss-factor", request->loss_factor,
                 "For --response: structural damping of all springs, K (1 + i eta)")
      .between(0, 1)
      .excludes(damping);
  app.add_flag("--free", request->free,
               "Of the link in the air, its six rigid motions left out; it is clamped at its fixed "
               "interface unless given");
  app.add_flag("--held", request->held,
               "Clamped at all its interfaces: the fixed-interface modes of Craig and Bampton")
      .excludes("--free");
  app.add_outputs("--reduced", request->reduced,
                  "Write stiffness and mass of the free link, with as many modes held at its "
                  "interfaces: .m or .mat (MATLAB, Simscape), .py (EXUDYN), .inp (CalculiX, "
                  "Abaqus), .fem (MBDyn), .hpp (Chrono); any number of times");
  app.add_output("--vtu", request->vtu, "Write the shapes of the modes for ParaView");
  app.add_option("--time", request->refinement.time_limit,
                 "Start no finer mesh after so many seconds; the best result so far is given")
      .type_name("S")
      .positive();
  app.add_option("--unknowns", request->refinement.most_unknowns,
                 "Plan no finer mesh with more unknowns than this")
      .type_name("N")
      .positive();
  app.add_option("--memory", request->memory,
                 "Memory that the program may have, as 8GB; nine tenths of what is free unless "
                 "given")
      .type_name("SIZE")
      .size_in_bytes();
  app.add_flag("--no-cache", request->no_cache, "Make the volume mesh anew, and do not keep it");
}

}  // namespace kinetostat::apps
