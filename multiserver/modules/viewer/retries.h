// SPDX-License-Identifier: Apache-2.0
// Windows that wait for room to show newer data. Rank 0.
#pragma once
#include <condition_variable>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

namespace gxy::viewer {

class Window;

/// Windows whose tenant had too much under way, or too little memory, for a frame of newer data. One of a tenant's tries
/// again whenever one of its renderings has ended, and one each second, for room that comes back in other ways. So what tries
/// in vain takes no more than what is rendered. Thread safe; a thread of its own from the first window on.
class Retries {
 public:
  ~Retries();
  /// Calls Window::tryAgain once, if the window is still there.
  void add(const std::string& tenant, std::weak_ptr<Window> window);
  /// A rendering of the tenant has ended. Short.
  void onEnd(const std::string& tenant);

 private:
  std::shared_ptr<Window> takeOne(const std::string& tenant);
  void run();

  std::mutex mutex_;
  std::condition_variable changed_;
  std::map<std::string, std::deque<std::weak_ptr<Window>>> waiting_;  ///< by tenant, in order; none is empty
  bool ending_ = false;
  std::thread thread_;
};

}  // namespace gxy::viewer
