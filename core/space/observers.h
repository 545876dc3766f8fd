// SPDX-License-Identifier: Apache-2.0
// Tells subscribers when objects are added, updated and dropped.
#pragma once
#include <functional>
#include <memory>

#include "core/space/key.h"

namespace gxy {

/// Counts the versions of an object's data, from 1. Rank 0 assigns it.
using Generation = uint64_t;

struct ObjectEvent {
  enum class Kind {
    Added,
    Updated,  ///< `generation` is the new one
    Skipped,  ///< an update was left out because both buffers were in use; `generation` stays current
    Dropped,
    Wanted  ///< an update waits for the buffer of `generation`, which is pinned; holders should release it early
  };
  Kind kind;
  Key key;
  Generation generation = 0;
  bool operator==(const ObjectEvent&) const = default;
};

/// Subscribers to object events. Thread safe. Callbacks run on the notifying thread while no lock of the data
/// space is held. A subscriber's callback never runs on two threads at once. A callback may subscribe,
/// unsubscribe (itself too) and notify.
class Observers {
  struct Subscriber;
  struct State;

 public:
  using Callback = std::function<void(const ObjectEvent&)>;

  /// Ends the subscription when it is destroyed. It first waits for a callback that is running on another
  /// thread; afterwards the callback does not run any more. So the caller must not hold a lock that the
  /// callback takes. A Subscription may outlive the Observers.
  class Subscription {
   public:
    Subscription() = default;
    Subscription(Subscription&&) = default;
    Subscription& operator=(Subscription&& other) noexcept;
    ~Subscription() { end(); }
    void end();

   private:
    friend class Observers;
    std::shared_ptr<Subscriber> subscriber_;
    std::weak_ptr<State> state_;
  };

  Observers();
  /// Subscribes to the events of one object, or, with an invalid key, of all objects.
  [[nodiscard]] Subscription subscribe(Key key, Callback callback);
  /// Calls every subscriber to the event's object, in order of subscription.
  void notify(const ObjectEvent& event) const;

 private:
  std::shared_ptr<State> state_;
};

}  // namespace gxy
