# Installs the libraries and the program, with what find_package(vcell) and pkg-config need.
include(CMakePackageConfigHelpers)
include(cmake/vcell_public_headers.cmake)
set(CMAKE_INSTALL_DEFAULT_COMPONENT_NAME dev)

install(TARGETS vcell ${vcell_joined_modules} EXPORT vcellTargets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
if(TARGET vcell_io)
  list(APPEND vcell_umbrella_headers io.hpp)
  install(TARGETS vcell_io EXPORT vcellIoTargets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
endif()
vcell_included_headers(headers ${vcell_umbrella_headers})
foreach(header IN LISTS headers)
  cmake_path(GET header PARENT_PATH folder)
  install(FILES ${header} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/vcell/${folder})
endforeach()
if(TARGET vcell_program)
  install(TARGETS vcell_program RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT program)
endif()

set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/vcell)
install(EXPORT vcellTargets NAMESPACE vcell:: DESTINATION ${package_dir})
if(TARGET vcell_io)
  install(EXPORT vcellIoTargets NAMESPACE vcell:: DESTINATION ${package_dir})
endif()
configure_package_config_file(cmake/vcellConfig.cmake.in ${PROJECT_BINARY_DIR}/vcellConfig.cmake
                              INSTALL_DESTINATION ${package_dir})
# Before 1.0 a minor version may break users.
write_basic_package_version_file(${PROJECT_BINARY_DIR}/vcellConfigVersion.cmake
                                 COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/vcellConfig.cmake ${PROJECT_BINARY_DIR}/vcellConfigVersion.cmake
        DESTINATION ${package_dir})

# The prefix is found from the file's own place, so that the installed tree may be moved.
set(pkgconfig_dir ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
cmake_path(RELATIVE_PATH CMAKE_INSTALL_PREFIX BASE_DIRECTORY ${CMAKE_INSTALL_PREFIX}/${pkgconfig_dir}
           OUTPUT_VARIABLE VCELL_PC_PREFIX)
set(pc_files vcell)
if(TARGET vcell_io)
  list(APPEND pc_files vcell-io)
endif()
foreach(name IN LISTS pc_files)
  configure_file(cmake/${name}.pc.in ${PROJECT_BINARY_DIR}/${name}.pc @ONLY)
  install(FILES ${PROJECT_BINARY_DIR}/${name}.pc DESTINATION ${pkgconfig_dir})
endforeach()
