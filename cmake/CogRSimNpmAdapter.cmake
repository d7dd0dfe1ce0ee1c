# cogrsim_add_npm_adapter(NAME ENGINE PACKAGE [LEAVE_OUT pattern…]): a backend that is a program in TypeScript,
# with its engine in the package PACKAGE of npm, of which files that match LEAVE_OUT are not taken. It is built
# where the registry of npm can be reached, as the studio's page is, into the folder of the other backends. The
# target is NAME_adapter. Without it a warning says what is missing, and backend.json alone is there, by which
# `cogrsim plugins` says so, too.
function(cogrsim_add_npm_adapter name engine package)
  cmake_parse_arguments(arg "" "" "LEAVE_OUT" ${ARGN})
  set(output ${CogRSim_BINARY_DIR}/lib/cogrsim/backends/${name})
  configure_file(backend.json ${output}/backend.json COPYONLY)
  cogrsim_component(component)
  install(DIRECTORY ${output} DESTINATION ${CMAKE_INSTALL_LIBDIR}/cogrsim/backends COMPONENT ${component})
  find_program(NODE_PROGRAM NAMES node nodejs)
  find_program(NPM_PROGRAM npm)
  set(left_out "The backend ${name} is left out. Everything else is built.")
  if(NOT COGRSIM_STUDIO OR NOT NODE_PROGRAM OR NOT NPM_PROGRAM)
    message(WARNING "${left_out} It needs Node.js and npm, as the studio does.")
    return()
  endif()
  set(work ${CMAKE_CURRENT_BINARY_DIR}/web)
  set(library ${PROJECT_SOURCE_DIR}/sdk/adapter)
  set(packages ${CMAKE_CURRENT_SOURCE_DIR}/package.json ${CMAKE_CURRENT_SOURCE_DIR}/package-lock.json)
  # Here and not in the build: a registry that cannot be reached decides what is built.
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${packages})
  file(MAKE_DIRECTORY ${work})
  if(NOT EXISTS ${work}/packages.stamp OR ${CMAKE_CURRENT_SOURCE_DIR}/package-lock.json IS_NEWER_THAN
      ${work}/packages.stamp)
    file(COPY ${packages} DESTINATION ${work})
    execute_process(COMMAND ${NPM_PROGRAM} ci --no-audit --no-fund --prefer-offline --loglevel=error
      WORKING_DIRECTORY ${work} RESULT_VARIABLE failed OUTPUT_QUIET ERROR_VARIABLE problem TIMEOUT 300)
    if(failed)
      message(WARNING "${left_out} npm cannot fetch its packages: ${problem}")
      return()
    endif()
    file(TOUCH ${work}/packages.stamp)
  endif()
  set(excluded)
  foreach(pattern IN ITEMS *.map ${arg_LEAVE_OUT})
    list(APPEND excluded PATTERN ${pattern} EXCLUDE)
  endforeach()
  file(REMOVE_RECURSE ${output}/node_modules)  # what an earlier configuration took
  get_filename_component(scope ${package} DIRECTORY)
  file(COPY ${work}/node_modules/${package} DESTINATION ${output}/node_modules/${scope} ${excluded})
  file(GLOB sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/src/*.ts)
  # What adapters of engines share.
  set(shared ${PROJECT_SOURCE_DIR}/backends/typescript)
  set(from_library ${library}/cogrsim_backend.mjs ${library}/cogrsim_backend.d.mts ${shared}/math.ts
    ${shared}/scene.ts)
  add_custom_command(OUTPUT ${output}/adapter.mjs
    COMMAND ${CMAKE_COMMAND} -E rm -rf ${work}/src
    COMMAND ${CMAKE_COMMAND} -E copy_directory ${CMAKE_CURRENT_SOURCE_DIR}/src ${work}/src
    COMMAND ${CMAKE_COMMAND} -E copy ${from_library} ${work}/src
    COMMAND ${CMAKE_COMMAND} -E copy ${shared}/tsconfig.json ${work}
    COMMAND ${NPM_PROGRAM} run --silent build
    COMMAND ${CMAKE_COMMAND} -E copy ${work}/adapter.mjs ${output}
    DEPENDS ${work}/packages.stamp ${sources} ${from_library} ${shared}/tsconfig.json
    WORKING_DIRECTORY ${work}
    COMMENT "Building the adapter of ${engine}"
    VERBATIM)
  add_custom_target(${name}_adapter ALL DEPENDS ${output}/adapter.mjs)
  set_property(GLOBAL APPEND PROPERTY COGRSIM_PLUGINS ${name}_adapter)
endfunction()
