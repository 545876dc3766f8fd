// SPDX-License-Identifier: Apache-2.0
// The tables of Cinema databases are read and replaced by one request at a time.
#pragma once
#include <map>
#include <memory>
#include <mutex>
#include <string>

namespace gxy::viewer {

/// A mutex for each database that a request works on. Thread safe.
class TableLocks {
 public:
  /// The mutex of a database's folder. Whoever has the same one holds the same mutex.
  std::shared_ptr<std::mutex> of(const std::string& folder) {
    const std::lock_guard lock(mutex_);
    std::erase_if(known_, [](const auto& k) { return k.second.expired(); });
    std::weak_ptr<std::mutex>& known = known_[folder];
    std::shared_ptr<std::mutex> one = known.lock();
    if (!one) known = one = std::make_shared<std::mutex>();
    return one;
  }

 private:
  std::mutex mutex_;
  std::map<std::string, std::weak_ptr<std::mutex>> known_;
};

}  // namespace gxy::viewer
