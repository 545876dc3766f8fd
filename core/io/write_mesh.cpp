// SPDX-License-Identifier: Apache-2.0
// Writes binary PLY and STL, little-endian on machines of either byte order, and points as text.
#include <algorithm>
#include <array>
#include <bit>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>
#include <limits>
#include <set>

#include "core/comm/error.h"
#include "core/io/file.h"
#include "core/io/write_geometry.h"

namespace gxy {
namespace {

template <class T>
void put(std::string& bytes, T value) {
  char raw[sizeof(T)];
  std::memcpy(raw, &value, sizeof(T));
  if constexpr (std::endian::native == std::endian::big) std::reverse(raw, raw + sizeof(T));
  bytes.append(raw, sizeof(T));
}

/// In quotes, and those of the name twice (RFC 4180).
std::string quotedColumn(const std::string& name) {
  std::string text = "\"";
  for (const char c : name) text += c == '"' ? std::string("\"\"") : std::string(1, c);
  return text + '"';
}

/// The name of a component in a file without arrays of several.
std::string componentName(const PointField& field, int component, char between) {
  return field.components == 1 ? field.name : field.name + between + std::to_string(component);
}

/// A word that no other property has.
std::string propertyName(std::string name, std::set<std::string>& taken) {
  for (char& c : name)
    if (!std::isgraph(static_cast<unsigned char>(c))) c = '_';
  while (!taken.insert(name).second) name += '_';
  return name;
}

}  // namespace

uint8_t byteOf(float component) { return uint8_t(std::lround(component * 255)); }

bool haveBytes(const std::vector<glm::vec3>& colors) {
  return std::all_of(colors.begin(), colors.end(), [](const glm::vec3& color) {
    for (int c = 0; c < 3; ++c)
      if (color[c] != float(byteOf(color[c]) / 255.)) return false;
    return true;
  });
}

void writeCsv(const std::string& path, const GeometryBlock& block, const std::string& array) {
  std::string text = "x,y,z";
  if (!block.values.empty()) text += ',' + quotedColumn(array);
  if (!block.colors.empty()) text += ",red,green,blue";
  if (!block.radiusValues.empty()) text += ",radius";
  std::vector<const PointField*> fields;
  for (const PointField& f : block.fields) {
    if (repeatsValues(block, f, array)) continue;
    fields.push_back(&f);
    for (int c = 0; c < f.components; ++c) text += ',' + quotedColumn(componentName(f, c, ':'));
  }
  const auto put = [&](auto value, char end) {
    std::array<char, 32> digits;
    const auto written = std::to_chars(digits.data(), digits.data() + digits.size(), value);
    text.append(digits.data(), written.ptr);
    text += end;
  };
  text += '\n';
  for (size_t i = 0; i < block.points.size(); ++i) {
    for (int a = 0; a < 3; ++a) put(block.points[i][a], ',');
    if (!block.values.empty()) put(block.values[i], ',');
    for (int c = 0; c < 3 && !block.colors.empty(); ++c) put(block.colors[i][c], ',');
    if (!block.radiusValues.empty()) put(block.radiusValues[i], ',');
    for (const PointField* f : fields)
      for (int c = 0; c < f->components; ++c) put(fieldValue(*f, c, i), ',');
    text.back() = '\n';
  }
  writeText(path, text);
}

void writePly(const std::string& path, const GeometryBlock& block) {
  std::string bytes = "ply\nformat binary_little_endian 1.0\nelement vertex " +
                      std::to_string(block.points.size()) +
                      "\nproperty double x\nproperty double y\nproperty double z\n";
  if (!block.normals.empty()) bytes += "property float nx\nproperty float ny\nproperty float nz\n";
  if (!block.values.empty()) bytes += "property float value\n";
  const bool inBytes = haveBytes(block.colors);
  for (const char* component : {"red", "green", "blue"})
    if (!block.colors.empty())
      bytes += std::string("property ") + (inBytes ? "uchar " : "float ") + component + "\n";
  std::set<std::string> taken{"x", "y", "z", "nx", "ny", "nz", "value", "red", "green", "blue", "alpha"};
  for (const PointField& f : block.fields)
    for (int c = 0; c < f.components; ++c)
      bytes += "property float " + propertyName(componentName(f, c, '_'), taken) + "\n";
  bytes += "element face " + std::to_string(block.triangles.size()) +
           "\nproperty list uchar int vertex_indices\nend_header\n";
  for (size_t i = 0; i < block.points.size(); ++i) {
    for (int a = 0; a < 3; ++a) put(bytes, block.points[i][a]);
    if (!block.normals.empty())
      for (int a = 0; a < 3; ++a) put(bytes, block.normals[i][a]);
    if (!block.values.empty()) put(bytes, block.values[i]);
    for (int c = 0; c < 3 && !block.colors.empty(); ++c)
      inBytes ? put(bytes, byteOf(block.colors[i][c])) : put(bytes, block.colors[i][c]);
    for (const PointField& f : block.fields)
      for (int c = 0; c < f.components; ++c) put(bytes, fieldValue(f, c, i));
  }
  for (const auto& triangle : block.triangles) {
    put(bytes, uint8_t(3));
    for (uint32_t index : triangle) {
      if (index > uint32_t(std::numeric_limits<int32_t>::max()))
        throw Error(path + ": more than 2^31 points");
      put(bytes, int32_t(index));
    }
  }
  writeText(path, bytes);
}

void writeStl(const std::string& path, const GeometryBlock& block) {
  if (block.triangles.size() > std::numeric_limits<uint32_t>::max())
    throw Error(path + ": more than 2^32 triangles");
  std::string bytes(80, ' ');
  put(bytes, uint32_t(block.triangles.size()));
  for (const auto& t : block.triangles) {
    const glm::dvec3 &a = block.points[t[0]], &b = block.points[t[1]], &c = block.points[t[2]];
    glm::dvec3 normal = glm::cross(b - a, c - a);
    if (const double length = glm::length(normal); length > 0) normal /= length;
    for (const glm::dvec3& v : {normal, a, b, c})
      for (int axis = 0; axis < 3; ++axis) put(bytes, float(v[axis]));
    put(bytes, uint16_t(0));
  }
  writeText(path, bytes);
}

}  // namespace gxy
