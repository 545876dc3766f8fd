// SPDX-License-Identifier: Apache-2.0
// What a rank of Galaxy accepts from the ranks of a simulation, and when a step is there.
#pragma once
#include <cstdint>
#include <vector>

#include "insitu/plan/records.h"

namespace gxy::insitu {

/// The state machine of a rank of Galaxy, for one stream. It uses no sockets, threads or clocks. Counts are those of publishes.
///
/// The count of a chunk says by itself which step it belongs to: a later appointment has a larger count, but where nobody has sent anything of the one before. So a chunk of a later
/// step makes what came of an earlier one void, and a chunk of an earlier step is dropped. A rank of Galaxy needs no message about
/// appointments, which could come later than the chunks.
class Receiver {
 public:
  /// What comes from one rank of the simulation.
  using Source = std::vector<Item>;
  /// Sources by rank of the simulation.
  explicit Receiver(std::vector<Source> sources);

  /// Steps have this form from now on. Only while there is no room.
  void expect(std::vector<Source> sources);
  /// There is room for a step from now on.
  void open();
  /// Takes a chunk of `bytes` bytes from a rank of the simulation. True: it is to be stored. False: it is to be dropped. Throws Error
  /// for a chunk that does not follow the one before it, or one of a step that cannot have been appointed.
  bool accept(int rank, const PieceHeader& header, uint64_t bytes);
  /// The step of publish `count` cannot be kept. What comes of it is dropped from now on.
  void refuse(uint64_t count);
  /// Whether everything of the step count() has come.
  bool complete() const { return state_ == State::Open && current_ > 0 && missing_ == 0; }
  uint64_t count() const { return current_; }

  /// The step is used from now on, so that nothing may be stored any more. False: the step is not complete here, or is another.
  bool take(uint64_t count);
  /// There is no room any more. Chunks of counts up to this one may still come, and are dropped.
  void close(uint64_t upTo);

 private:
  enum class State { Closed, Open, Taken };
  struct Cursor {
    Source source;
    uint32_t item = 0;
    uint64_t offset = 0;
    uint64_t entries = 0;  ///< of the item, and of those behind it that are not the first with their number
  };
  void restart(uint64_t count);

  State state_ = State::Closed;
  uint64_t current_ = 0;  ///< the largest count that has come since open(), or 0
  uint64_t last_ = 0;     ///< chunks up to this count are dropped
  size_t missing_ = 0;    ///< sources of which something is missing
  std::vector<Cursor> cursors_;
};

}  // namespace gxy::insitu
