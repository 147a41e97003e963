# Has bundle.py make the page's script and style. MODE ON: a failure ends the build; AUTO: it is reported, and left in
# missing.txt for `aslio report`.
execute_process(COMMAND ${PYTHON} ${SOURCE}/bundle.py ${SOURCE} ${WORK} ${OUTPUT} RESULT_VARIABLE result ERROR_VARIABLE reason)
if(NOT result EQUAL 0)
  string(STRIP "${reason}" reason)
  if(MODE STREQUAL "ON")
    message(FATAL_ERROR "ASLIO_REPORT=ON: ${reason}")
  endif()
  message(STATUS "aslio report will write no HTML: ${reason}")
endif()
