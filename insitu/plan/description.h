// SPDX-License-Identifier: Apache-2.0
// What a rank of a simulation says about its data, and the form of that on the wire.
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
inline constexpr int64_t kMostPoints = int64_t(1) << 31;  ///< by axis
inline constexpr int64_t kMostInAll = int64_t(1) << 46;   ///< points of a grid
inline constexpr uint64_t kMostParticles =
    (uint64_t(1) << 32) - 2;  ///< of one rank; also the most points of a mesh of cells, and corners
inline constexpr size_t kMostName = 100;  ///< bytes of the name of a stream, mesh or field

/// A field: one array with values at the points of a mesh, or in its cells. The cells of a grid are one with a rim (Grid::rim): its points
/// are their centres and one more layer around them, which the simulation owns too, and sends with the values of the outermost cells.
struct Field {
  std::string name;
  ScalarType type = ScalarType::Float32;
  int components = 1;
  bool ofCells = false;  ///< of a mesh of cells: whether each cell has a value, or each point
  size_t bytesPerPoint() const { return bytesOf(type) * size_t(components); }
  bool operator==(const Field&) const = default;
};

/// What all ranks of a simulation say alike of a mesh.
struct Mesh {
  enum class Kind : uint8_t {
    Grid,    ///< each rank owns the same points in each step, until it says something else
    Points,  ///< particles: each rank has any number of them, another one in each step
    Cells    ///< points, and cells between them: each rank has any number, others in each step
  };
  /// What the cells of a mesh become.
  enum class Shape : uint8_t {
    Unknown,  ///< the rank has no cells
    Lines,
    Triangles,
    Volume  ///< an unstructured volume
  };
  std::string name;
  Kind kind = Kind::Grid;
  std::vector<Field> fields;
  Grid grid;  ///< of a grid
  ScalarType positions =
      ScalarType::Float64;       ///< of points and cells: the type of coordinates, a float or a double
  bool ids = false;              ///< of points: whether they have numbers of their own
  Box box;                       ///< of points: the domain, world; empty: the simulation does not say
  Shape shape = Shape::Unknown;  ///< of cells
  bool operator==(const Mesh&) const = default;
};

/// What the entries of an array belong to. A corner is a point of a cell, once for each cell that it is in.
enum class Per : uint8_t { Point, Cell, Corner };

/// How many points, cells and corners a rank has of each mesh in a step; 0 of grids.
using Counts = std::vector<uint64_t>;
/// The place of a number in Counts.
constexpr size_t placeOf(size_t mesh, Per per) { return 3 * mesh + size_t(per); }

/// An array that is sent.
struct Array : Field {
  enum class What : uint8_t { Positions, Ids, Types, Ends, Connectivity, Field };
  What what = What::Field;
  Per per = Per::Point;
  size_t field = 0;  ///< which of the mesh's fields it is
};
/// Returns the arrays of a mesh, in the order in which they are sent: those of points, then those of cells, then those of corners.
/// Of a grid they are its fields. Points also have positions, which come first, and numbers, as 64 bits. Cells also have their type in
/// VTK (8 bits), and the number of corners up to their end (32 bits); and each corner the number of its point (32 bits).
std::vector<Array> arraysOf(const Mesh& mesh);

/// What cells of a shape are called, for users: "lines".
const char* nameOf(Mesh::Shape shape);

/// Whether a field marks the ghosts of cells with a volume, as arrays of that name do in files. It is no dataset.
bool isGhosts(const Mesh& mesh, const Field& field);

/// Throws Error for cells with a volume that have no field, or whose ghosts are not bytes. The fields and shapes are known.
void checkVolumes(std::span<const Mesh> meshes);

/// Whether a field has the normals of a mesh of triangles or lines: three components of points, with the name that files use. They
/// belong to all datasets of the mesh, and are none by themselves.
bool isNormals(const Mesh& mesh, const Field& field);

/// Throws Error unless a simulation may go on with `now` after `before`: grids may have another size, origin and spacing, and cells that
/// had no shape may have one; all else stays.
void checkContinues(const std::vector<Mesh>& before, const std::vector<Mesh>& now);

/// Takes over what another rank says of the meshes: the shape of cells, if this one does not know it. Throws Error if they differ; `rank`
/// is the other one.
void mergeMeshes(std::vector<Mesh>& meshes, const std::vector<Mesh>& others, int rank);

/// A dataset that a stream publishes: a field of a mesh, or points or cells that have no fields.
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
  Box bounds;  ///< of points and cells: the box of this rank's, before the first step; empty if it has none
};

/// What one rank says. It may say something else later: other blocks, or another grid. Then the meshes and their fields are the same,
/// and `from` is larger.
struct Description {
  uint64_t from = 1;  ///< the first publish that it is true of, counted from 1
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
