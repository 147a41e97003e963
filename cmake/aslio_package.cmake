# `cpack` in a build folder: aslio_VERSION_ARCH.deb with the program, the page of its report, the libraries and headers for
# plugins, configs, templates and the study of the quick start. tools/release/package builds and tries it.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME aslio)
set(CPACK_PACKAGE_VERSION ${PROJECT_VERSION})
set(CPACK_PACKAGE_CONTACT "the AS-LIO Lab authors <aslio@localhost>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "LiDAR-inertial odometry of interchangeable stages")
set(CPACK_PACKAGE_DESCRIPTION
    "AS-LIO and the systems it is compared with, as compositions of the same stages.\nReads recordings, runs studies, and writes tables and a report.")
set(CPACK_RESOURCE_FILE_LICENSE ${PROJECT_SOURCE_DIR}/LICENSE)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
# What the program is linked with. A plugin is compiled against the headers, which need more.
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_SUGGESTS
    "cmake, g++, pkg-config, libeigen3-dev, libyaml-cpp-dev, libspdlog-dev, libfmt-dev, nlohmann-json3-dev, libssl-dev, libbz2-dev, libdeflate-dev, liblz4-dev, libzstd-dev, libsqlite3-dev, libpcap-dev, catch2")
install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR} RENAME copyright)
install(FILES README.md CHANGELOG.md DESTINATION ${CMAKE_INSTALL_DOCDIR})
install(FILES experiments/quickstart.yaml DESTINATION ${CMAKE_INSTALL_DATADIR}/aslio/experiments)
include(CPack)
