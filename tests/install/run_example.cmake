# run_example(PROGRAM): the example of vcell::io on a scene, with what it says and what it writes.
function(run_example program)
  set(folder ${BUILD}/example)
  file(MAKE_DIRECTORY ${folder})
  execute_process(COMMAND ${program} ${EXAMPLES}/scenes/figure12.json ${folder}
    OUTPUT_VARIABLE said COMMAND_ERROR_IS_FATAL ANY)
  message("${said}")
  # The numbers are those of `vcell measure` on the scene; the volumes of all cells add up to the box.
  set(number "21 faces, volume 79\\.2022, proved; the middle is nearest to [0-9]+; all cells fill 1 of the box")
  if(NOT said MATCHES "${number}")
    message(FATAL_ERROR "the example says: ${said}")
  endif()
  foreach(name IN ITEMS cell.json cell.obj)
    if(NOT EXISTS ${folder}/${name})
      message(FATAL_ERROR "the example does not write ${name}")
    endif()
  endforeach()
endfunction()
