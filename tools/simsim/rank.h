// SPDX-License-Identifier: Apache-2.0
// One rank of the simulation: the block that it owns, and its side of the in situ interface.
#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/io/write_volume.h"
#include "insitu/api/galaxy_insitu.h"
#include "tools/simsim/block.h"
#include "tools/simsim/inputs.h"

namespace gxy::simsim {

/// Functions throw Error if the interface finds wrong use. Two threads must not use one Rank at the same time.
/// The destructor ends the stream on this rank without waiting.
class Rank {
 public:
  /// Opens the stream `name`, and describes the block and its arrays. `options` are those of gxy_open().
  Rank(const Inputs& inputs, const std::string& name, int rank, int ranks, const std::string& options);

  /// Memory for the block's values of array `index` of the inputs, in the first or in the second file.
  ReadTarget target(size_t index, bool second);

  /// Computes the values of a step in which the second file has this weight.
  void compute(double weight);
  /// Writes the block's values of the computed step. Array `index` of the writer is that of the inputs.
  void write(const VolumeWriter& writer) const;
  /// Offers the computed step, and returns what the interface says: a gxy_result that is not GXY_WRONG.
  int publish(int64_t step);
  /// Returns the interface's text about the last result.
  std::string message() const { return gxy_message(sim_.get()); }
  /// Ends the stream on this rank. Waits at most `seconds` for a step that was taken to reach the server.
  void close(double seconds) { gxy_close(sim_.release(), seconds); }

 private:
  void expectRight(int result) const;

  struct Close {
    void operator()(gxy_sim* sim) const { gxy_close(sim, 0); }
  };
  int rank_;
  Extent owned_;
  std::vector<BlockArray> arrays_;
  std::unique_ptr<gxy_sim, Close> sim_;  // is closed first: its fields lie in the arrays
};

/// Reads the blocks of all these ranks, each file once for each array. Calls `check` often; an exception from
/// it ends the reading.
void readBlocks(const Inputs& inputs, std::span<Rank> ranks, const std::function<void()>& check);

}  // namespace gxy::simsim
