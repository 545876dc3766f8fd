// SPDX-License-Identifier: Apache-2.0
#include "insitu/plan/description.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "core/comm/error.h"
#include "core/comm/wire.h"

namespace gxy::insitu {

namespace {

std::string text(const Index3& i) {
  return std::to_string(i[0]) + " x " + std::to_string(i[1]) + " x " + std::to_string(i[2]);
}

bool isUtf8(const std::string& text) {
  try {
    return !nlohmann::json(text).dump().empty();
  } catch (const nlohmann::json::exception&) {
    return false;
  }
}

void checkGrid(const Grid& grid) {
  for (int a = 0; a < 3; a++) {
    const size_t axis = size_t(a);
    const int64_t least = grid.rim ? 3 : 2;
    if (grid.points[axis] < least || grid.points[axis] > kMostPoints)
      throw Error("grid of " + text(grid.points) + " points" +
                  (grid.rim ? ", the layer around cells included" : "") + ", expected " +
                  std::to_string(least) + " to 2^31 by axis");
    const double end = grid.origin[a] + grid.spacing[a] * double(grid.points[axis] - 1);
    if (!std::isfinite(grid.origin[a]) || !std::isfinite(end) || !(grid.spacing[a] > 0))
      throw Error("grid with origin " + std::to_string(grid.origin[a]) + " and spacing " +
                  std::to_string(grid.spacing[a]) + " on axis " + std::to_string(a) +
                  ", expected finite numbers and a spacing above 0");
  }
  if (grid.points[0] > kMostInAll / grid.points[1] / grid.points[2])
    throw Error("grid of " + text(grid.points) + " points, expected at most 2^46 in all");
}

void checkFields(const std::vector<Field>& fields) {
  if (fields.empty() || fields.size() > kMostFields)
    throw Error(std::to_string(fields.size()) + " fields, expected 1 to " + std::to_string(kMostFields));
  std::set<std::string> names;
  for (const Field& f : fields) {
    checkName(f.name, "field");
    if (!names.insert(f.name).second) throw Error("field \"" + f.name + "\" is there twice");
    if (f.type > ScalarType::Float64)
      throw Error("field \"" + f.name + "\": type " + std::to_string(int(f.type)) + ", expected 0 to 9");
    if (f.components < 1 || f.components > kMostComponents)
      throw Error("field \"" + f.name + "\": " + std::to_string(f.components) +
                  " components, expected 1 to " + std::to_string(kMostComponents));
  }
}

void checkBlock(const Extent& block, const Grid& grid) {
  for (size_t a = 0; a < 3; a++)
    if (block.points[a] < 1 || block.first[a] < 0 || block.first[a] > grid.points[a] ||
        block.points[a] > grid.points[a] - block.first[a])
      throw Error("block of " + text(block.points) + " points from (" + std::to_string(block.first[0]) +
                  ", " + std::to_string(block.first[1]) + ", " + std::to_string(block.first[2]) +
                  "), expected it inside the grid of " + text(grid.points) + " points");
}

}  // namespace

void checkName(const std::string& name, const std::string& what) {
  const bool controls = std::any_of(name.begin(), name.end(),
                                    [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; });
  const bool isText = isUtf8(name) && !controls;
  if (name.empty() || name.size() > kMostName || !isText)
    throw Error("the name of a " + what + " has " + std::to_string(name.size()) + " bytes" +
                (isText ? "" : " that are no text, or control characters") + ", expected 1 to " +
                std::to_string(kMostName) + " bytes of text");
}

void check(const Description& description) {
  checkName(description.mesh.name, "mesh");
  checkGrid(description.mesh.grid);
  checkFields(description.mesh.fields);
  if (description.blocks.size() > kMostBlocks)
    throw Error(std::to_string(description.blocks.size()) + " blocks, expected at most 2^20");
  for (const Extent& block : description.blocks) checkBlock(block, description.mesh.grid);
}

Bytes written(const Description& d) {
  Writer w;
  w.write(d.mesh.name).write(d.mesh.grid.origin).write(d.mesh.grid.spacing).write(d.mesh.grid.points);
  w.write(d.mesh.grid.rim);
  w.write(uint32_t(d.mesh.fields.size()));
  for (const Field& f : d.mesh.fields) w.write(f.name).write(uint8_t(f.type)).write(uint32_t(f.components));
  return w.write(d.blocks).take();
}

Description readDescription(std::span<const std::byte> message) {
  Reader r(message, "description of a simulation's data");
  Description d;
  d.mesh.name = r.readString();
  d.mesh.grid.origin = r.read<glm::dvec3>();
  d.mesh.grid.spacing = r.read<glm::dvec3>();
  d.mesh.grid.points = r.read<Index3>();
  d.mesh.grid.rim = r.read<bool>();
  const auto fields = r.read<uint32_t>();
  if (fields > kMostFields) r.fail(std::to_string(fields) + " fields, expected at most 64");
  for (uint32_t i = 0; i < fields; i++) {
    Field f;
    f.name = r.readString();
    f.type = ScalarType(r.read<uint8_t>());
    f.components = int(std::min<uint32_t>(r.read<uint32_t>(), uint32_t(kMostComponents) + 1));
    d.mesh.fields.push_back(std::move(f));
  }
  d.blocks = r.readVector<Extent>();
  r.expectEnd();
  check(d);
  return d;
}

}  // namespace gxy::insitu
