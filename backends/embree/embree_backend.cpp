// SPDX-License-Identifier: Apache-2.0
#include "backends/embree/embree_backend.h"

#include "backends/bvh/embree.h"
#include "backends/embree/embree_fields.h"
#include "backends/embree/embree_scene.h"
#include "spawn_ispc.h"

namespace gxy {

namespace {

class EmbreeBackend final : public Backend {
 public:
  std::string name() const override { return "embree"; }
  std::string device() const override {
    return "CPU, Embree " + embree::version() + ", " + std::to_string(ispc::gangWidth()) + " rays at a time";
  }
  std::unique_ptr<DeviceScene> makeScene(std::shared_ptr<const CompiledScene> scene, int rank,
                                         const Advance& advance) const override {
    return std::make_unique<EmbreeScene>(shared_, std::move(scene), rank, advance);
  }
  std::unique_ptr<DeviceFields> makeFields(std::shared_ptr<const CompiledFields> fields,
                                           int rank) const override {
    return std::make_unique<EmbreeFields>(std::move(fields), rank);
  }

 private:
  std::shared_ptr<EmbreeShared> shared_ = std::make_shared<EmbreeShared>();
};

}  // namespace

std::unique_ptr<Backend> makeEmbreeBackend() { return std::make_unique<EmbreeBackend>(); }

}  // namespace gxy
