# Writes OUTPUT, a header with the revision of SOURCE; touches it only when that has changed.
cmake_minimum_required(VERSION 3.25)
execute_process(COMMAND git -C ${SOURCE} describe --always --abbrev=40 --match= --dirty OUTPUT_VARIABLE revision
                OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
file(CONFIGURE OUTPUT ${OUTPUT} CONTENT "#define ASLIO_GIT_REVISION \"@revision@\"\n" @ONLY)
