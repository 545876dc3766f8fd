// SPDX-License-Identifier: Apache-2.0
// What a simulation has said of its meshes, and where its arrays lie.
#pragma once
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "insitu/api/galaxy_insitu.h"
#include "insitu/client/cell_arrays.h"
#include "insitu/plan/description.h"
#include "insitu/plan/encodings.h"
#include "insitu/plan/redistribution.h"

namespace gxy::insitu {

/// The meshes of one rank. Functions throw Error for wrong use, which names the function of the interface; then nothing has changed. The
/// arrays are those of the simulation. They are read in describe(), counts(), copy() and keep() only.
class Meshes {
 public:
  /// Which calls of grid() after describe() lead to another description.
  enum class News { Changes, Each, None };
  /// `grid` and `owned` count points, or cells if `of` is GXY_OF_CELLS; the origin is that of the first point in both cases. After
  /// describe(), another grid than before has no blocks but this one. A block that changes loses its fields. With News::None
  /// a change is wrong.
  void grid(const std::string& mesh, int block, int of, Grid grid, const Extent& owned, News news);
  /// `box` may be empty.
  void points(const std::string& mesh, uint64_t count, const gxy_array& positions, const gxy_array& ids,
              const Box& box);
  void cells(const std::string& mesh, uint64_t count, const gxy_array& positions, const CellArrays& cells);
  void field(const std::string& mesh, int block, const std::string& name, int of, const gxy_array& values);

  bool isDescribed() const { return !meshes_.empty(); }
  /// Whether describe() has something new.
  bool hasNews() const { return news_; }
  /// Returns what is said to the server. From now on meshes and fields are as they are, but for the sizes and blocks of grids.
  Description describe();
  /// The same after describe(), also if blocks have no fields. That is told by check() then.
  Description describeBlocks();
  /// Throws Error if describe() would, after it was called once.
  void checkNews() const;
  /// Throws Error if particles, cells or blocks lack an array. `function` is the one that publishes.
  void check(const char* function) const;

  /// What this rank has of each mesh, in the order of the description. Reads the offsets of cells.
  Counts counts() const;
  /// Copies what is to be sent, in the order of the destinations. `to` has room for bytes(). `counts` are those of counts().
  void copy(std::span<const Destination> destinations, const Encodings& encodings, const Counts& counts,
            std::byte* to) const;
  /// Returns the bytes that copy() writes.
  uint64_t bytes(std::span<const Destination> destinations, const Encodings& encodings,
                 const Counts& counts) const;
  /// Copies all arrays, and reads the copies from then on. Nothing has changed if there is no memory for it.
  void keep();

 private:
  using Arrays = std::map<std::string, gxy_array>;
  struct Block {
    Extent owned;   ///< points of the stream's grid: for cells, with the rim beside them
    Extent values;  ///< those of them that fields have values of
    Arrays fields;
  };
  struct Data {
    Mesh mesh;                    ///< its fields are known once it is described
    std::map<int, Block> blocks;  ///< of a grid; of points and cells the block 0, with all points
    gxy_array positions{}, ids{};
    CellArrays cells;
    Box bounds;                         ///< of points and cells, as they were described first
    Arrays cellFields;                  ///< of a mesh of cells: the fields of cells
    std::vector<const Block*> present;  ///< the blocks that have points, once it is described
  };
  Data& at(const std::string& mesh, const std::string& what);
  /// Returns what the server knows of a mesh that is no grid; null before the first step.
  const Mesh* described(const std::string& what, const Mesh& mesh) const;
  /// The mesh has these points from now on. Its fields have to be told again.
  Data& replace(const Mesh& mesh, uint64_t points, const gxy_array& positions);
  static void copy(const Data& data, const Array& array, uint64_t count, std::byte* to);
  static std::vector<Field> fieldsOf(const Data& data);
  static void checkFields(const Data& data);
  static uint64_t pointsOf(const Data& data);

  std::map<std::string, Data> data_;  ///< by name
  std::vector<const Data*> meshes_;   ///< in the order of the description, once there is one
  bool news_ = true;
  bool lacksFields_ = false;  ///< perhaps
  std::vector<std::vector<std::byte>> kept_;
};

}  // namespace gxy::insitu
