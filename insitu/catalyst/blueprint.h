// SPDX-License-Identifier: Apache-2.0
// What Galaxy takes of a mesh in Conduit's Mesh Blueprint: blocks of uniform grids, points, cells, and fields.
#pragma once
#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "insitu/catalyst/conduit.h"

namespace gxy::catalyst {

using Index = std::array<int64_t, 3>;
using Position = std::array<double, 3>;

/// A field on a mesh of this rank.
struct Values {
  std::string path, name;
  bool ofElements = false;
  std::vector<Array> components;  ///< of one type and length
};

/// A box of a block's points, its last ones included.
struct Box {
  Index first{}, count{};
  bool ofPoints =
      false;  ///< ghosts of points have said so: exactly these points are owned. Else the cells between them are.
  bool empty() const { return count[0] <= 0 || count[1] <= 0 || count[2] <= 0; }
};

/// A block of a uniform grid.
struct GridBlock {
  std::string path, mesh;
  Index points{};  ///< 1 along z in two dimensions
  Position origin{}, spacing{};
  std::optional<Index> index;  ///< of the block's first point in the whole grid
  std::vector<Values> fields;
  std::optional<Values> ghosts;
};

/// Cells along an axis. A grid of one layer of points in z has two dimensions, and one layer of cells.
int64_t cells(const Index& points, size_t axis);

/// What the block has without ghosts. Throws std::runtime_error where that is not a box.
Box ownedOf(const GridBlock& block);

/// Cells between points.
struct Cells {
  uint8_t type = 0;  ///< gxy_cell of all cells; 0: each has another one
  Array types,       ///< where each has another one
      offsets,       ///< likewise, one more than there are cells
      connectivity;
  int64_t count = 0;
  bool isVolume = false;
  std::vector<std::shared_ptr<const void>>
      made;  ///< what holds those arrays that the simulation does not have
};

/// The name of the field that says which cells with a volume are ghosts, as gxy_field() takes it.
inline constexpr const char* kGhosts = "vtkGhostType";

/// Points, with a field for each. Or with cells between them, and fields of both; of cells with a volume kGhosts, too.
struct Points {
  std::string path, mesh;
  Values positions;
  std::vector<Values> fields;
  std::optional<Cells> cells;
  std::shared_ptr<const void> made{};  ///< what holds positions that the simulation does not have
};

/// What was made of lattices for the step before, so that it is made anew only where it is another one.
struct Lattices {
  /// The corners of the cells, by points along x, y and z.
  std::map<Index, std::shared_ptr<const std::vector<uint32_t>>> corners;
  struct Placed {
    std::array<std::vector<double>, 3> planes;  ///< coordinates along each axis
    std::shared_ptr<const std::vector<double>> points;
  };
  std::map<std::string, Placed> placed;  ///< by the path of the coordinates
};
void forgetUnused(Lattices& lattices);

/// What is published must not outlive it.
struct Meshes {
  std::vector<GridBlock> grids;
  std::vector<Points> points;
  Lattices lattices;
};

using Warn = std::function<void(const std::string&)>;

/// The domains of a Blueprint mesh: itself, or its children, without those that are empty.
std::vector<Node> domainsOf(const Node& data);

/// Adds the meshes of `mesh`, a Blueprint mesh, to `meshes`. `name` becomes that of its grid and `pointsName` that of its points or cells.
/// What Galaxy does not take is told to `warn` and left out. `ghosts` is the name of the field of ghosts; empty: one of the usual names.
/// Throws std::runtime_error where the mesh is not what the Blueprint says.
void addMeshes(const Node& mesh, const std::string& name, const std::string& pointsName,
               const std::string& ghosts, const Warn& warn, Meshes& meshes);

}  // namespace gxy::catalyst
