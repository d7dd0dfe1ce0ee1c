# Compiles one file for each engine header with the include paths given: each must fail. The control
# must succeed, or the failures would prove nothing.
set(flags "")
list(REMOVE_DUPLICATES INCLUDES)
foreach(path ${INCLUDES})
  if(path)
    list(APPEND flags -I${path})
  endif()
endforeach()
file(MAKE_DIRECTORY "${WORK_DIR}")

function(compiles header out)
  file(WRITE "${WORK_DIR}/probe.cpp" "#include <${header}>\nint main() {}\n")
  execute_process(COMMAND ${COMPILER} -std=c++17 -fsyntax-only ${flags} "${WORK_DIR}/probe.cpp"
    RESULT_VARIABLE status OUTPUT_QUIET ERROR_VARIABLE errors)
  set(${out} ${status} PARENT_SCOPE)
  set(errors "${errors}" PARENT_SCOPE)
endfunction()

compiles("cogrsim/core/parameter.h" status)
if(NOT status EQUAL 0)
  message(FATAL_ERROR "the control does not compile: ${errors}")
endif()
foreach(header Simbody.h SimTKsimbody.h SimTKcommon.h btBulletDynamicsCommon.h
        btBulletCollisionCommon.h LinearMath/btVector3.h
        BulletDynamics/Featherstone/btMultiBody.h)
  compiles("${header}" status)
  if(status EQUAL 0)
    message(SEND_ERROR "<${header}> can be included")
  elseif(NOT errors MATCHES "No such file")
    message(SEND_ERROR "<${header}> failed, but not because it cannot be found: ${errors}")
  endif()
endforeach()
