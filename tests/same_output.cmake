# Fails unless PROGRAM with ARGUMENT prints exactly the text of FILE.
execute_process(COMMAND ${PROGRAM} ${ARGUMENT} OUTPUT_VARIABLE output RESULT_VARIABLE status)
if(NOT status EQUAL 0)
  message(FATAL_ERROR "${PROGRAM} failed: ${status}")
endif()
file(READ ${FILE} expected)
if(NOT output STREQUAL expected)
  message(FATAL_ERROR "${FILE} is not what ${PROGRAM} prints; run it again")
endif()
