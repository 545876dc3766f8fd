// SPDX-License-Identifier: Apache-2.0
// What one rank is asked for in a trace of lines, and what it has of the result.
#pragma once
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <glm/vec3.hpp>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "core/rays/device_fields.h"
#include "core/render/priority.h"
#include "core/space/ledger.h"

namespace gxy {

/// What one rank gives to a trace. All members but the seeds, `device` and `takeMemory` are the same on all
/// ranks.
struct TraceRequest {
  /// Enters bytes for stored points and ends in the ledger. Throws Error if there is no room. It is called
  /// by one thread at a time, and not after the trace has ended.
  using TakeMemory = std::function<LedgerEntry(int64_t bytes)>;

  std::shared_ptr<const LineFields> fields;
  std::shared_ptr<const DeviceFields> device;  ///< made of `fields` for this rank
  /// This rank's seeds, in world coordinates, wherever they are, and the number of each one's line. Two seeds
  /// of all ranks have the same number only if both lines are to be one, which makeLines() refuses.
  std::vector<glm::dvec3> seeds;
  std::vector<uint64_t> lines;
  TraceDirection direction = TraceDirection::Forward;
  TraceOptions options;
  Priority priority;    ///< whose turn the work is done in
  std::string account;  ///< the ledger's tenant for heads; empty: that of Tracer::Options
  TakeMemory takeMemory = [](int64_t) { return LedgerEntry(); };

  /// The number of heads of a seed.
  int directions() const { return direction == TraceDirection::Both ? 2 : 1; }
  /// The number of this rank's heads, and so of the ends of their lines.
  uint64_t heads() const { return seeds.size() * uint64_t(directions()); }
};

/// What a trace has stored on one rank: of each line the points of the way that it has gone here, and its
/// ends here. Together all ranks have each point once, and for each seed and direction one end.
struct TracedLines {
  std::vector<PathPoints> points;  ///< in any order
  std::vector<LineEnd> ends;       ///< in any order
  std::vector<LedgerEntry> memory;
  AdvanceCounters counters;
};

/// A rank's part of one trace. Thread safe.
class TraceShare {
 public:
  explicit TraceShare(TraceRequest request) : request(std::move(request)) {}

  const TraceRequest request;

  /// Keeps the points and ends of a result. Their memory is taken in steps of 1 MiB before there is room made
  /// for them. Throws Error if there is none.
  void store(AdvanceResult& result);
  /// The number of ends that are kept here.
  uint64_t ends() const { return ends_; }

  /// Says that the trace has ended on this rank.
  void end();
  /// Waits until the trace has ended here, but not longer than `most`. Returns whether it has ended.
  bool waitForEnd(std::chrono::milliseconds most);
  /// Moves out what is kept, once the trace has ended.
  TracedLines take();

 private:
  void takeMemory(int64_t bytes);
  void storePoints(PathPoints& points);
  void storeEnds(const std::vector<LineEnd>& ends);

  std::mutex mutex_;
  std::condition_variable changed_;
  bool ended_ = false;
  TracedLines stored_;
  bool open_ = false;  ///< the last of stored_.points has room left
  std::atomic<uint64_t> ends_ = 0;
};

}  // namespace gxy
