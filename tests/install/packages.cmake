# The program's Debian package as a user meets it: unpacked into FOLDER it runs, has its manual, and bash, zsh
# and fish, of these what is there, complete its commands and options.
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
foreach(completion IN ITEMS zsh/vendor-completions/_vcell zsh/site-functions/_vcell
                            fish/vendor_completions.d/vcell.fish)
  if(NOT EXISTS ${FOLDER}/root/usr/share/${completion})
    message(FATAL_ERROR "the package lacks ${completion}")
  endif()
endforeach()
set(ENV{PATH} "${FOLDER}/root/usr/bin:$ENV{PATH}")
find_program(ZSH NAMES zsh)
if(ZSH)
  # What zsh offers before it compares it with what was typed.
  execute_process(
    COMMAND ${ZSH} -f -c "
      compadd() { print -r -- \"\$@\" }
      _describe() { print -r -- \"\${(P)@[-1]}\" }
      words=(vcell dia) CURRENT=2; . '${FOLDER}/root/usr/share/zsh/vendor-completions/_vcell'
      words=(vcell diagram --per) CURRENT=3; . '${FOLDER}/root/usr/share/zsh/vendor-completions/_vcell'"
    OUTPUT_VARIABLE completed COMMAND_ERROR_IS_FATAL ANY)
  if(NOT completed MATCHES " diagram:the cells of all objects\n.* --periodic ")
    message(FATAL_ERROR "zsh completed to ${completed}")
  endif()
endif()
find_program(FISH NAMES fish)
if(FISH)
  execute_process(
    COMMAND ${FISH} --no-config -c "
      source '${FOLDER}/root/usr/share/fish/vendor_completions.d/vcell.fish'
      complete -C 'vcell dia'; complete -C 'vcell diagram --per'"
    OUTPUT_VARIABLE completed COMMAND_ERROR_IS_FATAL ANY)
  if(NOT completed STREQUAL "diagram\tthe cells of all objects\n--periodic\n")
    message(FATAL_ERROR "fish completed to ${completed}")
  endif()
endif()
