# Is every source file as clang-format and .clang-format would write it?
file(GLOB_RECURSE files ${SOURCE}/core/*.?pp ${SOURCE}/primitives/*.?pp ${SOURCE}/arrangement/*.?pp
  ${SOURCE}/envelope/*.?pp ${SOURCE}/io/*.?pp ${SOURCE}/apps/*.?pp ${SOURCE}/mpi/*.?pp ${SOURCE}/bench/*.?pp ${SOURCE}/examples/*.?pp
  ${SOURCE}/tests/*.?pp ${SOURCE}/python/*.?pp)
execute_process(COMMAND ${CLANG_FORMAT} --dry-run -Werror ${files} RESULT_VARIABLE status)
if(NOT status EQUAL 0)
  message(FATAL_ERROR "clang-format -i mends these files")
endif()
