# SPDX-License-Identifier: Apache-2.0
# Installs files besides programs and libraries, and describes packages.
#
#   BIN/galaxy                           the script, which uses the programs beside it
#   lib/python3/dist-packages/galaxy.py  the client in Python
#   lib/python3/dist-packages/gxy/       the Python package of simulations
#   share/doc/galaxy/                    docs/, README.md, the licence, and examples/
#   share/galaxy/version                 the version, for the two scripts
#   share/galaxy/gui/                    the browser GUI (GalaxyGui)
#
# cpack -G DEB makes a package for the system that it runs on. The package depends on the packages that its
# libraries come from. cpack --config CPackSourceConfig.cmake (target package_source) makes a tarball of the
# sources.
set(doc ${CMAKE_INSTALL_DATAROOTDIR}/doc/galaxy)
file(WRITE ${PROJECT_BINARY_DIR}/version "${PROJECT_VERSION}\n")
install(PROGRAMS ${PROJECT_SOURCE_DIR}/tools/galaxy DESTINATION ${CMAKE_INSTALL_BINDIR})
install(PROGRAMS ${PROJECT_SOURCE_DIR}/tools/python/galaxy.py DESTINATION lib/python3/dist-packages)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/python/src/gxy DESTINATION lib/python3/dist-packages FILES_MATCHING PATTERN "*.py")
install(FILES ${PROJECT_BINARY_DIR}/version DESTINATION ${CMAKE_INSTALL_DATAROOTDIR}/galaxy)
install(FILES ${PROJECT_SOURCE_DIR}/README.md ${PROJECT_SOURCE_DIR}/LICENSE DESTINATION ${doc})
install(DIRECTORY ${PROJECT_SOURCE_DIR}/docs DESTINATION ${doc})
install(DIRECTORY ${PROJECT_SOURCE_DIR}/docs/examples DESTINATION ${doc})

set(CPACK_PACKAGE_NAME galaxy)
set(CPACK_PACKAGE_VENDOR Galaxy)
set(CPACK_PACKAGE_CONTACT "Galaxy <galaxy@localhost>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "Distributed renderer and multi-user visualization server")
set(CPACK_RESOURCE_FILE_LICENSE ${PROJECT_SOURCE_DIR}/LICENSE)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_THREADS 0)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_DEPENDS "fonts-dejavu-core, openmpi-bin")
set(CPACK_DEBIAN_PACKAGE_RECOMMENDS "python3-numpy, mesa-vulkan-drivers")
set(CPACK_DEBIAN_COMPRESSION_TYPE gzip)
set(CPACK_SOURCE_GENERATOR TGZ)
set(CPACK_SOURCE_PACKAGE_FILE_NAME galaxy-${PROJECT_VERSION})
set(CPACK_SOURCE_IGNORE_FILES "${PROJECT_SOURCE_DIR}/build/" "${PROJECT_SOURCE_DIR}/\\\\.git(/|$)"
                              "${PROJECT_SOURCE_DIR}/gui/node_modules/" "${PROJECT_SOURCE_DIR}/\\\\.cache/" "\\\\.swp$" "__pycache__/")
include(CPack)
