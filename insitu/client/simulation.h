// SPDX-License-Identifier: Apache-2.0
// What stands behind a gxy_sim.
#pragma once
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "insitu/api/galaxy_insitu.h"
#include "insitu/client/connection.h"

namespace gxy::insitu {

/// One rank of a simulation. Functions throw Error for wrong use; then nothing has changed.
class Simulation {
 public:
  Simulation(Options options, Member member);

  /// `grid` and `owned` count points, or cells if `of` is GXY_OF_CELLS; the origin is that of the first point in both cases.
  void grid(const std::string& mesh, int block, int of, Grid grid, const Extent& owned);
  void field(const std::string& mesh, int block, const std::string& name, int of, const gxy_array& values);
  /// Returns one of gxy_result, as publishLast().
  int publish(int64_t step, double time);
  int publishLast(int64_t step, double time);

  gxy_stat statistics() const;
  /// Why there is no connection; empty if there is one.
  std::string problem() const { return connection_ ? connection_->problem() : std::string(); }
  void close(double seconds);

 private:
  struct Block {
    Extent owned;   ///< points of the stream's grid: for cells, with the rim beside them
    Extent values;  ///< those of them that fields have values of
    std::map<std::string, gxy_array> fields;
  };
  struct Step {
    int64_t step = 0;
    double time = 0;
  };
  using Clock = Interrupt::Clock;
  void begin(int64_t step, const char* function);
  void count(int64_t step);
  int missed() const;
  bool passes(double time) const;
  void checkMesh(const std::string& mesh) const;
  void describe();
  std::vector<Field> fields() const;
  void take(const Step& step);
  void copy(const Route& route);
  void keepFields();
  void deliverLast(Clock::time_point until);

  const int64_t every_;
  const double firstTime_, lastTime_;
  const std::chrono::duration<double> patience_;
  const std::unique_ptr<Connection> connection_;  ///< null: publishing is off
  std::string mesh_;
  Grid grid_;  ///< of the stream: for cells, with a rim
  std::map<int, Block> blocks_;
  bool described_ = false;
  std::vector<Field> fields_;          ///< once it is described
  std::vector<const Block*> present_;  ///< the blocks that have points, once it is described
  int64_t lastStep_ = 0;
  std::optional<Step> last_;                  ///< of publishLast()
  std::vector<std::vector<std::byte>> kept_;  ///< the arrays of that step, which `blocks_` then names
  gxy_stat statistics_{};
};

}  // namespace gxy::insitu
