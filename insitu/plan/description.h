// SPDX-License-Identifier: Apache-2.0
// What a rank of a simulation says about its data before the first step, and the form of that on the wire.
#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/comm/transport.h"
#include "core/data/scalar.h"
#include "core/data/volume.h"

namespace gxy::insitu {

/// Limits of a stream. A description beyond them is refused.
inline constexpr int kMostRanks = 65536;
inline constexpr size_t kMostBlocks = size_t(1) << 20;  ///< of all ranks together
inline constexpr size_t kMostFields = 64;
inline constexpr int kMostComponents = 16;
inline constexpr int64_t kMostPoints = int64_t(1) << 31;  ///< by axis
inline constexpr int64_t kMostInAll = int64_t(1) << 46;   ///< points of a grid
inline constexpr size_t kMostName = 100;                  ///< bytes of the name of a stream, mesh or field

/// A field: one array with values at the points of the grid, or in its cells. Cells are a grid with a rim (Grid::rim): its points
/// are their centres and one more layer around them, which the simulation owns too, and sends with the values of the outermost cells.
struct Field {
  std::string name;
  ScalarType type = ScalarType::Float32;
  int components = 1;
  size_t bytesPerPoint() const { return bytesOf(type) * size_t(components); }
  bool operator==(const Field&) const = default;
};

/// What all ranks of a simulation say alike.
struct Mesh {
  std::string name;
  Grid grid;
  std::vector<Field> fields;
  bool operator==(const Mesh&) const = default;
};

/// What one rank says: the mesh, and the points that it owns. Blocks without points are left out.
struct Description {
  Mesh mesh;
  std::vector<Extent> blocks;
};

/// Throws Error unless the name has 1 to kMostName bytes of UTF-8 without control characters. `what` names it in the error.
void checkName(const std::string& name, const std::string& what);

/// Throws Error, with what was expected, for a description beyond the limits, a grid that is none, or a block that is not
/// inside the grid.
void check(const Description& description);

Bytes written(const Description& description);
/// Reads what written() wrote, and checks it. Throws Error for anything else.
Description readDescription(std::span<const std::byte> message);

}  // namespace gxy::insitu
