// SPDX-License-Identifier: Apache-2.0
// The objects of the data space on one rank: immutable data by key and generation, pinned by frames, updated
// in steps.
//
// An update takes three calls on every rank: reserve() the second buffer (before the new data are made, so
// that there are never three), stage() the data, and, when rank 0 says that they are complete everywhere,
// commit() the generation that it assigned. If a rank could not reserve, rank 0 has all others abandon(). What belongs
// together, as the fields of a simulation's step, is committed by one call and pinned by one call on each rank: then no frame
// shows one object of a step beside another of the next.
//
// The previous generation stays until its buffer is reserved again. A frame whose first message is still on
// its way holds a pin on rank 0 only, so rank 0 grants a reservation after the frames that use the previous
// generation are complete: it reserves before the other ranks, and commits after them. So while rank 0 pins generations of
// several objects, every rank has each of them as its current or its previous one, unless that object is dropped.
#pragma once
#include <chrono>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "core/space/key.h"
#include "core/space/observers.h"
#include "core/space/payload.h"

namespace gxy {

/// One generation of one object.
struct ObjectGeneration {
  Key key;
  Generation generation = 0;
  bool operator==(const ObjectGeneration&) const = default;
};

/// Keeps one generation of one object for a frame, never for a client. Move-only; may outlive the Objects.
class Pin {
 public:
  Pin() = default;
  Pin(Pin&& other) = default;
  Pin& operator=(Pin&& other) noexcept;
  ~Pin() { release(); }
  void release();

  explicit operator bool() const { return buffer_ != nullptr; }
  Generation generation() const;
  /// The data; not to be kept beyond the pin. Throws Error if they are of another type.
  template <typename T>
  std::shared_ptr<const T> get() const {
    return payload().get<T>();
  }

 private:
  friend class Objects;
  struct State;
  struct Buffer;
  const Payload& payload() const;

  std::shared_ptr<State> state_;
  std::shared_ptr<Buffer> buffer_;
};

/// What a publisher chose for the case that both buffers are taken: skip the step (wait 0), or wait this long
/// first, for those who pin the previous generation to let go of it.
struct WhenTaken {
  std::chrono::milliseconds wait{0};
};

/// The objects of one rank. Thread safe; observers are called after the change, no lock held. Every function
/// that takes a key throws Error if there is no such object, unless it says otherwise.
class Objects {
 public:
  /// `observers` must outlive this.
  explicit Objects(Observers& observers);

  /// A new object with generation 1. Throws Error if the key is in use or invalid.
  void add(Key key, Payload payload, WhenTaken whenTaken = {});
  bool contains(Key key) const;
  /// Forgets the object; its data live until the last pin goes.
  void drop(Key key);

  /// The current generation, or a given one: throws Error if it is neither the current nor the previous one.
  Pin pin(Key key) const;
  Pin pin(Key key, Generation generation) const;
  /// Pins the current generations of several objects under one lock, so that no commit and no drop comes in between. `keys`
  /// returns the objects; it is called with the lock held, so that names that it looks up still mean these objects when they are
  /// pinned. It must be short and must not call this Objects. If it throws, or one of the objects does not exist, none is pinned.
  std::vector<Pin> pin(const std::function<std::vector<Key>()>& keys) const;
  /// Pins given generations of several objects under one lock. Throws Error if one of them is neither the current nor the
  /// previous one of its object; then none is pinned.
  std::vector<Pin> pin(std::span<const ObjectGeneration> generations) const;

  /// Makes room for the next generation. Where the previous one is pinned, a Wanted event first. False, and a Skipped
  /// event, if both buffers are still taken after the wait that was chosen: by a pinned previous generation or by another
  /// update.
  bool reserve(Key key);
  /// Puts data in the reserved buffer. Throws Error unless it is reserved and still empty.
  void stage(Key key, Payload payload);
  /// Makes the staged data the current generation. Throws Error unless data are staged and the generation is
  /// newer.
  void commit(Key key, Generation generation);
  /// Does the same for several objects under one lock: whoever pins them by one call gets all of these generations or none. The
  /// keys differ. An object that has been dropped meanwhile is left out. `also` is called with the lock held, so that names can
  /// change at the same moment. It must be short and must not call this Objects. If it throws, or one of the generations cannot be
  /// committed, nothing has changed.
  void commit(std::span<const ObjectGeneration> generations, const std::function<void()>& also = {});
  /// Gives the reserved buffer up, with what was staged in it, if any.
  void abandon(Key key);

 private:
  /// With the lock held.
  Pin pinLocked(std::shared_ptr<Pin::Buffer> buffer) const;
  Pin pinLocked(Key key, Generation generation) const;

  Observers& observers_;
  std::shared_ptr<Pin::State> state_;
};

}  // namespace gxy
