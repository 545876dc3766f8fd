// SPDX-License-Identifier: Apache-2.0
#include "core/io/write_dataset.h"

#include <algorithm>
#include <filesystem>

#include "core/comm/error.h"
#include "core/data/gather.h"
#include "core/data/gather_mesh.h"
#include "core/data/geometry_bytes.h"
#include "core/io/write_geometry.h"
#include "core/io/write_volume.h"

namespace gxy {
namespace {

const char* nameOf(const std::optional<GeometryKind>& kind) {
  if (!kind) return "Volume";
  constexpr const char* kNames[] = {"Particles", "PathLines", "Triangles"};
  return kNames[size_t(*kind)];
}

void writeWholeVolume(const Dataset& dataset, Collectives& ranks, const std::string& path) {
  const Volume& volume = *dataset.volume;
  std::optional<VolumeWriter> writer;
  agree(ranks, [&] {
    if (ranks.rank() != 0) return;
    ArrayInfo array{arrayName(dataset), gatheredType(volume), volume.components, {}, volume.grid.rim};
    writer.emplace(path, volume.grid, std::vector{std::move(array)});
  });
  gatherSlices(volume, *dataset.partitioning, ranks, kSlabBytes,
               [&](int64_t first, std::span<const std::byte> values) { writer->write(0, first, values); });
}

void writeWholeGeometry(const Dataset& dataset, Collectives& ranks, const std::string& path) {
  const GeometryBlock all = gatherGeometry(*dataset.geometry, ranks);
  agree(ranks, [&] {
    if (ranks.rank() == 0) writeGeometry(path, all, dataset.geometry->kind, arrayName(dataset));
  });
}

void writeWholeMesh(const Dataset& dataset, Collectives& ranks, const std::string& path) {
  const Mesh& mesh = *dataset.mesh;
  const GatheredMesh all = gatherMesh(mesh, *dataset.partitioning, ranks);
  agree(ranks, [&] {
    if (ranks.rank() == 0)
      writeMesh(path, all, arrayName(dataset), gatheredType(mesh), mesh.components, mesh.ofCells);
  });
}

void checkExtension(const std::vector<std::string>& extensions, const std::string& file,
                    const std::string& what) {
  std::string list;
  for (const std::string& extension : extensions) {
    if (file.size() > extension.size() && file.ends_with(extension)) return;
    list += (list.empty() ? "" : ", ") + extension;
  }
  throw Error("file \"" + file + "\" for " + what + ": expected a name that ends with one of " + list);
}

}  // namespace

std::vector<std::string> extensionsFor(const std::optional<GeometryKind>& kind) {
  if (!kind) return {".vti", ".vtu"};
  switch (*kind) {
    case GeometryKind::Particles:
      return {".vtp", ".vtu", ".csv"};
    case GeometryKind::PathLines:
      return {".vtp", ".vtu"};
    case GeometryKind::Triangles:
      break;
  }
  return {".vtp", ".vtu", ".ply", ".stl"};
}

void checkFileFor(const std::optional<GeometryKind>& kind, const std::string& file, const std::string& what) {
  checkExtension(extensionsFor(kind), file, what + ", which is " + nameOf(kind));
}

void checkFileFor(const Dataset& dataset, const std::string& file, const std::string& what) {
  if (dataset.geometry) return checkFileFor(dataset.geometry->kind, file, what);
  if (dataset.mesh) return checkExtension({".vtu"}, file, what + ", which is an unstructured Volume");
  checkExtension({".vti"}, file, what + ", which is a Volume on a uniform grid");
}

int64_t gatheringBytes(const Dataset& dataset, bool root) {
  if (dataset.mesh) return gatheringBytes(*dataset.mesh, root);
  if (dataset.volume) {
    const int64_t slice = gatheredSliceBytes(*dataset.volume);
    return 2 * std::min(std::max(kSlabBytes, slice), slice * gatheredPoints(dataset.volume->grid)[2]);
  }
  const int64_t own = bytesOf(dataset.geometry->block);
  constexpr int64_t kPrimitive = 200;  // its points with all that they may have, and its indices
  int64_t floats = 0;                  // of further fields at each of at most three points
  for (const PointFieldInfo& f : dataset.geometry->fields) floats += f.components;
  const int64_t primitive = kPrimitive + 3 * floats * int64_t(sizeof(float));
  return root ? own + 3 * primitive * int64_t(dataset.geometry->primitives) : own;
}

std::string arrayName(const Dataset& dataset) {
  if (dataset.geometry && !dataset.geometry->array.empty()) return dataset.geometry->array;
  if (!dataset.array.empty()) return dataset.array;
  std::string name = dataset.volume ? dataset.volume->name
                     : dataset.mesh ? dataset.mesh->name
                                    : dataset.geometry->name;
  if (!dataset.file.empty()) {  // FILE:ARRAY of a volume or a mesh, FILE of geometry
    const size_t file = std::filesystem::path(dataset.file).stem().string().size();
    name = name.size() > file ? name.substr(file + 1) : "";
  }
  return name.empty() ? "data" : name;
}

void writeDataset(const Dataset& dataset, Collectives& ranks, const std::string& path) {
  if (dataset.volume)
    writeWholeVolume(dataset, ranks, path);
  else if (dataset.mesh)
    writeWholeMesh(dataset, ranks, path);
  else
    writeWholeGeometry(dataset, ranks, path);
}

}  // namespace gxy
