# SPDX-License-Identifier: Apache-2.0
# cmake -DCOMPILER=c++ -DFOLDERS=list -DALLOWED=a.h -DFORBIDDEN=b.h -DFILE=x.cpp -P CheckIncludes.cmake fails unless the compiler,
# given these include folders, finds ALLOWED and does not find FORBIDDEN.
cmake_minimum_required(VERSION 3.25)
list(REMOVE_ITEM FOLDERS "")
list(TRANSFORM FOLDERS PREPEND -I)
foreach(header ALLOWED FORBIDDEN)
  file(WRITE ${FILE} "#include \"${${header}}\"\n")
  execute_process(COMMAND ${COMPILER} -std=c++20 -M ${FOLDERS} ${FILE} RESULT_VARIABLE ${header}_STATUS OUTPUT_QUIET
                  ERROR_VARIABLE ${header}_ERRORS)
endforeach()
if(NOT ALLOWED_STATUS EQUAL 0)
  message(FATAL_ERROR "${ALLOWED} is not found:\n${ALLOWED_ERRORS}")
endif()
string(FIND "${FORBIDDEN_ERRORS}" "${FORBIDDEN}: No such file" missing)
if(FORBIDDEN_STATUS EQUAL 0 OR missing EQUAL -1)
  message(FATAL_ERROR "${FORBIDDEN} is found, or fails for another reason:\n${FORBIDDEN_ERRORS}")
endif()
