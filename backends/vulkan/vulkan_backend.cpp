// SPDX-License-Identifier: Apache-2.0
#include "backends/vulkan/vulkan_backend.h"

#include "backends/vulkan/vulkan_scene.h"
#include "core/comm/error.h"

namespace gxy {

namespace {

class VulkanBackend final : public Backend {
 public:
  explicit VulkanBackend(const VulkanOptions& options)
      : context_(std::make_shared<vulkan::Context>(options)) {}
  std::string name() const override { return "vulkan"; }
  std::string device() const override { return info().name + ", " + info().driver; }
  std::unique_ptr<DeviceScene> makeScene(std::shared_ptr<const CompiledScene> scene, int rank,
                                         const Advance& advance) const override {
    return std::make_unique<vulkan::VulkanScene>(context_, std::move(scene), rank, advance);
  }
  bool lost() const override { return context_->device.lost(); }
  const VulkanDeviceInfo& info() const { return context_->device.info(); }

 private:
  std::shared_ptr<vulkan::Context> context_;
};

}  // namespace

std::unique_ptr<Backend> makeVulkanBackend(const VulkanOptions& options) {
  return std::make_unique<VulkanBackend>(options);
}

const VulkanDeviceInfo& deviceOf(const Backend& backend) {
  return dynamic_cast<const VulkanBackend&>(backend).info();
}

}  // namespace gxy
