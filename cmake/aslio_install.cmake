# The export set: the modules add their targets to it (framework/, plugins/, tools/aslio).
include(CMakePackageConfigHelpers)
set(aslio_package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/aslio)
set(aslio_data_dir ${CMAKE_INSTALL_DATADIR}/aslio)
configure_package_config_file(${CMAKE_CURRENT_SOURCE_DIR}/cmake/aslio-config.cmake.in
                              ${CMAKE_CURRENT_BINARY_DIR}/aslio-config.cmake INSTALL_DESTINATION ${aslio_package_dir}
                              PATH_VARS aslio_data_dir)
# Until 1.0 a minor version may break the interface.
write_basic_package_version_file(${CMAKE_CURRENT_BINARY_DIR}/aslio-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/aslio-config.cmake ${CMAKE_CURRENT_BINARY_DIR}/aslio-config-version.cmake
        DESTINATION ${aslio_package_dir})
install(EXPORT aslio-targets NAMESPACE aslio:: DESTINATION ${aslio_package_dir})
install(DIRECTORY ${CMAKE_CURRENT_SOURCE_DIR}/configs ${CMAKE_CURRENT_SOURCE_DIR}/tools/templates DESTINATION ${aslio_data_dir})

# The contracts of the families, as sources: a project outside compiles that of its own (aslio_add_contract_test).
install(FILES ${CMAKE_CURRENT_SOURCE_DIR}/cmake/aslio_contract.cmake DESTINATION ${aslio_package_dir})
install(FILES ${CMAKE_CURRENT_SOURCE_DIR}/tests/main.cpp ${CMAKE_CURRENT_SOURCE_DIR}/tests/temporary_folder.hpp
        DESTINATION ${aslio_data_dir}/contract)
install(DIRECTORY ${CMAKE_CURRENT_SOURCE_DIR}/tests/plugins DESTINATION ${aslio_data_dir}/contract
        FILES_MATCHING PATTERN "*.hpp" PATTERN "*contract*.cpp" PATTERN "tiling_property_test.cpp" PATTERN "test_motions.cpp"
        PATTERN "test_map_surfaces.cpp" PATTERN "allocation_count.cpp"
        PATTERN "every_map.hpp" EXCLUDE PATTERN "smooth_motion.hpp" EXCLUDE)  # they know stages of the library
install(FILES ${CMAKE_CURRENT_SOURCE_DIR}/tests/pipeline/runs.hpp ${CMAKE_CURRENT_SOURCE_DIR}/tests/pipeline/runs.cpp
        DESTINATION ${aslio_data_dir}/contract/pipeline)
