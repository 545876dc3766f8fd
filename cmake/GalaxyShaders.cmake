# SPDX-License-Identifier: Apache-2.0
# galaxy_shaders(TARGET NAMES...) compiles shaders/NAME.comp to SPIR-V. TARGET's sources can include
# NAME_spirv.h, which has the module as the array NAME_spirv. galaxy_shader(TARGET FILE) does the same for a
# file of the tests.
find_program(GLSLANG_VALIDATOR glslangValidator REQUIRED)
foreach(tool dis as opt val)
  string(TOUPPER ${tool} name)
  find_program(SPIRV_${name} spirv-${tool} REQUIRED)
endforeach()
set(GALAXY_SHADERS_KEPT ${PROJECT_BINARY_DIR}/spirv CACHE PATH "Where compiled shaders are kept; builds may share it")
set(GALAXY_SHADER_FLAGS -DGLSLANG=${GLSLANG_VALIDATOR} -DSPIRV_DIS=${SPIRV_DIS} -DSPIRV_AS=${SPIRV_AS}
                        -DSPIRV_OPT=${SPIRV_OPT} -DSPIRV_VAL=${SPIRV_VAL})
galaxy_view(GALAXY_SHADERS_VIEW ${PROJECT_SOURCE_DIR}/shaders)
set(views ${PROJECT_BINARY_DIR}/include)
set(GALAXY_SHADER_INCLUDES ${GALAXY_SHADERS_VIEW} ${views}/core_kernels ${views}/core_rays ${GALAXY_TESTS_VIEW})

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
    OUTPUT ${out}/${name}_spirv.h ${out}/${name}.spv
    COMMAND ${CMAKE_COMMAND} ${GALAXY_SHADER_FLAGS} -DSOURCE=${source} "-DINCLUDES=${GALAXY_SHADER_INCLUDES}"
            -DMODULE=${out}/${name}.spv -DHEADER=${out}/${name}_spirv.h -DKEPT=${GALAXY_SHADERS_KEPT} -P ${script}
    DEPENDS ${source} ${headers} ${script}
    COMMENT "shader ${name}" VERBATIM)
  target_sources(${TARGET} PRIVATE ${out}/${name}_spirv.h)
  target_include_directories(${TARGET} PRIVATE ${out})
endfunction()

function(galaxy_shaders TARGET)
  foreach(name ${ARGN})
    galaxy_shader(${TARGET} ${PROJECT_SOURCE_DIR}/shaders/${name}.comp)
  endforeach()
endfunction()
