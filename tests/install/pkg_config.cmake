# Compiles and runs the example of vcell::io with the flags that pkg-config gives. Headers that no umbrella header
# includes are not there.
include(${CMAKE_CURRENT_LIST_DIR}/run_example.cmake)
find_program(PKG_CONFIG pkg-config REQUIRED)
set(ENV{PKG_CONFIG_PATH} ${PREFIX}/${LIBDIR}/pkgconfig)
separate_arguments(FLAGS UNIX_COMMAND "${FLAGS}")
file(REMOVE_RECURSE ${BUILD})
file(MAKE_DIRECTORY ${BUILD})

function(flags_of package into)
  execute_process(COMMAND ${PKG_CONFIG} --cflags --libs ${package}
    OUTPUT_VARIABLE usage OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
  separate_arguments(usage UNIX_COMMAND "${usage}")
  set(${into} ${usage} PARENT_SCOPE)
endfunction()
function(compile source)
  execute_process(COMMAND ${COMPILER} -std=c++20 ${FLAGS} ${source} ${usage} ${ARGN} COMMAND_ERROR_IS_FATAL ANY)
endfunction()
flags_of(vcell-io usage)
compile(${EXAMPLES}/scene_to_files.cpp -o ${BUILD}/scene_to_files)
compile(${SOURCE}/headers.cpp -E -o ${BUILD}/headers.ii)  # tests/envelope compiles them
run_example(${BUILD}/scene_to_files)

# The library alone has the same flags without what reads and writes, which formats numbers.
flags_of(vcell alone)
list(REMOVE_ITEM usage -lvcell_io -lfmt)
if(NOT alone STREQUAL usage)
  message(FATAL_ERROR "the flags of vcell are ${alone}, of vcell-io but for its own library ${usage}")
endif()

foreach(internal IN ITEMS io/files/json_reader.hpp io/check/krawczyk.hpp envelope/proofs/mixed_piece.hpp)
  if(EXISTS ${PREFIX}/include/vcell/${internal})
    message(FATAL_ERROR "${internal} is no user's concern, and installed")
  endif()
endforeach()
