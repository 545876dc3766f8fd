// SPDX-License-Identifier: Apache-2.0
#include "core/io/vtk_plugin.h"

#include "core/comm/plugin.h"

namespace {

const gxy::VtkPlugin table = {.shareReadRules = gxy::shareReadRules,
                              .openVti = gxy::openVti,
                              .openPvti = gxy::openPvti,
                              .xmlPieces = gxy::xmlPieces,
                              .geometryPieces = gxy::geometryPieces,
                              .valuesOfList = gxy::valuesOfList,
                              .readGeometry = gxy::readGeometry,
                              .summariseGeometry = gxy::summariseGeometry,
                              .likelyKind = gxy::likelyKind,
                              .readMesh = gxy::readMesh,
                              .writeGeometry = gxy::writeGeometry,
                              .writeMesh = gxy::writeMesh,
                              .copyGeometry = gxy::copyGeometry,
                              .writeGeometryPieces = gxy::writeGeometryPieces};

}  // namespace

GALAXY_PLUGIN(table)
