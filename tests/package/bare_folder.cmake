# An empty WORK_DIR, as for a user without any settings: run() runs commands there and stores their
# output in `output`; `flags` are for a project's compiler, which must not warn.
foreach(variable LD_LIBRARY_PATH COGRSIM_PLUGIN_PATH CMAKE_PREFIX_PATH CogRSim_DIR DESTDIR)
  unset(ENV{${variable}})
endforeach()
file(REMOVE_RECURSE "${WORK_DIR}")
file(MAKE_DIRECTORY "${WORK_DIR}")

function(run what)
  execute_process(COMMAND ${ARGN} WORKING_DIRECTORY "${WORK_DIR}" RESULT_VARIABLE status
    OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(NOT status EQUAL 0)
    message(FATAL_ERROR "${what}: exit status ${status}\n${output}")
  endif()
  set(output "${output}" PARENT_SCOPE)
endfunction()

set(flags "-Wall -Wextra -Wpedantic -Wshadow -Wconversion -Werror")
if(SANITIZE)
  # With it g++ reports parts of the standard library as uninitialised.
  string(APPEND flags " -fsanitize=${SANITIZE} -Wno-maybe-uninitialized")
endif()
