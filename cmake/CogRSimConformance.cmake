# cogrsim_add_conformance_tests(BACKEND EXPECTATIONS table.json [GROUPS g…] [MUTATIONS m…]
#                               [VARIANT name OPTION option=value] [CONFORMANCE_ONLY|ON_DEMAND]
#                               [PLUGIN_PATH folder])
#
# Makes CTest cases of the conformance suite for a backend: conformance.BACKEND.GROUP for each group of tests, compared
# with the backend's table of expectations, and conformance.BACKEND.mutation.FAULT for each fault that the suite must
# detect when it is injected into the backend's answers. A relative path starts at the current source folder. Without
# GROUPS: all groups. MUTATIONS: none by default; `all` is all.
# A VARIANT is the backend with an option of its world set in every scene; its cases are
# conformance.BACKEND-VARIANT.GROUP. CONFORMANCE_ONLY keeps the backend out of those suites of this repository that cost
# minutes on each engine (COGRSIM_ENGINES); what is cheap runs on all (COGRSIM_EVERY_ENGINE).
# ON_DEMAND keeps it out of both: PLUGIN_PATH is where it is found, and a build may lack it.
set(COGRSIM_CONFORMANCE_GROUPS contract free pendulum loop friction bounce contact stack heap pairs terrain
  joints limits motors robot momentum determinism runtime kinematic metamorphic reports faults)
# With the tests that must detect them, the cheap ones of their group.
set(COGRSIM_CONFORMANCE_MUTATIONS gravity=1.01 damping=0.04 swap-axes=1 friction=0.97
  restitution=0.9 inertia=1.02 effort=0.98 contact-force=1.02 limits=1.05 reaction=1.01 forget=1)
set(COGRSIM_CONFORMANCE_MUTATION_TESTS "[free]" "projectile*,rod pendulum*" "[free]" "[friction]"
  "bounce of a sphere on a plane" "rod pendulum*" "motor on hinge*" "[reports]" "[limits]"
  "[reports]" "a run resumes*")

function(cogrsim_add_conformance_tests backend)
  cmake_parse_arguments(arg "CONFORMANCE_ONLY;ON_DEMAND" "EXPECTATIONS;VARIANT;OPTION;PLUGIN_PATH"
    "GROUPS;MUTATIONS" ${ARGN})
  if(arg_UNPARSED_ARGUMENTS)
    message(FATAL_ERROR
      "cogrsim_add_conformance_tests(${backend}): unknown arguments: ${arg_UNPARSED_ARGUMENTS}")
  endif()
  if(NOT arg_EXPECTATIONS)
    message(FATAL_ERROR "cogrsim_add_conformance_tests(${backend}): no EXPECTATIONS given")
  endif()
  if(NOT arg_GROUPS)
    set(arg_GROUPS ${COGRSIM_CONFORMANCE_GROUPS})
  endif()
  foreach(group IN LISTS arg_GROUPS)
    if(NOT group IN_LIST COGRSIM_CONFORMANCE_GROUPS)
      list(JOIN COGRSIM_CONFORMANCE_GROUPS ", " known)
      message(FATAL_ERROR
        "cogrsim_add_conformance_tests(${backend}): there is no group '${group}': ${known}")
    endif()
  endforeach()
  get_filename_component(table "${arg_EXPECTATIONS}" ABSOLUTE)
  set(name ${backend})
  set(arguments --backend ${backend} --expectations "${table}")
  if(arg_VARIANT)
    string(APPEND name "-${arg_VARIANT}")
    list(APPEND arguments --option ${arg_OPTION})
  endif()
  if(arg_PLUGIN_PATH)
    list(APPEND arguments --plugin-path "${arg_PLUGIN_PATH}")
  endif()
  if(CogRSim_SOURCE_DIR)
    if(NOT arg_VARIANT AND NOT arg_ON_DEMAND)
      set_property(GLOBAL APPEND PROPERTY COGRSIM_EVERY_ENGINE ${backend})
      if(NOT arg_CONFORMANCE_ONLY)
        set_property(GLOBAL APPEND PROPERTY COGRSIM_ENGINES ${backend})
      endif()
    endif()
    # The default folder of the program for tables.
    set(shared "${CogRSim_BINARY_DIR}/share/cogrsim/expectations")
    file(MAKE_DIRECTORY "${shared}")
    file(CREATE_LINK "${table}" "${shared}/${name}.json" COPY_ON_ERROR SYMBOLIC)
    cogrsim_component(component)
    install(FILES "${table}" DESTINATION ${CMAKE_INSTALL_DATADIR}/cogrsim/expectations
      RENAME ${name}.json COMPONENT ${component})
    if(NOT COGRSIM_BUILD_TESTS OR NOT "conformance" IN_LIST COGRSIM_TEST_SUITES)
      return()
    endif()
    set(program $<TARGET_FILE:cogrsim_conformance>)
  elseif(NOT EXISTS "${CogRSim_CONFORMANCE}")
    message(FATAL_ERROR "cogrsim_add_conformance_tests(${backend}): ${CogRSim_CONFORMANCE} is missing: "
      "this CogRSim was built without its tests. Build its target 'product' with "
      "-DCOGRSIM_BUILD_TESTS=ON, or leave the call out")
  else()
    set(program "${CogRSim_CONFORMANCE}")
    list(APPEND arguments --plugin-path "${CMAKE_BINARY_DIR}/cogrsim_plugins")
    if(COGRSIM_PLUGIN_OUTPUT_DIRECTORY)
      list(APPEND arguments --plugin-path "${COGRSIM_PLUGIN_OUTPUT_DIRECTORY}")
    endif()
  endif()
  foreach(group IN LISTS arg_GROUPS)
    add_test(NAME conformance.${name}.${group} COMMAND ${program} ${arguments} "[${group}]")
    set_tests_properties(conformance.${name}.${group} PROPERTIES
      LABELS "conformance;${backend}" TIMEOUT 600)
  endforeach()
  if(arg_MUTATIONS STREQUAL "all")
    set(arg_MUTATIONS ${COGRSIM_CONFORMANCE_MUTATIONS})
    list(TRANSFORM arg_MUTATIONS REPLACE "=.*" "")
  endif()
  foreach(mutation tests IN ZIP_LISTS COGRSIM_CONFORMANCE_MUTATIONS COGRSIM_CONFORMANCE_MUTATION_TESTS)
    string(REGEX REPLACE "=.*" "" fault ${mutation})
    if(fault IN_LIST arg_MUTATIONS)
      list(REMOVE_ITEM arg_MUTATIONS ${fault})
      add_test(NAME conformance.${name}.mutation.${mutation}
        COMMAND ${program} ${arguments} --mutate ${mutation} "${tests}")
      set_tests_properties(conformance.${name}.mutation.${mutation} PROPERTIES
        LABELS "conformance;${backend};mutation" TIMEOUT 600)
    endif()
  endforeach()
  if(arg_MUTATIONS)
    message(FATAL_ERROR
      "cogrsim_add_conformance_tests(${backend}): there is no mutation '${arg_MUTATIONS}': ${COGRSIM_CONFORMANCE_MUTATIONS}")
  endif()
endfunction()
