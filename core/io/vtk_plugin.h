// SPDX-License-Identifier: Apache-2.0
// The table of plugin "vtk" (core/comm/plugin.h), which contains the readers and writers that call VTK.
// Callers need not know about it: they call the functions below by the names that the included headers
// declare. In galaxy_io these are the functions of vtk_files.cpp, which open the plugin and call through the
// table. In galaxy_vtk_files they are the functions themselves.
#pragma once
#include "core/io/file.h"
#include "core/io/geometry_file.h"
#include "core/io/mesh_file.h"
#include "core/io/volume_formats.h"
#include "core/io/write_geometry.h"

namespace gxy {

struct VtkPlugin {
  decltype(&gxy::shareReadRules) shareReadRules;  ///< called once, before the others
  decltype(&gxy::openVti) openVti;
  decltype(&gxy::openPvti) openPvti;
  decltype(&gxy::xmlPieces) xmlPieces;
  decltype(&gxy::geometryPieces) geometryPieces;
  decltype(&gxy::valuesOfList) valuesOfList;
  decltype(&gxy::readGeometry) readGeometry;
  decltype(&gxy::summariseGeometry) summariseGeometry;
  decltype(&gxy::likelyKind) likelyKind;
  decltype(&gxy::readMesh) readMesh;
  decltype(&gxy::writeGeometry) writeGeometry;
  decltype(&gxy::writeMesh) writeMesh;
  decltype(&gxy::copyGeometry) copyGeometry;
  decltype(&gxy::writeGeometryPieces) writeGeometryPieces;
};

}  // namespace gxy
