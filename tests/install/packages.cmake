# The program's Debian package as a user meets it: unpacked into FOLDER it runs, has its manual, and bash completes
# its commands and options.
file(REMOVE_RECURSE ${FOLDER})
file(MAKE_DIRECTORY ${FOLDER})
execute_process(COMMAND ${CPACK} -G DEB -D CPACK_COMPONENTS_ALL=program -D CPACK_PACKAGE_DIRECTORY=${FOLDER}
                  -D CPACK_DEBIAN_COMPRESSION_TYPE=gzip
                WORKING_DIRECTORY ${BUILD} OUTPUT_QUIET COMMAND_ERROR_IS_FATAL ANY)
file(GLOB package ${FOLDER}/vcell_*.deb)
execute_process(COMMAND dpkg-deb -f ${package} Depends OUTPUT_VARIABLE depends COMMAND_ERROR_IS_FATAL ANY)
if(NOT depends MATCHES "libstdc\\+\\+6")
  message(FATAL_ERROR "the package depends on ${depends}")
endif()
execute_process(COMMAND dpkg-deb -x ${package} ${FOLDER}/root COMMAND_ERROR_IS_FATAL ANY)
execute_process(COMMAND ${FOLDER}/root/usr/bin/vcell measure ${SCENE} OUTPUT_VARIABLE measures
                COMMAND_ERROR_IS_FATAL ANY)
if(NOT measures MATCHES "volume")
  message(FATAL_ERROR "the packaged program printed ${measures}")
endif()
file(GLOB pages ${FOLDER}/root/usr/share/man/man1/*.1*)
list(LENGTH pages count)
if(count LESS 8)
  message(FATAL_ERROR "manual pages: ${pages}")
endif()
# vcell dia<TAB>, then vcell diagram --per<TAB>
execute_process(
  COMMAND bash -c "
    PATH='${FOLDER}/root/usr/bin':$PATH
    . '${FOLDER}/root/usr/share/bash-completion/completions/vcell'
    COMP_WORDS=(vcell dia) COMP_CWORD=1; _vcell; echo \"\${COMPREPLY[@]}\"
    COMP_WORDS=(vcell diagram --per) COMP_CWORD=2; _vcell; echo \"\${COMPREPLY[@]}\""
  OUTPUT_VARIABLE completed COMMAND_ERROR_IS_FATAL ANY)
if(NOT completed STREQUAL "diagram\n--periodic\n")
  message(FATAL_ERROR "bash completed to ${completed}")
endif()
