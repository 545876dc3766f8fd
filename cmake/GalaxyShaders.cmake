# SPDX-License-Identifier: Apache-2.0
# galaxy_shaders(TARGET NAMES...): compiles shaders/NAME.comp to SPIR-V and gives TARGET's sources NAME.h, which holds
# it as NAME_spirv. galaxy_shader(TARGET FILE) does so for a file that is elsewhere, and may include its neighbours.
find_program(GLSLANG_VALIDATOR glslangValidator REQUIRED)
foreach(tool dis as opt val)
  string(TOUPPER ${tool} name)
  find_program(SPIRV_${name} spirv-${tool} REQUIRED)
endforeach()
set(GALAXY_SHADERS_KEPT ${PROJECT_BINARY_DIR}/spirv CACHE PATH "Where compiled shaders are kept; builds may share it")
set(GALAXY_SHADER_FLAGS -DGLSLANG=${GLSLANG_VALIDATOR} -DSPIRV_DIS=${SPIRV_DIS} -DSPIRV_AS=${SPIRV_AS}
                        -DSPIRV_OPT=${SPIRV_OPT} -DSPIRV_VAL=${SPIRV_VAL})
set(GALAXY_SHADER_INCLUDES ${PROJECT_SOURCE_DIR}/shaders ${PROJECT_SOURCE_DIR}/core/kernels ${PROJECT_SOURCE_DIR}/core/rays)

function(galaxy_shader TARGET FILE)
  set(out ${CMAKE_CURRENT_BINARY_DIR}/shaders)
  file(MAKE_DIRECTORY ${out})
  cmake_path(ABSOLUTE_PATH FILE NORMALIZE OUTPUT_VARIABLE source)
  cmake_path(GET source PARENT_PATH folder)
  cmake_path(GET source STEM name)
  file(GLOB headers CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/core/kernels/*.h ${PROJECT_SOURCE_DIR}/core/rays/ray_fields.h
       ${PROJECT_SOURCE_DIR}/shaders/*.glsl ${PROJECT_SOURCE_DIR}/shaders/*.h ${folder}/*probe.h)
  set(script ${PROJECT_SOURCE_DIR}/cmake/MakeShader.cmake)
  add_custom_command(
    OUTPUT ${out}/${name}.h ${out}/${name}.spv
    COMMAND ${CMAKE_COMMAND} ${GALAXY_SHADER_FLAGS} -DSOURCE=${source} "-DINCLUDES=${GALAXY_SHADER_INCLUDES}"
            -DMODULE=${out}/${name}.spv -DHEADER=${out}/${name}.h -DKEPT=${GALAXY_SHADERS_KEPT} -P ${script}
    DEPENDS ${source} ${headers} ${script}
    COMMENT "shader ${name}" VERBATIM)
  target_sources(${TARGET} PRIVATE ${out}/${name}.h)
  target_include_directories(${TARGET} PRIVATE ${out})
endfunction()

function(galaxy_shaders TARGET)
  file(MAKE_DIRECTORY ${PROJECT_BINARY_DIR}/include/shaders/gxy)
  file(CREATE_LINK ${PROJECT_SOURCE_DIR}/shaders ${PROJECT_BINARY_DIR}/include/shaders/gxy/shaders SYMBOLIC)
  foreach(name ${ARGN})
    galaxy_shader(${TARGET} ${PROJECT_SOURCE_DIR}/shaders/${name}.comp)
  endforeach()
endfunction()
