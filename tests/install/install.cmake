# cmake -DBUILD=... -DPREFIX=... -P install.cmake: a fresh installation of the build tree in PREFIX.
file(REMOVE_RECURSE ${PREFIX})
execute_process(COMMAND ${CMAKE_COMMAND} --install ${BUILD} --prefix ${PREFIX} COMMAND_ERROR_IS_FATAL ANY)
