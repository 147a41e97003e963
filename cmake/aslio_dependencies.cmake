# Third-party libraries. Imported targets, so their headers are SYSTEM and raise no warnings of ours.
# Keep in step with aslio-config.cmake.in: the framework is a static library, whoever links it needs them as well.
find_package(Eigen3 3.4 REQUIRED NO_MODULE)
find_package(yaml-cpp 0.7 REQUIRED)
find_package(spdlog REQUIRED)
find_package(fmt REQUIRED)
find_package(nlohmann_json REQUIRED)
find_package(OpenSSL REQUIRED COMPONENTS Crypto)
find_package(BZip2 REQUIRED)
find_package(Threads REQUIRED)
if(ASLIO_EXEC_BACKEND STREQUAL "openmp")
  find_package(OpenMP REQUIRED COMPONENTS CXX)
endif()
find_package(PkgConfig REQUIRED)
pkg_check_modules(LZ4 REQUIRED IMPORTED_TARGET liblz4)
pkg_check_modules(ZSTD REQUIRED IMPORTED_TARGET libzstd)
pkg_check_modules(DEFLATE REQUIRED IMPORTED_TARGET libdeflate)
find_package(SQLite3 REQUIRED)
pkg_check_modules(PCAP REQUIRED IMPORTED_TARGET libpcap)

# PCL by pkg-config: its CMake package would configure Boost, VTK and Qt to reach the two libraries asked for.
# Code that uses it is compiled without ASLIO_CODE_FLAGS: Eigen's alignment depends on -march, and distribution binaries
# were built without one.
set(ASLIO_HAVE_PCL OFF)
if(NOT ASLIO_WITH_PCL STREQUAL "OFF")
  pkg_check_modules(PCL_IO QUIET IMPORTED_TARGET pcl_io pcl_common)
  if(PCL_IO_FOUND)
    set(ASLIO_HAVE_PCL ON)
  elseif(ASLIO_WITH_PCL STREQUAL "ON")
    message(FATAL_ERROR "ASLIO_WITH_PCL=ON, but pkg-config finds no pcl_io: install libpcl-dev, or set ASLIO_WITH_PCL=OFF")
  endif()
endif()
message(STATUS "PCL: ${ASLIO_HAVE_PCL} (ASLIO_WITH_PCL=${ASLIO_WITH_PCL})")
