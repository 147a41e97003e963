# Options, warnings and code generation flags, in one place.
option(ASLIO_BUILD_TESTS "Build the tests" ON)
option(ASLIO_WERROR "Warnings are errors" OFF)
option(ASLIO_NATIVE "Generate code for this machine's CPU (not for binaries that travel)" OFF)
set(ASLIO_EXEC_BACKEND openmp CACHE STRING "Thread backend of exec: openmp or threads (for tsan, which libgomp confuses)")
set_property(CACHE ASLIO_EXEC_BACKEND PROPERTY STRINGS openmp threads)

add_library(aslio_flags INTERFACE)
target_compile_options(aslio_flags INTERFACE -Wall -Wextra -Wconversion $<$<BOOL:${ASLIO_WERROR}>:-Werror>)
# -fno-math-errno: sqrt would otherwise block vectorisation (6x on plane fits). No -ffast-math: it breaks reproducibility.
target_compile_options(aslio_flags INTERFACE -fno-math-errno $<$<BOOL:${ASLIO_NATIVE}>:-march=native>)

find_program(CCACHE_PROGRAM ccache)
if(CCACHE_PROGRAM AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CCACHE_PROGRAM})
endif()
