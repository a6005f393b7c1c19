include(CMakePackageConfigHelpers)
set(package_folder ${CMAKE_INSTALL_LIBDIR}/cmake/recede)
install(EXPORT recedeTargets NAMESPACE recede:: DESTINATION ${package_folder})
configure_package_config_file(cmake/recedeConfig.cmake.in ${PROJECT_BINARY_DIR}/recedeConfig.cmake
  INSTALL_DESTINATION ${package_folder})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/recedeConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/include/recede/version.h DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/recede)
install(FILES ${PROJECT_BINARY_DIR}/recedeConfig.cmake ${PROJECT_BINARY_DIR}/recedeConfigVersion.cmake
  cmake/OpenCascadeTarget.cmake cmake/OpenSubdivTarget.cmake
  DESTINATION ${package_folder})
