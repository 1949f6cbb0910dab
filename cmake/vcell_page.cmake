# Writes OUT, a source file with the texts of io/pictures/page_parts.hpp:
#   cmake -DOUT=... -DTHREE=... (empty: none) -DPAGE=io/pictures/page -P vcell_page.cmake
# String literals in pieces are what every compiler takes, and need no language but C++.

# The C++ literal of a text, in `result`. No text of ours holds the delimiter.
function(as_literal text result)
  set(literal "")
  string(LENGTH "${text}" length)
  set(at 0)
  while(at LESS length)
    string(SUBSTRING "${text}" ${at} 12000 piece)
    string(APPEND literal "R\"vcell~(${piece})vcell~\"\n")
    math(EXPR at "${at} + 12000")
  endwhile()
  if(literal STREQUAL "")
    set(literal "\"\"")
  endif()
  set(${result} "${literal}" PARENT_SCOPE)
endfunction()

function(read_part path result)
  file(READ "${path}" text)
  set(${result} "${text}" PARENT_SCOPE)
endfunction()

set(three "")
if(THREE)
  read_part("${THREE}" three)
endif()
read_part("${PAGE}/page.css" style)
read_part("${PAGE}/page.html" body)
set(script "")
foreach(file orbit solids view panel)  # each uses those before it
  read_part("${PAGE}/${file}.js" text)
  string(APPEND script "${text}")
endforeach()

set(source "#include \"page_parts.hpp\"\n\nnamespace vcell::page_parts {\n\n")
foreach(part three style body script)
  as_literal("${${part}}" literal)
  string(APPEND source "const std::string_view ${part} =\n${literal};\n\n")
endforeach()
string(APPEND source "}  // namespace vcell::page_parts\n")
file(WRITE "${OUT}" "${source}")
