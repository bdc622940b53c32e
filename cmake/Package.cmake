# `cmake --install`: headers, libraries and a package config, so that find_package(kinetostat) works.
include(CMakePackageConfigHelpers)

set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/kinetostat)
configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/kinetostatConfig.cmake.in
  ${PROJECT_BINARY_DIR}/kinetostatConfig.cmake INSTALL_DESTINATION ${package_dir})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/kinetostatConfigVersion.cmake
  COMPATIBILITY SameMinorVersion)
install(EXPORT kinetostat NAMESPACE kinetostat:: DESTINATION ${package_dir}
  FILE kinetostatTargets.cmake COMPONENT development)
install(FILES
  ${PROJECT_BINARY_DIR}/kinetostatConfig.cmake
  ${PROJECT_BINARY_DIR}/kinetostatConfigVersion.cmake
  DESTINATION ${package_dir} COMPONENT development)

if(KINETOSTAT_BUILD_APPS)
  include(Debian)
endif()
