# Runs a transport experiment with a single box and looks whether all of it is there.
include(${CMAKE_CURRENT_LIST_DIR}/pictures.cmake)
file(REMOVE_RECURSE ${FOLDER})
set(ENV{COGRSIM} ${PROGRAM})
execute_process(COMMAND ${EXPERIMENT} --seeds 1 --backends bullet --set boxes=1 ${FOLDER}
  RESULT_VARIABLE status OUTPUT_VARIABLE said ERROR_VARIABLE said)
if(NOT status EQUAL 0)
  message(FATAL_ERROR "the experiment failed (${status}):\n${said}")
endif()
check_pictures(between in_zone times nearest bullet/map bullet/end bullet/figures/paths)
file(READ ${FOLDER}/summary.txt summary)
if(NOT summary MATCHES "bullet +1 +100.0%")
  message(FATAL_ERROR "the box was not delivered:\n${summary}")
endif()
# Being recorded changes nothing: the same run of the sweep was not.
execute_process(COMMAND ${PROGRAM} run ${SCENE} --set boxes=1 --seed 1 --backend bullet --json -
    --record ${FOLDER}/again.mcap
  RESULT_VARIABLE status OUTPUT_VARIABLE result ERROR_VARIABLE said)
if(NOT status EQUAL 0)
  message(FATAL_ERROR "the run failed (${status}):\n${said}")
endif()
string(REGEX MATCH "\"state_hash\": *\"([0-9a-f]+)\"" found "${result}")
file(READ ${FOLDER}/sweep/results.csv table)
if(NOT found OR NOT table MATCHES "${CMAKE_MATCH_1}")
  message(FATAL_ERROR "recorded, the run ends differently: ${found}\n${table}")
endif()
