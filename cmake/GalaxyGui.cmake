# SPDX-License-Identifier: Apache-2.0
# Builds the page of the browser GUI from gui/ into share/galaxy/gui of the build tree, where gxyserver finds it, and installs it.
#
# GALAXY_GUI AUTO: with npm and Node 18 or newer it is built; else a ready gui/dist, which release tarballs have, is used; else there
# is no GUI, and this says so, as the build does where npm cannot get its packages. ON: an error instead. OFF: no GUI. Target `gui` makes the page; without one it does nothing.
# GALAXY_NODE is the program node if the page is built here.
set(GALAXY_GUI AUTO CACHE STRING "Browser GUI: AUTO, ON or OFF")
set_property(CACHE GALAXY_GUI PROPERTY STRINGS AUTO ON OFF)
set(gui_sources ${PROJECT_SOURCE_DIR}/gui)
set(gui_files ${PROJECT_BINARY_DIR}/share/galaxy/gui)

function(is_new_node result program)
  execute_process(COMMAND ${program} --version OUTPUT_VARIABLE version ERROR_QUIET)
  if(NOT version MATCHES "^v([0-9]+)[.]" OR CMAKE_MATCH_1 LESS 18)
    set(${result} FALSE PARENT_SCOPE)
  endif()
endfunction()

if(GALAXY_GUI)
  find_program(GALAXY_NODE node VALIDATOR is_new_node)
  find_program(GALAXY_NPM npm)
endif()

if(GALAXY_GUI AND GALAXY_NODE AND GALAXY_NPM)
  file(GLOB_RECURSE gui_inputs CONFIGURE_DEPENDS ${gui_sources}/src/* ${gui_sources}/public/* ${gui_sources}/scripts/*)
  list(APPEND gui_inputs ${gui_sources}/package.json ${gui_sources}/package-lock.json ${gui_sources}/.npmrc
       ${gui_sources}/index.html ${gui_sources}/vite.config.ts ${gui_sources}/tsconfig.json)
  set(if_possible)
  if(GALAXY_GUI STREQUAL "AUTO")
    set(if_possible --if-possible)
  endif()
  add_custom_command(OUTPUT ${gui_files}/index.html
    COMMAND ${GALAXY_NODE} scripts/build.mjs ${gui_files} ${if_possible} DEPENDS ${gui_inputs}
    WORKING_DIRECTORY ${gui_sources} COMMENT "Building the browser GUI" VERBATIM)
elseif(GALAXY_GUI AND EXISTS ${gui_sources}/dist/index.html)
  file(GLOB_RECURSE gui_inputs CONFIGURE_DEPENDS ${gui_sources}/dist/*)
  add_custom_command(OUTPUT ${gui_files}/index.html
    COMMAND ${CMAKE_COMMAND} -E rm -rf ${gui_files}
    COMMAND ${CMAKE_COMMAND} -E copy_directory ${gui_sources}/dist ${gui_files} DEPENDS ${gui_inputs} VERBATIM)
elseif(GALAXY_GUI STREQUAL "AUTO" OR NOT GALAXY_GUI)
  message(STATUS "No browser GUI: expected npm and Node 18 or newer, or ${gui_sources}/dist (GALAXY_GUI is ${GALAXY_GUI})")
  add_custom_target(gui)
  return()
else()
  message(FATAL_ERROR "GALAXY_GUI is ON: expected npm and Node 18 or newer, or ${gui_sources}/dist")
endif()
add_custom_target(gui ALL DEPENDS ${gui_files}/index.html)
install(DIRECTORY ${gui_files} DESTINATION ${CMAKE_INSTALL_DATAROOTDIR}/galaxy OPTIONAL)
