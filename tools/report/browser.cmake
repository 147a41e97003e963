# npm ci for the tests in a browser, in a copy, so that the sources stay free of node_modules.
file(COPY ${SOURCE}/package.json ${SOURCE}/package-lock.json DESTINATION ${WORK})
execute_process(COMMAND ${NPM} ci --no-audit --no-fund --ignore-scripts --fetch-retries=0 --fetch-timeout=60000
                WORKING_DIRECTORY ${WORK} RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
if(result EQUAL 0)
  file(WRITE ${OUTPUT} "installed\n")
elseif(MODE STREQUAL "ON")
  message(FATAL_ERROR "ASLIO_REPORT=ON: npm ci failed\n${output}")
else()
  message(STATUS "The tests in a browser cannot run: npm ci failed\n${output}")
endif()
