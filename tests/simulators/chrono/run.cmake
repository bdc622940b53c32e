# Exports the bar with PROGRAM, compiles its header with CXX against the interface in SOURCE in WORK, and runs it.
function(run)
  execute_process(COMMAND ${ARGN} WORKING_DIRECTORY ${WORK} COMMAND_ERROR_IS_FATAL ANY)
endfunction()

file(REMOVE_RECURSE ${WORK})
file(MAKE_DIRECTORY ${WORK})
run(${PROGRAM} modes ${SOURCE}/../../../meshes/test_bar.yaml --set elements.size=8 --modes 8 --reduced test_bar.hpp -q)
run(${CXX} -std=c++17 -Wall -Wextra -Werror -isystem ${EIGEN} -I ${SOURCE}/interface -I ${WORK} ${SOURCE}/main.cpp
  -o turned_bar)
run(${WORK}/turned_bar)
