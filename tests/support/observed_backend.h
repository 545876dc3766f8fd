// SPDX-License-Identifier: Apache-2.0
// A backend that reports its calls to a test. The test tells frames apart by their size.
#pragma once
#include <functional>
#include <memory>
#include <string>
#include <utility>

#include "backends/embree/embree_backend.h"

namespace gxy::test {

/// Functions that are called on the thread of the call. `begins` is called before the work is done.
struct Observer {
  /// A frame has been made on the device.
  std::function<void(glm::ivec2 size)> known = [](glm::ivec2) {};
  /// Work on a frame begins. `rays` is the number of rays of a packet, or 0 for a tile that is spawned.
  std::function<void(glm::ivec2 size, int rays)> begins = [](glm::ivec2, int) {};
};

/// Passes all work to Embree. The observer must outlive the backend's scenes.
class ObservedBackend : public Backend {
 public:
  explicit ObservedBackend(const Observer& observer) : observer_(observer) {}
  std::string name() const override { return "observed"; }
  std::string device() const override { return embree_->device(); }
  std::unique_ptr<DeviceScene> makeScene(std::shared_ptr<const CompiledScene> scene, int rank,
                                         const Advance& advance) const override {
    return std::make_unique<Scene>(embree_->makeScene(std::move(scene), rank, advance), observer_);
  }

 private:
  struct Frame : DeviceFrame {
    std::shared_ptr<const DeviceFrame> frame;
    glm::ivec2 size{0};
  };
  class Scene : public DeviceScene {
   public:
    Scene(std::unique_ptr<DeviceScene> scene, const Observer& observer)
        : scene_(std::move(scene)), observer_(observer) {}
    std::shared_ptr<const DeviceFrame> makeFrame(const CompiledFrame& frame) const override {
      auto made = std::make_shared<Frame>();
      made->frame = scene_->makeFrame(frame);
      made->size = {frame.width, frame.height};
      observer_.known(made->size);
      return made;
    }
    void spawn(const DeviceFrame& frame, const SpawnTile& tile, Done done) const override {
      const auto& ours = static_cast<const Frame&>(frame);
      observer_.begins(ours.size, 0);
      scene_->spawn(*ours.frame, tile, std::move(done));
    }
    void trace(const DeviceFrame& frame, int partition, bool primary, RayList rays,
               Done done) const override {
      const auto& ours = static_cast<const Frame&>(frame);
      observer_.begins(ours.size, rays.size());
      scene_->trace(*ours.frame, partition, primary, std::move(rays), std::move(done));
    }
    size_t bytes() const override { return scene_->bytes(); }

   private:
    std::unique_ptr<DeviceScene> scene_;
    const Observer& observer_;
  };

  const std::unique_ptr<Backend> embree_ = makeEmbreeBackend();
  const Observer& observer_;
};

}  // namespace gxy::test
