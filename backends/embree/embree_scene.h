// SPDX-License-Identifier: Apache-2.0
// EmbreeScene: a compiled scene in the form that the ISPC kernels read.
#pragma once
#include <map>
#include <memory>
#include <vector>

#include "backends/embree/geometry_tree.h"
#include "core/kernels/single_views.h"
#include "core/rays/backend.h"
#include "core/space/shared_by.h"

namespace gxy {

/// State that the scenes of a backend share: trees, keyed by the primitives that they are built of.
struct EmbreeShared {
  SharedBy<const GeometryInPartition*, GeometryTree> trees;
};

class EmbreeScene final : public DeviceScene {
 public:
  EmbreeScene(std::shared_ptr<EmbreeShared> shared, std::shared_ptr<const CompiledScene> scene, int rank,
              const Advance& advance);

  std::shared_ptr<const DeviceFrame> makeFrame(const CompiledFrame& frame) const override;
  std::shared_ptr<const DeviceFrame> makeSampling(std::shared_ptr<const CompiledSampling> sampling,
                                                  EnterMemory enter) const override;
  void spawn(const DeviceFrame& frame, const SpawnTile& tile, Done done) const override;
  void spawnRays(const DeviceFrame& frame, RayList rays, Done done) const override;
  void trace(const DeviceFrame& frame, int partition, bool primary, RayList rays, Done done) const override;
  size_t bytes() const override;
  std::vector<SharedBytes> sharedBytes() const override;

 private:
  struct PartitionViews {
    single::SceneView view{};
    std::vector<single::OperatorView> operators;
    std::vector<single::VolumeView> fields;
    std::vector<std::shared_ptr<const GeometryTree>> trees;  ///< what the views below see
    std::vector<GeometryTreeView> treeViews;   ///< of surfaces, per operator; empty if there are none
    std::vector<GeometryTreeView> shellViews;  ///< of shells of meshes, likewise
  };
  class Packet;

  std::shared_ptr<EmbreeShared> shared_;
  std::shared_ptr<const CompiledScene> scene_;
  int rank_;
  std::map<int, PartitionViews> parts_;  ///< key: local partition
  single::SceneView anywhere_{};         ///< a view without a partition of its own, for spawning
};

}  // namespace gxy
