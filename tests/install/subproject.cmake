# Configures the parent project with vcell inside; once, for both ways are the same there, builds its program and
# runs it.
file(REMOVE_RECURSE ${BUILD})
set(absent)
foreach(package IN ITEMS doctest benchmark nlohmann_json CLI11 fmt)
  list(APPEND absent -DCMAKE_DISABLE_FIND_PACKAGE_${package}=ON)
endforeach()
execute_process(
  COMMAND ${CMAKE_COMMAND} -S ${SOURCE} -B ${BUILD} -G ${GENERATOR} -DVCELL=${VCELL} -DWAY=${WAY}
    -DCMAKE_CXX_COMPILER=${COMPILER} -DCMAKE_DISABLE_PRECOMPILE_HEADERS=ON ${absent}
  COMMAND_ERROR_IS_FATAL ANY)
if(WAY STREQUAL "add_subdirectory")
  execute_process(COMMAND ${CMAKE_COMMAND} --build ${BUILD} --target app COMMAND_ERROR_IS_FATAL ANY)
  execute_process(COMMAND ${BUILD}/app COMMAND_ERROR_IS_FATAL ANY)
endif()
