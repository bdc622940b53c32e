// All commands of the program, in the order in which its help lists them.
#include "kinetostat/apps/commands/commands.h"

namespace kinetostat::apps {

void add_all_commands(Program& program) {
  add_new(program);
  add_mesh_check(program);
  add_identify(program);
  add_beam(program);
  add_modes(program);
  add_import(program);
  add_export(program);
  add_stiffness(program);
  add_deflect(program);
  add_trace(program);
  add_assemble(program);
  add_map(program);
  add_compensate(program);
  add_study(program);
  add_readings(program);
  add_measure_check(program);
  add_simulate(program);
  add_compare(program);
  add_calibrate(program);
  add_diagnose(program);
  add_plan(program);
  add_adopt(program);
  add_revert(program);
  add_material_list(program);
  add_effect_list(program);
  add_effect_show(program);
#ifdef KINETOSTAT_HAS_STUDIO
  add_studio(program);
#endif
  add_sweep(program);
  add_fleet(program);
  add_report(program);
  add_demo(program);
}

}  // namespace kinetostat::apps
