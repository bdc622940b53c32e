#include "kinetostat/apps/commands/links/link_exports.h"

#include "kinetostat/apps/cli/command.h"
#include "kinetostat/fea/link/calculix_deck.h"
#include "kinetostat/fea/link/gmsh_export.h"
#include "kinetostat/fea/link/matrix_export.h"
#include "kinetostat/io/text_file.h"

namespace kinetostat::apps {

void LinkExports::add_options(OptionList& app) {
  const auto add = [&app](const char* name, std::string& path, const char* description) {
    app.add_output(name, path, description);
  };
  add("--deck", deck, "Write the finite-element model as a CalculiX deck, a step per unit wrench");
  add("--msh", msh, "Write the volume mesh with its interfaces for Gmsh");
  add("--csv", csv, "Write the flexibility between the loaded interfaces as a table");
  add("--matlab", matlab, "Write flexibility and stiffness as a MATLAB script");
}

void LinkExports::write(const fea::LinkResult& result) const {
  for (const fea::CoupledInterface& interface : result.interfaces)
    if (!deck.empty() && interface.coupling == fea::Coupling::elastic)
      throw UsageError("--deck", "an elastic layer is not exported", "Leave it out");
  if (!deck.empty() && !result.joints.empty())
    throw UsageError("--deck", "joints between bodies are not exported", "Leave it out");
  if (!deck.empty() || !msh.empty()) {
    const fea::Solid solid =
        fea::with_stiff_bodies(result.mesh, result.materials, result.interfaces);
    if (!deck.empty())
      io::write_atomically(
          deck, fea::calculix_deck(result.name, solid.mesh, solid.materials, result.interfaces));
    if (!msh.empty()) io::write_atomically(msh, fea::gmsh_mesh(solid.mesh, result.interfaces));
  }
  if (!csv.empty()) io::write_atomically(csv, fea::flexibility_csv(result));
  if (!matlab.empty()) io::write_atomically(matlab, fea::flexibility_matlab(result));
}

}  // namespace kinetostat::apps
