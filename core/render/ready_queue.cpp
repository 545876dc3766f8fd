// SPDX-License-Identifier: Apache-2.0
#include "gxy/render/ready_queue.h"

#include <utility>

namespace gxy {

void ReadyQueue::push(const Share& share, Task task, bool first) {
  const std::lock_guard lock(mutex_);
  std::deque<Task>& tasks = (share.interactive ? interactive_ : others_)[share.tenant].tasks;
  tasks.insert(first ? tasks.begin() : tasks.end(), std::move(task));
  tasks_++;
}

ReadyQueue::Task ReadyQueue::pop() {
  const std::lock_guard lock(mutex_);
  for (Tenants* tenants : {&interactive_, &others_}) {
    Tenant* next = nullptr;
    for (auto& [number, tenant] : *tenants)
      if (!tenant.tasks.empty() && (!next || tenant.served < next->served)) next = &tenant;
    if (!next) continue;
    next->served = ++turn_;
    Task task = std::move(next->tasks.front());
    next->tasks.pop_front();
    tasks_--;
    return task;
  }
  return {};
}

size_t ReadyQueue::size() const {
  const std::lock_guard lock(mutex_);
  return tasks_;
}

}  // namespace gxy
