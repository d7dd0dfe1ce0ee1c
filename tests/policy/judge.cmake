# Networks evaluated by ONNX Runtime from npm, see judge/judge.mjs: our own, or those of FILES (cards and ONNX
# files), whose robots run on BACKEND. Says "skipped:" where there is no node or npm, or no registry.
find_program(NODE node)
find_program(NPM npm)
if(NOT NODE OR NOT NPM)
  message("skipped: node and npm are not installed; with them ONNX Runtime would evaluate networks")
  return()
endif()
file(MAKE_DIRECTORY "${MODULES}")
foreach(file package.json package-lock.json judge.mjs)
  configure_file("${SOURCE_DIR}/judge/${file}" "${MODULES}/${file}" COPYONLY)
endforeach()
if(NOT EXISTS "${MODULES}/node_modules/.package-lock.json"
   OR "${SOURCE_DIR}/judge/package-lock.json" IS_NEWER_THAN "${MODULES}/node_modules/.package-lock.json")
  # Its script after the installation would only fetch CUDA.
  execute_process(COMMAND ${NPM} ci --ignore-scripts --no-audit --no-fund WORKING_DIRECTORY "${MODULES}"
    RESULT_VARIABLE status OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(NOT status EQUAL 0)
    message("skipped: npm could not install onnxruntime-node\n${output}")
    return()
  endif()
endif()
# Networks of an earlier call would be judged, too.
file(REMOVE_RECURSE "${WORK_DIR}")
file(MAKE_DIRECTORY "${WORK_DIR}")
foreach(command "${WRITER};${BACKEND};${FILES}" "${NODE};${MODULES}/judge.mjs")
  execute_process(COMMAND ${command} WORKING_DIRECTORY "${WORK_DIR}" RESULT_VARIABLE status)
  if(NOT status EQUAL 0)
    list(GET command 0 program)
    message(FATAL_ERROR "${program}: exit status ${status}")
  endif()
endforeach()
