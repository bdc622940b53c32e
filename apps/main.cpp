#include "kinetostat/apps/cli/cancellation.h"
#include "kinetostat/apps/cli/command.h"
#include "kinetostat/apps/cli/process.h"
#include "kinetostat/apps/commands/commands.h"

int main(int argc, char** argv) {
  kinetostat::apps::prepare_process(argv);
  kinetostat::apps::catch_signals();
  kinetostat::apps::Program program;
  kinetostat::apps::add_all_commands(program);
  return program.run(argc, argv);
}
