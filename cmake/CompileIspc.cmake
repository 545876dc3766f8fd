# SPDX-License-Identifier: Apache-2.0
# cmake -DISPC=program -DFLAGS=list -DSOURCE=x.ispc -DHEADERS=list -DOUT=folder -DKEPT=folder -P
# CompileIspc.cmake makes x.o, x_TARGET.o for each target, and x_ispc.h in OUT. Results are kept in KEPT, and
# copied when the same texts are compiled with the same flags again, in any folder. Presets share them, and
# clones may. This saves minutes that ccache cannot save.
cmake_minimum_required(VERSION 3.25)
get_filename_component(name ${SOURCE} NAME_WE)
set(arguments ${FLAGS})
execute_process(COMMAND ${ISPC} --version OUTPUT_VARIABLE key COMMAND_ERROR_IS_FATAL ANY)
list(FILTER FLAGS EXCLUDE REGEX "^-I")  # The key has all headers instead.
string(APPEND key "${FLAGS}")
foreach(file ${SOURCE} ${HEADERS})
  file(SHA256 ${file} hash)
  string(APPEND key ${hash})
endforeach()
string(SHA256 key "${key}")
set(made ${KEPT}/${name}-${key})

if(NOT EXISTS ${made})
  string(RANDOM LENGTH 12 suffix)
  set(fresh ${made}.${suffix})  # becomes `made` when complete, in one step
  file(MAKE_DIRECTORY ${fresh})
  execute_process(COMMAND ${ISPC} ${arguments} ${SOURCE} -o ${fresh}/${name}.o -h ${fresh}/${name}_ispc.h
                  RESULT_VARIABLE status)
  if(NOT status EQUAL 0)
    file(REMOVE_RECURSE ${fresh})
    message(FATAL_ERROR "ispc failed: ${status}")
  endif()
  file(RENAME ${fresh} ${made} RESULT ignored)  # fails if another build was faster: same result
  file(REMOVE_RECURSE ${fresh})
endif()

file(GLOB files RELATIVE ${made} ${made}/*)
foreach(file ${files})
  file(COPY_FILE ${made}/${file} ${OUT}/${file})
  file(TOUCH ${OUT}/${file})
endforeach()
