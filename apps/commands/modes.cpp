// kinetostat modes: natural frequencies of a link from its CAD mesh.
#include "kinetostat/report/links/modes.h"

#include <cstdint>

#include "kinetostat/apps/cli/command.h"
#include "kinetostat/apps/commands/commands.h"
#include "kinetostat/fea/link/displacement_fields.h"
#include "kinetostat/fea/link/modal_study.h"
#include "kinetostat/io/cache.h"
#include "kinetostat/report/screen/modes.h"
#include "kinetostat/report/screen/wording.h"

namespace kinetostat::apps {
namespace {

struct ModesRequest {
  std::string link, vtu;
  bool free = false, held = false, no_cache = false;
  int modes = fea::ModalOptions{}.modes;
  std::uint64_t memory = 0;  // [bytes]; 0: a share of what is free
  fea::RefinementOptions refinement{.most_unknowns = 300'000};
};

fea::Support support_of(const ModesRequest& request) {
  if (request.free) return fea::Support::none;
  return request.held ? fea::Support::all_interfaces : fea::Support::first_interface;
}

io::Json find_modes(Run& run, const ModesRequest& request) {
  const fea::LinkSpec spec = fea::read_link(request.link);
  const io::Cache cache = request.no_cache ? io::Cache() : io::Cache::of_user();
  fea::ModalOptions options{
      .support = support_of(request),
      .modes = request.modes,
      .solver = {.threads = run.threads(), .memory = static_cast<double>(request.memory)},
      .refinement = request.refinement};
  options.meshing.cache = &cache;
  const fea::LinkGeometry geometry = fea::read_geometry(spec, run.progress());
  const fea::ModalResult result = fea::modal_study(spec, geometry, options, run.progress());
  if (!result.accuracy.shortfall.empty())
    run.stop_short(spec.name + ": " + result.accuracy.shortfall);
  if (!request.vtu.empty()) io::write_vtu(request.vtu, fea::mode_shapes(result));
  run.print(report::first_screen(result));
  run.print("\n" + report::next_step("kinetostat identify " + report::quoted(request.link),
                                     "how stiff is it at rest?"));
  run.print_more("\n" + report::text(result));
  io::Json json = report::to_json(result);
  json["headline"] = report::headline(result);
  if (run.out()) io::write_json(*run.out(), json);
  return json;
}

}  // namespace

void add_modes(Program& program) {
  auto request = std::make_shared<ModesRequest>();
  OptionList app =
      program.add({.name = "modes",
                   .summary = "Natural frequencies and modes of a link, by finite elements",
                   .example = "kinetostat modes meshes/foot.yaml --free --vtu modes.vtu",
                   .out = "Write the frequencies to a JSON file"},
                  [request](Run& run) { return find_modes(run, *request); });
  app.add_option("link", request->link, "Link file, with a density").required().type_name("LINK");
  app.add_option("--modes", request->modes, "How many, from the lowest on")
      .type_name("N")
      .between(1, 200)
      .show_default();
  app.add_flag("--free", request->free,
               "Of the link in the air, its six rigid motions left out; it is clamped at its fixed "
               "interface unless given");
  app.add_flag("--held", request->held,
               "Clamped at all its interfaces: the fixed-interface modes of Craig and Bampton")
      .excludes("--free");
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
