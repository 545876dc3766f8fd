// SPDX-License-Identifier: Apache-2.0
// A compiled scene in the form that the ISPC kernels read.
#pragma once
#include <map>
#include <memory>
#include <vector>

#include "gxy/embree/embree_geometry.h"
#include "gxy/rays/backend.h"

namespace gxy {

class EmbreeScene final : public DeviceScene {
 public:
  EmbreeScene(std::shared_ptr<EmbreeShared> shared, std::shared_ptr<const CompiledScene> scene, int rank);

  std::shared_ptr<const DeviceFrame> makeFrame(const CompiledFrame& frame) const override;
  void spawn(const DeviceFrame& frame, const Tile& tile, Done done) const override;
  void trace(const DeviceFrame& frame, int partition, bool primary, RayList rays, Done done) const override;
  size_t bytes() const override;
  std::vector<SharedBytes> sharedBytes() const override;

 private:
  struct Part {
    single::SceneView view{};
    std::vector<single::OperatorView> operators;
    std::vector<single::VolumeView> fields;
    std::shared_ptr<const GeometryHierarchy> geometry;        ///< null if there is none
    std::vector<std::shared_ptr<const OcclusionTree>> trees;  ///< of operators; empty without occlusion rays
    std::vector<OcclusionTreeView> treeViews;
  };
  class Packet;
  void plantTrees(Part& part, const std::vector<const GeometryPart*>& primitives) const;

  std::shared_ptr<EmbreeShared> shared_;
  std::shared_ptr<const CompiledScene> scene_;
  int rank_;
  std::map<int, Part> parts_;     ///< by local partition
  single::SceneView anywhere_{};  ///< without a partition of its own: for spawning
  std::vector<int> slicedOperators_, isoOperators_, renderedOperators_;
};

}  // namespace gxy
