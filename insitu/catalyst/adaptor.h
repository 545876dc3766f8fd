// SPDX-License-Identifier: Apache-2.0
// Publishes what a simulation hands to Catalyst through the interface of galaxy_insitu.h.
#pragma once
#include <limits>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <tuple>
#include <vector>

#include "insitu/api/galaxy_insitu.h"
#include "insitu/catalyst/parameters.h"

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
  void about(conduit_node_impl* node) const;

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
    Position origin, spacing;
    Box box;
    Index first{}, count{};  // in the whole grid; points or cells, as the grid counts
  };
  struct Grid {
    bool leftOut = false;
    int of = GXY_OF_POINTS;
    Index size{};  // the same
    Position origin{}, spacing{};
    std::vector<Placed> blocks;
  };
  using Key = std::tuple<std::string, int, std::string>;  // mesh, block, field; "": the positions of points

  void describe(const Node& params);
  void publish(bool last);
  Meshes meshesOf(const Node& params);
  Whole wholeOf(const std::vector<GridBlock>& blocks, const std::vector<Box>& boxes) const;
  Grid placed(const std::vector<GridBlock>& blocks);
  void tell(const std::string& mesh, const Grid& grid, size_t before);
  void grid(const std::string& mesh, const std::vector<GridBlock>& blocks);
  void points(const Points& points);
  void field(const Values& values, const Key& key, int of, const Index& extent, const Index& first);
  bool told(const Key& key, const std::string& path, int result);
  void warn(const std::string& text) const { messages_->say(text); }

  Messages* messages_;
  Parameters params_;
  std::unique_ptr<gxy_sim, Close> sim_;

  int64_t step_ = std::numeric_limits<int64_t>::min();  // of the last node
  double time_ = 0;
  bool published_ = false;  // once; from then on meshes and fields are the same
  bool off_ = false;        // publishing is, and so for ever
  std::map<std::string, Grid> grids_;
  std::map<std::string, std::string> owners_;  // by field, the first mesh with one of this name
  std::map<Key, bool> told_;                   // what gxy_publish() will read, and whether this step has it
  Meshes meshes_;                              // of this step, whose arrays gxy_publish() reads
  std::map<Key, std::vector<std::byte>> copies_;  // of components that lie at unequal distances
};

}  // namespace gxy::catalyst
