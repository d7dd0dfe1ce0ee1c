# Searches for engines' headers and names in all sources that must not depend on engines.
include("${CMAKE_CURRENT_LIST_DIR}/engines.cmake")

function(refuse file pattern what)
  file(STRINGS "${file}" lines REGEX "${pattern}")
  if(lines)
    list(GET lines 0 line)
    message(SEND_ERROR "${file}: ${what}: ${line}")
  endif()
endfunction()

set(sources "")
foreach(folder sdk dsl plugins apps examples python)
  file(GLOB_RECURSE found "${SOURCE_DIR}/${folder}/*.h" "${SOURCE_DIR}/${folder}/*.cpp")
  list(APPEND sources ${found})
  file(GLOB_RECURSE found "${SOURCE_DIR}/${folder}/CMakeLists.txt")
  list(APPEND cmake_files ${found})
endforeach()
list(LENGTH sources count)
if(count LESS 10)
  message(FATAL_ERROR "found ${count} sources below ${SOURCE_DIR}: the searched folder is wrong")
endif()

foreach(file ${sources})
  refuse("${file}" "#[ ]*include[ ]*[<\"](${engine_headers})"
    "includes an engine's header")
  refuse("${file}" "(^|[^A-Za-z_])(${engine_types})"
    "names an engine's types")
endforeach()
foreach(file ${cmake_files})
  refuse("${file}" "(${engine_words})" "names an engine")
endforeach()
