// SPDX-License-Identifier: Apache-2.0
#include "core/rays/substitutes.h"

#include <spdlog/spdlog.h>

#include <exception>
#include <mutex>

#include "core/comm/error.h"
#include "core/space/ledger.h"
#include "core/space/shared_by.h"

namespace gxy {

namespace {

// The backends in their order, addressed by number. Thread safe; shared by the backend that stands for them
// and its scenes.
class Backends {
 public:
  using Memory = std::vector<std::shared_ptr<const LedgerEntry>>;

  Backends(std::unique_ptr<Backend> first, std::vector<BackendRegistry::Entry> others, Ledger* ledger)
      : ledger_(ledger) {
    all_.push_back({{first->name(), {}, {}}, std::move(first)});
    for (BackendRegistry::Entry& other : others) all_.push_back({std::move(other), nullptr});
  }

  // Returns the first backend from number `i` on that can be used, and sets `i` to its number; null if there
  // is none.
  const Backend* from(size_t& i) {
    std::lock_guard lock(mutex_);
    for (; i < all_.size(); i++)
      if (isUsable(all_[i])) return all_[i].backend.get();
    return nullptr;
  }

  const Backend& first() const { return *all_[0].backend; }
  bool isLast(size_t i) const { return i + 1 == all_.size(); }

  // Logs that a scene no longer uses backend `i`.
  void passOver(size_t i, const std::string& why) {
    std::lock_guard lock(mutex_);
    One& one = all_[i];
    if (one.backend->lost())
      tellLost(one, ": " + why);
    else if (!isLast(i))
      spdlog::warn("backend {} fails with a scene: {}; {} takes its place", one.entry.name, why,
                   all_[i + 1].entry.name);
  }

  Memory enter(const DeviceScene& scene) {
    Memory memory;
    if (!ledger_) return memory;
    const auto entry = [&](size_t bytes) { return ledger_->enter("device", "scene", int64_t(bytes)); };
    memory.push_back(std::make_shared<const LedgerEntry>(entry(scene.bytes())));
    for (const SharedBytes& shared : scene.sharedBytes())
      memory.push_back(shared_.get(shared.what, [&] { return entry(shared.bytes); }));
    return memory;
  }

 private:
  struct One {
    BackendRegistry::Entry entry;
    std::unique_ptr<Backend> backend;  // null: not made yet, or it cannot be made
    bool cannotBeMade = false, toldLost = false;
  };

  void tellLost(One& one, const std::string& why) {
    const One* next = &one + 1;
    if (one.toldLost || next == all_.data() + all_.size()) return;
    one.toldLost = true;
    spdlog::warn("backend {} is lost{}; {} takes its place", one.entry.name, why, next->entry.name);
  }

  bool isUsable(One& one) {
    if (one.backend) {
      const bool lost = one.backend->lost();
      if (lost) tellLost(one, "");
      return !lost;
    }
    if (one.cannotBeMade) return false;
    try {
      if (!one.entry.fits || one.entry.fits()) one.backend = one.entry.maker(ledger_);
    } catch (const std::exception& error) {
      spdlog::warn("backend {} cannot be used: {}", one.entry.name, error.what());
    }
    one.cannotBeMade = !one.backend;
    return !one.cannotBeMade;
  }

  Ledger* const ledger_;
  std::mutex mutex_;
  std::vector<One> all_;
  SharedBy<const void*, LedgerEntry> shared_;
};

// A scene on one backend.
struct Made {
  size_t number = 0;  // the backend's
  std::unique_ptr<const DeviceScene> scene;
  Backends::Memory memory;
  mutable std::atomic<bool> failed = false;
};

class Frame final : public DeviceFrame {
 public:
  Frame(const Made& where, std::shared_ptr<const DeviceFrame> frame) : made(where), inner(std::move(frame)) {}
  void setUrgent(bool urgent) const override {
    DeviceFrame::setUrgent(urgent);
    inner->setUrgent(urgent);
  }
  void cancel() const override {
    DeviceFrame::cancel();
    inner->cancel();
  }

  const Made& made;
  const std::shared_ptr<const DeviceFrame> inner;
};

class Scene final : public DeviceScene {
 public:
  Scene(std::shared_ptr<Backends> backends, std::shared_ptr<const CompiledScene> compiled, int rank,
        const Advance& advance)
      : backends_(std::move(backends)), compiled_(std::move(compiled)), rank_(rank) {
    if (!make(advance))
      throw Error("backend " + backends_->first().name() +
                  " is lost, and there is no other to take its place");
    first_ = made_[0]->scene.get();
  }

  std::shared_ptr<const DeviceFrame> makeFrame(const CompiledFrame& frame) const override {
    std::lock_guard lock(mutex_);
    for (;;) {
      const Made& now = *made_.back();
      size_t number = now.number;
      const bool isSound = !now.failed && backends_->from(number) && number == now.number;
      try {
        if (isSound || !make([](double) {})) return std::make_shared<Frame>(now, now.scene->makeFrame(frame));
      } catch (const Error& error) {
        if (!isSound || backends_->isLast(now.number)) throw;
        fail(now, error.what());
      }
    }
  }

  std::shared_ptr<const DeviceFrame> makeSampling(std::shared_ptr<const CompiledSampling> sampling,
                                                  EnterMemory enter) const override {
    std::lock_guard lock(mutex_);
    do {
      if (auto made = made_.back()->scene->makeSampling(sampling, enter))
        return std::make_shared<Frame>(*made_.back(), std::move(made));
    } while (make([](double) {}));
    return nullptr;
  }

  void spawnRays(const DeviceFrame& frame, RayList rays, Done done) const override {
    const auto& f = static_cast<const Frame&>(frame);
    f.made.scene->spawnRays(*f.inner, std::move(rays), reportingErrors(f.made, std::move(done)));
  }

  void spawn(const DeviceFrame& frame, const SpawnTile& tile, Done done) const override {
    const auto& f = static_cast<const Frame&>(frame);
    f.made.scene->spawn(*f.inner, tile, reportingErrors(f.made, std::move(done)));
  }

  void trace(const DeviceFrame& frame, int partition, bool primary, RayList rays, Done done) const override {
    const auto& f = static_cast<const Frame&>(frame);
    f.made.scene->trace(*f.inner, partition, primary, std::move(rays),
                        reportingErrors(f.made, std::move(done)));
  }

  size_t bytes() const override { return first_->bytes(); }
  std::vector<SharedBytes> sharedBytes() const override { return first_->sharedBytes(); }

 private:
  // Wraps `done`: after an error this backend does nothing more for the scene.
  Done reportingErrors(const Made& made, Done done) const {
    if (backends_->isLast(made.number)) return done;
    return [this, &made, done = std::move(done)](TraceResult result) {
      if (!result.error.empty()) fail(made, result.error);
      done(std::move(result));
    };
  }

  void fail(const Made& made, const std::string& why) const {
    if (!made.failed.exchange(true)) backends_->passOver(made.number, why);
  }

  // Makes the scene on the next backend that can. Returns false if none is left to try. If all that are tried
  // fail, it throws what the first of them threw.
  bool make(const Advance& advance) const {
    std::exception_ptr first;
    for (const Backend* backend; (backend = backends_->from(next_));) {
      const size_t number = next_++;
      std::atomic<bool> ended = false;
      const Advance watched = [&](double fraction) {
        try {
          advance(fraction);
        } catch (...) {
          ended = true;
          throw;
        }
      };
      try {
        auto made = std::make_unique<Made>();
        made->number = number;
        made->scene = backend->makeScene(compiled_, rank_, watched);
        if (!made_.empty()) made->memory = backends_->enter(*made->scene);
        made_.push_back(std::move(made));
        return true;
      } catch (const Error& error) {
        if (ended) throw;
        if (!first) first = std::current_exception();
        backends_->passOver(number, error.what());
      }
    }
    if (first) std::rethrow_exception(first);
    return false;
  }

  const std::shared_ptr<Backends> backends_;
  const std::shared_ptr<const CompiledScene> compiled_;
  const int rank_;
  const DeviceScene* first_ = nullptr;
  mutable std::mutex mutex_;  // guards what is below
  mutable size_t next_ = 0;   // the first backend that has not been tried
  // The last is used for new frames; older frames may be on others.
  mutable std::vector<std::unique_ptr<const Made>> made_;
};

class Substituted final : public Backend {
 public:
  explicit Substituted(std::shared_ptr<Backends> backends) : backends_(std::move(backends)) {}
  std::string name() const override { return used().name(); }
  std::string device() const override { return used().device(); }
  std::unique_ptr<DeviceScene> makeScene(std::shared_ptr<const CompiledScene> scene, int rank,
                                         const Advance& advance) const override {
    return std::make_unique<Scene>(backends_, std::move(scene), rank, advance);
  }
  std::unique_ptr<DeviceFields> makeFields(std::shared_ptr<const CompiledFields> fields,
                                           int rank) const override {
    size_t i = 0;
    for (const Backend* backend; (backend = backends_->from(i)); i++)
      if (auto made = backend->makeFields(fields, rank)) return made;
    return nullptr;
  }

 private:
  const Backend& used() const {
    size_t i = 0;
    const Backend* backend = backends_->from(i);
    return backend ? *backend : backends_->first();
  }
  const std::shared_ptr<Backends> backends_;
};

}  // namespace

std::unique_ptr<Backend> withSubstitutes(std::unique_ptr<Backend> first,
                                         std::vector<BackendRegistry::Entry> others, Ledger* ledger) {
  if (others.empty()) return first;
  return std::make_unique<Substituted>(
      std::make_shared<Backends>(std::move(first), std::move(others), ledger));
}

}  // namespace gxy
