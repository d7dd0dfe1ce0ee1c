# Recordings: the MCAP container with zstd, the schemas compiled by protoc and carried as bytes.
find_package(Threads REQUIRED)
find_package(ZLIB REQUIRED)
find_package(zstd REQUIRED)
find_program(PROTOC_PROGRAM protoc REQUIRED)
find_path(PROTOZERO_INCLUDE protozero/pbf_writer.hpp REQUIRED)

set(here ${CMAKE_CURRENT_LIST_DIR})
set(made ${CMAKE_CURRENT_BINARY_DIR}/recording)
file(MAKE_DIRECTORY ${made})
foreach(name cogrsim foxglove)
  add_custom_command(OUTPUT ${made}/${name}.bin
    COMMAND ${PROTOC_PROGRAM} --proto_path=${here}/proto --include_imports
      --descriptor_set_out=${made}/${name}.bin ${here}/proto/${name}.proto
    DEPENDS ${here}/proto/${name}.proto VERBATIM)
endforeach()
add_custom_command(OUTPUT ${made}/schemas.cpp
  COMMAND ${CMAKE_COMMAND} -DOUT=${made}/schemas.cpp
    "-DIN=cogrsim=${made}/cogrsim.bin;foxglove=${made}/foxglove.bin" -P ${here}/proto/embed.cmake
  DEPENDS ${made}/cogrsim.bin ${made}/foxglove.bin ${here}/proto/embed.cmake VERBATIM)

target_sources(cogrsim_sdk PRIVATE
  ${here}/mcap/mcap_reader.cpp
  ${here}/mcap/mcap_writer.cpp
  ${here}/mcap/messages.cpp
  ${here}/recomputing.cpp
  ${here}/recorder.cpp
  ${here}/frame_tables.cpp
  ${here}/recording.cpp
  ${here}/recording_file.cpp
  ${here}/run_encoder.cpp
  ${here}/run_queue.cpp
  ${here}/run_stream.cpp
  ${here}/run_writer.cpp
  ${here}/mcap/scene_messages.cpp
  ${made}/schemas.cpp
  ${here}/ros2/ros2_types.cpp
  ${here}/ros2/ros2_writer.cpp)
set_property(SOURCE src/physics/provenance.cpp ${here}/recorder.cpp ${here}/ros2/ros2_writer.cpp ${here}/run_writer.cpp APPEND PROPERTY
  COMPILE_DEFINITIONS COGRSIM_VERSION="${PROJECT_VERSION}")
target_include_directories(cogrsim_sdk SYSTEM PRIVATE ${PROTOZERO_INCLUDE})
target_link_libraries(cogrsim_sdk
  PRIVATE Threads::Threads ZLIB::ZLIB zstd::libzstd_shared)
