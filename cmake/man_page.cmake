# OUT: the manual page of the program, or of its command in PAGE (vcell-compute), by HELP2MAN from --help.
set(command ${PROGRAM})
set(name "Voronoi cells of planes, spheres and cylinders")
if(PAGE MATCHES "^vcell-(.+)$")
  set(verb ${CMAKE_MATCH_1})
  # help2man runs one program without arguments.
  get_filename_component(folder ${OUT} DIRECTORY)
  set(command ${folder}/${PAGE}.sh)
  file(WRITE ${command} "#!/bin/sh\nexec '${PROGRAM}' ${verb} \"$@\"\n")
  file(CHMOD ${command} PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE)
  execute_process(COMMAND ${PROGRAM} ${verb} --help OUTPUT_VARIABLE help COMMAND_ERROR_IS_FATAL ANY)
  string(REGEX MATCH "^[^\n]*" name "${help}")
endif()
execute_process(COMMAND ${HELP2MAN} --no-info --version-string=${VERSION} --name=${name} ${command}
                OUTPUT_VARIABLE page COMMAND_ERROR_IS_FATAL ANY)
# The title is the page's, and examples stay one a line.
string(REGEX REPLACE "\n(vcell [a-z]+ [^\n]*)" "\n.br\n\\1" page "${page}")
string(REGEX REPLACE "\\.TH [^ ]+ " ".TH ${PAGE} " page "${page}")
string(REPLACE "${PAGE}.sh" "${PAGE}" page "${page}")
file(WRITE ${OUT} "${page}")
