// SPDX-License-Identifier: Apache-2.0
// TaskRunner: gives the tasks of a ReadyQueue to the Transport, in their turn.
#pragma once
#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>

#include "core/comm/transport.h"
#include "core/rays/packet_size.h"
#include "core/render/ready_queue.h"

namespace gxy {

/// Runs what waits in its ReadyQueue, at most Options::most tasks at once. What is posted to the Transport is
/// a *runner*, which takes whichever task or tile is next only when it runs. Whoever is more urgent therefore
/// waits for the tasks that run, and for none that were pushed before.
///
/// Threads: any thread may call all functions except the constructor and destructor.
class TaskRunner {
 public:
  using Task = std::function<void()>;
  struct Options {
    ReadyQueue::Options queue;
    int most = 0;            ///< most runners at once; 0: no limit
    bool longTasks = false;  ///< runners are Transport::postLong() tasks, for tasks that compute for long
    /// Processor time of the calling thread, by which the queue shares the processors.
    std::function<std::chrono::nanoseconds()> processorTime = PacketSize::processorTime;
  };

  /// `transport` must outlive the object.
  TaskRunner(Transport& transport, Options options);
  ~TaskRunner() { close(); }
  TaskRunner(const TaskRunner&) = delete;
  TaskRunner& operator=(const TaskRunner&) = delete;

  ReadyQueue& queue() { return queue_; }
  const ReadyQueue& queue() const { return queue_; }

  /// Queues a task, as ReadyQueue::push() does, and starts a runner.
  void push(const Priority& priority, uint64_t set, Task task, bool first = false);
  /// Starts a runner if there may be one more. To be called when something else than push() has made work
  /// ready: tiles were added, or credits came back.
  void start();
  /// Must be called by a task that is running. close() then waits until the returned pointer is destroyed,
  /// too: for work that goes on where no task runs, as on a device.
  [[nodiscard]] std::shared_ptr<void> stay();
  /// Waits for the tasks that are running. Others that still come do not run. What waits in the queue stays
  /// there until it is destroyed.
  void close();

 private:
  class Gate;
  void runNext();

  Transport& transport_;
  const Options options_;
  const std::shared_ptr<Gate> gate_;  ///< shared with tasks: those that start too late find it closed
  ReadyQueue queue_;
  std::atomic<int> running_ = 0;
};

}  // namespace gxy
