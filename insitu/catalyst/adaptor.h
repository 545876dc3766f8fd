// SPDX-License-Identifier: Apache-2.0
// Publishes what a simulation hands to Catalyst through the interface of galaxy_insitu.h.
#pragma once
#include <map>
#include <memory>
#include <set>
#include <string>
#include <tuple>
#include <vector>

#include "insitu/api/galaxy_insitu.h"
#include "insitu/catalyst/blueprint.h"

namespace gxy::catalyst {

/// Says each text once, on standard error, which is where users of Catalyst look.
class Messages {
 public:
  void say(const std::string& text);
  void setRank(int rank, int ranks);

 private:
  std::string prefix_ = "galaxy: ";
  std::set<std::string> said_;
};

/// One stream, from catalyst_initialize to catalyst_finalize. Functions throw std::runtime_error.
class Adaptor {
 public:
  Adaptor(const Node& params, Messages& messages);

  /// Offers the step. What is not taken is said and left out.
  void execute(const Node& params);
  void about(void* node) const;

 private:
  struct Close {
    double* seconds;
    void operator()(gxy_sim* sim) const { gxy_close(sim, *seconds); }
  };
  struct Whole {
    Index points;
    Position origin, spacing;
  };
  struct Placed {
    Index points;
    Position origin;
    Box box;
  };
  using Key = std::tuple<std::string, int, std::string>;  // mesh, block, field
  struct Told {
    bool now = true;  // in this step
    std::vector<std::byte> copy;
  };

  Meshes meshesOf(const Node& params);
  Whole wholeOf(const std::vector<GridBlock>& blocks, const std::vector<Box>& boxes) const;
  void place(const std::vector<GridBlock>& blocks);
  void grids(std::vector<GridBlock> blocks);
  void field(const Values& values, const std::string& mesh, int block, int of, const Index& extent,
             const Index& first);
  void warn(const std::string& text) const { messages_->say(text); }

  Messages* messages_;
  int rank_ = 0, ranks_ = 1;
  std::optional<Index> size_;  // what catalyst_initialize has said of the whole grid
  std::optional<Position> origin_;
  bool shared_;  // neighbouring blocks have a layer of points in common
  std::string ghosts_, association_, to_;
  double seconds_;
  std::unique_ptr<gxy_sim, Close> sim_;

  bool published_ = false;  // once; from then on blocks cannot change
  bool off_ = false;        // publishing is, and so for ever
  int of_ = GXY_OF_POINTS;
  std::string grid_;  // the mesh that is the stream's grid
  std::vector<Placed> placed_;
  std::map<Key, Told> told_;  // what gxy_publish() will read
};

}  // namespace gxy::catalyst
