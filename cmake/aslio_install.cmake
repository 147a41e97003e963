# The export set: the rooms add their targets to it (framework/, plugins/, tools/aslio).
include(CMakePackageConfigHelpers)
set(aslio_package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/aslio)
configure_package_config_file(${CMAKE_CURRENT_SOURCE_DIR}/cmake/aslio-config.cmake.in
                              ${CMAKE_CURRENT_BINARY_DIR}/aslio-config.cmake INSTALL_DESTINATION ${aslio_package_dir})
# Until 1.0 a minor version may break the interface.
write_basic_package_version_file(${CMAKE_CURRENT_BINARY_DIR}/aslio-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/aslio-config.cmake ${CMAKE_CURRENT_BINARY_DIR}/aslio-config-version.cmake
        DESTINATION ${aslio_package_dir})
install(EXPORT aslio-targets NAMESPACE aslio:: DESTINATION ${aslio_package_dir})
install(DIRECTORY ${CMAKE_CURRENT_SOURCE_DIR}/configs DESTINATION ${CMAKE_INSTALL_DATADIR}/aslio)
