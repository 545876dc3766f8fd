// SPDX-License-Identifier: Apache-2.0
// What stands behind a gxy_sim.
#pragma once
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "insitu/api/galaxy_insitu.h"
#include "insitu/client/connection.h"
#include "insitu/client/meshes.h"

namespace gxy::insitu {

/// One rank of a simulation. Functions throw Error for wrong use; then nothing has changed.
class Simulation {
 public:
  Simulation(Options options, Member member);

  /// `function` is the one of the interface that changes them. Throws Error after publishLast(), whose arrays are kept.
  Meshes& meshes(const char* function);
  /// As Meshes::grid(). Between wanted() and publish() nothing may change.
  void grid(const std::string& mesh, int block, int of, const Grid& grid, const Extent& owned);
  /// Whether the next publish, which is of this step, is wanted; 1 or 0. Unless it is, or settle() says 1, this rank does not take it.
  int wanted(int64_t step, double time);
  void settle(int64_t step, bool any);
  /// Whether a parameter has changed; then `value` is what it has now. Throws Error unless the options declare it.
  bool steered(const std::string& parameter, double& value);
  /// Returns one of gxy_result, as publishLast().
  int publish(int64_t step, double time);
  /// Counts a publish that this rank does not take.
  int skip(int64_t step, double time);
  int publishLast(int64_t step, double time);

  gxy_stat statistics() const;
  /// Why there is no connection; empty if there is one.
  std::string problem() const { return connection_ ? connection_->problem() : std::string(); }
  void close(double seconds);

 private:
  struct Step {
    int64_t step = 0;
    double time = 0;
  };
  using Clock = Interrupt::Clock;
  void begin(int64_t step, const char* function);
  void describe();
  void checkOrder(int64_t step, const char* function) const;
  void count(int64_t step);
  int missed() const;
  bool passes(int64_t number, double time) const;
  void await(Clock::time_point begun);
  int take(const Step& step);
  void deliverLast(Clock::time_point until);

  const int64_t every_;
  const double firstTime_, lastTime_;
  const std::chrono::duration<double> patience_;
  const std::set<std::string> steerable_;
  const std::unique_ptr<Connection> connection_;  ///< null: publishing is off
  Meshes meshes_;
  int64_t lastStep_ = 0;
  struct Asked {
    Step step;
    bool take = false;
  };
  std::optional<Asked> asked_;  ///< what wanted() has said of the next publish
  Steering steering_, seen_;    ///< of the last step that was taken; what steered() has returned
  std::optional<Step> last_;    ///< of publishLast(), whose arrays are kept
  gxy_stat statistics_{};
};

}  // namespace gxy::insitu
