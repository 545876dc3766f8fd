// SPDX-License-Identifier: Apache-2.0
#include "multiserver/modules/viewer/retries.h"

#include <chrono>
#include <vector>

#include "multiserver/modules/viewer/window.h"

namespace gxy::viewer {

Retries::~Retries() {
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
  }
  changed_.notify_all();
  if (thread_.joinable()) thread_.join();
}

void Retries::add(const std::string& tenant, std::weak_ptr<Window> window) {
  const std::lock_guard lock(mutex_);
  waiting_[tenant].push_back(std::move(window));
  if (!thread_.joinable()) thread_ = std::thread([this] { run(); });
  changed_.notify_all();
}

void Retries::onEnd(const std::string& tenant) {
  if (const auto window = takeOne(tenant)) window->tryAgain();
}

std::shared_ptr<Window> Retries::takeOne(const std::string& tenant) {
  const std::lock_guard lock(mutex_);
  const auto at = waiting_.find(tenant);
  if (at == waiting_.end()) return nullptr;
  std::shared_ptr<Window> window;
  while (!window && !at->second.empty()) {
    window = at->second.front().lock();
    at->second.pop_front();
  }
  if (at->second.empty()) waiting_.erase(at);
  return window;
}

void Retries::run() {
  std::unique_lock lock(mutex_);
  while (!ending_) {
    changed_.wait(lock, [this] { return ending_ || !waiting_.empty(); });
    if (changed_.wait_for(lock, std::chrono::seconds(1), [this] { return ending_; })) return;
    std::vector<std::string> tenants;
    for (const auto& [tenant, windows] : waiting_) tenants.push_back(tenant);
    lock.unlock();
    for (const std::string& tenant : tenants) onEnd(tenant);
    lock.lock();
  }
}

}  // namespace gxy::viewer
