// SPDX-License-Identifier: Apache-2.0
// A backend whose scenes take as long as a test wants.
#pragma once
#include <atomic>
#include <memory>
#include <thread>
#include <utility>

#include "backends/embree/embree_backend.h"
#include "core/comm/error.h"

namespace gxy::test {

/// Embree, whose scenes are half made as long as they are held: so long they say how far they are.
class Holding final : public Backend {
 public:
  struct Scenes {
    std::atomic<bool> held = false;
    std::atomic<int> begun = 0, made = 0, givenUp = 0;  // on all ranks
  };
  explicit Holding(std::shared_ptr<Scenes> scenes) : scenes_(std::move(scenes)) {}
  std::string name() const override { return embree_->name(); }
  std::string device() const override { return embree_->device(); }
  std::unique_ptr<DeviceScene> makeScene(std::shared_ptr<const CompiledScene> scene, int rank,
                                         const Advance& advance) const override {
    scenes_->begun++;
    try {
      for (; scenes_->held; std::this_thread::yield()) advance(0.5);
    } catch (const Error&) {
      scenes_->givenUp++;
      throw;
    }
    scenes_->made++;
    return embree_->makeScene(std::move(scene), rank, advance);
  }

 private:
  std::unique_ptr<Backend> embree_ = makeEmbreeBackend();
  std::shared_ptr<Scenes> scenes_;
};

inline BackendRegistry::Maker holding(std::shared_ptr<Holding::Scenes> scenes) {
  return [scenes = std::move(scenes)](Ledger*) { return std::make_unique<Holding>(scenes); };
}

}  // namespace gxy::test
