// The commands of the program, one file each.
#pragma once

namespace kinetostat::apps {

class Program;

void add_new(Program& program);
void add_mesh_check(Program& program);
void add_identify(Program& program);
void add_beam(Program& program);
void add_modes(Program& program);
void add_import(Program& program);
void add_export(Program& program);
void add_stiffness(Program& program);
void add_deflect(Program& program);
void add_trace(Program& program);
void add_assemble(Program& program);
void add_map(Program& program);
void add_compensate(Program& program);
void add_readings(Program& program);
void add_measure_check(Program& program);
void add_simulate(Program& program);
void add_compare(Program& program);
void add_calibrate(Program& program);
void add_diagnose(Program& program);
void add_plan(Program& program);
void add_adopt(Program& program);
void add_revert(Program& program);
void add_material_list(Program& program);
void add_effect_list(Program& program);
void add_effect_show(Program& program);
void add_studio(Program& program);
void add_study(Program& program);
/// All of them.
void add_all_commands(Program& program);

void add_sweep(Program& program);
void add_fleet(Program& program);
void add_report(Program& program);
void add_demo(Program& program);

}  // namespace kinetostat::apps
