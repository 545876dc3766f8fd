// SPDX-License-Identifier: Apache-2.0
#include "core/data/geometry_bytes.h"

namespace gxy {

void write(Writer& writer, const GeometryBlock& block) {
  writer.write(block.points).write(block.normals).write(block.values).write(block.colors);
  writer.write(block.radiusValues);
  writer.write(block.triangles).write(block.segments).write(block.neighbours).write(block.ids);
}

GeometryBlock readBlock(Reader& reader) {
  GeometryBlock block;
  block.points = reader.readVector<glm::dvec3>();
  block.normals = reader.readVector<glm::vec3>();
  block.values = reader.readVector<float>();
  block.colors = reader.readVector<glm::vec3>();
  block.radiusValues = reader.readVector<float>();
  block.triangles = reader.readVector<std::array<uint32_t, 3>>();
  block.segments = reader.readVector<std::array<uint32_t, 2>>();
  block.neighbours = reader.readVector<std::array<uint32_t, 2>>();
  block.ids = reader.readVector<uint64_t>();
  return block;
}

}  // namespace gxy
