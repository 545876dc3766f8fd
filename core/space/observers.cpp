// SPDX-License-Identifier: Apache-2.0
#include "core/space/observers.h"

#include <mutex>
#include <vector>

namespace gxy {

struct Observers::Subscriber {
  Key key;
  Callback callback;
  /// Held while the callback runs. It is recursive because callbacks may unsubscribe or notify.
  std::recursive_mutex running;
  bool active = true;  ///< guarded by `running`
};

struct Observers::State {
  std::mutex mutex;
  std::vector<std::shared_ptr<Subscriber>> subscribers;  ///< in order of subscription
};

Observers::Observers() : state_(std::make_shared<State>()) {}

Observers::Subscription Observers::subscribe(Key key, Callback callback) {
  Subscription subscription;
  subscription.subscriber_ = std::make_shared<Subscriber>();
  subscription.subscriber_->key = key;
  subscription.subscriber_->callback = std::move(callback);
  subscription.state_ = state_;
  const std::lock_guard lock(state_->mutex);
  state_->subscribers.push_back(subscription.subscriber_);
  return subscription;
}

void Observers::notify(const ObjectEvent& event) const {
  std::vector<std::shared_ptr<Subscriber>> concerned;
  {
    const std::lock_guard lock(state_->mutex);
    for (const auto& s : state_->subscribers) {
      if (!s->key.valid() || s->key == event.key) concerned.push_back(s);
    }
  }
  for (const auto& s : concerned) {
    const std::lock_guard lock(s->running);
    if (s->active) s->callback(event);
  }
}

Observers::Subscription& Observers::Subscription::operator=(Subscription&& other) noexcept {
  if (this != &other) {
    end();
    subscriber_ = std::move(other.subscriber_);
    state_ = std::move(other.state_);
  }
  return *this;
}

void Observers::Subscription::end() {
  if (!subscriber_) return;
  {
    const std::lock_guard lock(subscriber_->running);
    subscriber_->active = false;
  }
  if (const auto state = state_.lock()) {
    const std::lock_guard lock(state->mutex);
    std::erase(state->subscribers, subscriber_);
  }
  subscriber_.reset();
}

}  // namespace gxy
