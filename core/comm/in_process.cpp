// SPDX-License-Identifier: Apache-2.0
#include "core/comm/in_process.h"

#include <atomic>
#include <condition_variable>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include "core/comm/error.h"
#include "core/comm/random.h"
#include "core/comm/thread_pool.h"

namespace gxy {

/// The interface of both kinds of world.
class InProcessWorld::World {
 public:
  virtual ~World() = default;
  virtual int size() const = 0;
  virtual Transport& rank(int rank) = 0;
  virtual bool step() = 0;
  virtual void run() = 0;
};

namespace {

void checkDestination(int destination, int size) {
  if (destination < 0 || destination >= size)
    throw Error("message to rank " + std::to_string(destination) + ", expected 0 to " +
                std::to_string(size - 1));
}

/// A rank's counters; every message is a packet of its own.
class Count {
 public:
  void sent(size_t bytes) {
    bytes_ += bytes;
    ++messages_;
  }
  Transport::Counters counters() const { return {bytes_, messages_, messages_, 0}; }

 private:
  std::atomic<uint64_t> bytes_ = 0, messages_ = 0;
};

// ----------------------------------------------------------------------------------------------------------
// seeded

/// Decides from the seed which events are slow. When the scheduler draws a slow event, it takes it once in
/// patience() draws and passes it over otherwise.
class Bias {
 public:
  explicit Bias(Random& random) {
    static constexpr uint64_t patiences[] = {1, 4, 32, 256};
    patience_ = patiences[random.below(4)];
    slowRanks_ = random.oneIn(2) ? random.next() & random.next() : 0;
    slowChannels_ = random.oneIn(2) ? random.next() & random.next() : 0;
    slowTasks_ = random.oneIn(4);
    slowEvents_ = random.oneIn(2) ? 2 + random.below(30) : 0;
  }

  bool slowMessage(Random& random, int source, int destination, Channel channel) const {
    return bit(slowRanks_, source) || bit(slowRanks_, destination) || bit(slowChannels_, int(channel)) ||
           slowEvent(random);
  }
  bool slowTask(Random& random, int rank) const {
    return bit(slowRanks_, rank) || slowTasks_ || slowEvent(random);
  }
  uint64_t patience() const { return patience_; }

 private:
  static bool bit(uint64_t mask, int i) { return mask >> (i % 64) & 1; }
  bool slowEvent(Random& random) const { return slowEvents_ && random.oneIn(slowEvents_); }

  uint64_t patience_ = 1;
  uint64_t slowRanks_ = 0;     ///< bit r mod 64: messages from and to rank r, and its tasks, are slow
  uint64_t slowChannels_ = 0;  ///< bit c mod 64: the messages of channel c are slow
  uint64_t slowEvents_ = 0;    ///< one event in this many is slow; 0: none
  bool slowTasks_ = false;     ///< all tasks are slow
};

class SeededWorld final : public InProcessWorld::World {
 public:
  SeededWorld(int ranks, uint64_t seed, ErrorReport report)
      : random_(seed), bias_(random_), report_(std::move(report)) {
    for (int r = 0; r < ranks; ++r) ranks_.push_back(std::make_unique<Rank>(*this, r));
  }

  int size() const override { return int(ranks_.size()); }
  Transport& rank(int rank) override { return *ranks_.at(rank); }
  void run() override {
    do {
      while (step()) {
      }
    } while (waitForPost());
  }

  bool step() override {
    std::unique_lock lock(mutex_);
    if (events_.empty()) return false;
    const size_t chosen = choose();
    std::swap(events_[chosen], events_.back());
    Event event = std::move(events_.back());
    events_.pop_back();
    lock.unlock();
    const auto act = [&] {
      if (event.task)
        event.task();
      else
        ranks_[event.rank]->mailbox.deliver(std::move(event.delivery));
    };
    if (report_)
      guarded(report_, event.rank, event.task ? "a task" : "a message handler", act);
    else
      act();
    return true;
  }

 private:
  struct Event {
    int rank;
    bool slow;
    Delivery delivery;
    Transport::Task task;  ///< empty: a message
  };

  class Rank final : public Transport {
   public:
    Rank(SeededWorld& world, int rank) : world_(world), rank_(rank) {}
    int rank() const override { return rank_; }
    int size() const override { return world_.size(); }
    void send(int destination, Channel channel, Bytes message) override {
      checkDestination(destination, size());
      count_.sent(message.size());
      world_.addMessage(destination, {rank_, channel, std::move(message)});
    }
    void onMessage(Channel channel, Handler handler) override {
      for (auto& kept : mailbox.setHandler(channel, std::move(handler)))
        world_.addMessage(rank_, std::move(kept));
    }
    void post(Task task) override { world_.addTask(rank_, std::move(task)); }
    void postWaiting(Task task) override { post(std::move(task)); }
    std::shared_ptr<void> expectPost() override { return world_.expectPost(); }
    Counters counters() const override { return count_.counters(); }

    Mailbox mailbox;

   private:
    SeededWorld& world_;
    const int rank_;
    Count count_;
  };

  std::shared_ptr<void> expectPost() {
    std::lock_guard lock(mutex_);
    expected_++;
    return {this, [](SeededWorld* world) {
              std::lock_guard lock(world->mutex_);
              world->expected_--;
              world->changed_.notify_all();
            }};
  }
  // Waits for an event while posts are expected. Returns whether there is one.
  bool waitForPost() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return !events_.empty() || expected_ == 0; });
    return !events_.empty();
  }

  void addMessage(int destination, Delivery delivery) {
    std::lock_guard lock(mutex_);
    const bool slow = bias_.slowMessage(random_, delivery.source, destination, delivery.channel);
    events_.push_back({destination, slow, std::move(delivery), {}});
  }
  void addTask(int rank, Transport::Task task) {
    std::lock_guard lock(mutex_);
    changed_.notify_all();
    events_.push_back({rank, bias_.slowTask(random_, rank), {}, std::move(task)});
  }

  size_t choose() {
    static constexpr int draws = 64;
    size_t chosen = 0;
    for (int i = 0; i < draws; ++i) {
      chosen = random_.below(events_.size());
      if (!events_[chosen].slow || random_.oneIn(bias_.patience())) break;
    }
    return chosen;
  }

  Random random_;
  Bias bias_;
  ErrorReport report_;
  std::vector<std::unique_ptr<Rank>> ranks_;
  std::mutex mutex_;  ///< guards random_ and the members below: expected tasks are posted by other threads
  std::condition_variable changed_;
  std::vector<Event> events_;
  size_t expected_ = 0;
};

// --------------------------------------------------------------------------------------------------------
// threaded

/// Counts the messages under way and the tasks posted or running, and waits until there are none.
class Outstanding {
 public:
  void add(size_t n = 1) { count_ += n; }
  void remove() {
    if (--count_ > 0) return;
    std::lock_guard lock(mutex_);
    zero_.notify_all();
  }
  void wait() {
    std::unique_lock lock(mutex_);
    zero_.wait(lock, [this] { return count_ == 0; });
  }

 private:
  std::atomic<size_t> count_ = 0;
  std::mutex mutex_;
  std::condition_variable zero_;
};

class ThreadedWorld final : public InProcessWorld::World {
 public:
  ThreadedWorld(int ranks, uint64_t seed, int workers, ErrorReport report)
      : report_(std::move(report)), workers_(size_t(workers)) {
    for (int r = 0; r < ranks; ++r) ranks_.push_back(std::make_unique<Rank>(*this, r, seed));
    for (auto& rank : ranks_) rank->start();
  }
  ~ThreadedWorld() override {
    outstanding_.wait();
    for (auto& rank : ranks_) rank->stop();
  }

  int size() const override { return int(ranks_.size()); }
  Transport& rank(int rank) override { return *ranks_.at(rank); }
  bool step() override { throw Error("InProcessWorld::step: the world is threaded, expected a seeded one"); }
  void run() override { outstanding_.wait(); }

 private:
  class Rank final : public Transport {
   public:
    Rank(ThreadedWorld& world, int rank, uint64_t seed)
        : world_(world), rank_(rank), random_(seed + 0x51ed2701 * uint64_t(rank)) {}

    void start() {
      thread_ = std::thread([this] { progress(); });
    }
    void stop() {
      {
        std::lock_guard lock(mutex_);
        stopping_ = true;
      }
      arrived_.notify_one();
      thread_.join();
    }

    int rank() const override { return rank_; }
    int size() const override { return world_.size(); }
    void send(int destination, Channel channel, Bytes message) override {
      checkDestination(destination, size());
      count_.sent(message.size());
      world_.ranks_[destination]->arrive({rank_, channel, std::move(message)});
    }
    void onMessage(Channel channel, Handler handler) override {
      for (auto& kept : mailbox_.setHandler(channel, std::move(handler))) arrive(std::move(kept));
    }
    void post(Task task) override { runOn(world_.workers_, std::move(task)); }
    void postWaiting(Task task) override { runOn(world_.waiting_, std::move(task)); }
    void postLong(Task task) override { runOn(world_.long_, std::move(task)); }
    std::shared_ptr<void> expectPost() override {
      world_.outstanding_.add();
      return {this, [](Rank* rank) { rank->world_.outstanding_.remove(); }};
    }
    Counters counters() const override { return count_.counters(); }

   private:
    void arrive(Delivery delivery) {
      world_.outstanding_.add();
      std::lock_guard lock(mutex_);
      waiting_.push_back(std::move(delivery));
      arrived_.notify_one();
    }

    void runOn(ThreadPool& pool, Task task) {
      world_.outstanding_.add();
      pool.run([this, task = std::move(task)]() mutable {
        guarded(world_.report_, rank_, "a task", task);
        task = nullptr;  // its captures are destroyed before the world can be
        world_.outstanding_.remove();
      });
    }

    void progress() {
      std::unique_lock lock(mutex_);
      while (true) {
        arrived_.wait(lock, [this] { return stopping_ || !waiting_.empty(); });
        if (waiting_.empty()) return;
        std::swap(waiting_[random_.below(waiting_.size())], waiting_.back());
        Delivery delivery = std::move(waiting_.back());
        waiting_.pop_back();
        lock.unlock();
        guarded(world_.report_, rank_, "a message handler", [&] { mailbox_.deliver(std::move(delivery)); });
        world_.outstanding_.remove();
        lock.lock();
      }
    }

    ThreadedWorld& world_;
    const int rank_;
    Random random_;
    Mailbox mailbox_;
    Count count_;
    std::mutex mutex_;
    std::condition_variable arrived_;
    std::vector<Delivery> waiting_;
    bool stopping_ = false;
    std::thread thread_;
  };

  ErrorReport report_;
  Outstanding outstanding_;
  std::vector<std::unique_ptr<Rank>> ranks_;
  ThreadPool workers_;
  ThreadPool waiting_, long_{ThreadPool::unlimited, ThreadPool::Priority::Low};
};

}  // namespace

InProcessWorld::InProcessWorld(int ranks, uint64_t seed, Options options) {
  if (ranks < 1) throw Error("InProcessWorld: " + std::to_string(ranks) + " ranks, expected at least 1");
  if (options.threaded)
    world_ = std::make_unique<ThreadedWorld>(ranks, seed, options.workers,
                                             options.onError ? std::move(options.onError) : logError);
  else
    world_ = std::make_unique<SeededWorld>(ranks, seed, std::move(options.onError));
}

InProcessWorld::~InProcessWorld() = default;
Transport& InProcessWorld::rank(int rank) { return world_->rank(rank); }
int InProcessWorld::size() const { return world_->size(); }
bool InProcessWorld::step() { return world_->step(); }
void InProcessWorld::run() { world_->run(); }

}  // namespace gxy
