# SPDX-License-Identifier: Apache-2.0
# cmake -DGLSLANG= -DSPIRV_DIS= -DSPIRV_AS= -DSPIRV_OPT= -DSPIRV_VAL= -DSOURCE=x.comp -DINCLUDES=list -DMODULE=x.spv
# -DHEADER=x.h -DKEPT=folder -P MakeShader.cmake compiles a compute shader in which no float operation may be contracted
# or reordered: each is marked NoContraction, as `precise` would where it reaches; and none may take it that there is no
# NaN, infinity or signed zero (SignedZeroInfNanPreserve). Its quotients and roots of floats go by way of doubles, unless the
# constant SPEC_ROUNDS_RIGHT is true. The header holds the module as the array x_spirv. Optimizing takes nearly all of
# the time, so each finished module is kept in the folder KEPT, which presets share, and is copied from there when glslang
# gives the same code again.
cmake_minimum_required(VERSION 3.25)
get_filename_component(name ${SOURCE} NAME_WE)
list(TRANSFORM INCLUDES PREPEND -I)
execute_process(COMMAND ${GLSLANG} --quiet -V --target-env vulkan1.2 ${INCLUDES} ${SOURCE} -o ${MODULE}.plain
                COMMAND_ERROR_IS_FATAL ANY)
execute_process(COMMAND ${SPIRV_OPT} --version OUTPUT_VARIABLE key COMMAND_ERROR_IS_FATAL ANY)
file(STRINGS ${CMAKE_CURRENT_LIST_DIR}/../shaders/layout.h spec_line REGEX "^#define SPEC_ROUNDS_RIGHT [0-9]+$")
string(REGEX MATCH "[0-9]+$" spec "${spec_line}")
foreach(file ${MODULE}.plain ${CMAKE_CURRENT_LIST_FILE})
  file(SHA256 ${file} hash)
  string(APPEND key ${hash})
endforeach()
string(SHA256 key "${key}")
set(made ${KEPT}/${name}-${key}.spv)

if(NOT EXISTS ${made})
  execute_process(COMMAND ${SPIRV_DIS} --raw-id --no-header --no-indent ${MODULE}.plain OUTPUT_VARIABLE text
                  COMMAND_ERROR_IS_FATAL ANY)
  # Vulkan lets a quotient or a root of floats be 2.5 units in the last place off. That of doubles, rounded to a float, is the
  # nearest to the exact one (Figueroa, "When is double rounding innocuous?", 1995). Both are computed, and the constant selects
  # one; a device's compiler leaves out the other.
  if(text MATCHES "OpDecorate (%[0-9]+) SpecId ${spec}\n")
    set(rounds_right ${CMAKE_MATCH_1})
    string(REGEX MATCH "(%[0-9]+) = OpTypeFloat 32\n" unused "${text}")
    set(float ${CMAKE_MATCH_1})
    if(NOT text MATCHES "OpTypeFloat 64\n")
      string(REPLACE "OpCapability Shader\n" "OpCapability Shader\nOpCapability Float64\n" text "${text}")
      string(REPLACE "${float} = OpTypeFloat 32\n" "${float} = OpTypeFloat 32\n%99999 = OpTypeFloat 64\n" text "${text}")
    endif()
    string(REGEX MATCH "(%[0-9]+) = OpTypeFloat 64\n" unused "${text}")
    set(double ${CMAKE_MATCH_1})
    set(next 100000)  # glslang numbers far fewer values; the assembler refuses a number that is used twice
    string(REGEX MATCHALL "%[0-9]+ = Op(FDiv ${float}|ExtInst ${float} %[0-9]+ Sqrt) [^\n]*\n" operations "${text}")
    foreach(operation ${operations})
      string(REGEX MATCH "^(%[0-9]+) = (OpFDiv|OpExtInst) ${float}(( %[0-9]+ Sqrt)?) (.*)\n" unused "${operation}")
      set(result ${CMAKE_MATCH_1})
      set(instruction ${CMAKE_MATCH_2})
      set(root "${CMAKE_MATCH_3}")
      string(REPLACE " " ";" operands "${CMAKE_MATCH_5}")
      set(rounded)
      set(doubles)
      foreach(operand ${operands})
        string(APPEND rounded "%${next} = OpFConvert ${double} ${operand}\n")
        string(APPEND doubles " %${next}")
        math(EXPR next "${next} + 1")
      endforeach()
      math(EXPR wide "${next} + 1")
      math(EXPR nearest "${next} + 2")
      string(REGEX REPLACE "^%[0-9]+" "%${next}" own "${operation}")
      string(APPEND rounded "${own}%${wide} = ${instruction} ${double}${root}${doubles}\n%${nearest} = OpFConvert ${float} %${wide}\n"
                            "${result} = OpSelect ${float} ${rounds_right} %${next} %${nearest}\n")
      math(EXPR next "${next} + 3")
      string(REPLACE "\n${operation}" "\n${rounded}" text "${text}")
    endforeach()
  elseif(text MATCHES "OpFDiv|Sqrt")
    message(FATAL_ERROR "${SOURCE} divides, or takes a root, without the constant SPEC_ROUNDS_RIGHT")
  endif()
  string(REGEX MATCHALL "%[0-9]+ = Op(FAdd|FSub|FMul|FDiv|FRem|FMod|Dot|VectorTimesScalar)" operations "${text}")
  string(REGEX MATCHALL "OpDecorate %[0-9]+ NoContraction\n" decorations "${text}")
  set(marks)
  foreach(operation ${operations})
    string(REGEX MATCH "^%[0-9]+" id "${operation}")
    set(mark "OpDecorate ${id} NoContraction\n")
    if(NOT mark IN_LIST decorations)
      string(APPEND marks "${mark}")
    endif()
  endforeach()
  string(REPLACE "OpCapability Shader\n" "OpCapability Shader\nOpCapability SignedZeroInfNanPreserve\n" text "${text}")
  string(REGEX REPLACE "OpExecutionMode (%[0-9]+) LocalSize" "OpExecutionMode \\1 SignedZeroInfNanPreserve 32\nOpExecutionMode \\1 LocalSize"
         text "${text}")
  string(FIND "${text}" "%2 = OpType" types)
  string(SUBSTRING "${text}" 0 ${types} head)
  string(SUBSTRING "${text}" ${types} -1 tail)
  file(WRITE ${MODULE}.txt "${head}${marks}${tail}")
  execute_process(COMMAND ${SPIRV_AS} --preserve-numeric-ids --target-env vulkan1.2 ${MODULE}.txt -o ${MODULE}
                  COMMAND_ERROR_IS_FATAL ANY)
  execute_process(COMMAND ${SPIRV_OPT} -O ${MODULE} -o ${MODULE} COMMAND_ERROR_IS_FATAL ANY)
  execute_process(COMMAND ${SPIRV_VAL} --target-env vulkan1.2 ${MODULE} COMMAND_ERROR_IS_FATAL ANY)
  file(MAKE_DIRECTORY ${KEPT})
  string(RANDOM LENGTH 12 suffix)
  file(COPY_FILE ${MODULE} ${made}.${suffix})  # becomes `made` when complete, in one step
  file(RENAME ${made}.${suffix} ${made})
endif()
file(COPY_FILE ${made} ${MODULE})
file(REMOVE ${MODULE}.plain ${MODULE}.txt)
file(READ ${MODULE} words HEX)
string(REGEX REPLACE "(..)(..)(..)(..)" "0x\\4\\3\\2\\1," words "${words}")
file(WRITE ${HEADER} "#pragma once\n#include <cstdint>\ninline constexpr std::uint32_t ${name}_spirv[] = {${words}};\n")
