# SPDX-License-Identifier: Apache-2.0
# cmake -DSPIRV_DIS=... -DMODULE=x.spv -P CheckPrecise.cmake: fails unless every + - * / of the module is NoContraction,
# that is, `precise` in GLSL reaches all of it.
cmake_minimum_required(VERSION 3.25)
execute_process(COMMAND ${SPIRV_DIS} --raw-id ${MODULE} OUTPUT_VARIABLE text COMMAND_ERROR_IS_FATAL ANY)
string(REGEX MATCHALL "%[0-9]+ = Op(FAdd|FSub|FMul|FDiv|Dot|VectorTimesScalar)[^\n]*" operations "${text}")
string(REGEX MATCHALL "OpDecorate %[0-9]+ NoContraction" decorations "${text}")
list(LENGTH operations total)
set(loose 0)
foreach(operation ${operations})
  string(REGEX MATCH "^%[0-9]+" id "${operation}")
  if(NOT "OpDecorate ${id} NoContraction" IN_LIST decorations)
    math(EXPR loose "${loose} + 1")
    message("not precise: ${operation}")
  endif()
endforeach()
if(total EQUAL 0 OR loose GREATER 0)
  message(FATAL_ERROR "${loose} of ${total} floating-point operations are not precise")
endif()
