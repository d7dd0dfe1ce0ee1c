# cogrsim_add_plugin(NAME SOURCES a.cpp … [LIBRARIES target …] [KIND plugin|backend])
#
# Builds the shared library NAME.so that CogRSim finds by NAME. In CogRSim's own build it lands
# beside the other plugins; in yours, in ${CMAKE_BINARY_DIR}/cogrsim_plugins unless you set
# COGRSIM_PLUGIN_OUTPUT_DIRECTORY: name that folder in COGRSIM_PLUGIN_PATH or --plugin-path.
# Without CMAKE_BUILD_TYPE it is built as with RelWithDebInfo: optimised, with debug information.
# `install(TARGETS NAME …)` is done for you, into lib/cogrsim/plugins of the install prefix.
include(GNUInstallDirs)

function(cogrsim_add_plugin name)
  cmake_parse_arguments(arg "" "KIND" "SOURCES;LIBRARIES" ${ARGN})
  if(NOT arg_SOURCES)
    message(FATAL_ERROR "cogrsim_add_plugin(${name}): no SOURCES given")
  endif()
  if(arg_UNPARSED_ARGUMENTS)
    message(FATAL_ERROR "cogrsim_add_plugin(${name}): unknown arguments: ${arg_UNPARSED_ARGUMENTS}")
  endif()
  if(arg_KIND STREQUAL "backend")
    set(folder backends)
  else()
    set(folder plugins)
  endif()
  add_library(${name} MODULE ${arg_SOURCES})
  target_compile_features(${name} PRIVATE cxx_std_17)
  target_link_libraries(${name} PRIVATE cogrsim::sdk ${arg_LIBRARIES})
  # Without a build type CMake would not optimise, and Eigen is then ten times slower.
  if(NOT CMAKE_BUILD_TYPE AND NOT CMAKE_CONFIGURATION_TYPES)
    target_compile_options(${name} PRIVATE -O2 -g)
    target_compile_definitions(${name} PRIVATE NDEBUG)
  endif()
  if(CogRSim_SOURCE_DIR)
    set(output "${CogRSim_BINARY_DIR}/lib/cogrsim/${folder}")
    target_link_libraries(${name} PRIVATE cogrsim_warnings)
    set_property(GLOBAL APPEND PROPERTY COGRSIM_PLUGINS ${name})
  elseif(COGRSIM_PLUGIN_OUTPUT_DIRECTORY)
    set(output "${COGRSIM_PLUGIN_OUTPUT_DIRECTORY}")
  else()
    set(output "${CMAKE_BINARY_DIR}/cogrsim_plugins")
  endif()
  set_target_properties(${name} PROPERTIES
    PREFIX ""
    SUFFIX ".so"
    LIBRARY_OUTPUT_DIRECTORY "${output}"
    CXX_EXTENSIONS OFF
    CXX_VISIBILITY_PRESET hidden
    VISIBILITY_INLINES_HIDDEN ON
    # Padded by CMake, a build tree's paths would hold the folder a program is started in.
    BUILD_WITH_INSTALL_RPATH ON
    INSTALL_RPATH_USE_LINK_PATH ON
    INSTALL_RPATH "$ORIGIN/../..")
  if(CogRSim_SOURCE_DIR)
    cogrsim_component(component)
    list(APPEND component COMPONENT)
    list(REVERSE component)
  endif()
  install(TARGETS ${name} LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}/cogrsim/${folder} ${component})
endfunction()
