// SPDX-License-Identifier: Apache-2.0
// What a rank of a simulation does with the steps that it publishes: which it takes, and in which order it sends them.
#pragma once
#include <atomic>
#include <cstdint>
#include <mutex>
#include <optional>
#include <vector>

#include "insitu/plan/appointment.h"
#include "insitu/plan/records.h"

namespace gxy::insitu {

/// The state machine of a rank of the simulation. It uses no sockets, threads or clocks: the caller passes on what comes from
/// the server (receive), and sends what this returns. It has one slot for the copy of one step.
///
/// The simulation's thread calls publish(), publishLast(), filled(), notFilled(), isDue(), isNext(), await(), idle(), count() and published(); one other
/// thread calls the rest.
class Sender {
 public:
  /// What goes to each rank of Galaxy, in the order in the slot. Chunks are cut between points.
  struct Load {
    int owner = 0;
    std::vector<Item> items;
  };
  /// Part of the slot that is to be sent to `owner` behind `header`.
  struct Chunk {
    int owner = 0;
    PieceHeader header;
    uint64_t place = 0, bytes = 0;  ///< in the slot
  };

  /// Begins anew with a server. What was under way is forgotten. The count of publishes goes on.
  void begin();
  /// Steps have this form from now on. Throws Error if one is under way.
  void expect(std::vector<Load> loads);

  /// Counts a publish. True: the caller copies the step into the slot, and calls filled(). No lock is taken, and nothing waits.
  bool publish() { return appointment_.publish(); }
  /// Whether the next publish, or one after it, is appointed.
  bool isDue() const { return appointment_.isDue(); }
  /// Whether the next publish is appointed.
  bool isNext() const { return appointment_.isNext(); }
  /// The simulation waits until the next publish is due. The server is told (waits).
  void await();
  /// The last publish of all takes whatever is due. True as for publish(). False: nothing is due, and nothing is counted.
  bool publishLast() { return appointment_.publishLast(); }
  /// The copy is in the slot. `counts`: of all meshes, or up to the last one that is no grid.
  void filled(int64_t step, double time, Counts counts = {});
  /// The step is not copied. The server is told that the publish was missed (answer); `late`: it came too late for this rank, else
  /// there is no memory for the copy.
  void notFilled(bool late);

  /// Takes a message of the server. Returns what is answered at once, if anything.
  std::optional<Control> receive(const Control& message);
  /// Returns what is answered later, once it is due. A rank that copies a step which has been cancelled has no room
  /// until filled(), so it says nothing before that would lead to an appointment.
  std::optional<Control> answer();

  /// Returns, once for each publish that is waited for, that the server is to appoint it; but not before the server has said
  /// anything after the last such message. Only after begin().
  std::optional<Control> waits();
  /// Returns what the server's rank 0 is told about the step in the slot, once it is there.
  std::optional<StepHeader> announcement();
  /// Returns the next chunk for a rank of Galaxy, if there is one.
  std::optional<Chunk> next(int owner);
  /// A taken step has reached the server, or was given up by it, or there is none.
  bool idle() const;

  uint64_t count() const { return appointment_.count(); }
  uint64_t published() const { return published_.load(); }  ///< steps that the server has published

  static constexpr uint64_t kChunkBytes = 1 << 20;

 private:
  enum class Slot { Free, Appointed, Full, Void };  ///< Void: cancelled while the simulation copies into it
  struct Cursor {
    Load load;
    uint32_t item = 0;
    uint64_t begin = 0, offset = 0;  ///< of the item in the slot; of what is sent next, in the item
  };
  uint64_t pointsOf(const Item& item) const;

  std::optional<Control> answerNow();
  std::optional<Control> appoint(uint64_t count);
  void settle();

  Appointment appointment_;
  std::atomic<uint64_t> published_ = 0;
  /// Guards the members below. The simulation's thread takes it for steps that are taken or waited for, not in publish().
  mutable std::mutex mutex_;
  Slot slot_ = Slot::Free;
  uint64_t appointed_ = 0;            ///< the count that the slot is for, unless it is free
  Counts counts_;                     ///< of what is in the slot
  std::optional<uint64_t> question_;  ///< that waits for an answer
  std::optional<Control> missed_;     ///< that is to be told
  std::optional<StepHeader> announcement_;
  uint64_t awaited_ = 0, told_ = 0;  ///< the publish that is waited for, and of which the server knows so
  bool heard_ = true;                ///< whether the server has said anything since it was told
  std::vector<Cursor> cursors_;
};

}  // namespace gxy::insitu
