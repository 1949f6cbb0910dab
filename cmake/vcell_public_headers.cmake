# What users include: these umbrella headers, and whatever headers of ours those include. All other headers stay in the
# source tree.
set(vcell_umbrella_headers vcell.hpp core/core.hpp core/solver/roots/solver.hpp
  primitives/primitives.hpp arrangement/arrangement.hpp envelope/envelope.hpp)

# The umbrella headers given, with all that they include, relative to the source folder.
function(vcell_included_headers result)
  set(found)
  set(waiting ${ARGN})
  while(waiting)
    list(POP_FRONT waiting header)
    if(header IN_LIST found)
      continue()
    endif()
    list(APPEND found ${header})
    set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${vcell_SOURCE_DIR}/${header})
    cmake_path(GET header PARENT_PATH folder)
    file(STRINGS ${vcell_SOURCE_DIR}/${header} lines REGEX "^#include \".+\\.hpp\"")
    foreach(line IN LISTS lines)
      string(REGEX REPLACE "^#include \"([^\"]+)\".*" "\\1" included "${line}")
      cmake_path(APPEND folder "${included}" OUTPUT_VARIABLE path)
      cmake_path(NORMAL_PATH path)
      list(APPEND waiting ${path})
    endforeach()
  endwhile()
  set(${result} ${found} PARENT_SCOPE)
endfunction()
