// SPDX-License-Identifier: Apache-2.0
// Functions of plugin "vtk". The first call of one opens the plugin.
#include "core/comm/plugin.h"
#include "core/io/vtk_plugin.h"

namespace gxy {
namespace {

const VtkPlugin& vtk(const std::string& path) {
  static const VtkPlugin& table = [&]() -> const VtkPlugin& {
    const VtkPlugin& opened = plugin<VtkPlugin>("vtk", path + ": reading or writing it");
    opened.shareReadRules(readRules());
    return opened;
  }();
  return table;
}

}  // namespace

VolumeFile openVti(const std::string& path, const std::string& array) {
  return vtk(path).openVti(path, array);
}

VolumeFile openPvti(const std::string& path, const std::string& array) {
  return vtk(path).openPvti(path, array);
}

std::vector<std::string> xmlPieces(const std::string& path, const char* type) {
  return vtk(path).xmlPieces(path, type);
}

std::vector<std::string> geometryPieces(const std::string& path) { return vtk(path).geometryPieces(path); }

std::optional<ValuesWanted> valuesOfList(const std::string& path, std::optional<bool> ofCells) {
  return vtk(path).valuesOfList(path, ofCells);
}

GeometryContent readGeometry(const std::string& path, GeometryKind kind, const ValuesWanted& values,
                             const TakeMemory& toTake) {
  return vtk(path).readGeometry(path, kind, values, toTake);
}

GeometrySummary summariseGeometry(const std::string& path, const TakeMemory& toTake) {
  return vtk(path).summariseGeometry(path, toTake);
}

GeometryKind likelyKind(const GeometrySummary& summary) { return vtk("geometry").likelyKind(summary); }

MeshContent readMesh(const std::string& path, const MeshWanted& wanted, const TakeMemory& toTake) {
  return vtk(path).readMesh(path, wanted, toTake);
}

void writeGeometry(const std::string& path, const GeometryBlock& block, GeometryKind kind,
                   const std::string& array, const GeometryBlock* whole) {
  vtk(path).writeGeometry(path, block, kind, array, whole);
}

void writeMesh(const std::string& path, const GatheredMesh& mesh, const std::string& array, ScalarType type,
               int components, bool ofCells) {
  vtk(path).writeMesh(path, mesh, array, type, components, ofCells);
}

bool copyGeometry(const std::string& from, const std::string& to) { return vtk(to).copyGeometry(from, to); }

void writeGeometryPieces(const std::string& path, const std::vector<GeometryPiece>& pieces,
                         const GeometryBlock& like, const std::string& array) {
  vtk(path).writeGeometryPieces(path, pieces, like, array);
}

}  // namespace gxy
