# Installs the build into an empty prefix, builds the example against that prefix alone, and runs its test on the result.
function(run)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(NOT result EQUAL 0)
    message(FATAL_ERROR "failed (${result}): ${ARGN}\n${output}")
  endif()
  set(output "${output}" PARENT_SCOPE)
endfunction()

set(prefix ${WORK_DIR}/prefix)
set(build ${WORK_DIR}/build)
file(REMOVE_RECURSE ${prefix} ${build})
run(${CMAKE_COMMAND} --install ${BUILD_DIR} --prefix ${prefix})
run(${CMAKE_COMMAND} -S ${EXAMPLE_DIR} -B ${build} -G Ninja -DCMAKE_PREFIX_PATH=${prefix} -DCMAKE_CXX_COMPILER=${CXX})
run(${CMAKE_COMMAND} --build ${build})
run(${CMAKE_COMMAND} -E env ASLIO_TEST_EXAMPLE=${build}/my_window.so
    ${TEST} "The example is listed*")  # a comma in a name would separate two filters
if(NOT output MATCHES "All tests passed")
  message(FATAL_ERROR "the test of the example did not run:\n${output}")
endif()
