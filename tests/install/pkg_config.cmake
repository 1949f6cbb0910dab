# Compiles and runs the consumer and the example of vcell::io with the flags that pkg-config gives. Headers that no
# umbrella header includes are not there.
include(${CMAKE_CURRENT_LIST_DIR}/run_example.cmake)
find_program(PKG_CONFIG pkg-config REQUIRED)
set(ENV{PKG_CONFIG_PATH} ${PREFIX}/${LIBDIR}/pkgconfig)
separate_arguments(FLAGS UNIX_COMMAND "${FLAGS}")
file(REMOVE_RECURSE ${BUILD})
file(MAKE_DIRECTORY ${BUILD})

function(compile package source)
  execute_process(COMMAND ${PKG_CONFIG} --cflags --libs ${package}
    OUTPUT_VARIABLE usage OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
  separate_arguments(usage UNIX_COMMAND "${usage}")
  execute_process(COMMAND ${COMPILER} -std=c++20 ${FLAGS} ${source} ${usage} ${ARGN} COMMAND_ERROR_IS_FATAL ANY)
endfunction()
compile(vcell ${SOURCE}/consumer.cpp -o ${BUILD}/consumer)
compile(vcell-io ${EXAMPLES}/scene_to_files.cpp -o ${BUILD}/scene_to_files)
compile(vcell-io ${SOURCE}/headers.cpp -E -o ${BUILD}/headers.ii)  # tests/envelope compiles them
execute_process(COMMAND ${BUILD}/consumer COMMAND_ERROR_IS_FATAL ANY)
run_example(${BUILD}/scene_to_files)

foreach(internal IN ITEMS io/files/json_reader.hpp io/check/krawczyk.hpp envelope/proofs/mixed_piece.hpp)
  if(EXISTS ${PREFIX}/include/vcell/${internal})
    message(FATAL_ERROR "${internal} is no user's concern, and installed")
  endif()
endforeach()
