// SPDX-License-Identifier: Apache-2.0
// Shares values between several owners, and finds them by the inputs that they were made from.
#pragma once
#include <chrono>
#include <condition_variable>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <set>

namespace gxy {

/// Values by key. A value lives as long as somebody holds it. If a key contains addresses of objects,
/// everyone who holds the value must hold these objects too. Thread safe.
template <class Key, class Value>
class SharedBy {
 public:
  /// Returns the existing value, or makes it by `make()` and passes on its exception. Meanwhile other callers
  /// with the same key wait. While they wait, each of them calls its own `check()` about every 20 ms and
  /// passes on its exception.
  template <class Make>
  std::shared_ptr<const Value> get(
      const Key& key, Make&& make, const std::function<void()>& check = [] {}) {
    std::unique_lock lock(mutex_);
    for (;; check(), lock.lock()) {
      std::erase_if(known_, [](const auto& entry) { return entry.second.expired(); });
      if (const auto known = known_.find(key); known != known_.end())
        if (auto value = known->second.lock()) return value;
      if (making_.insert(key).second) break;
      made_.wait_for(lock, std::chrono::milliseconds(20));
      lock.unlock();
    }
    lock.unlock();
    const std::shared_ptr<void> end(nullptr, [&](void*) {
      const std::lock_guard again(mutex_);
      making_.erase(key);
      made_.notify_all();
    });
    auto made = std::make_shared<const Value>(make());
    lock.lock();
    known_[key] = made;
    lock.unlock();
    return made;
  }

  /// Whether the value exists or somebody is making it.
  bool has(const Key& key) const {
    const std::lock_guard lock(mutex_);
    const auto known = known_.find(key);
    return (known != known_.end() && !known->second.expired()) || making_.count(key) > 0;
  }

  /// Returns the existing value, or null.
  std::shared_ptr<const Value> find(const Key& key) const {
    const std::lock_guard lock(mutex_);
    const auto known = known_.find(key);
    return known == known_.end() ? nullptr : known->second.lock();
  }

 private:
  mutable std::mutex mutex_;
  std::condition_variable made_;
  std::set<Key> making_;
  std::map<Key, std::weak_ptr<const Value>> known_;
};

}  // namespace gxy
