// SPDX-License-Identifier: Apache-2.0
// The thread by which a rank of a simulation is connected to a server.
#pragma once
#include <atomic>
#include <condition_variable>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "insitu/client/interrupt.h"
#include "insitu/client/join.h"
#include "insitu/client/options.h"
#include "insitu/client/wire_socket.h"
#include "insitu/plan/description.h"
#include "insitu/plan/encodings.h"
#include "insitu/plan/sender.h"

namespace gxy::insitu {

/// Room for the copy of one step: the items of each destination one behind the other.
class Slot {
 public:
  /// Makes room for so many bytes. What was there is lost where it grows. Throws std::bad_alloc.
  std::byte* reserve(uint64_t bytes);
  const std::byte* data() const { return data_.get(); }

 private:
  std::unique_ptr<std::byte[]> data_;
  uint64_t bytes_ = 0;
};

/// Where the samples of a step go, and the slot that they are copied into. It is immutable but for the slot.
struct Route {
  uint64_t from = 0;  ///< the publish from which on this is the plan
  std::vector<Destination> destinations;
  Encodings encodings;
  std::vector<Sender::Load> loads;  ///< by destination
  std::shared_ptr<Slot> slot;
};

/// Returns a route with loads that fit the rest of it.
std::shared_ptr<const Route> withLoads(Route route, const std::vector<Mesh>& meshes);

/// Connects in the background and sends what is taken. If the connection is lost, it tries again as the options say. The
/// simulation's thread uses all functions.
class Connection {
 public:
  Connection(Options options, Member member);
  /// Waits for the thread.
  ~Connection();
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  /// Says what this rank has, from the next publish on. Called before the first publish() at least, and once at most before another.
  void describe(Description description);
  /// Counts a publish. True: the caller copies the step into the slot of route() and calls filled().
  bool publish() { return sender_.publish(); }
  /// Whether the next publish is appointed, so far, and can be taken.
  bool isNext() const { return sender_.isNext() && route(); }
  enum class Loss { EndsTheWait, IsWaitedOut };
  /// Waits until the next publish is due and can be taken, a later one is due, `until` has come, there will be no connection any more, or, if `loss` says so, the connection is
  /// lost or could not be made. Returns whether the publish is due.
  bool await(Interrupt::Clock::time_point until, Loss loss);
  /// As publish(), of the last publish of all. False: none is due, and nothing is counted.
  bool publishLast() { return sender_.publishLast(); }
  /// Returns null unless there is a plan for what was described last.
  std::shared_ptr<const Route> route() const;
  /// `counts` as in Sender::filled().
  void filled(int64_t step, double time, Counts counts);
  /// The step is not copied, as in Sender::notFilled().
  void notFilled(bool late);

  bool connected() const { return connected_; }
  /// There is no connection, and the last attempt has failed.
  bool lost() const;
  uint64_t published() const { return sender_.published(); }
  /// The parameters that the server has told last.
  Steering steering() const;
  /// Waits until what was taken is published or given up, or `until` has come.
  void settle(Interrupt::Clock::time_point until);
  /// Why there is no connection; empty if there is one, or if none has failed so far.
  std::string problem() const;
  /// Ends the stream on this rank.
  void close();

 private:
  static std::thread started(Connection& connection);
  void run();
  void serve();
  void end();
  void tellDescription(WireSocket& root);
  void tellRoot(const Control& message);
  bool isPlanned() const;
  bool isDueNow(Loss loss) const;
  void follow(const Joined& joined, std::vector<Destination> destinations);
  void exchange();
  Checksum checksumOf(const WireSocket& socket) const;
  void sendPieces(int owner, WireSocket& socket);
  void waitForSockets();
  void receive(int owner, WireSocket& socket);
  void receiveControl(const Control& message);
  void receivePlan(std::span<const std::byte> message);
  void receiveEncodings(std::span<const std::byte> message);
  void lose(const std::string& why);
  void sayBye();

  const Options options_;
  const Member member_;
  Interrupt interrupt_;
  Sender sender_;
  std::atomic<bool> connected_ = false;

  mutable std::mutex mutex_;  ///< guards the next seven
  std::condition_variable changed_;
  std::optional<Description> description_;
  std::shared_ptr<const Route> route_;
  std::string problem_;
  bool lost_ = false;   ///< the last attempt to connect has failed, or what it made was lost
  bool ended_ = false;  ///< there are no further attempts
  Steering steering_;

  // Used by the thread only.
  std::map<int, std::unique_ptr<WireSocket>> sockets_;  ///< by rank of the server
  Joined joined_;
  uint64_t described_ =
      0;  ///< what the server was told last is true from this publish on; 0: it was told nothing
  bool planned_ = false;
  bool over_ = false;  ///< the simulation has closed the stream on another rank

  std::thread thread_;
};

}  // namespace gxy::insitu
