// SPDX-License-Identifier: Apache-2.0
// Which of the tasks that wait on a rank runs next.
#pragma once
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <mutex>

namespace gxy {

/// For whom a frame is rendered.
struct Share {
  uint32_t tenant = 0;
  bool interactive = false;  ///< somebody looks at it: goes before all that is not
  uint64_t stream = 0;       ///< of the tenant: one window or batch, whose frames are wanted in their order
};

/// Tasks of interactive frames first, then the others; within each, tenants in turn (the one that was served longest ago),
/// and the tasks of a tenant in their order. So a task waits for those that run, and for one of each other tenant. Thread
/// safe.
class ReadyQueue {
 public:
  using Task = std::function<void()>;

  /// `first`: before the other tasks of its tenant, as the rest of one that gave way.
  void push(const Share& share, Task task, bool first = false);
  /// Takes the next; empty if there is none.
  Task pop();
  bool empty() const { return size() == 0; }
  size_t size() const;

 private:
  struct Tenant {
    uint64_t served = 0;  ///< the turn in which it was, last
    std::deque<Task> tasks;
  };
  using Tenants = std::map<uint32_t, Tenant>;

  mutable std::mutex mutex_;
  Tenants interactive_, others_;
  size_t tasks_ = 0;
  uint64_t turn_ = 0;
};

}  // namespace gxy
