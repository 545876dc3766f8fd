// SPDX-License-Identifier: Apache-2.0
// MeshFields: unstructured volumes through which lines go.
#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "core/analysis/mesh_reader.h"
#include "core/data/mesh.h"
#include "core/rays/compiled_fields.h"
#include "core/rays/device_fields.h"

namespace gxy {

/// Whether the blocks of this rank have the same points and cells.
bool haveSameCells(const Mesh& a, const Mesh& b);

/// Volumes on one mesh and one partitioning, with the partitions of one rank. The lines are integrated on the host, in double precision:
/// the same code whichever backend draws. Immutable and thread safe. It keeps the volumes alive.
///
/// A head goes through the cells of its block (MeshWalk) until it leaves a cell at a point in another partition and the block does not
/// say what is there. It goes on in that partition, whose block has all cells around the point.
class MeshFields final : public LineFields, public DeviceFields {
 public:
  /// The first volume is the vectors. All components of the others are recorded, in order. Throws Error unless there are 1 to 8 volumes,
  /// the first has 3 components, and all have the same points and cells. `check` is called now and then and may throw.
  MeshFields(
      std::vector<std::shared_ptr<const Mesh>> meshes, std::shared_ptr<const Partitioning> partitioning,
      const std::function<void()>& check = [] {});

  /// About the memory of what finds cells, in bytes.
  static int64_t bytesFor(const Mesh& vectors) { return MeshReader::bytesFor(vectors); }

  const Mesh& vectors() const { return *meshes_.front(); }
  std::span<const std::shared_ptr<const Mesh>> meshes() const { return meshes_; }
  std::span<const RecordedField> recorded() const { return recorded_; }
  const MeshReader& reader() const { return reader_; }
  /// The length of the diagonal of the box.
  double diagonal() const;
  /// What is 0 beside the largest vector: slower heads do not move.
  double leastSpeed() const { return leastSpeed_; }

  // LineFields
  const Partitioning& partitioning() const override { return *partitioning_; }
  size_t recordedComponents() const override { return recorded_.size(); }
  HeadKind headKind() const override { return kMeshHeads; }
  SeedHeads seeds(std::span<const glm::dvec3> positions, std::span<const uint64_t> ids,
                  TraceDirection direction) const override;
  const char* wrongHeads(const HeadList& heads) const override;

  // DeviceFields
  void advance(int partition, HeadList heads, const TraceOptions& options, Done done) const override;
  size_t bytes() const override { return size_t(MeshReader::bytesFor(vectors())); }

 private:
  std::vector<std::shared_ptr<const Mesh>> meshes_;
  std::shared_ptr<const Partitioning> partitioning_;
  std::vector<RecordedField> recorded_;
  double leastSpeed_;
  MeshReader reader_;
};

}  // namespace gxy
