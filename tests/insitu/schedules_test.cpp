// SPDX-License-Identifier: Apache-2.0
// Sender, Receiver and Conductor together, with every order of events that a seed draws: connections are queues, and each rank
// is as slow as the seed says.
#include <gtest/gtest.h>

#include <algorithm>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/comm/error.h"
#include "core/comm/random.h"
#include "insitu/plan/conductor.h"
#include "insitu/plan/receiver.h"
#include "insitu/plan/sender.h"
#include "tests/support/seeds.h"

namespace gxy::insitu {
namespace {

constexpr uint64_t kItem = 3 * Sender::kChunkBytes / 2 / 4;  // points of two chunks

/// A simulation of `ranks` ranks and a server of `owners` ranks, without data: a slot holds the count that it was filled for.
class Schedule {
 public:
  /// Ranks never wait; or each waits until its publish is due; or waits with its last publish only, and stops then.
  enum class Ranks { Skip, Wait, End };
  explicit Schedule(uint64_t seed, Ranks policy = Ranks::Skip) : random_(seed), policy_(policy) {
    ranks_ = 1 + int(random_.below(4));
    owners_ = 1 + int(random_.below(3));
    stride_ = 1 + int64_t(random_.below(1000000));
    latency_ = uint64_t(1) << random_.below(8);
    if (policy_ == Ranks::End) end_ = 1 + random_.below(30);
    calm_ = random_.oneIn(2);
    eager_ = random_.oneIn(2);
    patience_ = random_.oneIn(4) ? 20 : 1000 * latency_;
    copy_ = latency_ <= 8 ? 1 + random_.below(100) : 1;  // up to a hundred times as long as a message
    computes_ = policy_ == Ranks::Wait && latency_ <= 8 ? 1 + random_.below(100) : 1;
    for (int r = 0; r < ranks_; r++) simulation_.push_back(std::make_unique<Simulation>());
    drawChanges();
    server_.resize(size_t(owners_));
    conductor_ = std::make_unique<Conductor>(ranks_);
  }

  /// Runs until so many steps are published; false if that takes too long.
  bool run(uint64_t steps) {
    for (int i = 0; i < 5000000 && published_.size() < steps; i++) step();
    return published_.size() >= steps;
  }

  /// Runs until all ranks know that the last step is published.
  bool runToTheEnd() {
    const auto isDone = [](const auto& s) { return s->done; };
    for (int i = 0; i < 5000000; i++) {
      step();
      if (std::all_of(simulation_.begin(), simulation_.end(), isDone)) return true;
    }
    return false;
  }
  bool isPatient() const { return patience_ > 20; }
  bool isCalm() const { return calm_; }  ///< no step is given up, and nobody loses patience

  const std::vector<StepHeader>& published() const { return published_; }
  const Conductor::Counters& counters() const { return conductor_->counters(); }
  uint64_t plans() const { return plans_; }
  uint64_t heldUp() const { return heldUp_; }
  std::string description() const {
    return std::to_string(ranks_) + " -> " + std::to_string(owners_) + " ranks, latency " +
           std::to_string(latency_) + ", " + std::to_string(conductor_->counters().missed) + " missed";
  }

 private:
  using Loads = std::vector<Sender::Load>;
  /// A message of rank 0 of the server: a plan from a publish on, or a control message.
  struct Down {
    Control control;
    std::optional<std::pair<uint64_t, Loads>> plan;
  };
  /// A message to it: from which publish on the rank has what, or a control message.
  struct Up {
    Control control;
    std::optional<std::pair<uint64_t, size_t>> description;
  };
  struct Sent {
    Sender::Chunk chunk;
    uint64_t slot = 0, plan = 0;  // the count that the slot was filled for, and by which plan
  };
  struct Simulation {
    Sender sender;
    uint64_t from = 0, planned = 0,
             told = 0;  // what it has now, has a plan for and has told: from which publish on
    size_t has = 0;     // what it has now: a number
    uint64_t slot = 0,
             filledBy = 0;          // the count whose values are in the slot, and the plan that they are for
    std::optional<uint64_t> takes;  // the count that is being copied; by the plan of then
    uint64_t calls = 0;             // of publish: the step
    uint64_t before = 0;            // steps that were published when the last one was taken
    bool waits = false, done = false;
    std::deque<Down> down;
    std::deque<Up> up;
    std::map<int, std::deque<Sent>> data;    // by owner
    std::pair<uint64_t, size_t> said{0, 0};  // what the server has heard of it
    size_t plannedFor = 0;                   // and what the plan is for
  };
  struct Owner {
    std::unique_ptr<Receiver> receiver;
    std::map<std::pair<int, uint32_t>, std::set<uint64_t>> stored;  // what was stored, by rank and item
    uint64_t told = 0;
  };

  // The publishes from which on ranks have something else: all of them, or some where steps may be left out.
  void drawChanges() {
    uint64_t count = 1;
    for (uint64_t left = random_.below(policy_ == Ranks::Wait ? 8 : 4); left > 0; left--) {
      count += 1 + random_.below(policy_ == Ranks::Skip ? 4 * latency_ : 3);
      std::set<int> ranks;
      for (int r = 0; r < ranks_; r++)
        if ((policy_ != Ranks::Skip && calm_) || random_.oneIn(2)) ranks.insert(r);
      changes_.emplace_back(count, std::move(ranks));
    }
  }
  /// What a rank has at a publish: a number, and from which publish on.
  std::pair<uint64_t, size_t> has(int r, uint64_t count) const {
    std::pair<uint64_t, size_t> result{1, 0};
    for (size_t i = 0; i < changes_.size(); i++)
      if (changes_[i].first <= count && changes_[i].second.count(r) > 0) result = {changes_[i].first, i + 1};
    return result;
  }

  // Each rank sends to each owner but those that the seed leaves out.
  void plan() {
    using Sources = std::vector<Receiver::Source>;
    auto sources = std::vector<Sources>(size_t(owners_), Sources(size_t(ranks_)));
    std::set<int> receiving;
    const uint64_t from = conductor_->described();
    for (int r = 0; r < ranks_; r++) {
      Loads loads;
      for (int g = 0; g < owners_; g++) {
        const size_t items = random_.below(3);
        if (items == 0) continue;
        std::vector<Item> load(items, Item{kItem, 4, -1, false});
        if (random_.oneIn(2)) load.push_back({0, 24, 0, true});  // and particles
        sources[size_t(g)][size_t(r)] = load;
        loads.push_back({g, std::move(load)});
        receiving.insert(g);
      }
      simulation_[size_t(r)]->plannedFor = simulation_[size_t(r)]->said.second;
      simulation_[size_t(r)]->down.push_back({{}, std::pair(from, std::move(loads))});
    }
    for (int g = 0; g < owners_; g++) {
      auto& receiver = server_[size_t(g)].receiver;
      if (receiver)
        receiver->expect(std::move(sources[size_t(g)]));
      else
        receiver = std::make_unique<Receiver>(std::move(sources[size_t(g)]));
    }
    conductor_->plan(from, receiving);
    plan_ = from;
    plans_++;
  }

  // What a queue brings is late: it is taken once in latency_ tries.
  bool late() { return latency_ > 1 && !random_.oneIn(latency_); }

  void step() {
    const int r = int(random_.below(uint64_t(ranks_)));
    switch (random_.below(7)) {
      case 0:
        return publish(*simulation_[size_t(r)], r);
      case 1:
        return fill(*simulation_[size_t(r)]);
      case 2:
        return answer(*simulation_[size_t(r)]);
      case 3:
        return send(*simulation_[size_t(r)], int(random_.below(uint64_t(owners_))));
      case 4:
        return receive(r, int(random_.below(uint64_t(owners_))));
      case 5:
        return hear(r);
      default:
        return conduct();
    }
  }

  void publish(Simulation& s, int r) {
    if (s.takes) return;  // The simulation is in gxy_publish() still.
    if (!s.waits && !random_.oneIn(computes_)) return;
    const std::pair<uint64_t, size_t> now = has(r, s.sender.count() + 1);
    if (s.from == 0 || now.second != s.has) {
      s.from = s.sender.count() + 1;
      s.has = now.second;
    }
    if (policy_ == Ranks::End && s.calls + 1 >= end_) return publishLast(s);
    if (policy_ == Ranks::Wait && !isOver(s)) return;
    s.calls++;
    if (s.sender.publish()) take(s);
  }
  void take(Simulation& s) {
    if (s.planned >= s.from)
      s.takes = s.sender.count();
    else
      s.sender.notFilled(false);
  }
  static bool isDue(const Simulation& s) {
    return s.sender.isDue() && (s.planned >= s.from || !s.sender.isNext());
  }
  // Whether a rank need not wait any more.
  bool isOver(Simulation& s) {
    if (!std::exchange(s.waits, true)) s.sender.await();
    if (!isDue(s) && (calm_ || !random_.oneIn(patience_))) return false;
    s.waits = false;
    return true;
  }
  // As gxy_close() does it.
  void publishLast(Simulation& s) {
    if (s.done || (s.calls == end_ && !s.sender.idle())) return;
    if (s.calls == end_ && s.sender.published() > s.before) {
      s.done = true;
      EXPECT_EQ(published_.back().step, int64_t(end_) * stride_) << "the rank takes it for published";
      return;
    }
    s.calls = end_ - 1;
    s.sender.await();
    if (s.planned < s.from || !s.sender.isDue() || !s.sender.publishLast()) return;
    s.before = s.sender.published();
    s.takes = s.sender.count();
    s.calls = end_;
  }
  void fill(Simulation& s) {
    if (!s.takes || late() || !random_.oneIn(copy_)) return;
    s.slot = *s.takes;
    s.filledBy = s.planned;
    s.sender.filled(int64_t(s.calls) * stride_, double(s.calls), {random_.below(3) * 30000});
    s.takes.reset();
  }
  // The thread of a rank that sends.
  void answer(Simulation& s) {
    if (const auto told = s.sender.announcement()) announced_.push_back({&s, *told});
    if (const auto due = s.sender.answer()) tellRoot(s, *due);
    if (s.told > 0)
      if (const auto waits = s.sender.waits()) tellRoot(s, *waits);
    if (s.told == 0) describe(s);
    if (s.down.empty() || late()) return;
    const Down message = std::move(s.down.front());
    s.down.pop_front();
    if (!message.plan) {
      if (const auto reply = s.sender.receive(message.control)) tellRoot(s, *reply);
    } else if (message.plan->first >= s.from) {
      s.sender.expect(message.plan->second);
      s.planned = message.plan->first;
    }
  }
  void describe(Simulation& s) {
    if (std::exchange(s.told, s.from) != s.from) s.up.push_back({{}, std::pair(s.from, s.has)});
  }
  void tellRoot(Simulation& s, const Control& control) {
    describe(s);
    s.up.push_back({control, {}});
  }
  void send(Simulation& s, int owner) {
    if (const auto chunk = s.sender.next(owner)) s.data[owner].push_back({*chunk, s.slot, s.filledBy});
  }
  // A rank of the server.
  void receive(int r, int owner) {
    auto& queue = simulation_[size_t(r)]->data[owner];
    if (queue.empty() || late()) return;
    const auto [chunk, slot, plan] = queue.front();
    queue.pop_front();
    Owner& o = server_[size_t(owner)];
    if (!o.receiver->accept(r, chunk.header, chunk.bytes)) return;
    EXPECT_EQ(slot, chunk.header.count) << "the slot was used again before it was sent";
    EXPECT_EQ(plan, plan_) << "it was filled by another plan";
    if (chunk.header.offset == 0) o.stored[{r, chunk.header.item}].clear();
    o.stored[{r, chunk.header.item}].insert(slot);
    if (o.receiver->complete() && o.told != o.receiver->count()) {
      o.told = o.receiver->count();
      completed_.push_back({owner, o.told});
    }
  }
  // Rank 0 of the server.
  void hear(int r) {
    Simulation& s = *simulation_[size_t(r)];
    if (!s.up.empty() && !late()) {
      const Up message = s.up.front();
      s.up.pop_front();
      if (message.description) {
        s.said = *message.description;
        conductor_->describe(r, s.said.first);
      } else {
        tell(conductor_->receive(r, message.control));
      }
    }
    if (!announced_.empty() && !late() && !random_.oneIn(2)) {
      const size_t i = random_.below(announced_.size());
      conductor_->receive(rankOf(announced_[i].first), announced_[i].second);
      announced_.erase(announced_.begin() + std::ptrdiff_t(i));
    }
    if (!completed_.empty() && !late()) {
      const size_t i = random_.below(completed_.size());
      conductor_->complete(completed_[i].first, completed_[i].second);
      completed_.erase(completed_.begin() + std::ptrdiff_t(i));
    }
  }
  void conduct() {
    if (!open_) {
      if (random_.oneIn(8)) tell(conductor_->look());
      if (conductor_->needsPlan() && conductor_->canPlan()) plan();
      const bool wanted = (policy_ != Ranks::Wait || eager_) && random_.oneIn(4);
      if (!wanted && !(policy_ == Ranks::Wait && conductor_->isAwaited())) return;
      // Nobody looks at a simulation that has come to its end.
      if (plans_ == 0 || (conductor_->needsPlan() && !conductor_->ranksWait())) return;
      const bool ends = policy_ == Ranks::End && simulation_[0]->calls + 1 >= end_;
      if (ends && !conductor_->isAwaited()) return;
      for (Owner& o : server_) o.receiver->open();
      open_ = true;
      const bool some = published_.size() >= 2 && random_.oneIn(2);  // publishes are not needed
      return tell(conductor_->begin(some ? conductor_->last() + random_.below(100) : 0));
    }
    if (!(calm_ && policy_ != Ranks::Skip) &&
        random_.oneIn((policy_ == Ranks::End ? 60 : 600) * latency_ * copy_)) {  // too late
      tell(conductor_->abandon());
      return close();
    }
    if (random_.oneIn(100 * latency_ * copy_)) tell(conductor_->again());  // nobody comes to it
    if (conductor_->isHeldUp()) {
      heldUp_++;
      const uint64_t last = conductor_->last();
      tell(conductor_->abandon());
      again_ = last - conductor_->last();
      return close();
    }
    if (!conductor_->isComplete()) return;
    for (int r = 0; r < ranks_; r++) {
      EXPECT_EQ(simulation_[size_t(r)]->plannedFor, has(r, conductor_->last()).second)
          << "the plan is one of what rank " << r << " has in this step";
    }
    for (Owner& o : server_) {
      ASSERT_TRUE(o.receiver->take(conductor_->last()));
      for (const auto& [from, counts] : o.stored) EXPECT_EQ(counts, std::set{conductor_->last()});
    }
    published_.push_back(conductor_->step());
    tell(conductor_->published());
    close();
  }
  void close() {
    for (Owner& o : server_) {
      o.receiver->close(conductor_->last());
      o.stored.clear();
    }
    open_ = false;
  }
  void tell(const std::vector<Control>& messages) {
    for (const Control& m : messages) {
      if (m.kind == Control::Kind::Appoint) {
        // A step that was held up may be appointed again.
        EXPECT_GT(m.count + std::exchange(again_, 0), std::exchange(appointed_, m.count));
      }
      for (const auto& s : simulation_) s->down.push_back({m, {}});
    }
  }
  int rankOf(const Simulation* s) const {
    for (int r = 0; r < ranks_; r++)
      if (simulation_[size_t(r)].get() == s) return r;
    throw Error("no such rank");
  }

  Random random_;
  Ranks policy_;
  uint64_t patience_ = 0;              ///< looks after which a rank waits no more, on average
  uint64_t end_ = 0;                   ///< the last publish
  bool calm_ = false, eager_ = false;  ///< eager: clients want steps, whether or not ranks wait
  int ranks_ = 1, owners_ = 1;
  int64_t stride_ = 1;
  uint64_t latency_ = 1, copy_ = 1, computes_ = 1;  ///< how long messages, copies and the steps of ranks take
  std::vector<std::unique_ptr<Simulation>> simulation_;
  std::vector<Owner> server_;
  std::unique_ptr<Conductor> conductor_;
  std::vector<std::pair<const Simulation*, StepHeader>> announced_;
  std::vector<std::pair<int, uint64_t>> completed_;
  std::vector<StepHeader> published_;
  uint64_t appointed_ = 0, again_ = 0;
  std::vector<std::pair<uint64_t, std::set<int>>>
      changes_;  ///< from which publishes on which ranks have something else
  uint64_t plan_ = 0, plans_ = 0,
           heldUp_ = 0;  ///< the publish from which on the plan is; how many; steps that waited for one
  bool open_ = false;
};

/// How many seeds: --seeds=N for long runs.
uint64_t seeds(uint64_t few) {
  for (const std::string& a : testing::internal::GetArgvs())
    if (a.rfind("--seeds=", 0) == 0) return std::stoull(a.substr(8));
  return uint64_t(test::sweep(int(few)));
}

TEST(Schedules, PublishWholeStepsOnlyAndAlwaysOneAtLast) {
  uint64_t missed = 0, abandoned = 0, plans = 0, heldUp = 0;
  for (uint64_t seed = 1; seed <= seeds(600); seed++) {
    Schedule schedule(seed);
    ASSERT_TRUE(schedule.run(5)) << "seed " << seed << ": " << schedule.description();
    const auto& steps = schedule.published();
    for (size_t i = 0; i < steps.size(); i++) {
      EXPECT_EQ(steps[i].time, double(steps[i].count));
      if (i > 0) {
        EXPECT_GT(steps[i].step, steps[i - 1].step);
      }
    }
    missed += schedule.counters().missed;
    plans += schedule.plans();
    heldUp += schedule.heldUp();
    abandoned += schedule.counters().abandoned;
    if (testing::Test::HasFailure()) FAIL() << "seed " << seed << ": " << schedule.description();
  }
  EXPECT_GT(missed, 100u) << "appointments that come too late are tried as well";
  EXPECT_GT(abandoned, uint64_t(test::sweep(100))) << "and steps that are given up";
  EXPECT_GT(plans, seeds(600) + uint64_t(test::sweep(100)))
      << "and ranks that have something else from a publish on";
  EXPECT_GT(heldUp, uint64_t(test::sweep(50))) << "also while a step is appointed";
}

TEST(Schedules, EachStepIsPublishedWhereRanksWait) {
  uint64_t calm = 0, left = 0, heldUp = 0;
  for (uint64_t seed = 1; seed <= seeds(300); seed++) {
    Schedule schedule(seed, Schedule::Ranks::Wait);
    ASSERT_TRUE(schedule.run(schedule.isPatient() ? 8 : 2))
        << "seed " << seed << ": " << schedule.description();
    const auto& steps = schedule.published();
    for (size_t i = 0; i < steps.size(); i++) {
      EXPECT_EQ(steps[i].time, double(steps[i].count));
      if (schedule.isCalm()) {
        EXPECT_EQ(steps[i].count, i + 1);
      }
      if (i > 0) left += steps[i].count - steps[i - 1].count - 1;
    }
    calm += schedule.isCalm();
    heldUp += schedule.heldUp();
    if (testing::Test::HasFailure()) FAIL() << "seed " << seed << ": " << schedule.description();
  }
  EXPECT_GT(calm, uint64_t(test::sweep(100)));
  EXPECT_GT(heldUp, uint64_t(test::sweep(20))) << "appointments of ranks that have something else by then";
  EXPECT_GT(left, 100u) << "steps are left out where ranks lose patience, or steps are given up";
}

TEST(Schedules, TheLastStepIsPublishedWhateverWasBefore) {
  uint64_t abandoned = 0;
  for (uint64_t seed = 1; seed <= seeds(300); seed++) {
    Schedule schedule(seed, Schedule::Ranks::End);
    ASSERT_TRUE(schedule.runToTheEnd()) << "seed " << seed << ": " << schedule.description();
    const auto& steps = schedule.published();
    for (size_t i = 1; i < steps.size(); i++) EXPECT_GT(steps[i].step, steps[i - 1].step);
    abandoned += schedule.counters().abandoned;
    if (testing::Test::HasFailure()) FAIL() << "seed " << seed << ": " << schedule.description();
  }
  EXPECT_GT(abandoned, uint64_t(test::sweep(20))) << "also where steps are given up";
}

}  // namespace
}  // namespace gxy::insitu
