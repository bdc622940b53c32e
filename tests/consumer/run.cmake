# Installs kinetostat from BUILD, builds the consumer in SOURCE against it in WORK, and runs it.
function(run)
  execute_process(COMMAND ${ARGN} COMMAND_ERROR_IS_FATAL ANY)
endfunction()

file(REMOVE_RECURSE ${WORK})
run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${WORK}/prefix)
run(${CMAKE_COMMAND} -S ${SOURCE} -B ${WORK}/build -G Ninja -D CMAKE_PREFIX_PATH=${WORK}/prefix
  -D CMAKE_CXX_FLAGS=${CXX_FLAGS})
run(${CMAKE_COMMAND} --build ${WORK}/build)
run(${WORK}/build/consumer)

# The installed program finds its helper beside itself: what it was configured for is another prefix.
file(RENAME ${WORK}/prefix ${WORK}/moved)
run(${WORK}/moved/bin/kinetostat identify ${SOURCE}/../../meshes/bar.yaml --quiet
  --out ${WORK}/bar.link.json)
