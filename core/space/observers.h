// SPDX-License-Identifier: Apache-2.0
// Who is told when objects come, change and go.
#pragma once
#include <functional>
#include <memory>

#include "core/space/key.h"

namespace gxy {

/// Counts the data an object has had, from 1; assigned by rank 0.
using Generation = uint64_t;

struct ObjectEvent {
  enum class Kind {
    Added,
    Updated,  ///< `generation` is the new one
    Skipped,  ///< a new step was left out, because both buffers were taken; `generation` is the one that
              ///< stays
    Dropped,
    Wanted  ///< an update waits for the buffer of `generation`, which is pinned: who can let go of it early does
  };
  Kind kind;
  Key key;
  Generation generation = 0;
  bool operator==(const ObjectEvent&) const = default;
};

/// Subscribers to object events. Thread safe. Callbacks run on the notifying thread, no lock of the data
/// space held; one subscriber's callback never runs twice at once. A callback may subscribe, unsubscribe
/// (itself too) and notify.
class Observers {
  struct Subscriber;
  struct State;

 public:
  using Callback = std::function<void(const ObjectEvent&)>;

  /// Ends a subscription when destroyed, after waiting for a callback that runs on another thread: afterwards
  /// it runs no more. So hold no lock that the callback takes. May outlive the Observers.
  class Subscription {
   public:
    Subscription() = default;
    Subscription(Subscription&&) = default;
    Subscription& operator=(Subscription&& other);
    ~Subscription() { end(); }
    void end();

   private:
    friend class Observers;
    std::shared_ptr<Subscriber> subscriber_;
    std::weak_ptr<State> state_;
  };

  Observers();
  /// Events of one object, or, with an invalid key, of all.
  [[nodiscard]] Subscription subscribe(Key key, Callback callback);
  /// Calls every subscriber that the event concerns, in order of subscription.
  void notify(const ObjectEvent& event) const;

 private:
  std::shared_ptr<State> state_;
};

}  // namespace gxy
