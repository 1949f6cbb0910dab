# Installs the libraries and the program, with what find_package(vcell) and pkg-config need.
include(CMakePackageConfigHelpers)
set(CMAKE_INSTALL_DEFAULT_COMPONENT_NAME dev)

install(TARGETS vcell ${vcell_joined_modules} EXPORT vcellTargets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(FILES vcell.hpp DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/vcell)
foreach(folder IN LISTS vcell_module_folders)
  install(DIRECTORY ${folder}/ DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/vcell/${folder}
          FILES_MATCHING PATTERN "*.hpp")
endforeach()
if(TARGET vcell_program)
  install(TARGETS vcell_program RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT program)
endif()

set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/vcell)
install(EXPORT vcellTargets NAMESPACE vcell:: DESTINATION ${package_dir})
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
configure_file(cmake/vcell.pc.in ${PROJECT_BINARY_DIR}/vcell.pc @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/vcell.pc DESTINATION ${pkgconfig_dir})
