# Debian packages: `cpack` in the build folder makes vcell, the program with its manual, completion for shells and scenes
# to start from; libvcell-dev, the libraries; and, where the Python module is built for Debian's own Python, python3-vcell.
# Manual pages are what --help prints, so that they say the same.
if(TARGET vcell_program)
  install(FILES apps/completion/vcell DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions
          COMPONENT program)
  # Debian's zsh looks into the first of these folders below /usr; others', and Debian's below /usr/local, into the second.
  foreach(folder IN ITEMS vendor-completions site-functions)
    install(FILES apps/completion/_vcell DESTINATION ${CMAKE_INSTALL_DATADIR}/zsh/${folder} COMPONENT program)
  endforeach()
  install(FILES apps/completion/vcell.fish DESTINATION ${CMAKE_INSTALL_DATADIR}/fish/vendor_completions.d
          COMPONENT program)
  find_program(VCELL_HELP2MAN NAMES help2man)
  if(VCELL_HELP2MAN)
    set(pages vcell)
    foreach(verb IN ITEMS compute draw query measure check refine diagram)
      list(APPEND pages vcell-${verb})
    endforeach()
    foreach(page IN LISTS pages)
      set(file ${PROJECT_BINARY_DIR}/man/${page}.1)
      add_custom_command(OUTPUT ${file}
        COMMAND ${CMAKE_COMMAND} -DHELP2MAN=${VCELL_HELP2MAN} -DPROGRAM=$<TARGET_FILE:vcell_program> -DPAGE=${page}
          -DVERSION=${PROJECT_VERSION} -DOUT=${file} -P ${PROJECT_SOURCE_DIR}/cmake/man_page.cmake
        DEPENDS vcell_program cmake/man_page.cmake VERBATIM)
      list(APPEND man_files ${file})
    endforeach()
    add_custom_target(vcell_man ALL DEPENDS ${man_files})
    install(FILES ${man_files} DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 COMPONENT program)
  endif()
endif()

# What Debian's packages have beside.
function(vcell_package_documents package component)
  install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DATAROOTDIR}/doc/${package} RENAME copyright
          COMPONENT ${component} EXCLUDE_FROM_ALL)
endfunction()
vcell_package_documents(vcell program)
vcell_package_documents(libvcell-dev dev)
vcell_package_documents(python3-vcell debian_python)
set(examples ${CMAKE_INSTALL_DATAROOTDIR}/doc/vcell/examples)
install(DIRECTORY examples/scenes DESTINATION ${examples} COMPONENT program EXCLUDE_FROM_ALL)

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_VENDOR "the vcell developers")
set(CPACK_PACKAGE_CONTACT "the vcell developers")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY ${PROJECT_DESCRIPTION})
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_ALL program dev)
get_property(python_depends GLOBAL PROPERTY vcell_debian_python)
if(python_depends)
  list(APPEND CPACK_COMPONENTS_ALL debian_python)
endif()
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_NAME vcell)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SHLIBDEPS ON)
set(CPACK_COMPONENT_PROGRAM_DESCRIPTION
    "Computes the Voronoi cell of a plane, a sphere or a cylinder among others, and whole diagrams of balls.")
set(CPACK_DEBIAN_DEV_PACKAGE_NAME libvcell-dev)
set(CPACK_DEBIAN_DEV_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEV_PACKAGE_DEPENDS "libeigen3-dev, libboost-dev, libfmt-dev")
set(CPACK_COMPONENT_DEV_DESCRIPTION "Static libraries and headers: Voronoi cells of planes, spheres and cylinders.")
set(CPACK_DEBIAN_DEBIAN_PYTHON_PACKAGE_NAME python3-vcell)
set(CPACK_DEBIAN_DEBIAN_PYTHON_PACKAGE_SECTION python)
set(CPACK_DEBIAN_DEBIAN_PYTHON_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_DEBIAN_PYTHON_PACKAGE_DEPENDS "${python_depends}")
set(CPACK_COMPONENT_DEBIAN_PYTHON_DESCRIPTION
    "Python module: cells of planes, spheres and cylinders as numpy arrays, and whole diagrams.")
include(CPack)
