// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <cstring>
#include <filesystem>
#include <iomanip>
#include <sstream>

#include "core/io/file.h"
#include "core/io/write_geometry.h"
#include "core/io/write_volume.h"
#include "core/scene/state_file.h"
#include "tests/random/random_scene.h"

namespace gxy::test {

namespace {

void save(const WholeVolume& volume, const std::string& path) {
  const bool encoded = volume.shift != 0 || volume.scale != 1;
  const ScalarType type = encoded ? ScalarType::Float64 : volume.stored;
  Samples samples = volume.samples;
  if (encoded) {
    const size_t n = samples.size() / sizeof(float);
    samples.resize(n * sizeof(double));
    for (size_t i = 0; i < n; i++) {
      float stored;
      std::memcpy(&stored, volume.samples.data() + i * sizeof stored, sizeof stored);
      const double value = volume.shift + volume.scale * double(stored);
      std::memcpy(samples.data() + i * sizeof value, &value, sizeof value);
    }
  }
  VolumeWriter(path, volume.grid, {{"data", type, volume.components, {}}}).write(0, 0, samples);
}

/// As an unstructured grid, in text.
void save(const WholeMesh& mesh, const std::string& path) {
  const MeshPiece& piece = mesh.cells;
  constexpr std::array<int, kCellTypes> kVtkTypes{10, 14, 13, 12};
  std::ostringstream out;
  out << std::setprecision(17);
  const auto array = [&](const char* type, const char* name, int components, auto write) {
    out << "<DataArray type=\"" << type << "\" Name=\"" << name << "\" NumberOfComponents=\"" << components
        << "\" format=\"ascii\">\n";
    write();
    out << "</DataArray>\n";
  };
  out << "<VTKFile type=\"UnstructuredGrid\" version=\"0.1\" "
         "byte_order=\"LittleEndian\">\n<UnstructuredGrid>\n"
      << "<Piece NumberOfPoints=\"" << piece.points.size() << "\" NumberOfCells=\"" << piece.cells.size()
      << "\">\n<Points>\n";
  array("Float64", "Points", 3, [&] {
    for (const glm::dvec3& p : piece.points) out << p.x << ' ' << p.y << ' ' << p.z << '\n';
  });
  out << "</Points>\n<Cells>\n";
  array("Int64", "connectivity", 1, [&] {
    for (const auto& ofType : piece.cells.points)
      for (const uint32_t point : ofType) out << point << '\n';
  });
  array("Int64", "offsets", 1, [&] {
    size_t end = 0;
    for (uint32_t cell = 0; cell < piece.cells.size(); cell++)
      out << (end += piece.cells.pointsOf(cell).size()) << '\n';
  });
  array("UInt8", "types", 1, [&] {
    for (uint32_t cell = 0; cell < piece.cells.size(); cell++)
      out << kVtkTypes[size_t(piece.cells.typeOf(cell))] << '\n';
  });
  out << "</Cells>\n<PointData Scalars=\"data\">\n";
  const bool encoded = mesh.shift != 0 || mesh.scale != 1;
  array(encoded ? "Float64" : "Float32", "data", piece.components, [&] {
    for (const float stored : piece.values) out << mesh.shift + mesh.scale * double(stored) << '\n';
  });
  out << "</PointData>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n";
  writeText(path, out.str());
}

}  // namespace

std::string saveScene(const TestScene& scene, const std::string& folder) {
  std::filesystem::create_directories(folder);
  const State state = stateOf(scene);
  for (size_t i = 0; i < scene.data.size(); i++) {
    const std::string path = folder + "/" + state.datasets[i].filename;
    if (const auto* volume = std::get_if<std::shared_ptr<const WholeVolume>>(&scene.data[i])) {
      save(**volume, path);
    } else if (const auto* mesh = std::get_if<std::shared_ptr<const WholeMesh>>(&scene.data[i])) {
      save(**mesh, path);
    } else {
      const auto& geometry = *std::get<std::shared_ptr<const WholeGeometry>>(scene.data[i]);
      writeGeometry(path, geometry.block, geometry.kind);
    }
  }
  const std::string path = folder + "/scene.state.json";
  writeText(path, writeState(state));
  return path;
}

}  // namespace gxy::test
