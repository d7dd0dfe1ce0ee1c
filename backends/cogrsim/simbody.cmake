# cogrsim_use_simbody(BACKEND): a backend on Simbody's multibody trees, with how bodies and joints of a scene become
# Simbody's.
find_library(COGRSIM_SIMTK_COMMON SimTKcommon REQUIRED)
find_library(COGRSIM_SIMTK_MATH SimTKmath REQUIRED)
find_library(COGRSIM_SIMTK_SIMBODY SimTKsimbody REQUIRED)
find_path(COGRSIM_SIMBODY_INCLUDE Simbody.h PATH_SUFFIXES simbody REQUIRED)

# Debian's Simbody is built without NDEBUG and its headers' layout depends on it.
foreach(flags CMAKE_CXX_FLAGS CMAKE_CXX_FLAGS_RELEASE CMAKE_CXX_FLAGS_RELWITHDEBINFO)
  if(${flags} MATCHES "DNDEBUG")
    message(FATAL_ERROR "backends on Simbody must be compiled without -DNDEBUG, but ${flags} has it")
  endif()
endforeach()

function(cogrsim_use_simbody backend)
  target_sources(${backend} PRIVATE ${CMAKE_CURRENT_FUNCTION_LIST_DIR}/src/mobilizers.cpp)
  target_include_directories(${backend} PRIVATE ${CMAKE_CURRENT_FUNCTION_LIST_DIR}/src)
  target_include_directories(${backend} SYSTEM PRIVATE ${COGRSIM_SIMBODY_INCLUDE})
  target_compile_options(${backend} PRIVATE -UNDEBUG)
  target_link_libraries(${backend} PRIVATE ${COGRSIM_SIMTK_SIMBODY} ${COGRSIM_SIMTK_MATH}
    ${COGRSIM_SIMTK_COMMON})
  target_precompile_headers(${backend} PRIVATE <Simbody.h> <Eigen/Core> <Eigen/Geometry> <vector>)
endfunction()
