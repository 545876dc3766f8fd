# SPDX-License-Identifier: Apache-2.0
# galaxy_ispc(TARGET FILES...) compiles ISPC files for every instruction set that is dispatched at run time,
# and adds the objects to TARGET. TARGET's sources can include the generated header NAME_ispc.h.

if(NOT ISPC_EXECUTABLE)
  find_program(ISPC_FOUND ispc HINTS $ENV{XDG_CACHE_HOME}/ispc-private/bin $ENV{HOME}/.cache/ispc-private/bin)
  if(NOT ISPC_FOUND)
    message(FATAL_ERROR "ispc not found: run tools/fetch-ispc.sh, or configure with -DISPC_EXECUTABLE=/path/to/ispc")
  endif()
  set(ISPC_EXECUTABLE ${ISPC_FOUND} CACHE FILEPATH "ispc compiler" FORCE)
endif()
set(GALAXY_ISPC_TARGETS sse4-i32x4 avx2-i32x8 avx512skx-x16)
set(GALAXY_ISPC_KEPT ${PROJECT_BINARY_DIR}/ispc CACHE PATH "Where compiled ISPC is kept; builds may share it")

# Include folders by which ISPC files find the kernels in core/, and the functions of backends/embree by which
# kernels read memory.
set(GALAXY_KERNELS_SEEN -I${PROJECT_BINARY_DIR}/include/core_kernels -I${PROJECT_BINARY_DIR}/include/core_rays
                        -I${PROJECT_BINARY_DIR}/include/backends_embree)

function(galaxy_ispc TARGET)
  set(out ${CMAKE_CURRENT_BINARY_DIR}/ispc)
  file(MAKE_DIRECTORY ${out})
  list(JOIN GALAXY_ISPC_TARGETS , targets)
  list(TRANSFORM GALAXY_ISPC_TARGETS REPLACE "-.*" "" OUTPUT_VARIABLE suffixes)
  file(GLOB headers CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/core/kernels/*.h ${PROJECT_SOURCE_DIR}/core/rays/ray_fields.h
       ${PROJECT_SOURCE_DIR}/core/rays/head_fields.h ${PROJECT_SOURCE_DIR}/core/rays/stored_fields.h
       ${PROJECT_SOURCE_DIR}/backends/embree/*.isph ${CMAKE_CURRENT_SOURCE_DIR}/*_view.h ${CMAKE_CURRENT_SOURCE_DIR}/*_layout.h)
  galaxy_view(view ${CMAKE_CURRENT_SOURCE_DIR})
  set(flags -O3 --pic --opt=disable-fma --target=${targets} --woff --math-lib=default ${GALAXY_KERNELS_SEEN} -I${view})
  set(script ${PROJECT_SOURCE_DIR}/cmake/CompileIspc.cmake)
  set(made)
  foreach(file ${ARGN})
    get_filename_component(name ${file} NAME_WE)
    set(objects ${out}/${name}.o)
    foreach(suffix ${suffixes})
      list(APPEND objects ${out}/${name}_${suffix}.o)
    endforeach()
    set(source ${CMAKE_CURRENT_SOURCE_DIR}/${file})
    add_custom_command(
      OUTPUT ${objects} ${out}/${name}_ispc.h
      COMMAND ${CMAKE_COMMAND} -DISPC=${ISPC_EXECUTABLE} "-DFLAGS=${flags}" -DSOURCE=${source} "-DHEADERS=${headers}"
              -DOUT=${out} -DKEPT=${GALAXY_ISPC_KEPT} -P ${script}
      DEPENDS ${source} ${headers} ${script}
      COMMENT "ISPC ${name}" VERBATIM)
    target_sources(${TARGET} PRIVATE ${objects} ${out}/${name}_ispc.h)
    set_source_files_properties(${objects} PROPERTIES EXTERNAL_OBJECT TRUE GENERATED TRUE)
    list(APPEND made ${objects} ${out}/${name}_ispc.h)
  endforeach()
  # A target of its own, so that ISPC, which takes longest, need not wait for the libraries that TARGET links.
  add_custom_target(${TARGET}_ispc DEPENDS ${made})
  add_dependencies(${TARGET} ${TARGET}_ispc)
  target_include_directories(${TARGET} PRIVATE ${out})
endfunction()

# galaxy_ispc_probes(TARGET FILE PROBE) compiles a test's FILE for each instruction set into TARGET. The
# function that FILE calls PROBE is exported as PROBE_<set>.
function(galaxy_ispc_probes TARGET FILE PROBE)
  get_filename_component(name ${FILE} NAME_WE)
  file(GLOB headers CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/core/kernels/*.h ${PROJECT_SOURCE_DIR}/core/rays/ray_fields.h
       ${PROJECT_SOURCE_DIR}/backends/embree/*_fetch.isph ${CMAKE_CURRENT_SOURCE_DIR}/*probe.h)
  foreach(target ${GALAXY_ISPC_TARGETS})
    string(REGEX REPLACE "-.*" "" isa ${target})
    set(object ${CMAKE_CURRENT_BINARY_DIR}/${name}_${isa}.o)
    add_custom_command(
      OUTPUT ${object}
      COMMAND ${ISPC_EXECUTABLE} -O3 --pic --opt=disable-fma --target=${target} --woff -DPROBE=${PROBE}_${isa}
              ${GALAXY_KERNELS_SEEN} -I${GALAXY_TESTS_VIEW}
              ${CMAKE_CURRENT_SOURCE_DIR}/${FILE} -o ${object}
      DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/${FILE} ${headers}
      COMMENT "ISPC ${name} (${target})" VERBATIM)
    set_source_files_properties(${object} PROPERTIES EXTERNAL_OBJECT TRUE GENERATED TRUE)
    target_sources(${TARGET} PRIVATE ${object})
  endforeach()
endfunction()
