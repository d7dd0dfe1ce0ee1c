# Makes a project with `cogrsim new KIND` and follows its README, against the build tree: configure,
# build, ctest.
include(${CMAKE_CURRENT_LIST_DIR}/bare_folder.cmake)
# By the environment, because it is a list.
set(ENV{CMAKE_CXX_COMPILER_LAUNCHER} "${LAUNCHER}")

set(name "trial_${KIND}")
run("new" "${PREFIX}/bin/cogrsim" new ${KIND} ${name})
string(FIND "${output}" "-DCMAKE_PREFIX_PATH=${PREFIX}\n" found)
if(found EQUAL -1)
  message(SEND_ERROR "cogrsim new does not say where it is installed:\n${output}")
endif()
run("configure" ${CMAKE_COMMAND} -S ${name} -B ${name}/build -G "${GENERATOR}"
  -DCMAKE_MAKE_PROGRAM=${MAKE_PROGRAM} -DCMAKE_CXX_COMPILER=${COMPILER}
  "-DCMAKE_CXX_FLAGS=${flags}"
  -DCMAKE_PREFIX_PATH=${PREFIX})
run("build" ${CMAKE_COMMAND} --build ${name}/build)
find_program(CTEST ctest REQUIRED)
run("ctest" ${CTEST} --test-dir ${name}/build --output-on-failure)
# As many as the template registers: none may be lost when a package is not found.
if(NOT output MATCHES "100% tests passed, 0 tests failed out of ${TESTS}\n")
  message(SEND_ERROR "not the ${TESTS} tests expected:\n${output}")
endif()

# Again, with another existing file: nothing is changed.
execute_process(COMMAND "${PREFIX}/bin/cogrsim" new sensor ${name} WORKING_DIRECTORY "${WORK_DIR}"
  RESULT_VARIABLE status ERROR_VARIABLE error OUTPUT_QUIET)
if(NOT status EQUAL 1 OR NOT error MATCHES "there already")
  message(SEND_ERROR "a folder that is there: exit status ${status}\n${error}")
endif()
