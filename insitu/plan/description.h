// SPDX-License-Identifier: Apache-2.0
// What a rank of a simulation says about its data before the first step, and the form of that on the wire.
#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/comm/transport.h"
#include "core/data/box.h"
#include "core/data/scalar.h"
#include "core/data/volume.h"

namespace gxy::insitu {

/// Limits of a stream. A description beyond them is refused.
inline constexpr int kMostRanks = 65536;
inline constexpr size_t kMostBlocks = size_t(1) << 20;  ///< of all ranks together
inline constexpr size_t kMostMeshes = 16;
inline constexpr size_t kMostFields = 64;  ///< of a mesh
inline constexpr int kMostComponents = 16;
inline constexpr int64_t kMostPoints = int64_t(1) << 31;             ///< by axis
inline constexpr int64_t kMostInAll = int64_t(1) << 46;              ///< points of a grid
inline constexpr uint64_t kMostParticles = (uint64_t(1) << 32) - 2;  ///< of one rank
inline constexpr size_t kMostName = 100;  ///< bytes of the name of a stream, mesh or field

/// A field: one array with values at the points of a mesh, or in its cells. Cells are a grid with a rim (Grid::rim): its points
/// are their centres and one more layer around them, which the simulation owns too, and sends with the values of the outermost cells.
struct Field {
  std::string name;
  ScalarType type = ScalarType::Float32;
  int components = 1;
  size_t bytesPerPoint() const { return bytesOf(type) * size_t(components); }
  bool operator==(const Field&) const = default;
};

/// What all ranks of a simulation say alike of a mesh.
struct Mesh {
  enum class Kind : uint8_t {
    Grid,   ///< each rank owns the same points in each step
    Points  ///< particles: each rank has any number of them, another one in each step
  };
  std::string name;
  Kind kind = Kind::Grid;
  std::vector<Field> fields;
  Grid grid;  ///< of a grid
  ScalarType positions =
      ScalarType::Float64;  ///< of points: the type of their coordinates, a float or a double
  bool ids = false;         ///< of points: whether they have numbers of their own
  Box box;                  ///< of points: the domain, world; empty: the simulation does not say
  bool operator==(const Mesh&) const = default;
};

/// Returns the arrays of a mesh that are sent: its fields, and before them the positions of points, and their numbers as 64 bits.
std::vector<Field> arraysOf(const Mesh& mesh);

/// A dataset that a stream publishes: a field of a mesh, or points that have no fields.
struct Publishes {
  size_t mesh = 0;
  std::optional<size_t> field;  ///< of the mesh
  std::string name;             ///< that of the dataset is STREAM.NAME
};
/// Returns all of them. Throws Error if two would have one name.
std::vector<Publishes> datasetsOf(std::span<const Mesh> meshes);

/// What one rank says of its part of a mesh.
struct Part {
  std::vector<Extent>
      blocks;  ///< of a grid: the points that the rank owns. Blocks without points are left out
  Box bounds;  ///< of points: the box of this rank's, before the first step; empty if it has none
};

/// What one rank says.
struct Description {
  std::vector<Mesh> meshes;
  std::vector<Part> parts;  ///< by mesh
};

/// Throws Error unless the name has 1 to kMostName bytes of UTF-8 without control characters. `what` names it in the error.
void checkName(const std::string& name, const std::string& what);

/// Throws Error, with what was expected, for a description beyond the limits, two meshes or datasets of one name, a grid that is
/// none, or a block that is not inside its grid.
void check(const Description& description);

Bytes written(std::span<const Mesh> meshes);
/// Reads what written() wrote. Throws Error for anything that is no list of meshes, but does not check() them.
std::vector<Mesh> readMeshes(std::span<const std::byte> message);
Bytes written(const Description& description);
/// Reads what written() wrote, and checks it. Throws Error for anything else.
Description readDescription(std::span<const std::byte> message);

}  // namespace gxy::insitu
