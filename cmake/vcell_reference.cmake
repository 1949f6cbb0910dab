# The reference of the public headers (docs/api.dox is its first page): target docs, where Doxygen is installed.
find_program(VCELL_DOXYGEN NAMES doxygen DOC "Doxygen 1.9 or later, for the target docs")
mark_as_advanced(VCELL_DOXYGEN)
if(NOT VCELL_DOXYGEN)
  return()
endif()

include(cmake/vcell_public_headers.cmake)
vcell_included_headers(public_headers ${vcell_umbrella_headers} io.hpp)
set(vcell_reference_input docs/api.dox)
foreach(header IN LISTS public_headers)
  string(APPEND vcell_reference_input " \\\n  ${header}")
endforeach()
set(vcell_reference_folder ${PROJECT_BINARY_DIR}/reference)
file(MAKE_DIRECTORY ${vcell_reference_folder})
configure_file(docs/Doxyfile.in ${PROJECT_BINARY_DIR}/Doxyfile @ONLY)
add_custom_target(docs COMMAND ${VCELL_DOXYGEN} ${PROJECT_BINARY_DIR}/Doxyfile
  COMMAND ${CMAKE_COMMAND} -E echo "${vcell_reference_folder}/html/index.html"
  WORKING_DIRECTORY ${PROJECT_SOURCE_DIR} VERBATIM)
