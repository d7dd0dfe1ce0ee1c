# No binary of the build tree, or of the tree installed beside it, looks for libraries in the folder it
# is started in: every entry of its RUNPATH begins with $ORIGIN or is absolute.
#
# -DBINARY_DIR= -DREADELF=
cmake_policy(SET CMP0009 NEW)  # pages that are tried have links to the build folder
file(GLOB_RECURSE files LIST_DIRECTORIES false "${BINARY_DIR}/bin/*" "${BINARY_DIR}/lib/*"
  "${BINARY_DIR}/*.so")
set(looked 0)
set(wrong "")
foreach(file IN LISTS files)
  execute_process(COMMAND ${READELF} -d ${file} OUTPUT_VARIABLE said ERROR_QUIET)
  if(NOT said MATCHES "NEEDED")
    continue()
  endif()
  math(EXPR looked "${looked} + 1")
  if(NOT said MATCHES "R(UN)?PATH[^\n]*\\[([^\n]*)\\]")
    continue()
  endif()
  set(paths ":${CMAKE_MATCH_2}:")
  if(paths MATCHES "::" OR paths MATCHES ":[^:$/]" OR paths MATCHES ":[$][^O{]")
    string(APPEND wrong "\n  ${file}: [${CMAKE_MATCH_2}]")
  endif()
endforeach()
if(looked LESS 10)
  message(FATAL_ERROR "${looked} binaries in ${BINARY_DIR} were found; there are more")
endif()
if(wrong)
  message(FATAL_ERROR "libraries are taken from the present folder by:${wrong}")
endif()
message(STATUS "${looked} binaries looked at")
