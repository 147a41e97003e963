# Options, warnings and code generation flags, in one place.
option(ASLIO_BUILD_TESTS "Build the tests; needs ASLIO_BUILD_TOOLS and ASLIO_BUILD_SIMULATOR" ${PROJECT_IS_TOP_LEVEL})
option(ASLIO_BUILD_TOOLS "Build the program `aslio`; needs ASLIO_BUILD_SIMULATOR" ${PROJECT_IS_TOP_LEVEL})
option(ASLIO_BUILD_SIMULATOR "Build the simulator; needs Embree, assimp and libpng" ${PROJECT_IS_TOP_LEVEL})
option(ASLIO_SPEED_TESTS "Limits of cost as tests, label `speed`: for an optimised build on an idle machine" OFF)
option(ASLIO_WERROR "Warnings are errors" OFF)
option(ASLIO_NATIVE "Generate code for this machine's CPU (not for binaries that travel)" OFF)
option(ASLIO_PCH "Compile the headers of the standard library and of Eigen once, ahead of the sources" ON)
option(ASLIO_UNITY "Compile up to eight sources as one: a first build in two thirds of the time, a longer one after a change to one file" OFF)
option(ASLIO_REPRODUCIBLE "No fused multiply-add by contraction: the same bits on every machine of one ASLIO_ARCH" OFF)
set(ASLIO_ARCH "" CACHE STRING "Value of -march, for example x86-64-v3; empty: the compiler's default")
set(ASLIO_EXEC_BACKEND threads CACHE STRING "Thread backend of exec: threads (sleeps when idle) or openmp (spins unless OMP_WAIT_POLICY=passive)")
set_property(CACHE ASLIO_EXEC_BACKEND PROPERTY STRINGS threads openmp)
set(ASLIO_SANITIZE none CACHE STRING "none, address (with undefined), thread, or fuzz (address, and what libFuzzer needs of Clang)")
set_property(CACHE ASLIO_SANITIZE PROPERTY STRINGS none address thread fuzz)
set(ASLIO_TEST_MODULES "" CACHE STRING "Folders of tests/ that are built, as core;io, with what they need and nothing else; empty: all")
set(ASLIO_WITH_PCL AUTO CACHE STRING "PCL behind io: AUTO (when found), ON (required) or OFF")
set_property(CACHE ASLIO_WITH_PCL PROPERTY STRINGS AUTO ON OFF)
set(ASLIO_REPORT AUTO CACHE STRING "Page of `aslio report`, built by npm: AUTO (when npm can), ON (required) or OFF")
set_property(CACHE ASLIO_REPORT PROPERTY STRINGS AUTO ON OFF)
set(ASLIO_RECORDINGS_DIR "${CMAKE_CURRENT_SOURCE_DIR}/../shared/data" CACHE PATH
    "Folder of recordings for the tests labelled `recordings`")

foreach(part TOOLS TESTS)
  if(ASLIO_BUILD_${part} AND NOT ASLIO_BUILD_SIMULATOR)
    message(FATAL_ERROR "ASLIO_BUILD_${part}=ON needs the simulator: set ASLIO_BUILD_SIMULATOR=ON, or ASLIO_BUILD_${part}=OFF")
  endif()
endforeach()
if(ASLIO_BUILD_TESTS AND NOT ASLIO_BUILD_TOOLS)
  message(FATAL_ERROR "ASLIO_BUILD_TESTS=ON needs the program: set ASLIO_BUILD_TOOLS=ON, or ASLIO_BUILD_TESTS=OFF")
endif()
if(ASLIO_NATIVE AND ASLIO_ARCH)
  message(FATAL_ERROR "ASLIO_NATIVE=ON and ASLIO_ARCH=${ASLIO_ARCH} exclude each other: set one of them")
endif()
foreach(choice "ASLIO_EXEC_BACKEND;threads;openmp" "ASLIO_SANITIZE;none;address;thread;fuzz" "ASLIO_WITH_PCL;AUTO;ON;OFF" "ASLIO_REPORT;AUTO;ON;OFF")
  list(POP_FRONT choice name)
  if(NOT "${${name}}" IN_LIST choice)
    list(JOIN choice ", " choice)
    message(FATAL_ERROR "${name} is '${${name}}', must be one of: ${choice}")
  endif()
endforeach()

# Flags that choose instructions. One list, because a manifest must name them and every target must agree on them.
set(ASLIO_CODE_FLAGS "")
if(ASLIO_NATIVE)
  # Without AVX-512: Eigen's 512-bit packets gain nothing on 18 x 18 matrices, and GCC 12 warns about its own AVX-512
  # intrinsics (GCC bug 105593).
  list(APPEND ASLIO_CODE_FLAGS -march=native -mno-avx512f)
elseif(ASLIO_ARCH)
  list(APPEND ASLIO_CODE_FLAGS -march=${ASLIO_ARCH})
endif()
if(ASLIO_REPRODUCIBLE)
  list(APPEND ASLIO_CODE_FLAGS -ffp-contract=off)
endif()
# -fno-math-errno: sqrt would otherwise block vectorisation (6x on plane fits). No -ffast-math: it breaks reproducibility.
# -fno-semantic-interposition: GCC would else not inline what a shared library might replace (3 % of a run).
list(APPEND ASLIO_CODE_FLAGS -fno-math-errno -fno-semantic-interposition)

add_library(aslio_flags INTERFACE)
target_compile_options(aslio_flags INTERFACE -Wall -Wextra -Wconversion $<$<BOOL:${ASLIO_WERROR}>:-Werror> ${ASLIO_CODE_FLAGS})

if(ASLIO_NATIVE OR ASLIO_ARCH)
  # GCC 12 sees a 256-bit load from a 3-vector in a branch Eigen never takes; builds for the default CPU keep the check.
  target_compile_options(aslio_flags INTERFACE -Wno-array-bounds)
endif()

if(ASLIO_SANITIZE STREQUAL "none")
  # Bags and configurations come from anywhere. _FORTIFY_SOURCE needs an optimised build to do anything.
  target_compile_options(aslio_flags INTERFACE -fstack-protector-strong)
  target_compile_definitions(aslio_flags INTERFACE $<$<NOT:$<CONFIG:Debug>>:_FORTIFY_SOURCE=2>)
  target_link_options(aslio_flags INTERFACE -Wl,-z,relro -Wl,-z,now)
else()
  if(ASLIO_SANITIZE STREQUAL "thread")
    set(sanitizers -fsanitize=thread)
  else()
    # float-cast-overflow is not part of `undefined`, and a non-finite coordinate cast to a cell index is what it finds.
    set(sanitizers -fsanitize=address,undefined,float-cast-overflow -fno-sanitize-recover=all)
    if(ASLIO_SANITIZE STREQUAL "fuzz")
      list(APPEND sanitizers -fsanitize=fuzzer-no-link)
    else()
      # A third of the time that Eigen's templates take to compile. ASan stops at most of what these find; the readers, which
      # get their pointers from files, have all of them in the fuzz targets.
      list(APPEND sanitizers -fno-sanitize=null,alignment,object-size,vptr,pointer-overflow)
    endif()
  endif()
  # A target of property ASLIO_UNSANITIZED is compiled without: what is not looked at need not take long to compile.
  target_compile_options(aslio_flags INTERFACE -fno-omit-frame-pointer
    "$<$<NOT:$<BOOL:$<TARGET_PROPERTY:ASLIO_UNSANITIZED>>>:${sanitizers}>")
  target_link_options(aslio_flags INTERFACE ${sanitizers})
endif()

# What a run's manifest states about the build.
string(TOUPPER "${CMAKE_BUILD_TYPE}" aslio_build_type)
list(JOIN ASLIO_CODE_FLAGS " " ASLIO_CODE_FLAGS_TEXT)
string(STRIP "${CMAKE_CXX_FLAGS} ${CMAKE_CXX_FLAGS_${aslio_build_type}} ${ASLIO_CODE_FLAGS_TEXT}" ASLIO_FLAGS_TEXT)
set(ASLIO_COMPILER_TEXT "${CMAKE_CXX_COMPILER_ID} ${CMAKE_CXX_COMPILER_VERSION}")

include(CheckPIESupported)
check_pie_supported()

# aslio_precompile(TARGET): it takes the headers of aslio_pch (below) as compiled already. Most of what a compiler does for
# one of our sources is to read the standard library and Eigen. Every source still includes what it uses: the lint compiles
# without. A missing header of the standard library may hide behind a neighbour there, one of ours not (neighbours.py).
function(aslio_precompile target)
  if(NOT ASLIO_PCH)
    return()
  endif()
  target_precompile_headers(${target} REUSE_FROM aslio_pch)
  get_target_property(type ${target} TYPE)
  if(type STREQUAL "EXECUTABLE")
    # GCC takes them for code of one kind only, and CMake compiles programs as -fPIE.
    target_compile_options(${target} PRIVATE -fPIC)
  endif()
endfunction()

if(ASLIO_UNITY)
  find_package(Python3 REQUIRED COMPONENTS Interpreter)
  if(ASLIO_NATIVE OR ASLIO_ARCH)
    message(STATUS "ASLIO_UNITY has no effect with ASLIO_NATIVE or ASLIO_ARCH")
  endif()
endif()

# aslio_unity(TARGET [APART REGEX]): where ASLIO_UNITY, up to eight of its sources are compiled as one that includes them. Which
# ones, tools/lib/neighbours.py decides by their names. Those whose path matches, and sources with options of their own, stay
# alone. The time that GCC takes for long matrix expressions grows faster than their number: their sources are better alone.
# Not for ASLIO_NATIVE and ASLIO_ARCH: with fused multiply-add, what is inlined decides how a pose is rounded, and a neighbour
# must not.
function(aslio_unity target)
  if(NOT ASLIO_UNITY OR ASLIO_NATIVE OR ASLIO_ARCH)
    return()
  endif()
  cmake_parse_arguments(ARG "" "APART" "" ${ARGN})
  get_target_property(sources ${target} SOURCES)
  get_target_property(folder ${target} SOURCE_DIR)
  set(paths "")
  foreach(source IN LISTS sources)
    cmake_path(ABSOLUTE_PATH source BASE_DIRECTORY ${folder} NORMALIZE)
    cmake_path(RELATIVE_PATH source BASE_DIRECTORY ${folder} OUTPUT_VARIABLE name)
    if(ARG_APART AND name MATCHES "${ARG_APART}")
      set_source_files_properties("${source}" TARGET_DIRECTORY ${target} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
    elseif(source MATCHES "[.]cpp$")
      string(APPEND paths "${source}\n")
    endif()
  endforeach()
  set(list ${CMAKE_CURRENT_BINARY_DIR}/${target}.sources)
  file(WRITE ${list} "${paths}")
  execute_process(COMMAND ${Python3_EXECUTABLE} ${PROJECT_SOURCE_DIR}/tools/lib/neighbours.py INPUT_FILE ${list}
                  OUTPUT_VARIABLE groups COMMAND_ERROR_IS_FATAL ANY)
  string(REGEX MATCHALL "[0-9]+:[^\n]+" groups "${groups}")
  foreach(member IN LISTS groups)
    string(REGEX MATCH "^([0-9]+):(.*)$" member "${member}")
    set_source_files_properties("${CMAKE_MATCH_2}" TARGET_DIRECTORY ${target} PROPERTIES UNITY_GROUP "${target}_${CMAKE_MATCH_1}")
    set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS "${CMAKE_MATCH_2}")  # its names may change
  endforeach()
  # A new name in a header does not configure again by itself; tools/test does, whenever it is called.
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/tools/lib/neighbours.py)
  set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_MODE GROUP)
  # A class of a source may have members of an unnamed namespace of that source; the compiler takes the source for a header.
  target_compile_options(${target} PRIVATE $<$<CXX_COMPILER_ID:GNU>:-Wno-subobject-linkage>)
endfunction()

# aslio_shorten_build(TARGET [APART REGEX]): both of the above.
function(aslio_shorten_build target)
  aslio_precompile(${target})
  aslio_unity(${target} ${ARGN})
endfunction()

find_program(CCACHE_PROGRAM ccache)
if(CCACHE_PROGRAM AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
  # It takes sources with precompiled headers only where it may ignore macros that nothing of them uses.
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CMAKE_BINARY_DIR}/compile_cached)
  file(WRITE ${CMAKE_CXX_COMPILER_LAUNCHER} "#!/bin/sh\n"
       "export CCACHE_SLOPPINESS=pch_defines,time_macros,include_file_mtime,include_file_ctime\n"
       "exec '${CCACHE_PROGRAM}' \"$@\"\n")
  file(CHMOD ${CMAKE_CXX_COMPILER_LAUNCHER} PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE)
endif()
