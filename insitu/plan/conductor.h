// SPDX-License-Identifier: Apache-2.0
// How rank 0 of the server agrees with all ranks of a simulation on the step that is taken next.
#pragma once
#include <cstdint>
#include <set>
#include <string>
#include <vector>

#include "insitu/plan/records.h"

namespace gxy::insitu {

/// The state machine of rank 0, for one stream. It uses no sockets, threads or clocks. What it returns is sent to all ranks of the
/// simulation, in this order.
///
/// A step is taken by appointment. Rank 0 asks all ranks how many publishes there have been, and appoints one in the future, which
/// all take: no rank of the simulation waits for another. If the appointment reaches a rank too late, the rank says that it has
/// missed it. Then rank 0 cancels it and appoints one that lies further ahead.
///
/// What a rank says of its data is true from a publish on, whose number it tells. A rank that has said something new takes no step
/// before there is a plan for it.
class Conductor {
 public:
  /// `ranks`: the number of ranks of the simulation. There is no plan yet.
  explicit Conductor(int ranks);

  /// A rank has said what it has, from publish `from` on. Throws Error unless it says so for the first time, or of later publishes
  /// than before.
  void describe(int rank, uint64_t from);
  /// Whether something that a rank has said is in no plan.
  bool needsPlan() const { return described_ > planned_; }
  /// Whether no rank can say anything more of publishes up to described(), so that there can be a plan. Until then look() asks.
  bool canPlan() const;
  uint64_t described() const { return described_; }
  /// There is a plan for the publishes from `from` on. `owners`: the ranks of Galaxy that get samples. Only while no step is under way.
  void plan(uint64_t from, std::set<int> owners);
  /// Whether the appointed step cannot be taken before there is another plan, and no rank has to come to it first.
  bool isHeldUp() const;
  /// Whether the same publish can be appointed again once it is given up: it is held up, and no rank can have taken it.
  bool comesAgain() const;

  /// Asks how many publishes there have been, while no step is under way. Once all ranks have answered, newest() is the largest.
  std::vector<Control> look();
  uint64_t newest() const { return newest_; }
  /// There is room for a step on all ranks of Galaxy. Publishes before `from` are not needed, unless a rank waits. It should be near:
  /// nothing sooner can be appointed then.
  std::vector<Control> begin(uint64_t from = 0);
  /// A rank of the simulation answers. Throws Error for a message that only a server sends.
  std::vector<Control> receive(int rank, const Control& message);
  /// A rank of the simulation has taken a step. Throws Error if ranks say different things of the same publish.
  void receive(int rank, const StepHeader& step);
  /// A rank of Galaxy has all samples of the step of publish `count`.
  void complete(int owner, uint64_t count);

  /// Whether all ranks have taken the step, and all of its samples are there.
  bool isComplete() const;
  /// Whether a rank of the simulation waits for a publish that has not been published.
  bool isAwaited() const { return awaited_ > published_; }
  /// Whether a rank waits for its publishes, or has done so.
  bool ranksWait() const { return ranksWait_; }
  /// Whether a rank has taken the step that is appointed now.
  bool someTaken() const;
  /// The rank that took the appointed step last; -1 if none has taken it.
  int latest() const { return latest_; }
  /// What of the step has not come, as text.
  std::string missing() const;
  /// The step that was appointed. Its `step` and `time` are known once isComplete().
  const StepHeader& step() const { return step_; }
  /// The count that was appointed last, or the one before it if it comes again.
  uint64_t last() const { return last_; }

  /// Nobody has come to the appointed publish for a while: perhaps the simulation has become slower since, and an appointment
  /// that lies less far ahead will do. Returns nothing where that cannot be.
  std::vector<Control> again();
  /// The step is published.
  std::vector<Control> published();
  /// The step is given up.
  std::vector<Control> abandon();

  struct Counters {
    uint64_t appointed = 0, missed = 0, published = 0, abandoned = 0;
    uint64_t margin = 0;  ///< publishes that an appointment lies further ahead than the next one
  };
  const Counters& counters() const { return counters_; }

 private:
  enum class State { Idle, Looking, Asking, Collecting };
  Control ask();
  std::vector<Control> appoint();
  void widen(uint64_t newest);
  void isAt(int rank, uint64_t count);

  std::set<int> owners_;
  std::vector<uint64_t>
      said_;  ///< from which publish on its data are what it has said, by rank; 0: it has said nothing
  std::vector<uint64_t> known_;  ///< what a rank says next is true of later publishes than this, by rank
  uint64_t described_ = 0, planned_ = 0;  ///< the largest of said_, and that of the plan
  State state_ = State::Idle;
  uint64_t question_ = 0;       ///< the number of the last AskNewest
  std::vector<bool> answered_;  ///< the question, by rank
  size_t answers_ = 0;
  uint64_t answer_ = 0;      ///< the largest of the answers so far
  uint64_t newest_ = 0;      ///< of all ranks
  std::vector<bool> taken_;  ///< the appointed publish, by rank
  size_t takes_ = 0;
  int latest_ = -1;
  std::set<int> completed_;  ///< ranks of Galaxy
  StepHeader step_;
  uint64_t last_ = 0, from_ = 0;
  bool ranksWait_ = false;
  uint64_t awaited_ = 0,
           published_ = 0;        ///< counts: the largest that a rank waits for, and of the last published
  int successes_ = 0, late_ = 0;  ///< in a row: steps without a miss; appointments that came too late
  Counters counters_;
};

}  // namespace gxy::insitu
