// kinetostat material list: the materials that link and robot files may name.
#include <fmt/format.h>

#include "kinetostat/apps/cli/command.h"
#include "kinetostat/apps/commands/commands.h"
#include "kinetostat/io/material_table.h"

namespace kinetostat::apps {
namespace {

io::Json to_json(const io::NamedMaterial& material) {
  return {{"name", material.name},      {"words", material.words},  {"E", material.young},
          {"E_sd", material.deviation}, {"nu", material.poisson},   {"density", material.density},
          {"source", material.source},  {"spread", material.spread}};
}

std::string line(const io::NamedMaterial& material) {
  return fmt::format("{:<18} {:>6.4g} GPa +- {:>4.2g} %  {:>5.3g}  {:>4.0f} kg/m^3  {}\n",
                     material.name, material.young / 1e9, 100 * material.deviation / material.young,
                     material.poisson, material.density, material.words);
}

io::Json list_materials(Run& run) {
  io::Json list = io::Json::array();
  run.print("name                        E (1 sd)        nu       density\n");
  for (const io::NamedMaterial& material : io::named_materials()) {
    run.print(line(material));
    run.print_more(fmt::format("    values: {}; spread: {}\n", material.source, material.spread));
    list.push_back(to_json(material));
  }
  run.print(
      "\nUse one in a link or robot file: 'material: steel_s235'. --verbose adds the sources.\n");
  return {{"materials", list}};
}

}  // namespace

void add_material_list(Program& program) {
  program.add({.name = "material list",
               .summary = "Materials that link and robot files can name",
               .example = "kinetostat material list"},
              [](Run& run) { return list_materials(run); });
}

}  // namespace kinetostat::apps
