// SPDX-License-Identifier: Apache-2.0
#include "core/data/geometry_bytes.h"

#include <string>

namespace gxy {

void write(Writer& writer, const GeometryBlock& block) {
  writer.write(block.points).write(block.normals).write(block.values).write(block.colors);
  writer.write(block.radiusValues);
  writer.write(uint32_t(block.fields.size()));
  for (const PointField& f : block.fields) writer.write(f.name).write(int32_t(f.components)).write(f.values);
  writer.write(block.triangles).write(block.segments).write(block.neighbours).write(block.ids);
}

GeometryBlock readBlock(Reader& reader) {
  GeometryBlock block;
  block.points = reader.readVector<glm::dvec3>();
  block.normals = reader.readVector<glm::vec3>();
  block.values = reader.readVector<float>();
  block.colors = reader.readVector<glm::vec3>();
  block.radiusValues = reader.readVector<float>();
  const auto fields = reader.read<uint32_t>();
  if (fields > kMostPointFields)
    reader.fail(std::to_string(fields) + " fields of points were announced, expected at most " +
                std::to_string(kMostPointFields));
  for (uint32_t f = 0; f < fields; f++) {
    PointField& field = block.fields.emplace_back();
    field.name = reader.readString();
    field.components = reader.read<int32_t>();
    field.values = reader.readVector<float>();
  }
  block.triangles = reader.readVector<std::array<uint32_t, 3>>();
  block.segments = reader.readVector<std::array<uint32_t, 2>>();
  block.neighbours = reader.readVector<std::array<uint32_t, 2>>();
  block.ids = reader.readVector<uint64_t>();
  return block;
}

}  // namespace gxy
