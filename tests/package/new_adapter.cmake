# Makes a backend with `cogrsim new backend --language LANGUAGE` and follows its README, against the build
# tree: its scene, and the conformance suite.
include(${CMAKE_CURRENT_LIST_DIR}/bare_folder.cmake)
find_program(NODE NAMES node)
if(LANGUAGE STREQUAL "js" AND NOT NODE)
  message("SKIPPED: there is no Node.js")
  return()
endif()
set(name "trial_${LANGUAGE}")
run("new" "${PREFIX}/bin/cogrsim" new backend ${name} --language ${LANGUAGE})
run("test" "${PREFIX}/bin/cogrsim" test ${name}/${name}.scene.xml --backends ${name}
  --plugin-path ${name})
run("conformance" "${PREFIX}/bin/cogrsim_conformance" --backend ${name} --plugin-path ${name}
  --expectations ${name}/expectations.json "[contract],[free],[kinematic]")
if(NOT output MATCHES "21 tests, 0 not as in ")
  message(SEND_ERROR "not the 21 tests expected:\n${output}")
endif()
