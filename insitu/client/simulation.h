// SPDX-License-Identifier: Apache-2.0
// What stands behind a gxy_sim.
#pragma once
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "insitu/api/galaxy_insitu.h"
#include "insitu/client/connection.h"

namespace gxy::insitu {

/// One rank of a simulation. Functions throw Error for wrong use; then nothing has changed.
class Simulation {
 public:
  Simulation(Options options, Member member);

  void grid(const std::string& mesh, int block, const Grid& grid, const Extent& owned);
  void field(const std::string& mesh, int block, const std::string& name, const gxy_array& values);
  /// Returns one of gxy_result.
  int publish(int64_t step, double time);

  bool on() const { return connection_ != nullptr; }
  gxy_stat statistics() const;
  /// Why there is no connection; empty if there is one.
  std::string problem() const { return connection_ ? connection_->problem() : std::string(); }
  void close(double seconds);

 private:
  struct Block {
    Extent owned;
    std::map<std::string, gxy_array> fields;
    int index = 0;  ///< among the blocks that have points, once it is described
  };
  void checkMesh(const std::string& mesh) const;
  void describe();
  std::vector<Field> fields() const;
  void copy(const Route& route);

  const std::unique_ptr<Connection> connection_;  ///< null: publishing is off
  std::string mesh_;
  Grid grid_;
  std::map<int, Block> blocks_;
  bool described_ = false;
  std::vector<Field> fields_;          ///< once it is described
  std::vector<const Block*> present_;  ///< the blocks that have points
  int64_t lastStep_ = 0;
  gxy_stat statistics_{};
};

}  // namespace gxy::insitu
