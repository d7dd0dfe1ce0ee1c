# Runs the seeker's scene with one steering and sees where it ends: within 10 cm of its goal at
# (1.5, 1) m, which is the largest distance at which one of them calls itself arrived.
execute_process(COMMAND "${CLI}" run "${SCENE}" --backend ${BACKEND} --set steering=${STEERING}
    --plugin-path "${PLUGINS}" --json -
  OUTPUT_VARIABLE json ERROR_VARIABLE errors RESULT_VARIABLE exit_status)
if(NOT exit_status EQUAL 0)
  message(FATAL_ERROR "exit status ${exit_status}\n${errors}${json}")
endif()
string(JSON x GET "${json}" bodies robot.chassis position 0)
string(JSON y GET "${json}" bodies robot.chassis position 1)
message("${STEERING} on ${BACKEND}: x = ${x} m, y = ${y} m")
if(x LESS 1.40 OR x GREATER 1.60 OR y LESS 0.90 OR y GREATER 1.10)
  message(SEND_ERROR "it is not at its goal")
endif()
