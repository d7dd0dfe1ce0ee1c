# Looks for engines' headers and names in the sources of everything that must not know engines.
set(failed FALSE)

function(refuse file pattern what)
  file(STRINGS "${file}" lines REGEX "${pattern}")
  if(lines)
    list(GET lines 0 line)
    message(SEND_ERROR "${file}: ${what}: ${line}")
  endif()
endfunction()

set(sources "")
foreach(folder sdk dsl plugins apps examples)
  file(GLOB_RECURSE found "${SOURCE_DIR}/${folder}/*.h" "${SOURCE_DIR}/${folder}/*.cpp")
  list(APPEND sources ${found})
  file(GLOB_RECURSE found "${SOURCE_DIR}/${folder}/CMakeLists.txt")
  list(APPEND cmake_files ${found})
endforeach()
list(LENGTH sources count)
if(count LESS 10)
  message(FATAL_ERROR "found ${count} sources below ${SOURCE_DIR}: looking in the wrong place")
endif()

foreach(file ${sources})
  refuse("${file}" "#[ ]*include[ ]*[<\"](bt[A-Z]|[Bb]ullet[^/\"]*[/.]|LinearMath/|SimTK|[Ss]imbody|simmath)"
    "includes an engine's header")
  refuse("${file}" "(^|[^A-Za-z_])(SimTK::|bt(Vector3|Quaternion|Transform|Scalar|RigidBody|MultiBody|Collision|Discrete))"
    "names an engine's types")
endforeach()
foreach(file ${cmake_files})
  refuse("${file}" "([Ss]imbody|SIMBODY|[Bb]ullet|BULLET)" "names an engine")
endforeach()
