# The preset `install` configures without the packages of tests, benches and examples, and offers none of them.
file(REMOVE_RECURSE ${BUILD})
execute_process(
  COMMAND ${CMAKE_COMMAND} -S ${VCELL} --preset install -B ${BUILD} -DCMAKE_CXX_COMPILER=${COMPILER}
    -DCMAKE_DISABLE_FIND_PACKAGE_doctest=ON -DCMAKE_DISABLE_FIND_PACKAGE_benchmark=ON
    -DCMAKE_DISABLE_FIND_PACKAGE_nlohmann_json=ON
  WORKING_DIRECTORY ${VCELL} COMMAND_ERROR_IS_FATAL ANY)
execute_process(COMMAND ${CMAKE_COMMAND} --build ${BUILD} --target help OUTPUT_VARIABLE targets COMMAND_ERROR_IS_FATAL ANY)
if(NOT targets MATCHES "vcell_program")
  message(FATAL_ERROR "no program among the targets")
endif()
if(targets MATCHES "test_core|bench_solver|cell_of_a_plane")
  message(FATAL_ERROR "tests, benches or examples among the targets")
endif()
