// SPDX-License-Identifier: Apache-2.0
#include "core/comm/mpi_transport.h"

#include <mpi.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "core/comm/backoff.h"
#include "core/comm/error.h"
#include "core/comm/mpi_environment.h"
#include "core/comm/mpi_packets.h"
#include "core/comm/thread_order.h"
#include "core/comm/thread_pool.h"

namespace gxy {

namespace {

MPI_Comm duplicate(const void* communicator) {
  MPI_Comm own;
  MPI_Comm_dup(communicator ? *static_cast<const MPI_Comm*>(communicator) : MPI_COMM_WORLD, &own);
  return own;
}

int rankIn(MPI_Comm communicator) {
  int rank = 0;
  MPI_Comm_rank(communicator, &rank);
  return rank;
}

int sizeOf(MPI_Comm communicator) {
  int size = 0;
  MPI_Comm_size(communicator, &size);
  return size;
}

// The number of ranks on this rank's node, and the rank's index among those with its role.
struct Node {
  Node(MPI_Comm communicator, int role) {
    MPI_Comm node, alike;
    MPI_Comm_split_type(communicator, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &node);
    ranks = sizeOf(node);
    MPI_Comm_split(node, role, 0, &alike);
    rank = rankIn(alike);
    MPI_Comm_free(&alike);
    MPI_Comm_free(&node);
  }
  int ranks, rank;
};

int cores() { return std::max(1, int(std::thread::hardware_concurrency())); }

MpiTransport::Options checked(MpiTransport::Options options) {
  if (options.packetBytes < 256 || options.packetBytes > size_t(1) << 30)
    throw Error("MpiTransport: packetBytes is " + std::to_string(options.packetBytes) +
                ", expected 256 to 2^30");
  if (options.chunkBytes < 1 || options.chunkBytes > size_t(1) << 30)
    throw Error("MpiTransport: chunkBytes is " + std::to_string(options.chunkBytes) + ", expected 1 to 2^30");
  if (options.threads < 0)
    throw Error("MpiTransport: threads is " + std::to_string(options.threads) + ", expected 0 or more");
  if (options.role < 0)
    throw Error("MpiTransport: role is " + std::to_string(options.role) + ", expected 0 or more");
  return options;
}

}  // namespace

class MpiTransport::Progress {
 public:
  explicit Progress(Options options)
      : options_(checked(std::move(options))),
        communicator_(duplicate(options_.communicator)),
        rank_(rankIn(communicator_)),
        size_(sizeOf(communicator_)),
        node_(communicator_, options_.role),
        threads_(options_.threads > 0 ? options_.threads : std::max(1, cores() / node_.ranks)),
        sender_(communicator_, size_, {options_.packetBytes, options_.chunkBytes}),
        receiver_(communicator_, {options_.packetBytes, options_.chunkBytes}),
        backoff_(node_.ranks * (threads_ + 1) <= cores(), size_, node_.ranks) {
    // oneTBB makes one thread fewer than it is allowed, because it expects the caller to join. No caller
    // joins here.
    if (threads_ >= cores())
      allowed_.emplace(tbb::global_control::max_allowed_parallelism, size_t(threads_) + 1);
    arena_.initialize(threads_, 0);
    thread_ = std::thread([this] { run(); });
  }

  ~Progress() { MPI_Comm_free(&communicator_); }

  /// Returns when all ranks have called it and no message or task is left. Until then everything else still works.
  void end() {
    {
      std::lock_guard lock(mutex_);
      ending_ = true;
    }
    thread_.join();
  }

  int rank() const { return rank_; }
  int size() const { return size_; }
  int threads() const { return threads_; }
  int rankOnNode() const { return node_.rank; }

  void send(int destination, Channel channel, Bytes message) {
    if (destination < 0 || destination >= size_)
      throw Error("message to rank " + std::to_string(destination) + ", expected 0 to " +
                  std::to_string(size_ - 1));
    ++created_;
    enqueue({destination, {rank_, channel, std::move(message)}});
  }

  void onMessage(Channel channel, Handler handler) {
    for (auto& kept : mailbox_.setHandler(channel, std::move(handler))) {
      ++created_;
      enqueue({rank_, std::move(kept)});
    }
  }

  void post(Task task) {
    const ThreadOrder order(&arena_);
    order.handOver();
    arena_.enqueue([order, task = counted(std::move(task))] {
      order.begin();
      task();
    });
  }

  void postWaiting(Task task) { waitingTasks_.run(counted(std::move(task))); }

  void postLong(Task task) {
    longTasks_.run([task = counted(std::move(task))]() mutable {
      // A oneTBB worker that this thread started would inherit its low priority and keep it for good.
      tbb::task_arena alone(1);
      alone.execute([&task] { std::exchange(task, nullptr)(); });
    });
  }

  void abort() { aborting_ = true; }

  std::map<Channel, Traffic> traffic() const {
    std::lock_guard lock(trafficMutex_);
    return traffic_;
  }
  int partners() const {
    std::lock_guard lock(trafficMutex_);
    return int(std::count(isPartner_.begin(), isPartner_.end(), true));
  }

  Counters counters() const {
    std::lock_guard lock(mutex_);
    return {bytesSent_, packetsSent_, messagesSent_, queuedBytes_ + heldBySender_, mostWaiting_};
  }

 private:
  struct Outgoing {
    int destination;
    Delivery delivery;
  };

  void enqueue(Outgoing outgoing) {
    bool wake;
    {
      std::lock_guard lock(mutex_);
      wake = sleeping_;
      if (outgoing.destination != rank_) queuedBytes_ += outgoing.delivery.message.size();
      mostWaiting_ = std::max<uint64_t>(mostWaiting_, queuedBytes_ + heldBySender_);
      outgoing_.push_back(std::move(outgoing));
    }
    if (wake) changed_.notify_one();
  }

  /// Wraps a task so that its exception is reported and its end is counted.
  Task counted(Task task) {
    ++created_;
    return [this, task = std::move(task)]() mutable {
      guarded(options_.onError, rank_, "a task", task);
      task = nullptr;
      ++retired_;
    };
  }

  // ------------------------------------------------------------------------------------- on the progress
  // thread

  void run() {
    try {
      while (!ended()) {
        if (aborting_) MPI_Abort(communicator_, 1);
        // Each step runs, whether or not the ones before it found anything to do.
        const bool handed = handOver(), reaped = sender_.reap(), received = receive();
        const bool active = handed || reaped || received;
        heldBySender_ = sender_.bytesHeld();
        bytesSent_ = sender_.bytesSent();
        packetsSent_ = sender_.packetsSent();
        if (active)
          backoff_.active();
        else
          pause();
      }
      sender_.finish();
    } catch (const std::exception& error) {
      options_.onError(rank_, std::string("the progress thread failed, the job ends: ") + error.what());
      MPI_Abort(communicator_, 1);
    }
  }

  bool handOver() {
    std::vector<Outgoing> outgoing;
    {
      std::lock_guard lock(mutex_);
      outgoing.swap(outgoing_);
      queuedBytes_ = 0;
    }
    for (auto& [destination, delivery] : outgoing) {
      if (destination == rank_) {
        deliver(std::move(delivery));
      } else {
        ++messagesSent_;
        countSent(destination, delivery);
        sender_.add(destination, delivery.channel, std::move(delivery.message));
      }
    }
    sender_.flush();
    return !outgoing.empty();
  }

  bool receive() {
    return receiver_.poll([this](Delivery delivery) {
      countReceived(delivery);
      deliver(std::move(delivery));
    });
  }

  void countSent(int destination, const Delivery& delivery) {
    std::lock_guard lock(trafficMutex_);
    Traffic& traffic = traffic_[delivery.channel];
    traffic.messagesSent++;
    traffic.bytesSent += delivery.message.size();
    isPartner_[size_t(destination)] = true;
  }

  void countReceived(const Delivery& delivery) {
    std::lock_guard lock(trafficMutex_);
    Traffic& traffic = traffic_[delivery.channel];
    traffic.messagesReceived++;
    traffic.bytesReceived += delivery.message.size();
    isPartner_[size_t(delivery.source)] = true;
  }

  void deliver(Delivery delivery) {
    guarded(options_.onError, rank_, "a message handler", [&] { mailbox_.deliver(std::move(delivery)); });
    ++retired_;
  }

  void pause() {
    const auto sleep = backoff_.next(!sender_.idle() || !receiver_.idle());
    if (sleep.count() == 0) return std::this_thread::yield();
    std::unique_lock lock(mutex_);
    sleeping_ = true;
    changed_.wait_for(lock, sleep, [this] { return !outgoing_.empty(); });
    sleeping_ = false;
  }

  /// True when all ranks are ending and no message or task is left on any of them. Messages and tasks are
  /// counted as in completion.h; one MPI sum over all ranks takes the place of a wave.
  bool ended() {
    if (sum_ != MPI_REQUEST_NULL) {
      int done = 0;
      MPI_Test(&sum_, &done, MPI_STATUS_IGNORE);
      if (!done) return false;
      const uint64_t retiredBefore = std::exchange(retiredLastWave_, sums_.retired);
      if (sums_.created == retiredBefore) return true;
    }
    {
      std::lock_guard lock(mutex_);
      if (!ending_ || !outgoing_.empty()) return false;
    }
    if (!receiver_.idle()) return false;
    // Each rank's existence counts as an item, created by the constructor and retired here.
    mine_ = {created_ + 1, retired_ + 1};
    MPI_Iallreduce(&mine_, &sums_, 2, MPI_UINT64_T, MPI_SUM, communicator_, &sum_);
    return false;
  }

  struct Sums {
    uint64_t created = 0, retired = 0;
  };

  const MpiEnvironment environment_;
  const Options options_;
  MPI_Comm communicator_;
  const int rank_, size_;
  const Node node_;
  const int threads_;
  Mailbox mailbox_{options_.trace};
  PacketSender sender_;
  PacketReceiver receiver_;
  Backoff backoff_;

  mutable std::mutex mutex_;  ///< guards the next five members
  std::condition_variable changed_;
  std::vector<Outgoing> outgoing_;
  uint64_t queuedBytes_ = 0;  ///< of outgoing_ messages to other ranks
  bool sleeping_ = false, ending_ = false;

  std::atomic<uint64_t> created_ = 0, retired_ = 0;  ///< messages and tasks of this rank
  std::atomic<uint64_t> bytesSent_ = 0, packetsSent_ = 0, messagesSent_ = 0;
  std::atomic<bool> aborting_ = false;
  std::atomic<uint64_t> heldBySender_ = 0, mostWaiting_ = 0;
  mutable std::mutex trafficMutex_;  ///< guards the next two members
  std::map<Channel, Traffic> traffic_;
  std::vector<bool> isPartner_ = std::vector<bool>(size_t(size_));  ///< by rank
  Sums mine_, sums_;
  uint64_t retiredLastWave_ = 0;
  MPI_Request sum_ = MPI_REQUEST_NULL;

  std::optional<tbb::global_control> allowed_;
  tbb::task_arena arena_;
  ThreadPool waitingTasks_, longTasks_{ThreadPool::unlimited, ThreadPool::Priority::Low};
  std::thread thread_;
};

MpiTransport::MpiTransport(Options options) : progress_(std::make_unique<Progress>(std::move(options))) {}
MpiTransport::~MpiTransport() { progress_->end(); }

int MpiTransport::rank() const { return progress_->rank(); }
int MpiTransport::size() const { return progress_->size(); }
int MpiTransport::threads() const { return progress_->threads(); }
int MpiTransport::rankOnNode() const { return progress_->rankOnNode(); }
void MpiTransport::send(int destination, Channel channel, Bytes message) {
  progress_->send(destination, channel, std::move(message));
}
void MpiTransport::onMessage(Channel channel, Handler handler) {
  progress_->onMessage(channel, std::move(handler));
}
void MpiTransport::post(Task task) { progress_->post(std::move(task)); }
void MpiTransport::postWaiting(Task task) { progress_->postWaiting(std::move(task)); }
void MpiTransport::postLong(Task task) { progress_->postLong(std::move(task)); }
void MpiTransport::abort() { progress_->abort(); }
Transport::Counters MpiTransport::counters() const { return progress_->counters(); }
std::map<Channel, MpiTransport::Traffic> MpiTransport::traffic() const { return progress_->traffic(); }
int MpiTransport::partners() const { return progress_->partners(); }

}  // namespace gxy
