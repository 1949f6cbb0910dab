# Compiles HEADER with FLAGS: the compiler must stop with exactly one error, and that one MESSAGE.
# INCLUDES follow the compiler's own folders: /usr/include before them would leave #include_next without a successor.
set(includes)
foreach(folder IN LISTS INCLUDES)
  if(folder)
    list(APPEND includes -idirafter ${folder})
  endif()
endforeach()
execute_process(COMMAND ${COMPILER} ${FLAGS} ${includes} -fsyntax-only -x c++ ${HEADER}
  RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
if(result EQUAL 0)
  message(FATAL_ERROR "compiled with ${FLAGS}")
endif()
string(REGEX MATCHALL "error: " errors "${output}")
list(LENGTH errors count)
if(NOT count EQUAL 1 OR NOT output MATCHES "error: [^\n]*${MESSAGE}")
  message(FATAL_ERROR "${count} errors, expected one with \"${MESSAGE}\":\n${output}")
endif()
