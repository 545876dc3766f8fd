# SPDX-License-Identifier: Apache-2.0
# Compile settings of the whole project, and the functions that declare its targets.

set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/bin)
if(NOT CMAKE_BUILD_TYPE)
  set(CMAKE_BUILD_TYPE Release)
endif()
find_program(CCACHE_PROGRAM ccache)
if(CCACHE_PROGRAM)
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CCACHE_PROGRAM})
endif()

# One floating-point mode everywhere: no contraction (docs/conventions.md).
add_compile_options(-Wall -Wextra -ffp-contract=off)
# When g++ 12 vectorizes straight-line code, it removes conversions double -> float -> double, and the
# rounding is lost.
add_compile_options(-fno-tree-slp-vectorize)
if(CMAKE_CXX_COMPILER_ID STREQUAL GNU AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
  add_compile_options(-Wno-restrict)  # GCC bug 105651: false warnings for "text" + std::string
endif()
if(CMAKE_UNITY_BUILD AND CMAKE_CXX_COMPILER_ID STREQUAL GNU)
  add_compile_options($<$<COMPILE_LANGUAGE:CXX>:-Wno-subobject-linkage>)  # In unity builds, GCC takes a .cpp file for a header.
endif()
if(GALAXY_WERROR)
  add_compile_options(-Werror)
endif()
if(GALAXY_SANITIZE)
  add_compile_options(-fsanitize=${GALAXY_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all)
  add_link_options(-fsanitize=${GALAXY_SANITIZE})
  if(GALAXY_SANITIZE MATCHES undefined)
    # A null pointer faults without the check. This saves a fifth of the time to compile.
    add_compile_options(-fno-sanitize=null,vptr)
  endif()
endif()
if(GALAXY_FUZZ)
  if(NOT CMAKE_CXX_COMPILER_ID MATCHES Clang)
    message(FATAL_ERROR "GALAXY_FUZZ needs clang (libFuzzer): cmake --preset asan")
  endif()
  add_compile_options(-fsanitize=fuzzer-no-link)
endif()
if(GALAXY_COVERAGE)
  # Without atomic updates, counts that threads lose become negative, which gcovr refuses.
  add_compile_options(--coverage -fprofile-update=atomic)
  add_link_options(--coverage)
endif()

# galaxy_view(RESULT FOLDER) sets RESULT to an include folder that contains only FOLDER, under its path in
# the repository. A target with the view of core/comm can include "core/comm/transport.h", and no headers
# of other folders.
function(galaxy_view RESULT FOLDER)
  cmake_path(RELATIVE_PATH FOLDER BASE_DIRECTORY ${PROJECT_SOURCE_DIR} OUTPUT_VARIABLE path)
  string(REPLACE / _ name ${path})
  set(view ${PROJECT_BINARY_DIR}/include/${name})
  cmake_path(GET path PARENT_PATH parent)
  file(MAKE_DIRECTORY ${view}/${parent})
  file(CREATE_LINK ${FOLDER} ${view}/${path} SYMBOLIC)
  set(${RESULT} ${view} PARENT_SCOPE)
endfunction()

# Tests can include each other's headers, and so can tools.
galaxy_view(GALAXY_TESTS_VIEW ${PROJECT_SOURCE_DIR}/tests)
galaxy_view(GALAXY_TOOLS_VIEW ${PROJECT_SOURCE_DIR}/tools)

# galaxy_library(NAME SOURCES... DEPENDS targets... [PRIVATE_DEPENDS targets...])
# declares the static library galaxy_NAME (alias Galaxy::NAME) for the current folder. Its headers are
# included by their path in the repository, and only by targets that link it: a forbidden include does not
# compile. Library and headers are installed, and exported as Galaxy::NAME for find_package(Galaxy).
function(galaxy_library NAME)
  cmake_parse_arguments(ARG "" "" "SOURCES;DEPENDS;PRIVATE_DEPENDS" ${ARGN})
  galaxy_view(view ${CMAKE_CURRENT_SOURCE_DIR})
  if(ARG_SOURCES)
    add_library(galaxy_${NAME} STATIC ${ARG_SOURCES})
    set(scope PUBLIC)
    target_link_libraries(galaxy_${NAME} PRIVATE ${ARG_PRIVATE_DEPENDS})
  else()
    add_library(galaxy_${NAME} INTERFACE)
    set(scope INTERFACE)
  endif()
  add_library(Galaxy::${NAME} ALIAS galaxy_${NAME})
  set_target_properties(galaxy_${NAME} PROPERTIES EXPORT_NAME ${NAME} GALAXY_VIEW ${view})
  target_include_directories(galaxy_${NAME} ${scope} $<BUILD_INTERFACE:${view}> $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}/galaxy>)
  target_link_libraries(galaxy_${NAME} ${scope} ${ARG_DEPENDS})
  file(GLOB headers CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/*.h)
  install(TARGETS galaxy_${NAME} EXPORT GalaxyTargets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
  cmake_path(RELATIVE_PATH CMAKE_CURRENT_SOURCE_DIR BASE_DIRECTORY ${PROJECT_SOURCE_DIR} OUTPUT_VARIABLE path)
  install(FILES ${headers} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/galaxy/${path})
endfunction()

# galaxy_install_package() installs the files that find_package(Galaxy) reads. It is called once, after all
# libraries are declared. cmake --install BUILD --component insitu installs what simulations link, and no more.
function(galaxy_install_package)
  include(CMakePackageConfigHelpers)
  set(where ${CMAKE_INSTALL_LIBDIR}/cmake/Galaxy)
  set(modules ${CMAKE_INSTALL_INCLUDEDIR}/galaxy/insitu/api)
  configure_package_config_file(${PROJECT_SOURCE_DIR}/cmake/GalaxyConfig.cmake.in ${PROJECT_BINARY_DIR}/GalaxyConfig.cmake
                                INSTALL_DESTINATION ${where} PATH_VARS modules)
  write_basic_package_version_file(${PROJECT_BINARY_DIR}/GalaxyConfigVersion.cmake COMPATIBILITY SameMinorVersion)
  install(FILES ${PROJECT_BINARY_DIR}/GalaxyConfig.cmake ${PROJECT_BINARY_DIR}/GalaxyConfigVersion.cmake
          DESTINATION ${where} COMPONENT insitu)
  install(EXPORT GalaxyTargets NAMESPACE Galaxy:: DESTINATION ${where})
  if(TARGET galaxy_insitu)
    install(EXPORT GalaxyInsituTargets NAMESPACE Galaxy:: DESTINATION ${where} COMPONENT insitu)
  endif()
endfunction()

# galaxy_plugin(NAME SOURCES... DEPENDS targets...) declares libgalaxy_NAME.so, which programs open when they
# need it (core/comm/plugin.h). It has its own copies of the code that it uses from Galaxy's libraries, and
# exports only its table. All programs are built after the plugins.
add_custom_target(galaxy_plugins)
function(galaxy_plugin NAME)
  cmake_parse_arguments(ARG "" "" "SOURCES;DEPENDS" ${ARGN})
  set(target galaxy_plugin_${NAME})
  set(exported ${PROJECT_SOURCE_DIR}/cmake/plugin.map)
  add_library(${target} MODULE ${ARG_SOURCES})
  target_link_libraries(${target} PRIVATE ${ARG_DEPENDS})
  target_compile_definitions(${target} PRIVATE GALAXY_VERSION="${PROJECT_VERSION}")
  target_link_options(${target} PRIVATE LINKER:--version-script=${exported} LINKER:--as-needed)
  set_target_properties(${target} PROPERTIES OUTPUT_NAME galaxy_${NAME} LINK_DEPENDS ${exported}
                        LIBRARY_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/lib/galaxy)
  add_dependencies(galaxy_plugins ${target})
  install(TARGETS ${target} LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}/galaxy)
endfunction()

# galaxy_glue(TARGET) compiles a target's own sources with -O1. They handle options, files and checks and call
# libraries that compute, so that full optimization takes long and gains little.
function(galaxy_glue TARGET)
  target_compile_options(${TARGET} PRIVATE $<$<CONFIG:Release>:-O1>)
endfunction()

# galaxy_program(NAME SOURCES... DEPENDS targets...) declares a program in build/<preset>/bin.
function(galaxy_program NAME)
  cmake_parse_arguments(ARG "" "" "SOURCES;DEPENDS" ${ARGN})
  add_executable(${NAME} ${ARG_SOURCES})
  add_dependencies(${NAME} galaxy_plugins)
  galaxy_glue(${NAME})
  target_link_libraries(${NAME} PRIVATE ${ARG_DEPENDS})
  target_include_directories(${NAME} PRIVATE ${GALAXY_TOOLS_VIEW})
  install(TARGETS ${NAME} RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
endfunction()

# galaxy_fuzzer(NAME SOURCES... DEPENDS targets... [CORPUS folder])
# declares one libFuzzer program, and the test fuzz_NAME, which runs it for ten seconds, starting from the
# files in CORPUS. Nothing is declared unless GALAXY_FUZZ is on (preset asan).
function(galaxy_fuzzer NAME)
  if(NOT GALAXY_FUZZ)
    return()
  endif()
  cmake_parse_arguments(ARG "" "CORPUS" "SOURCES;DEPENDS" ${ARGN})
  set(program fuzz_${NAME})
  set(found ${CMAKE_BINARY_DIR}/fuzz/${NAME})  # inputs that reached new code, kept between runs
  file(MAKE_DIRECTORY ${found})
  add_executable(${program} ${ARG_SOURCES})
  add_dependencies(${program} galaxy_plugins)
  set_target_properties(${program} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/fuzz)
  target_link_libraries(${program} PRIVATE ${ARG_DEPENDS})
  target_include_directories(${program} PRIVATE ${GALAXY_TESTS_VIEW})
  target_link_options(${program} PRIVATE -fsanitize=fuzzer)
  if(NOT TARGET fuzzers)
    add_custom_target(fuzzers)
  endif()
  add_dependencies(fuzzers ${program})
  add_test(NAME ${program} COMMAND ${program} -max_total_time=10 -timeout=5 -rss_limit_mb=2048 -seed=1
                                   -print_final_stats=1 -artifact_prefix=${CMAKE_BINARY_DIR}/fuzz/ ${found} ${ARG_CORPUS})
  set_tests_properties(${program} PROPERTIES LABELS fuzz TIMEOUT 120)
endfunction()

# Faults in libraries of others that sanitizers are to ignore.
set(sanitizer_environment)
if(GALAXY_SANITIZE MATCHES address)
  set(sanitizer_environment LSAN_OPTIONS=suppressions=${PROJECT_SOURCE_DIR}/tests/lsan.supp:print_suppressions=0)
elseif(GALAXY_SANITIZE MATCHES thread)
  set(sanitizer_environment TSAN_OPTIONS=suppressions=${PROJECT_SOURCE_DIR}/tests/tsan.supp:print_suppressions=0)
endif()

# galaxy_test(NAME SOURCES... DEPENDS targets... [LABELS labels...] [TIMEOUT seconds] [COMPUTES])
# declares one GoogleTest program, run by ctest as one test; target LABEL_tests builds all programs of one label.
#   unit     fast and in one process; also run under asan and ubsan. The default.
#   threads  tests concurrent code in one process; also run under tsan
#   images   compares many pictures
#   nightly  large or long; left out unless asked for
# Under the address sanitizer its own sources are compiled as they are, in a third of the time, and without what fuzzers count:
# the libraries that it tests are not. COMPUTES says that most of its time goes into what it compiles itself.
function(galaxy_test NAME)
  cmake_parse_arguments(ARG "COMPUTES" "TIMEOUT" "SOURCES;DEPENDS;LABELS" ${ARGN})
  add_executable(${NAME} ${ARG_SOURCES})
  add_dependencies(${NAME} galaxy_plugins)
  set_target_properties(${NAME} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/tests)
  galaxy_glue(${NAME})
  if(GALAXY_SANITIZE MATCHES address AND NOT ARG_COMPUTES)
    target_compile_options(${NAME} PRIVATE -O0)
  endif()
  if(GALAXY_FUZZ)
    target_compile_options(${NAME} PRIVATE -fno-sanitize=fuzzer-no-link)
  endif()
  target_link_libraries(${NAME} PRIVATE ${ARG_DEPENDS} GTest::gtest GTest::gtest_main)
  target_include_directories(${NAME} PRIVATE ${GALAXY_TESTS_VIEW})
  add_test(NAME ${NAME} COMMAND ${NAME})
  if(NOT ARG_TIMEOUT)
    set(ARG_TIMEOUT 300)
  endif()
  if(NOT ARG_LABELS)
    set(ARG_LABELS unit)
  endif()
  foreach(label ${ARG_LABELS})
    if(NOT TARGET ${label}_tests)
      add_custom_target(${label}_tests)
    endif()
    add_dependencies(${label}_tests ${NAME})
  endforeach()
  set_tests_properties(${NAME} PROPERTIES LABELS "${ARG_LABELS}" TIMEOUT ${ARG_TIMEOUT}
    ENVIRONMENT "${sanitizer_environment}")
  if("images" IN_LIST ARG_LABELS)
    set_tests_properties(${NAME} PROPERTIES COST 30)  # most are long: not the last to begin, where there was no run before
  endif()
endfunction()

# galaxy_mpi_test(NAME RANKS n... SOURCES ... DEPENDS ... [OWN_MAIN] [LABELS labels...] [TIMEOUT seconds])
# declares one GoogleTest program, which ctest runs once for each number of ranks. Its main() is in
# tests/mpi_main.cpp unless OWN_MAIN is given.
function(galaxy_mpi_test NAME)
  cmake_parse_arguments(ARG "OWN_MAIN" "TIMEOUT" "RANKS;SOURCES;DEPENDS;LABELS" ${ARGN})
  if(NOT ARG_OWN_MAIN)
    list(APPEND ARG_SOURCES ${PROJECT_SOURCE_DIR}/tests/mpi_main.cpp)
  endif()
  add_executable(${NAME} ${ARG_SOURCES})
  add_dependencies(${NAME} galaxy_plugins)
  set_target_properties(${NAME} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/tests)
  galaxy_glue(${NAME})
  target_link_libraries(${NAME} PRIVATE ${ARG_DEPENDS} Galaxy::comm GTest::gtest)
  target_include_directories(${NAME} PRIVATE ${GALAXY_TESTS_VIEW})
  if(NOT ARG_TIMEOUT)
    set(ARG_TIMEOUT 120)
  endif()
  set(environment OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 ${sanitizer_environment})
  foreach(ranks ${ARG_RANKS})
    add_test(NAME ${NAME}_${ranks} COMMAND ${GALAXY_MPIEXEC} -n ${ranks} $<TARGET_FILE:${NAME}>)
    set_tests_properties(${NAME}_${ranks} PROPERTIES LABELS "mpi;${ARG_LABELS}" TIMEOUT ${ARG_TIMEOUT}
      PROCESSORS ${ranks} ENVIRONMENT "${environment}")
  endforeach()
endfunction()

# galaxy_nightly(NAME TIMEOUT seconds COMMAND program args...) declares an additional run of a test program
# that is larger or longer than the run that every change must pass.
function(galaxy_nightly NAME)
  cmake_parse_arguments(ARG "" "TIMEOUT" "COMMAND" ${ARGN})
  add_test(NAME ${NAME} COMMAND ${ARG_COMMAND})
  set_tests_properties(${NAME} PROPERTIES LABELS nightly TIMEOUT ${ARG_TIMEOUT}
    ENVIRONMENT "OMPI_ALLOW_RUN_AS_ROOT=1;OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1;${sanitizer_environment}")
endfunction()
