// SPDX-License-Identifier: Apache-2.0
// Path lines from the points that ranks have stored while lines were traced.
#pragma once
#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "core/analysis/trace_share.h"
#include "core/comm/collectives.h"
#include "core/data/geometry.h"

namespace gxy {

/// The number of a stored point that becomes its value in the geometry.
struct LineValue {
  enum class Kind : uint8_t { Speed, Time, Length, Recorded };
  Kind kind = Kind::Speed;
  int component = 0;  ///< Recorded: index into CompiledFields::recorded()
};

/// A further field of points.
struct NamedLineValue {
  std::string name;
  LineValue value;
};

/// Lines as geometry.
struct MadeLines {
  GeometryBlock block;                       ///< PathLines: the segments of this rank
  LedgerEntry memory;                        ///< of the block
  uint64_t lines = 0;                        ///< on all ranks: lines with a segment
  uint64_t points = 0;                       ///< on all ranks: points of these, each counted once
  std::array<uint64_t, kEndReasons> ends{};  ///< on all ranks: how many heads have ended so, by EndReason
};

/// Collective. Joins the points of each line, on whichever ranks they lie, in order of their numbers. So the
/// backward and the forward half of a line become one, in order of time. A segment belongs to the rank that
/// has its second point, and its id is line << 24 | number of the segment, counted from the line's first
/// point. Points that are equal to the one before them, in position, value and fields, are left out, as
/// dropUnusable() would. Lines of one point have no segment.
///
/// All blocks together depend only on the points: merged() makes equal bytes of them.
///
/// At borders, each rank sends the first two and the last two points of what it has of a line to the line's
/// home, which is rank (line % ranks). The home answers with the two points before and the one after.
///
/// `takeMemory` enters the bytes of the block in the ledger, and those of what is needed meanwhile. If any rank fails, all throw the same Error.
///
/// `fields`, fewer than kMostLineValues (line_runs.h), become fields of the points.
MadeLines makeLines(TracedLines lines, const LineValue& value,
                    const std::function<LedgerEntry(int64_t bytes)>& takeMemory, Collectives& ranks,
                    const std::vector<NamedLineValue>& fields = {});

}  // namespace gxy
