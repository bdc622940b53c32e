#include "kinetostat/apps/cli/cancellation.h"
#include "kinetostat/apps/cli/command.h"
#include "kinetostat/apps/cli/process.h"
#include "kinetostat/apps/commands/commands.h"

int main(int argc, char** argv) {
  kinetostat::apps::prepare_process(argv);
  kinetostat::apps::catch_signals();
  kinetostat::apps::Program program;
  kinetostat::apps::add_new(program);
  kinetostat::apps::add_mesh_check(program);
  kinetostat::apps::add_identify(program);
  kinetostat::apps::add_beam(program);
  kinetostat::apps::add_modes(program);
  kinetostat::apps::add_import(program);
  kinetostat::apps::add_export(program);
  kinetostat::apps::add_stiffness(program);
  kinetostat::apps::add_deflect(program);
  kinetostat::apps::add_trace(program);
  kinetostat::apps::add_assemble(program);
  kinetostat::apps::add_map(program);
  kinetostat::apps::add_compensate(program);
  kinetostat::apps::add_study(program);
  kinetostat::apps::add_readings(program);
  kinetostat::apps::add_measure_check(program);
  kinetostat::apps::add_simulate(program);
  kinetostat::apps::add_compare(program);
  kinetostat::apps::add_calibrate(program);
  kinetostat::apps::add_diagnose(program);
  kinetostat::apps::add_plan(program);
  kinetostat::apps::add_adopt(program);
  kinetostat::apps::add_revert(program);
  kinetostat::apps::add_effect_list(program);
  kinetostat::apps::add_effect_show(program);
#ifdef KINETOSTAT_HAS_STUDIO
  kinetostat::apps::add_studio(program);
#endif
  kinetostat::apps::add_sweep(program);
  kinetostat::apps::add_fleet(program);
  kinetostat::apps::add_report(program);
  kinetostat::apps::add_demo(program);
  return program.run(argc, argv);
}
