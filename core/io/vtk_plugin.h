// SPDX-License-Identifier: Apache-2.0
// The table of plugin "vtk" (core/comm/plugin.h), which holds the readers and writers that call VTK. Nobody need know: the
// functions below are declared in the headers given and called by their names. In galaxy_io they are those of
// vtk_files.cpp, which open the plugin and call the function behind the pointer; in galaxy_vtk_files they are themselves.
#pragma once
#include "core/io/file.h"
#include "core/io/geometry_file.h"
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
  decltype(&gxy::writeGeometry) writeGeometry;
  decltype(&gxy::copyGeometry) copyGeometry;
  decltype(&gxy::writeGeometryPieces) writeGeometryPieces;
};

}  // namespace gxy
