# Every public header reaches core/platform.hpp: each of the others includes one of ours, and includes have no cycle.
file(GLOB_RECURSE headers RELATIVE ${SOURCE} ${SOURCE}/core/*.hpp ${SOURCE}/primitives/*.hpp
  ${SOURCE}/arrangement/*.hpp ${SOURCE}/envelope/*.hpp)
foreach(header IN LISTS headers ITEMS vcell.hpp)
  file(READ ${SOURCE}/${header} text)
  if(NOT header STREQUAL "core/platform.hpp" AND NOT text MATCHES "\n#include \"")
    message(SEND_ERROR "${header} does not include core/platform.hpp")
  endif()
endforeach()
