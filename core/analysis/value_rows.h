// SPDX-License-Identifier: Apache-2.0
// Values that statistics are of, row by row. Used inside core/analysis only.
#pragma once
#include <cstdint>
#include <functional>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "core/data/geometry.h"
#include "core/data/mesh.h"
#include "core/data/morton.h"
#include "core/data/partitioning.h"
#include "core/data/volume.h"

namespace gxy {

/// Where a value is: an index of a point or an id, and which of the points with that id; of a mesh, the place along Morton's curve.
struct ValueKey {
  uint64_t id = 0;
  uint32_t which = 0;
  auto operator<=>(const ValueKey&) const = default;
};

/// Values that stand in one row. A value is offset + scale * stored. Infinities and NaN are no data; denormal numbers are 0, and
/// there is no negative 0.
struct ValueRow {
  std::span<const float> stored;
  const uint8_t* where = nullptr;            ///< which values count; null: all
  ValueKey first;                            ///< of the first value; those of the others follow
  const ValueKey* keys = nullptr;            ///< of all values, if they do not follow
  int weight = 0;                            ///< 8 times the part of a cell that a value stands for
  bool halfFirst = false, halfLast = false;  ///< the first or the last one stands for half of it
  std::function<glm::dvec3(size_t)> position;

  ValueKey key(size_t i) const { return keys ? keys[i] : ValueKey{first.id + i, 0}; }
};

/// A part of all values of this rank.
struct ValueRows {
  virtual ~ValueRows() = default;
  /// Number of parts, which different threads may visit at once.
  virtual size_t parts() const = 0;
  virtual void visit(size_t part, const std::function<void(const ValueRow&)>& use) const = 0;
  double offset = 0, scale = 1;
};

/// The owned points of a volume, but its rim.
class VolumeRows final : public ValueRows {
 public:
  VolumeRows(const Volume& volume, const Partitioning& partitioning, int component, const Volume* where);
  size_t parts() const override { return parts_.size(); }
  void visit(size_t part, const std::function<void(const ValueRow&)>& use) const override;

 private:
  struct Part {
    int partition;
    Extent points;
  };
  const Volume& volume_;
  const int component_;
  const Volume* const where_;
  std::vector<Part> parts_;
};

/// The place of a point of a block, or, if the data are those of cells, of a cell: the mean of its corners.
glm::dvec3 placeOf(const Mesh& mesh, const MeshBlock& block, uint32_t entry);

/// The points of a mesh, or its cells if the data are those of cells, each in one partition: the one that is nearest to the point, or to the
/// cell's lowest point.
class MeshRows final : public ValueRows {
 public:
  /// `component`: as many as there are means the magnitude. All must outlive it.
  MeshRows(const Mesh& mesh, const Partitioning& partitioning, int component);
  size_t parts() const override { return parts_.size(); }
  void visit(size_t part, const std::function<void(const ValueRow&)>& use) const override;

 private:
  static constexpr size_t kPart = 8192;
  struct Part {
    const MeshBlock* block;
    std::vector<uint32_t> entries;  ///< points or cells of the block
  };
  float valueOf(const float* values) const;

  const Mesh& mesh_;
  const MortonCurve curve_;
  const int component_;
  std::vector<Part> parts_;
};

/// The points of particles and path lines. A segment has its first point; the last segment of a line has its end, too.
class GeometryRows final : public ValueRows {
 public:
  GeometryRows(const GeometryBlock& block, GeometryKind kind) : block_(block), kind_(kind) {}
  size_t parts() const override { return (block_.ids.size() + kPart - 1) / kPart; }
  void visit(size_t part, const std::function<void(const ValueRow&)>& use) const override;

 private:
  static constexpr size_t kPart = 8192;
  const GeometryBlock& block_;
  const GeometryKind kind_;
};

}  // namespace gxy
