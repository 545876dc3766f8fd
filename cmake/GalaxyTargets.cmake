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

# One floating-point mode everywhere: no contraction (numerics.md section 1).
add_compile_options(-Wall -Wextra -ffp-contract=off)
# g++ 12 folds double -> float -> double to nothing where it vectorizes straight-line code: the rounding is lost.
add_compile_options(-fno-tree-slp-vectorize)
if(GALAXY_WERROR)
  add_compile_options(-Werror)
endif()
if(GALAXY_SANITIZE)
  add_compile_options(-fsanitize=${GALAXY_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all)
  add_link_options(-fsanitize=${GALAXY_SANITIZE})
endif()
if(GALAXY_COVERAGE)
  add_compile_options(--coverage)
  add_link_options(--coverage)
endif()

# galaxy_library(NAME SOURCES... DEPENDS targets... [PRIVATE_DEPENDS targets...])
# declares static library galaxy_NAME (alias Galaxy::NAME) for the current folder. Its headers are seen as
# "gxy/NAME/x.h", and only by targets that link it: a forbidden include does not compile.
function(galaxy_library NAME)
  cmake_parse_arguments(ARG "" "" "SOURCES;DEPENDS;PRIVATE_DEPENDS" ${ARGN})
  set(view ${PROJECT_BINARY_DIR}/include/${NAME})
  file(MAKE_DIRECTORY ${view}/gxy)
  file(CREATE_LINK ${CMAKE_CURRENT_SOURCE_DIR} ${view}/gxy/${NAME} SYMBOLIC)
  if(ARG_SOURCES)
    add_library(galaxy_${NAME} STATIC ${ARG_SOURCES})
    set(scope PUBLIC)
    target_link_libraries(galaxy_${NAME} PRIVATE ${ARG_PRIVATE_DEPENDS})
  else()
    add_library(galaxy_${NAME} INTERFACE)
    set(scope INTERFACE)
  endif()
  add_library(Galaxy::${NAME} ALIAS galaxy_${NAME})
  set_target_properties(galaxy_${NAME} PROPERTIES EXPORT_NAME ${NAME})
  target_include_directories(galaxy_${NAME} ${scope} $<BUILD_INTERFACE:${view}> $<INSTALL_INTERFACE:include>)
  target_link_libraries(galaxy_${NAME} ${scope} ${ARG_DEPENDS})
endfunction()

# galaxy_program(NAME SOURCES... DEPENDS targets...) declares a program in build/<preset>/bin.
function(galaxy_program NAME)
  cmake_parse_arguments(ARG "" "" "SOURCES;DEPENDS" ${ARGN})
  add_executable(${NAME} ${ARG_SOURCES})
  target_link_libraries(${NAME} PRIVATE ${ARG_DEPENDS})
  install(TARGETS ${NAME} RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
endfunction()

# galaxy_test(NAME SOURCES... DEPENDS targets... [LABELS labels...] [TIMEOUT seconds])
# declares one GoogleTest program, run by ctest as one test.
function(galaxy_test NAME)
  cmake_parse_arguments(ARG "" "TIMEOUT" "SOURCES;DEPENDS;LABELS" ${ARGN})
  add_executable(${NAME} ${ARG_SOURCES})
  set_target_properties(${NAME} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/tests)
  target_link_libraries(${NAME} PRIVATE ${ARG_DEPENDS} GTest::gtest GTest::gtest_main)
  add_test(NAME ${NAME} COMMAND ${NAME})
  if(NOT ARG_TIMEOUT)
    set(ARG_TIMEOUT 300)
  endif()
  set_tests_properties(${NAME} PROPERTIES LABELS "${ARG_LABELS}" TIMEOUT ${ARG_TIMEOUT})
endfunction()

# galaxy_mpi_test(NAME RANKS n... SOURCES ... DEPENDS ... [LABELS labels...] [TIMEOUT seconds])
# declares one GoogleTest program with a main() of its own, run by ctest once for each number of ranks.
function(galaxy_mpi_test NAME)
  cmake_parse_arguments(ARG "" "TIMEOUT" "RANKS;SOURCES;DEPENDS;LABELS" ${ARGN})
  add_executable(${NAME} ${ARG_SOURCES})
  set_target_properties(${NAME} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/tests)
  target_link_libraries(${NAME} PRIVATE ${ARG_DEPENDS} GTest::gtest)
  if(NOT ARG_TIMEOUT)
    set(ARG_TIMEOUT 120)
  endif()
  set(environment OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1)
  if(GALAXY_SANITIZE MATCHES "address")
    list(APPEND environment LSAN_OPTIONS=suppressions=${PROJECT_SOURCE_DIR}/tests/lsan.supp:print_suppressions=0)
  endif()
  foreach(ranks ${ARG_RANKS})
    # Several ranks a core, in a container: no binding, shared memory without ptrace rights, and yielding.
    add_test(NAME ${NAME}_${ranks}
      COMMAND ${MPIEXEC_EXECUTABLE} --bind-to none --oversubscribe --mca btl self,vader
              --mca btl_vader_single_copy_mechanism none --mca mpi_yield_when_idle 1
              -n ${ranks} $<TARGET_FILE:${NAME}>)
    set_tests_properties(${NAME}_${ranks} PROPERTIES LABELS "mpi;${ARG_LABELS}" TIMEOUT ${ARG_TIMEOUT}
      PROCESSORS ${ranks} ENVIRONMENT "${environment}")
  endforeach()
endfunction()
