// SPDX-License-Identifier: Apache-2.0
#include "core/space/objects.h"

#include <condition_variable>
#include <mutex>
#include <string>
#include <unordered_map>
#include <unordered_set>
#include <utility>

#include "core/comm/error.h"

namespace gxy {

struct Pin::Buffer {
  Payload payload;
  Generation generation = 0;
  int pins = 0;  ///< guarded by State::mutex
};

struct Pin::State {
  struct Object {
    WhenTaken whenTaken;
    std::shared_ptr<Buffer> current, previous;
    bool reserved = false;
    Payload staged;
  };

  mutable std::mutex mutex;
  std::condition_variable changed;  ///< a pin was released, an update ended, an object was dropped
  std::unordered_map<Key, Object> objects;

  Object& at(Key key) {
    const auto found = objects.find(key);
    if (found == objects.end()) {
      throw Error("object " + std::to_string(key.value) + ": there is none, expected a key in use");
    }
    return found->second;
  }
};

namespace {

[[noreturn]] void fail(Key key, const std::string& what) {
  throw Error("object " + std::to_string(key.value) + ": " + what);
}

}  // namespace

Pin& Pin::operator=(Pin&& other) noexcept {
  if (this != &other) {
    release();
    state_ = std::move(other.state_);
    buffer_ = std::move(other.buffer_);
  }
  return *this;
}

void Pin::release() {
  if (!buffer_) return;
  {
    const std::lock_guard lock(state_->mutex);
    --buffer_->pins;
  }
  state_->changed.notify_all();
  buffer_.reset();
  state_.reset();
}

const Payload& Pin::payload() const {
  if (!buffer_) throw Error("pin: it is empty, expected one that holds an object");
  return buffer_->payload;
}

Generation Pin::generation() const { return buffer_ ? buffer_->generation : 0; }

Objects::Objects(Observers& observers) : observers_(observers), state_(std::make_shared<Pin::State>()) {}

void Objects::add(Key key, Payload payload, WhenTaken whenTaken) {
  if (!key.valid()) fail(key, "the key is invalid, expected one from a KeySource");
  auto buffer = std::make_shared<Pin::Buffer>();
  buffer->payload = std::move(payload);
  buffer->generation = 1;
  {
    const std::lock_guard lock(state_->mutex);
    const auto [at, isNew] = state_->objects.try_emplace(key);
    if (!isNew) fail(key, "it exists, expected a new key");
    at->second.whenTaken = whenTaken;
    at->second.current = std::move(buffer);
  }
  observers_.notify({ObjectEvent::Kind::Added, key, 1});
}

bool Objects::contains(Key key) const {
  const std::lock_guard lock(state_->mutex);
  return state_->objects.contains(key);
}

void Objects::drop(Key key) {
  Pin::State::Object dropped;  // freed after the lock is
  {
    const std::lock_guard lock(state_->mutex);
    dropped = std::move(state_->at(key));
    state_->objects.erase(key);
  }
  state_->changed.notify_all();
  observers_.notify({ObjectEvent::Kind::Dropped, key, dropped.current->generation});
}

Pin Objects::pinLocked(std::shared_ptr<Pin::Buffer> buffer) const {
  Pin pin;
  pin.buffer_ = std::move(buffer);
  pin.state_ = state_;
  ++pin.buffer_->pins;
  return pin;
}

Pin Objects::pinLocked(Key key, Generation generation) const {
  const Pin::State::Object& object = state_->at(key);
  for (const auto& buffer : {object.current, object.previous})
    if (buffer && buffer->generation == generation) return pinLocked(buffer);
  fail(key, "generation " + std::to_string(generation) + " is not here, expected " +
                std::to_string(object.current->generation) +
                (object.previous ? " or " + std::to_string(object.previous->generation) : std::string()));
}

Pin Objects::pin(Key key) const {
  const std::lock_guard lock(state_->mutex);
  return pinLocked(state_->at(key).current);
}

Pin Objects::pin(Key key, Generation generation) const {
  const std::lock_guard lock(state_->mutex);
  return pinLocked(key, generation);
}

std::vector<Pin> Objects::pin(const std::function<std::vector<Key>()>& keys) const {
  std::vector<Pin> pins;  // before the lock: where this throws, they are released after it
  const std::lock_guard lock(state_->mutex);
  const std::vector<Key> all = keys();
  pins.reserve(all.size());  // A pin that is lost would be released under the lock.
  for (const Key key : all) pins.push_back(pinLocked(state_->at(key).current));
  return pins;
}

std::vector<Pin> Objects::pin(std::span<const ObjectGeneration> generations) const {
  std::vector<Pin> pins;  // as above
  pins.reserve(generations.size());
  const std::lock_guard lock(state_->mutex);
  for (const auto& [key, generation] : generations) pins.push_back(pinLocked(key, generation));
  return pins;
}

bool Objects::reserve(Key key) {
  std::shared_ptr<Pin::Buffer> freed;
  Generation stays = 0;
  {
    std::unique_lock lock(state_->mutex);
    const auto deadline = std::chrono::steady_clock::now() + state_->at(key).whenTaken.wait;
    if (const auto& previous = state_->at(key).previous; previous && previous->pins > 0) {
      const Generation wanted = previous->generation;
      lock.unlock();
      observers_.notify({ObjectEvent::Kind::Wanted, key, wanted});
      lock.lock();
    }
    // Looked up anew each time: the object may be dropped while this waits.
    const auto isFree = [&] {
      const Pin::State::Object& object = state_->at(key);
      return !object.reserved && (!object.previous || object.previous->pins == 0);
    };
    const bool free = state_->changed.wait_until(lock, deadline, isFree);
    Pin::State::Object& object = state_->at(key);
    stays = object.current->generation;
    if (free) {
      object.reserved = true;
      freed = std::move(object.previous);
      return true;
    }
  }
  observers_.notify({ObjectEvent::Kind::Skipped, key, stays});
  return false;
}

void Objects::stage(Key key, Payload payload) {
  if (payload.empty()) fail(key, "nothing was staged, expected data");
  const std::lock_guard lock(state_->mutex);
  Pin::State::Object& object = state_->at(key);
  if (!object.reserved) fail(key, "data were staged without a buffer, expected reserve() first");
  if (!object.staged.empty()) fail(key, "data were staged twice, expected commit() or abandon() in between");
  object.staged = std::move(payload);
}

void Objects::commit(Key key, Generation generation) {
  {
    const std::lock_guard lock(state_->mutex);
    state_->at(key);
  }
  const ObjectGeneration one{key, generation};
  commit(std::span(&one, 1));
}

void Objects::commit(std::span<const ObjectGeneration> generations, const std::function<void()>& also) {
  std::vector<ObjectEvent> events;
  std::unordered_set<Key> keys;
  std::vector<std::shared_ptr<Pin::Buffer>> buffers;
  for (size_t i = 0; i < generations.size(); i++) buffers.push_back(std::make_shared<Pin::Buffer>());
  {
    const std::lock_guard lock(state_->mutex);
    for (const auto& [key, generation] : generations) {
      const auto found = state_->objects.find(key);
      if (found == state_->objects.end()) continue;
      if (!keys.insert(key).second) fail(key, "it is there twice, expected one generation of each object");
      const Pin::State::Object& object = found->second;
      if (object.staged.empty()) fail(key, "nothing is staged, expected data before a commit");
      if (generation <= object.current->generation)
        fail(key, "generation " + std::to_string(generation) + " was committed, expected one after " +
                      std::to_string(object.current->generation));
      events.push_back({ObjectEvent::Kind::Updated, key, generation});
    }
    if (also) also();
    for (size_t i = 0; i < events.size(); i++) {
      Pin::State::Object& object = state_->objects.at(events[i].key);
      buffers[i]->payload = std::exchange(object.staged, {});
      buffers[i]->generation = events[i].generation;
      object.previous = std::exchange(object.current, std::move(buffers[i]));
      object.reserved = false;
    }
  }
  state_->changed.notify_all();
  for (const ObjectEvent& event : events) observers_.notify(event);
}

void Objects::abandon(Key key) {
  Payload freed;
  {
    const std::lock_guard lock(state_->mutex);
    Pin::State::Object& object = state_->at(key);
    freed = std::exchange(object.staged, {});
    object.reserved = false;
  }
  state_->changed.notify_all();
}

}  // namespace gxy
