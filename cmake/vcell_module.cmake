# One module, one static library: vcell_module(name [BESIDE_JOINED] [TOGETHER count] SOURCES ... [DEPENDS modules ...]).
# The target is vcell_<name> (vcell::<name> for users), the archive libvcell_<name>.a. Headers lie beside
# the sources; <vcell/module/header.hpp> finds them in the build tree as it does installed. BESIDE_JOINED: it is no part
# of libvcell.a, which is what it links where it is installed. TOGETHER: how many sources are compiled at a time, 8 if it
# is left out.
function(vcell_module name)
  cmake_parse_arguments(ARG "BESIDE_JOINED" "TOGETHER" "SOURCES;DEPENDS" ${ARGN})
  if(NOT ARG_TOGETHER)
    set(ARG_TOGETHER 8)
  endif()
  add_library(vcell_${name} STATIC ${ARG_SOURCES})
  add_library(vcell::${name} ALIAS vcell_${name})
  set_target_properties(vcell_${name} PROPERTIES EXPORT_NAME ${name})
  vcell_usage(vcell_${name})
  vcell_together(vcell_${name} ${ARG_TOGETHER})
  if(name STREQUAL "core")
    target_precompile_headers(vcell_core PRIVATE ${vcell_precompiled_headers})
  else()
    target_precompile_headers(vcell_${name} REUSE_FROM vcell_core)
  endif()
  if(ARG_BESIDE_JOINED)
    list(TRANSFORM ARG_DEPENDS REPLACE "(.+)" "$<BUILD_INTERFACE:vcell_\\1>" OUTPUT_VARIABLE depends)
    list(APPEND depends $<INSTALL_INTERFACE:vcell::vcell>)
  else()
    list(TRANSFORM ARG_DEPENDS PREPEND vcell_ OUTPUT_VARIABLE depends)
    set_property(GLOBAL APPEND PROPERTY VCELL_MODULES vcell_${name})
  endif()
  target_link_libraries(vcell_${name} PUBLIC ${depends})

  cmake_path(RELATIVE_PATH CMAKE_CURRENT_SOURCE_DIR BASE_DIRECTORY ${vcell_SOURCE_DIR} OUTPUT_VARIABLE folder)
  set(link ${vcell_BINARY_DIR}/include/vcell/${folder})
  if(NOT EXISTS ${link})  # a module inside another's folder is there already
    file(CREATE_LINK ${CMAKE_CURRENT_SOURCE_DIR} ${link} SYMBOLIC)
  endif()
endfunction()

# With VCELL_UNITY so many of the target's sources are compiled at a time, so names in their anonymous namespaces must
# differ, and a template there that takes anything must not have the name of a function in a header: it would hide that
# one from the sources behind.
function(vcell_together target count)
  if(NOT VCELL_UNITY OR count LESS 2)
    return()
  endif()
  set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE ${count})
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    # A source that another one includes looks like a header to GCC, which should use no anonymous namespace. What a
    # unit may grow by when functions are inlined is for one source: with no more than that balls over a plane take 12 %
    # longer.
    target_compile_options(${target} PRIVATE -Wno-subobject-linkage --param=large-unit-insns=80000)
  endif()
endfunction()

# What nearly every file of ours includes, or pays for through a header that does, is parsed once: number types and
# matrices are most of a file's compile time.
set(vcell_precompiled_headers <algorithm> <array> <cmath> <functional> <map> <optional> <span> <string> <variant>
  <vector> <Eigen/Core> <Eigen/Geometry> <Eigen/LU> <boost/multiprecision/cpp_bin_float.hpp>
  <boost/multiprecision/cpp_int.hpp>)

# libvcell.a: the objects of all modules declared so far in one archive; target vcell::vcell. Leaves
# the modules' targets in vcell_joined_modules.
function(vcell_joined_library)
  get_property(modules GLOBAL PROPERTY VCELL_MODULES)
  add_library(vcell STATIC)
  add_library(vcell::vcell ALIAS vcell)
  foreach(module IN LISTS modules)
    target_sources(vcell PRIVATE $<TARGET_OBJECTS:${module}>)
  endforeach()
  set_target_properties(vcell PROPERTIES LINKER_LANGUAGE CXX)
  vcell_usage(vcell)
  set(vcell_joined_modules ${modules} PARENT_SCOPE)
endfunction()

# What compiling against any of our libraries takes.
function(vcell_usage target)
  target_compile_features(${target} PUBLIC cxx_std_20)
  # Contraction would break the error bounds of the predicates' first rung; the interval operations
  # are inline, so users need the flag too.
  target_compile_options(${target} PUBLIC -ffp-contract=off PRIVATE -fno-math-errno -fno-trapping-math)
  # With AVX Eigen would align vectors of four doubles to 32 bytes, and a program built for its own machine
  # would lay out cells otherwise than the library.
  target_compile_definitions(${target} PUBLIC EIGEN_MAX_STATIC_ALIGN_BYTES=16)
  target_include_directories(${target} PUBLIC $<BUILD_INTERFACE:${vcell_BINARY_DIR}/include>)
  if(VCELL_INSTALL)
    target_include_directories(${target} PUBLIC $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
  endif()
  target_link_libraries(${target} PUBLIC Eigen3::Eigen Boost::headers)
  if(UNIX)
    target_link_options(${target} PUBLIC -pthread)  # whole diagrams; nothing where the C library has threads
  endif()
endfunction()

# Warnings of everything we compile; a project that includes vcell keeps its own.
function(vcell_warnings)
  add_compile_options(-Wall -Wextra -Wpedantic -Wnon-virtual-dtor)
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    # The last five see, after inlining, errors in std::string, Eigen and Boost.Multiprecision that are not
    # there (GCC bug 105651 and its kin).
    add_compile_options(-Wshadow=local -Wno-restrict -Wno-array-bounds -Wno-stringop-overread
      -Wno-stringop-overflow -Wno-maybe-uninitialized)
  endif()
  if(VCELL_WERROR)
    add_compile_options(-Werror)
  endif()
endfunction()
