# Fuzzers by clang beside a build by any compiler: the tested code of a target is compiled again,
# with libFuzzer's counters and the sanitizers; all the rest is linked as it was built. Nothing here
# is part of `all`.
file(WRITE ${CMAKE_CURRENT_BINARY_DIR}/try/empty.cpp
  "#include <cstddef>\n#include <cstdint>\n"
  "extern \"C\" int LLVMFuzzerTestOneInput(const std::uint8_t*, std::size_t) { return 0; }\n")
execute_process(COMMAND ${COGRSIM_FUZZ_CXX} -fsanitize=fuzzer,address,undefined
  ${CMAKE_CURRENT_BINARY_DIR}/try/empty.cpp -o ${CMAKE_CURRENT_BINARY_DIR}/try/empty
  RESULT_VARIABLE failed OUTPUT_QUIET ERROR_QUIET)
if(failed)
  message(STATUS "No libFuzzer (Debian: clang libclang-rt-14-dev): fuzzers are left out")
  return()
endif()

set(objects_of cogrsim_sdk cogrsim_dsl_objects)
foreach(part cogrsim_cli_lib cogrsim_share_lib cogrsim_studio_lib)
  if(TARGET ${part})
    list(APPEND objects_of ${part})
  endif()
endforeach()
# An archive: of these, the linker takes only what the instrumented ones do not have. A unity build's
# objects bring some of that along; the first definition is then used (-z muldefs).
set(rest_objects "")
foreach(part ${objects_of})
  list(APPEND rest_objects $<TARGET_OBJECTS:${part}>)
endforeach()
add_library(cogrsim_fuzz_rest STATIC EXCLUDE_FROM_ALL ${rest_objects})
set_target_properties(cogrsim_fuzz_rest PROPERTIES LINKER_LANGUAGE CXX)

set(flags -std=c++${CMAKE_CXX_STANDARD} -O1 -g1 -fPIC -fno-omit-frame-pointer -ffp-contract=off
  -fvisibility-inlines-hidden -Wall -Wextra
  -fsanitize=fuzzer-no-link,address,undefined -fno-sanitize-recover=undefined -fno-sanitize=vptr
  -DCOGRSIM_VERSION="${PROJECT_VERSION}" -DCOGRSIM_FUZZ_TOYS="${toys}"
  -I${PROJECT_SOURCE_DIR}/sdk/include -I${PROJECT_SOURCE_DIR}/dsl/include
  -I${PROJECT_SOURCE_DIR}/apps/cogrsim -I${PROJECT_SOURCE_DIR}/apps/studio)
foreach(folder ${includes})
  list(APPEND flags -I${folder})
endforeach()
get_target_property(eigen Eigen3::Eigen INTERFACE_INCLUDE_DIRECTORIES)
find_package(PkgConfig REQUIRED)
pkg_check_modules(COGRSIM_FUZZ_CAIRO REQUIRED cairo)
foreach(folder ${eigen} ${COGRSIM_FUZZ_CAIRO_INCLUDE_DIRS})
  list(APPEND flags -isystem ${folder})
endforeach()
set(libraries -lfmt -ljpeg -lpng -lqhull_r -lcairo -lembree3 -ltinyxml2 -lyaml-cpp -lzstd -lz -ldl -pthread)
if(TARGET cogrsim_share_lib)
  list(APPEND libraries -lcurl -larchive -lcrypto -lsqlite3)
endif()

# Compiles a source once, however many fuzzers it is in. One that has moved is found when the build is configured.
function(cogrsim_fuzz_object source out)
  if(NOT EXISTS ${source})
    message(FATAL_ERROR "a fuzzer is made of ${source}, which is not there: see tests/fuzz/fuzzers.cmake")
  endif()
  string(REPLACE "${CMAKE_CURRENT_BINARY_DIR}/" "" name ${source})
  string(REPLACE "${PROJECT_SOURCE_DIR}/" "" name ${name})
  set(object ${CMAKE_CURRENT_BINARY_DIR}/instrumented/${name}.o)
  set(${out} ${object} PARENT_SCOPE)
  get_property(known GLOBAL PROPERTY COGRSIM_FUZZ_OBJECTS)
  if(object IN_LIST known)
    return()
  endif()
  set_property(GLOBAL APPEND PROPERTY COGRSIM_FUZZ_OBJECTS ${object})
  get_filename_component(folder ${object} DIRECTORY)
  file(MAKE_DIRECTORY ${folder})
  add_custom_command(OUTPUT ${object}
    COMMAND ${CMAKE_CXX_COMPILER_LAUNCHER} ${COGRSIM_FUZZ_CXX} ${flags} -MD -MF ${object}.d
      -c ${source} -o ${object}
    DEPENDS ${source} DEPFILE ${object}.d VERBATIM
    COMMENT "Instrumenting ${name}")
endfunction()

# cogrsim_add_fuzzer(NAME SOURCES…): SOURCES are instrumented in addition to the target itself.
add_custom_target(fuzzers)
function(cogrsim_add_fuzzer name)
  set(entry ${CMAKE_CURRENT_BINARY_DIR}/entries/${name}.cpp)
  file(CONFIGURE OUTPUT ${entry} CONTENT
    "#define COGRSIM_FUZZ_TARGET ${name}\n#include \"${CMAKE_CURRENT_SOURCE_DIR}/libfuzzer.cpp\"\n")
  set(objects "")
  foreach(source ${entry} ${CMAKE_CURRENT_SOURCE_DIR}/targets/${name}.cpp
      ${CMAKE_CURRENT_SOURCE_DIR}/support.cpp ${CMAKE_CURRENT_SOURCE_DIR}/toy_scene.cpp ${ARGN})
    cogrsim_fuzz_object(${source} object)
    list(APPEND objects ${object})
  endforeach()
  set(program ${CMAKE_RUNTIME_OUTPUT_DIRECTORY}/fuzz/${name})
  add_custom_command(OUTPUT ${program}
    COMMAND ${CMAKE_COMMAND} -E make_directory ${CMAKE_RUNTIME_OUTPUT_DIRECTORY}/fuzz
    COMMAND ${COGRSIM_FUZZ_CXX} -fsanitize=fuzzer,address,undefined -rdynamic -Wl,-z,muldefs ${objects}
      $<TARGET_FILE:cogrsim_fuzz_rest> ${libraries} -o ${program}
    DEPENDS ${objects} cogrsim_fuzz_rest cogrsim_fuzz_toy VERBATIM
    COMMENT "Linking the fuzzer ${name}")
  add_custom_target(fuzz_${name} DEPENDS ${program})
  add_dependencies(fuzzers fuzz_${name})
endfunction()

function(cogrsim_with_folder folder out)
  set(full "")
  foreach(file ${ARGN})
    list(APPEND full ${folder}/${file}.cpp)
  endforeach()
  set(${out} ${full} PARENT_SCOPE)
endfunction()

cogrsim_with_folder(${dsl}/values values expression functions number_list value)
cogrsim_add_fuzzer(expression ${values} ${dsl}/study/values.cpp ${sdk}/core/units.cpp)
cogrsim_add_fuzzer(image ${sdk}/core/image.cpp ${sdk}/core/image_jpeg.cpp ${sdk}/core/image_png.cpp)
cogrsim_with_folder(${dsl}/assets meshes mesh_file mesh_gltf mesh_obj mesh_stl)
cogrsim_add_fuzzer(gltf ${meshes})
cogrsim_add_fuzzer(mesh ${meshes})
cogrsim_add_fuzzer(plugin ${sdk}/plugin/elf_symbols.cpp)
cogrsim_with_folder(${sdk}/policy files arrangement card card_check card_draft import import_gym
  import_isaac import_playground network onnx_model operators recurrent yaml_text)
cogrsim_add_fuzzer(policy ${files})
cogrsim_with_folder(${sdk}/recording files mcap/mcap_reader mcap/messages mcap/scene_messages
  recomputing recording)
cogrsim_add_fuzzer(recording ${files} ${sdk}/model/model_check.cpp ${sdk}/model/model_json.cpp
  ${sdk}/map/canvas.cpp ${sdk}/map/map.cpp ${sdk}/map/outline.cpp)
cogrsim_with_folder(${sdk}/signals files arithmetic condition parse signal terms)
cogrsim_with_folder(${sdk}/geometry geometry bounds convex gjk surface_distance triangles)
cogrsim_add_fuzzer(signal ${files} ${geometry} ${sdk}/core/units.cpp)
cogrsim_with_folder(${sdk}/simulation/snapshot files changes events file numbers resume)
cogrsim_add_fuzzer(snapshot ${files})

# The whole language but for its tables and the documents made of them.
get_target_property(all cogrsim_dsl_objects SOURCES)
set(files "")
foreach(source ${all})
  if(source MATCHES "^src/" AND NOT source MATCHES "/(codes|vocabulary_(events|mazes|sensors|table|tests)|write_)")
    list(APPEND files ${PROJECT_SOURCE_DIR}/dsl/${source})
  endif()
endforeach()
cogrsim_with_folder(${sdk}/geometry geometry bounds convex gjk overlap penetration triangles)
cogrsim_add_fuzzer(scene ${files} ${geometry})
foreach(name collada mjcf sdf srdf urdf xacro yaml)
  cogrsim_add_fuzzer(${name} ${files} ${geometry} ${CMAKE_CURRENT_SOURCE_DIR}/import_input.cpp)
endforeach()

if(TARGET cogrsim_share_lib)
  cogrsim_add_fuzzer(listing ${share}/listing_xml.cpp ${share}/store.cpp)
  cogrsim_with_folder(${share} files hash manifest rules zip_read)
  cogrsim_add_fuzzer(package ${files})
endif()
if(TARGET cogrsim_studio_lib)
  cogrsim_with_folder(${server} files http server token)
  cogrsim_with_folder(${PROJECT_SOURCE_DIR}/apps/cogrsim/net net http mailbox server)
  cogrsim_add_fuzzer(http ${files} ${net})
  cogrsim_with_folder(${server} files complete document document_file document_history
    document_json engine engine_carry engine_record engine_scene engine_watch mass protocol_check
    run_live run_recorded run_requests run_scenes run_viewers run_wire scene_json series sources studio)
  cogrsim_add_fuzzer(requests ${files})
endif()
